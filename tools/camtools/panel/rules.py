# SPDX-License-Identifier: Apache-2.0
"""The orders that the panel knows: their arguments, and what right each needs.

Every order needs the token, and all but `stop` the command. Numbers are in the unit of their name.

>>> RULES["step"].arguments["mm"] is float, RULES["stop"].needs_command
(True, False)
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Rule:
    """What an order needs.

    Attributes
    ----------
    arguments : Mapping
        type by name; all must be there but those of `optional`
    optional : Mapping
        type by name of those that may be missing
    needs_command : bool
        whether only the commander may give it
    """

    arguments: Mapping[str, type]
    optional: Mapping[str, type]
    needs_command: bool = True


def _rule(optional: Mapping[str, type] | None = None, **arguments: type) -> Rule:
    return Rule(arguments, optional or {})


RULES = {
    # Without arguments, as camctl has them. home: finds the index; of an axis: in manual.
    "stop": Rule({}, {}, needs_command=False),
    **{name: _rule() for name in ("enable", "disable", "manual", "start", "hold", "resume")},
    "reset": _rule(),
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
}
