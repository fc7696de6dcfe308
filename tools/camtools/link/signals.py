"""Signals of a recording in the units of people, and the trigger that they start it by.

>>> unit_of("u_actual_nm", 20000)
Unit(name='u_actual_um', factor=0.001, is_wrapping=False)
>>> unit_of("angle_q32", 20000).name, unit_of("u_force_q6", 20000).name
('angle_deg', 'u_force_n')

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

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.link import scope
from camtools.link.controller import Link
from camtools.link.messages import FAULT_TEXTS, NAMES, NUMBERS
from camtools.link.scope import Recording

FAULTS = tuple(FAULT_TEXTS)
# Bits of hal.h by their numbers, hal_in_* and hal_out_*.
_AT = (
    "estop drive_ready bus_lost home_u home_x home_z index_u index_x index_z acknowledge key "
    "limit_u_low limit_u_high"
)
INPUTS = dict(enumerate(_AT.split()))
OUTPUTS = {0: "enable", 1: "fault", 2: "in_cut"}
BITS = {"faults": dict(enumerate(FAULTS)), "inputs": INPUTS, "outputs": OUTPUTS}
_TURN = 2.0**32
_S_PER_MIN = 60.0


@dataclass(frozen=True)
class Unit:
    """How a signal is shown."""

    name: str  # of the column; the last word is the unit
    factor: float  # that unit per unit of the controller
    is_wrapping: bool = False  # it counts from 0 to 2^32, not from -2^31


def unit_of(signal: str, tick_hz: int) -> Unit:
    """Return how a signal of that tick rate is shown; what has no unit stays as it is."""
    factors = {
        "_force_q6": ("_force_n", 1e-3 / 64),
        "_nm": ("_um", 1e-3),
        "_q6": ("_um", 1e-3 / 64),
        "vel_q10": ("vel_mm_per_s", 1e-6 / 1024 * tick_hz),
        "acc_q10": ("acc_m_per_s2", 1e-9 / 1024 * tick_hz**2),
        "speed_q32": ("speed_rpm", tick_hz * _S_PER_MIN / _TURN),
        "_q32": ("_deg", 360 / _TURN),
        "_mrpm": ("_rpm", 1e-3),
    }
    for end, (shown_end, factor) in factors.items():
        if signal.endswith(end):
            return Unit(signal.removesuffix(end) + shown_end, factor, signal == "angle_q32")
    return Unit(signal, 1)


def physical(recording: Recording) -> dict[str, Floats]:
    """Return the columns of a recording in the units of people, by their names in these."""
    columns = {}
    for signal in recording.signals:
        unit = unit_of(signal, recording.tick_hz)
        whole = recording[signal] % 2**32 if unit.is_wrapping else recording[signal]
        columns[unit.name] = whole.astype(np.float64) * unit.factor
    return columns


def faults_in(bits: int) -> list[str]:
    """Return the names of faults, a bit each."""
    return [name for i, name in enumerate(FAULTS) if bits >> i & 1]


def state_name(number: int) -> str:
    """Return the name of a state; its number where it has none."""
    return NAMES["state"].get(number, str(number))


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
    """Return the trigger of a text. Raises CamtoolsError: it is none; the line has the forms."""
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
