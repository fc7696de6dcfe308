"""Roundness, straightness and harmonics of measured profiles, as the standards define them."""
