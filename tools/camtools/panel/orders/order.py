# SPDX-License-Identifier: Apache-2.0
"""Orders of the panel, and what came of them.

>>> order = Order("feed", {"percent": 90.0})
>>> order.name, Outcome(True, "feed override = 90 %").is_done
('feed', True)
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Order:
    """What a visitor wants done.

    Attributes
    ----------
    name : str
        one of camtools.panel.orders.order_rules.RULES
    arguments : Mapping
        by their names there
    """

    name: str
    arguments: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Outcome:
    """What came of an order.

    Attributes
    ----------
    is_done : bool
        whether the controller accepted it
    text : str
        one line for people: what is so now, or why not and what to do
    """

    is_done: bool
    text: str
