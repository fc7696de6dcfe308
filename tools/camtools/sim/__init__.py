"""The host simulator: how it is run, and what it wrote."""
