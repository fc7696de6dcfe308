"""Orders to the controller: their rules, who gives them, and how they are executed."""
