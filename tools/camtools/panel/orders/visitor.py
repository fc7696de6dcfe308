# SPDX-License-Identifier: Apache-2.0
"""Who looks at the panel: one open page, as the server knows it.

>>> str(Visitor("v1"))
'page v1'
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

_numbers = itertools.count(1)


@dataclass(eq=False)
class Visitor:
    """An open page; the server makes it, no message of a browser can name another.

    Attributes
    ----------
    back_at_s : float
        [s] of time.monotonic: when the connection stood again after a loss; what the browser had
        kept back meanwhile arrives right after it
    """

    id: str  # short name, shown and logged; it opens nothing
    is_here: bool = True  # whether the page's connection stands
    was_connected: bool = False  # whether it has stood before
    n_losses: int = 0  # how often it was lost
    back_at_s: float = -1e9

    def __str__(self) -> str:
        return f"page {self.id}"


def new_visitor() -> Visitor:
    """Return the visitor of a page that was just opened."""
    return Visitor(f"v{next(_numbers)}")
