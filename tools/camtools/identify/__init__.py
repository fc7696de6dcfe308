"""Measures the constants of U's drive: excitation, fit, what they mean for a part."""
