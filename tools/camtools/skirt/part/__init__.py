"""The part file of a skirt: its keys and the curves that they describe."""
