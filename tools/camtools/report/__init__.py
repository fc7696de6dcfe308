"""What the reports of all kinds share: the page and its pictures of axes and comparison."""
