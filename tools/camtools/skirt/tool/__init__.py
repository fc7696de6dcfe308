"""The tool on a skirt: its nose and flank, and how the axes move."""
