"""Behind the design page: preview in processes of its own, form, text, library of parts."""
