"""The browser panel: a page that shows a controller, and lets one visitor command it."""
