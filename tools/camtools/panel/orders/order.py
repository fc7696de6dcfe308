"""Orders of the panel: their arguments, what right each needs, and what came of them.

All but those of `URGENT` need the command: every page may end what moves, at once. Numbers are in
the unit of their name.

>>> checked(Order("step", {"axis": "x", "mm": 1}))
{'axis': 'x', 'mm': 1.0}
"""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

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


class OrderRule(NamedTuple):
    """Types of an order's arguments by their names, and of those that may be missing."""

    arguments: Mapping[str, type]
    optional: Mapping[str, type]


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


def _rule(optional: Mapping[str, type] | None = None, **arguments: type) -> OrderRule:
    return OrderRule(arguments, optional or {})


RULES = {
    # Without arguments, as camctl has them. home: finds the index; of an axis: in manual.
    **{name: _rule() for name in URGENT},
    **{name: _rule() for name in ("enable", "manual", "start", "hold", "resume", "reset")},
    "home": _rule({"axis": str}),
    # By hand. press: a number that rises with each press of a button in one page. The page repeats
    # jog_hold every 100 ms; sent_ms is performance.now() of the browser: by it late ones are known.
    "jog_begin": _rule({"sent_ms": float}, press=int, axis=str, mm_per_s=float),
    "jog_hold": _rule({"sent_ms": float}, press=int),
    "jog_end": _rule(press=int),
    "step": _rule(axis=str, mm=float),
    "zero": _rule(axis=str, mm=float),  # x: the diameter that the tip touches; z: its height
    "tool": _rule(number=int),
    "tool_offset": _rule(number=int, axis=str, mm=float),
    # Overrides and trims, also while cutting.
    "feed": _rule(percent=float),
    "spindle": _rule(percent=float),
    "trim": _rule(measure=str, mm=float),  # measure: diameter or radius
    "parts": _rule(number=int),
    "amplitude": _rule(percent=float),
    "phase": _rule(deg=float),
    # From the next start on; 0: those of the table.
    "speed": _rule(rpm=float),
    "feed_per_turn": _rule(mm=float),
    # Tables: whole images, with a name for people.
    "download": _rule(image=bytes, name=str),
    "table_next": _rule(image=bytes, name=str),  # and takes it into use, also in ready
    "select": _rule(),
    # Parameters, in the controller's whole numbers.
    "set": _rule(name=str, value=int),
    "params_load": _rule(text=bytes, name=str),  # a TOML file of camctl params save
    "keep": _rule(),
    "revert": _rule(),
    "defaults": _rule(),
    # The position loop of a U that takes forces.
    "push_u": _rule(force_n=float),
    "measure_loop": _rule(),
    "apply_loop": _rule(),  # what was proposed last
    # The level of the controller: limits, constants and tables change in the unlocked one only.
    "lock": _rule(),
}


def checked(order: Order) -> dict[str, Any]:
    """Return the arguments of an order; raise CamtoolsError where one is none of its rule's."""
    rule = RULES.get(order.name)
    if rule is None:
        raise CamtoolsError([f"{shown(order.name)}: no such order"])
    given, known = order.arguments, {**rule.arguments, **rule.optional}
    missing = [name for name in rule.arguments if name not in given]
    if missing or set(given) - set(known):
        wanted = ", ".join(known) or "nothing"
        raise CamtoolsError([f"{order.name}: give {wanted}"])
    return {name: _argument(order.name, name, known[name], value) for name, value in given.items()}


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
