"""The controller's verdict on a cut: its own code, called in this process."""
