"""The table of a skirt: channels, their accuracy, the smallest that suffices."""
