"""Checks of images and sources: none of them makes a table, and camtools never needs them."""
