"""Every figure and table of the papers, made anew and set beside what is printed."""
