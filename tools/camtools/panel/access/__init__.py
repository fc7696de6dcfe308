"""Who may see the panel and command it: token, connections, requests, pages."""
