"""Runs of parts on the simulator: kept in folders, cut one after the other, compared."""
