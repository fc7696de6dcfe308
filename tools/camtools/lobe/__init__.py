"""A kind of part: lobes and camshafts, turned with a swinging tool or ground with a wheel."""
