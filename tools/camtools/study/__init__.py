"""Studies beside the table: one section, paths, the refit of a corner, the size of tables."""
