# SPDX-License-Identifier: Apache-2.0
"""Numbers as people read them: fixed decimals, a sign that takes its place, a unit at each.

>>> signed(0.5, 4), signed(-0.00001, 4), plain(None, 1) == NOTHING
('+0.5000', '+0.0000', True)
>>> clock(3725.4), clock(59.6)
('1:02:05', '1:00')
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite

NOTHING = "\N{EN DASH}"
_MINUS = "\N{MINUS SIGN}"  # as wide as a plus, unlike the hyphen
_UM_PER_MM = 1e3


def _digits(value: float, decimals: int) -> str:
    return f"{abs(value):.{decimals}f}"


def _is_negative(value: float, decimals: int) -> bool:
    """Whether a value is below 0 as it is shown: no minus stands in front of zeros."""
    return value < 0 and float(_digits(value, decimals)) > 0


def signed(value: float | None, decimals: int) -> str:
    """Return a number with its sign, so that its width does not depend on it."""
    if value is None or not isfinite(value):
        return NOTHING
    return f"{_MINUS if _is_negative(value, decimals) else '+'}{_digits(value, decimals)}"


def plain(value: float | None, decimals: int) -> str:
    """Return a number with a minus only where it is below 0."""
    if value is None or not isfinite(value):
        return NOTHING
    return f"{_MINUS if _is_negative(value, decimals) else ''}{_digits(value, decimals)}"


def clock(seconds: float | None) -> str:
    """Return a time as minutes and seconds, with hours where there are any."""
    if seconds is None or not isfinite(seconds):
        return NOTHING
    whole = max(0, round(seconds))
    minutes, s = divmod(whole, 60)
    hours, m = divmod(minutes, 60)
    return f"{hours}:{m:02d}:{s:02d}" if hours else f"{m}:{s:02d}"


@dataclass(frozen=True)
class Field:
    """A number of the status.

    Attributes
    ----------
    label, unit : str
        for people
    decimals : int
    """

    key: str  # stable name, also of the test
    label: str
    unit: str
    signal: str  # of the DBC
    decimals: int
    factor: float = 1.0  # that unit per unit of the signal
    is_signed: bool = False  # a plus stands in front of what is not negative

    def text(self, signals: Mapping[str, float]) -> str:
        """Return the number as it is shown."""
        value = signals.get(self.signal)
        scaled = None if value is None else value * self.factor
        return (signed if self.is_signed else plain)(scaled, self.decimals)


SPEED = Field("speed", "Spindle speed", "r/min", "speed", 1)
ANGLE = Field("angle", "Angle of the drawing", "°", "angle", 1)
U_SET = Field("u-set", "U set", "mm", "u_set", 4, is_signed=True)
U_ACTUAL = Field("u-actual", "U actual", "mm", "u_actual", 4, is_signed=True)
FOLLOWING = Field(
    "following", "Following error", "µm", "following_error", 2, _UM_PER_MM, is_signed=True
)
X_RADIUS = Field("x-radius", "X radius", "mm", "x", 4)
X_DIAMETER = Field("x-diameter", "X diameter ⌀", "mm", "x", 4, 2.0)
Z_HEIGHT = Field("z", "Z height", "mm", "z", 3, is_signed=True)
PARTS = Field("parts", "Parts cut", "parts", "parts_cut", 0)
LATE_TICKS = Field("tick-late", "Late ticks", "ticks", "late_ticks", 0)
AXES = (U_SET, U_ACTUAL, Z_HEIGHT, X_RADIUS, X_DIAMETER)


def homed_text(signals: Mapping[str, float]) -> str:
    """Return which axes have their home.

    >>> homed_text({"homed_x": 1.0, "homed_z": 0.0})
    'U not homed, X homed, Z not homed'
    """
    marks = ((axis.upper(), signals.get(f"homed_{axis}", 0.0)) for axis in "uxz")
    return ", ".join(f"{axis} {'homed' if is_so else 'not homed'}" for axis, is_so in marks)


def pass_text(signals: Mapping[str, float]) -> str:
    """Return the pass that is cut, or that the next start cuts; "" for a table of one.

    >>> pass_text({"pass": 2.0, "passes": 3.0})
    'pass 2 of 3'
    """
    n = int(signals.get("passes", 0.0))
    return f"pass {int(signals.get('pass', 0.0))} of {n}" if n else ""
