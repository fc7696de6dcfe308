"""What every part file has, of whatever kind, and how one is read."""
