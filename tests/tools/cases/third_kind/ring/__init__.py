"""A third kind of part, for the tests: a ring whose outside is eccentric to its axis."""
