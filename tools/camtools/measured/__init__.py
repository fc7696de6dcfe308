"""From the gauged surface of a part to the correction of its next table."""
