"""What is reported about a skirt: summary, pictures, page."""
