"""Loops of force drives: responses, margins, proposals."""
