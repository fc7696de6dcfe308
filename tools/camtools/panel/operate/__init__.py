"""Pieces of the operator's page: each draws one thing and shows a snapshot in it."""
