# SPDX-License-Identifier: Apache-2.0
"""Which orders make sense in a state, and in words why not; the controller judges once more.

>>> why_not("start", "off", {})
'only in ready'
>>> why_not("start", "ready", {})
''
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

_IDLE = ("off", "ready")
_BY_HAND = ("off", "manual", "ready")
_AT_REST = ("off", "ready", "manual", "fault", "homing")
_RAMPED = ("off", "ready", "rehearsing", "engaging", "cutting", "disengaging", "holding")
_ANY = (
    *("off", "homing", "ready", "engaging", "cutting", "disengaging", "fault", "rehearsing"),
    *("identifying", "manual", "holding"),
)
_STOPS = {
    "rehearsing": "stop",
    "engaging": "stop",
    "cutting": "stop",
    "holding": "stop",
    "manual": "stop",
    "identifying": "stop",
    "homing": "disable",
    "ready": "disable",
}


@dataclass(frozen=True)
class Rule:
    """When an order is accepted."""

    states: tuple[str, ...]
    otherwise: str


RULES = {
    "enable": Rule(("off",), "only in off"),
    "disable": Rule(("homing", "ready", "manual"), "only in homing, ready and by hand"),
    "start": Rule(("ready",), "only in ready"),
    "hold": Rule(("rehearsing", "engaging", "cutting"), "only during a cut"),
    "resume": Rule(("rehearsing", "engaging", "cutting", "holding"), "only while the feed is held"),
    "reset": Rule(("fault",), "only after a fault"),
    "home": Rule(("off", "ready"), "only in off and ready"),
    "manual": Rule(("off",), "only in off"),
    "jog": Rule(("manual",), "only by hand; press By hand first"),
    "step": Rule(("manual",), "only by hand; press By hand first"),
    "home_axis": Rule(("manual",), "only by hand; press By hand first"),
    "zero": Rule(_BY_HAND, "only in off, ready and by hand"),
    "tool": Rule(_BY_HAND, "only in off, ready and by hand"),
    "feed": Rule(_RAMPED, "not in this state"),
    "spindle": Rule(_RAMPED, "not in this state"),
    "trim": Rule(_RAMPED, "not in this state"),
    "parts": Rule(_ANY, ""),
    "table": Rule(_IDLE, "only in off and ready"),
    "params": Rule(_ANY, ""),
    "keep": Rule(("off",), "only in off"),
    "revert": Rule(_IDLE, "only in off and ready"),
    "defaults": Rule(_IDLE, "only in off and ready"),
    "push_u": Rule(("ready",), "only in ready"),
    "measure_loop": Rule(("ready",), "only in ready"),
    "apply_loop": Rule(("ready",), "only in ready"),
    "unlock": Rule(_AT_REST, "only while the machine is at rest"),
    "lock": Rule(_ANY, ""),
}


def why_not(order: str, state: str, signals: Mapping[str, float]) -> str:
    """Return why an order would be refused now, a clause; "" when it makes sense."""
    rule = RULES[order]
    if state not in rule.states:
        return rule.otherwise
    is_held = bool(signals.get("is_held", 0.0))
    if order == "hold" and is_held:
        return "the feed is held already"
    if order == "resume" and not is_held:
        return "only while the feed is held"
    is_unlocked = bool(signals.get("level", 0.0))
    if order == "unlock" and is_unlocked:
        return "already unlocked"
    if order == "lock" and not is_unlocked:
        return "already locked"
    if order == "reset" and not signals.get("is_retracted", 1.0):
        return "the tool is still leaving the work; wait a moment"
    return ""


def stop_order(state: str) -> str:
    """Return what the one big button orders: to end what moves, in the mildest way that does.

    In the work the tool leaves it and the spindle goes on; in homing and ready the drives go off;
    by hand the axis brakes. Elsewhere nothing moves, and stop is ordered all the same: whoever
    presses it gets an answer.
    """
    return _STOPS.get(state, "stop")
