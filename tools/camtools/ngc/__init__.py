"""NC programs for machines that have a controller of their own."""
