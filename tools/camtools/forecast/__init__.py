"""What is to be expected of a part on a machine whose numbers are not known exactly."""
