"""What the reports of all kinds share: the page, its charts and pictures."""
