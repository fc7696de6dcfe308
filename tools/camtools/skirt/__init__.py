"""A kind of part: the skirt of a piston, whose radius varies with angle and height."""
