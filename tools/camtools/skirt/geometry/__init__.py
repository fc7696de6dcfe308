"""The exact shape of a skirt: sections, surfaces, measured points, refitted corners."""
