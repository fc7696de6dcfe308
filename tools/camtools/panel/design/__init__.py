"""The design page without its page: preview in processes of its own, form, text, shelf of parts."""
