"""The table image: its bytes, its evaluation, its quantisation, its C source."""
