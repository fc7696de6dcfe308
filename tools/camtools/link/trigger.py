# SPDX-License-Identifier: Apache-2.0
"""The trigger of a recording, as it is written on a command line.

>>> trigger_of("u_actual_nm>1000", 20000)
Trigger(kind='level', watched='u_actual_nm', level=1000, is_falling=False)
>>> trigger_of("angle<90", 20000).level == 2**30, trigger_of("time=0.5", 20000).level
(True, 10000)
>>> trigger_of("fault=estop+following_error", 20000).level
1025
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from camtools.base.errors import CamtoolsError
from camtools.link import scope
from camtools.link.controller import Link
from camtools.link.messages import NUMBERS
from camtools.link.signals import FAULTS

GRAMMAR = (
    "now, time=SECONDS, SIGNAL>VALUE, SIGNAL<VALUE, angle>DEGREES, angle<DEGREES, state=NAME, "
    "fault, fault=NAME+NAME"
)


@dataclass(frozen=True)
class Trigger:
    """When a recording begins; see cam_recorder.h."""

    kind: str  # one of scope.TRIGGERS
    watched: str = "tick"  # signal of kind level
    level: int = 0  # in the unit of the controller
    is_falling: bool = False  # of kind level and angle


def _number(text: str, what: str) -> float:
    try:
        value = float(text)
    except ValueError as error:
        raise CamtoolsError([f"--trigger {what}: {text} is not a number"]) from error
    if not abs(value) < 2**31:  # not a number is not below, either
        raise CamtoolsError([f"--trigger {what}: {text}: give less than 2^31"])
    return value


def _passing(text: str, signal: str, edge: str, value: str) -> Trigger:
    is_falling = edge == "<"
    if signal == "angle":
        turns = _number(value, text) / 360 % 1
        return Trigger("angle", level=round(turns * 2**32) % 2**32, is_falling=is_falling)
    scope.mask_of([signal])
    return Trigger("level", signal, round(_number(value, text)), is_falling)


def _faults(text: str, names: str) -> int:
    for name in names.split("+"):
        if name not in FAULTS:
            known = ", ".join(FAULTS)
            raise CamtoolsError([f"--trigger {text}: {name} is not a fault; give some of {known}"])
    return sum(1 << FAULTS.index(name) for name in set(names.split("+")))


def trigger_of(text: str, tick_hz: int) -> Trigger:
    """Return the trigger of a text.

    Raises
    ------
    CamtoolsError
        It is none; the line tells the forms.
    """
    if match := re.fullmatch(r"(\w+)([<>])(.+)", text):
        return _passing(text, match[1], match[2], match[3])
    kind, _, value = text.partition("=")
    if text in ("now", "fault"):
        return Trigger(text)
    if kind == "time" and value:
        ticks = _number(value, text) * tick_hz
        if not 0 <= ticks < 2**31:
            raise CamtoolsError([f"--trigger {text}: give 0 .. {2**31 // tick_hz} s"])
        return Trigger("time", level=round(ticks))
    if kind == "fault" and value:
        return Trigger("fault", level=_faults(text, value))
    if kind == "state" and value in NUMBERS["state"]:
        return Trigger("state", level=NUMBERS["state"][value])
    if kind == "state":
        known = ", ".join(NUMBERS["state"])
        raise CamtoolsError([f"--trigger {text}: no such state; give one of {known}"])
    raise CamtoolsError([f"--trigger {text}: give one of {GRAMMAR}"])


def arm(link: Link, trigger: Trigger, n_before: int) -> None:
    """Set trigger and rows of before it for the recordings to come."""
    scope.put(link, "trigger", scope.TRIGGERS.index(trigger.kind))
    scope.put(link, "watched", scope.SIGNALS.index(trigger.watched))
    scope.put(link, "level", trigger.level)
    scope.put(link, "edge", int(trigger.is_falling))
    scope.put(link, "before", n_before)
