# SPDX-License-Identifier: Apache-2.0
"""What a page leaves in the memory of the libraries when it goes, and how it is freed.

Each field for a file (ui.upload) has a route of its own. FastAPI remembers of the functions behind
the last routes whether they are coroutines, and with a function all of the page that it is part of:
0.7 MB for each operator's page. Nothing but speed is lost when that is forgotten.

>>> forget_routes()
"""

from __future__ import annotations

from fastapi.dependencies import models


def forget_routes() -> None:
    """Forget functions of routes, so that pages which are gone can be freed."""
    for cached in vars(models).values():
        clear = getattr(cached, "cache_clear", None)
        if callable(clear):
            clear()
