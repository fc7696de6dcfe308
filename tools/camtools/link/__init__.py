"""The controller at the other end of a CAN bus."""
