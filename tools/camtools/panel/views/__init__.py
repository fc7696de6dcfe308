"""What the pages of the panel show, as functions of what is known; nothing here draws."""
