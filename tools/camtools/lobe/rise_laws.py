"""Rises from the base circle to the nose, over 0 .. 1: the flanks of lobes.

A new rise is one class with `evaluate`, which has the derivatives up to the third. Peaks Cv of the
speed and Ca of the acceleration are those of the handbooks (Norton; Rothbart).

| rise | Cv | Ca | continuous at both ends |
|---|---|---|---|
| `Quintic` (3-4-5) | 1.875 | 5.774 | acceleration; the jerk steps |
| `Cycloidal` | 2 | 6.283 | acceleration; the jerk steps |
| `ModifiedSine` | 1.760 | 5.528 | acceleration; the jerk steps |
| `ModifiedTrapezoid` | 2 | 4.888 | acceleration; the jerk steps |
| `Harmonic` | 1.571 | 4.935 | speed; the acceleration steps |
| `Polydyne` | 2.461 | 9.372 | acceleration; the jerk steps; of the driven mass alone |

>>> [f"{float(y[0]):.6f}" for y in Cycloidal().evaluate(np.array([0.25]))]
['0.090845', '1.000000', '6.283185', '0.000000']
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.polynomial import Polynomial

from camtools.base.quantities import Floats


class Rise(NamedTuple):
    """A rise of height 1 and its derivatives by the share of its angle."""

    y: Floats
    d1: Floats
    d2: Floats
    d3: Floats


class RiseLaw(Protocol):
    """A rise from 0 at 0 to 1 at 1, at rest at both ends."""

    def evaluate(self, x: Floats) -> Rise:
        """Return rise and derivatives at shares 0 .. 1."""


@dataclass(frozen=True)
class Quintic:
    """The 3-4-5 polynomial. Source: MATHS.md (37)."""

    def evaluate(self, x: Floats) -> Rise:
        """See `RiseLaw.evaluate`."""
        return _polynomial(x, Polynomial([0, 0, 0, 10, -15, 6]))


@dataclass(frozen=True)
class Cycloidal:
    """The acceleration is one wave of a sine. Source: MATHS.md (89)."""

    def evaluate(self, x: Floats) -> Rise:
        """See `RiseLaw.evaluate`."""
        turn = 2 * np.pi * x
        sin, cos = np.sin(turn), np.cos(turn)
        return Rise(x - sin / (2 * np.pi), 1 - cos, 2 * np.pi * sin, 4 * np.pi**2 * cos)


@dataclass(frozen=True)
class Harmonic:
    """Half a wave of a cosine: the acceleration steps where the rise begins and ends."""

    def evaluate(self, x: Floats) -> Rise:
        """See `RiseLaw.evaluate`. Source: MATHS.md (89)."""
        sin, cos = np.sin(np.pi * x), np.cos(np.pi * x)
        return Rise((1 - cos) / 2, np.pi / 2 * sin, np.pi**2 / 2 * cos, -(np.pi**3) / 2 * sin)


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


@dataclass(frozen=True)
class ModifiedSine:
    """A quarter of a fast wave, half of a slow one, a quarter of the fast one: MATHS.md (90)."""

    def evaluate(self, x: Floats) -> Rise:
        """See `RiseLaw.evaluate`."""
        waves = (
            _Wave(0.125, 0, 1, _FAST, 0),
            _Wave(0.875, 0, 1, _SLOW, np.pi / 3),
            _Wave(1.0, 0, 1, _FAST, 0),
        )
        return _integrated(x, waves)


@dataclass(frozen=True)
class ModifiedTrapezoid:
    """A trapezoid of acceleration whose flanks are eighths of a sine: MATHS.md (91)."""

    def evaluate(self, x: Floats) -> Rise:
        """See `RiseLaw.evaluate`."""
        waves = (
            _Wave(0.125, 0, 1, _FAST, 0),
            _Wave(0.375, 1, 0, _FAST, 0),
            _Wave(0.625, 0, 1, _FAST, -np.pi),
            _Wave(0.875, -1, 0, _FAST, 0),
            _Wave(1.0, 0, 1, _FAST, 0),
        )
        return _integrated(x, waves)


_DRIVEN = Polynomial([0, 0, 0, 0, 0, 126, -420, 540, -315, 70])


@dataclass(frozen=True)
class Polydyne:
    """The lift that lets an elastic follower move by a polynomial: MATHS.md (92).

    Attributes
    ----------
    deflection : float
        Lift that deflects the follower over the acceleration of its mass, in the square of the
        angle of the rise: (speed of the cam / natural frequency / angle of the rise)^2.
    """

    deflection: float

    def evaluate(self, x: Floats) -> Rise:
        """See `RiseLaw.evaluate`."""
        return _polynomial(x, _DRIVEN + self.deflection * _DRIVEN.deriv(2))


def _polynomial(x: Floats, law: Polynomial) -> Rise:
    return Rise(law(x), law.deriv(1)(x), law.deriv(2)(x), law.deriv(3)(x))
