# SPDX-License-Identifier: Apache-2.0
"""Who looks at the panel: one open page, as the server knows it.

>>> visitor = Visitor("v1", "127.0.0.1")
>>> visitor.has_token, str(visitor)
(False, 'v1 at 127.0.0.1')
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

_numbers = itertools.count(1)


@dataclass(eq=False)
class Visitor:
    """One open page; the server makes it, no message of a browser can name another one.

    Attributes
    ----------
    back_at_s : float
        [s] of time.monotonic: when it stood again after it was lost; what a browser had kept back
        meanwhile comes just behind that
    """

    id: str  # short name, shown and logged; it opens nothing
    address: str  # of the computer that asked for the page
    has_token: bool = False  # whether the page has shown the token of this start
    is_here: bool = True  # whether the page's connection stands
    was_connected: bool = False  # whether it has stood before
    n_losses: int = 0  # how often it was lost
    back_at_s: float = -1e9

    def __str__(self) -> str:
        return f"{self.id} at {self.address}"


def new_visitor(address: str) -> Visitor:
    """Return the visitor of a page that was just opened."""
    return Visitor(f"v{next(_numbers)}", address)
