"""The mathematics of a cut: path, metal removed, spindle speed, what the axes need."""
