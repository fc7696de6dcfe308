"""From a part file to its report, for every kind of part; a kind is one package that it finds."""
