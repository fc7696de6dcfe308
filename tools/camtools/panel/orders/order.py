"""Orders of the panel: their arguments, what right each needs, and what came of them.

All but those of `URGENT` need the command: every page may end what moves, at once. Numbers are in
the unit of their name.

>>> checked(Order("step", {"axis": "x", "mm": 1}))
{'axis': 'x', 'mm': 1.0}
"""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

from camtools.base.errors import CamtoolsError, shown
from camtools.link.operator import AXES, MEASURES, N_TOOLS


@dataclass(frozen=True)
class Order:
    """What a visitor wants done."""

    name: str  # one of camtools.panel.orders.order.RULES
    arguments: Mapping[str, Any] = field(default_factory=dict)  # by their names there


@dataclass(frozen=True)
class Outcome:
    """What came of an order."""

    is_done: bool  # whether the controller accepted it
    text: str  # one line for people: what is so now, or why not and what to do


# They overtake everything, break off what runs, and drop what waits.
URGENT = ("stop", "disable")
# They end when the visitor's page is closed or command is lost.
ATTENDED = ("push_u", "measure_loop")
_LONGEST_TEXT = 200
_MOST_TEXT_BYTES, MOST_IMAGE_BYTES = 1 << 20, 16 << 20
_SIZES = {"text": _MOST_TEXT_BYTES, "image": MOST_IMAGE_BYTES}
_CHOICES: Mapping[str, Collection[object]] = {"axis": tuple(AXES), "measure": MEASURES}
_OWN_CHOICES: Mapping[tuple[str, str], Collection[object]] = {
    ("zero", "axis"): ("x", "z"),
    ("tool_offset", "axis"): ("x", "z"),
    ("tool_offset", "number"): range(1, N_TOOLS + 1),
    ("tool", "number"): range(N_TOOLS + 1),
}


# Types of the arguments of each order by their names.
RULES: Mapping[str, Mapping[str, type]] = {
    # Without arguments, as camctl has them. home: finds the index; of an axis: in manual.
    **{name: {} for name in (*URGENT, "enable", "manual", "start", "hold", "resume", "reset")},
    "home": {"axis": str},
    # By hand. press: a number that rises with each press of a button in one page. The page repeats
    # jog_hold every 100 ms; sent_ms is performance.now() of the browser: by it late ones are known.
    "jog_begin": {"press": int, "axis": str, "mm_per_s": float, "sent_ms": float},
    "jog_hold": {"press": int, "sent_ms": float},
    "jog_end": {"press": int},
    "step": {"axis": str, "mm": float},
    "zero": {"axis": str, "mm": float},  # x: the diameter that the tip touches; z: its height
    "tool": {"number": int},
    "tool_offset": {"number": int, "axis": str, "mm": float},
    # Overrides and trims, also while cutting.
    **{name: {"percent": float} for name in ("feed", "spindle", "amplitude")},
    "trim": {"measure": str, "mm": float},  # measure: diameter or radius
    "parts": {"number": int},
    "phase": {"deg": float},
    # From the next start on; 0: those of the table.
    "speed": {"rpm": float},
    "feed_per_turn": {"mm": float},
    # Tables: whole images, with a name for people; table_next takes it into use, also in ready.
    **{name: {"image": bytes, "name": str} for name in ("download", "table_next")},
    "select": {},
    # Parameters, in the controller's whole numbers.
    "set": {"name": str, "value": int},
    "params_load": {"text": bytes, "name": str},  # a TOML file of camctl params save
    **{name: {} for name in ("keep", "revert", "defaults")},
    # The position loop of a U that takes forces; apply_loop: what was proposed last.
    "push_u": {"force_n": float},
    **{name: {} for name in ("measure_loop", "apply_loop")},
    # The level of the controller: limits, constants and tables change in the unlocked one only.
    "lock": {},
}
_OPTIONAL = {("home", "axis"), ("jog_begin", "sent_ms"), ("jog_hold", "sent_ms")}


def checked(order: Order) -> dict[str, Any]:
    """Return the arguments of an order; raise CamtoolsError where one is none of its rule's."""
    rule = RULES.get(order.name)
    if rule is None:
        raise CamtoolsError([f"{shown(order.name)}: no such order"])
    given = order.arguments
    missing = {name for name in rule if (order.name, name) not in _OPTIONAL} - set(given)
    if missing or set(given) - set(rule):
        wanted = ", ".join(rule) or "nothing"
        raise CamtoolsError([f"{order.name}: give {wanted}"])
    return {name: _argument(order.name, name, rule[name], value) for name, value in given.items()}


def _argument(order: str, name: str, kind: type, value: object) -> object:
    what = f"{order}: {name} = {shown(value)}"
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        value = float(value)
    if type(value) is not kind:
        raise CamtoolsError([f"{what}: give a value of type {kind.__name__}"])
    if isinstance(value, float) and not math.isfinite(value):
        raise CamtoolsError([f"{what}: give a finite number"])
    if isinstance(value, str) and len(value) > _LONGEST_TEXT:
        raise CamtoolsError([f"{what}: longer than {_LONGEST_TEXT} characters"])
    if isinstance(value, bytes) and len(value) > _SIZES[name]:
        raise CamtoolsError([f"{order}: {name}: larger than {_SIZES[name]} bytes"])
    choices = _OWN_CHOICES.get((order, name)) or _CHOICES.get(name)
    if choices and value not in choices:
        raise CamtoolsError([f"{what}: give one of {', '.join(map(str, choices))}"])
    return value
