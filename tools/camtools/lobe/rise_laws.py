"""Rises from the base circle to the nose, over 0 .. 1: the flanks of lobes.

A new rise is one function in `_RISES`, which gives the derivatives up to the third. Peaks Cv of the
speed and Ca of the acceleration are those of the handbooks (Norton; Rothbart).

| rise | Cv | Ca | continuous at both ends |
|---|---|---|---|
| poly345 | 1.875 | 5.774 | acceleration; the jerk steps |
| cycloidal | 2 | 6.283 | acceleration; the jerk steps |
| modified-sine | 1.760 | 5.528 | acceleration; the jerk steps |
| modified-trapezoid | 2 | 4.888 | acceleration; the jerk steps |
| harmonic | 1.571 | 4.935 | speed; the acceleration steps |
| polydyne | 2.461 | 9.372 | acceleration; the jerk steps; of the driven mass alone |

>>> [f"{float(y[0]):.6f}" for y in RiseLaw("cycloidal").evaluate(np.array([0.25]))]
['0.090845', '1.000000', '6.283185', '0.000000']
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Polynomial

from camtools.base.quantities import Floats


class Rise(NamedTuple):
    """A rise of height 1 and its derivatives by the share of its angle."""

    y: Floats
    d1: Floats
    d2: Floats
    d3: Floats


def _cycloidal(x: Floats) -> Rise:
    turn = 2 * np.pi * x
    sin, cos = np.sin(turn), np.cos(turn)
    return Rise(x - sin / (2 * np.pi), 1 - cos, 2 * np.pi * sin, 4 * np.pi**2 * cos)


def _harmonic(x: Floats) -> Rise:
    sin, cos = np.sin(np.pi * x), np.cos(np.pi * x)
    return Rise((1 - cos) / 2, np.pi / 2 * sin, np.pi**2 / 2 * cos, -(np.pi**3) / 2 * sin)


def _polynomial(x: Floats, law: Polynomial) -> Rise:
    return Rise(law(x), law.deriv(1)(x), law.deriv(2)(x), law.deriv(3)(x))


class _Wave(NamedTuple):
    """A piece of an acceleration: level + size sin(rate x + phase), up to an end."""

    end: float
    level: float
    size: float
    rate: float
    phase: float


def _integrated(x: Floats, waves: tuple[_Wave, ...]) -> Rise:
    """Return the rise whose acceleration is made of pieces, up to a factor that makes it end at 1.

    Speed and place of each piece continue those of the one before.
    """
    y, d1, d2, d3 = (np.zeros_like(x) for _ in range(4))
    begin = speed = place = 0.0
    for wave in waves:
        inside = (x >= begin) & (x <= wave.end)
        at = np.append(x[inside], wave.end)
        s, angle, before = at - begin, wave.rate * at + wave.phase, wave.rate * begin + wave.phase
        by = wave.size / wave.rate
        slope = speed + by * np.cos(before)
        rising = speed + wave.level * s - by * (np.cos(angle) - np.cos(before))
        risen = place + slope * s + wave.level * s**2 / 2
        risen -= by / wave.rate * (np.sin(angle) - np.sin(before))
        y[inside], d1[inside] = risen[:-1], rising[:-1]
        d2[inside] = wave.level + wave.size * np.sin(angle[:-1])
        d3[inside] = wave.size * wave.rate * np.cos(angle[:-1])
        begin, speed, place = wave.end, float(rising[-1]), float(risen[-1])
    return Rise(y / place, d1 / place, d2 / place, d3 / place)


_FAST, _SLOW = 4 * np.pi, 4 * np.pi / 3
_MODIFIED_SINE = (
    _Wave(0.125, 0, 1, _FAST, 0),
    _Wave(0.875, 0, 1, _SLOW, np.pi / 3),
    _Wave(1.0, 0, 1, _FAST, 0),
)
_MODIFIED_TRAPEZOID = (
    _Wave(0.125, 0, 1, _FAST, 0),
    _Wave(0.375, 1, 0, _FAST, 0),
    _Wave(0.625, 0, 1, _FAST, -np.pi),
    _Wave(0.875, -1, 0, _FAST, 0),
    _Wave(1.0, 0, 1, _FAST, 0),
)
_RISES: dict[str, Callable[[Floats], Rise]] = {  # MATHS.md (37), (89) .. (91)
    "poly345": partial(_polynomial, law=Polynomial([0, 0, 0, 10, -15, 6])),
    "cycloidal": _cycloidal,
    "harmonic": _harmonic,
    "modified-sine": partial(_integrated, waves=_MODIFIED_SINE),
    "modified-trapezoid": partial(_integrated, waves=_MODIFIED_TRAPEZOID),
}
_DRIVEN = Polynomial([0, 0, 0, 0, 0, 126, -420, 540, -315, 70])


@dataclass(frozen=True)
class RiseLaw:
    """A rise from 0 at 0 to 1 at 1, at rest at both ends.

    A polydyne rise lets an elastic follower move by a polynomial, MATHS.md (92). `deflection` is
    the lift that deflects the follower over the acceleration of its mass, in the square of the
    angle of the rise: (speed of the cam / natural frequency / angle of the rise)^2.
    """

    name: str
    deflection: float = 0.0

    def evaluate(self, x: Floats) -> Rise:
        """Return rise and derivatives at shares 0 .. 1."""
        if self.name == "polydyne":
            return _polynomial(x, _DRIVEN + self.deflection * _DRIVEN.deriv(2))
        return _RISES[self.name](x)
