"""Curves of a section in polar form: radius over the drawing's angle, with three derivatives.

A new curve is one class with `polar` and `reach`; nothing else has to know it.

>>> line = Line(10.0, 0.0)
>>> [f"{mm:.6f}" for mm in line.polar(np.radians([-30.0, 0.0, 60.0])).r]
['11.547005', '10.000000', '20.000000']
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

from camtools.base.quantities import Floats

HALF_TURN_RAD = np.pi
_REACH = 0.999  # share of the angle at which a curve turns its back to the axis
_GRID, _NEWTON_STEPS = 2049, 6


class Polar(NamedTuple):
    """Radius and its derivatives by the angle, shapes as the angles."""

    r: Floats  # mm
    d1: Floats  # mm/rad
    d2: Floats  # mm/rad^2
    d3: Floats  # mm/rad^3


class Reach(NamedTuple):
    """Angles [rad] between which a curve has one radius."""

    first: float
    last: float


class Curve(Protocol):
    """A smooth curve round the axis, or a piece of one."""

    def polar(self, phi_rad: Floats) -> Polar:
        """Return radius and derivatives at angles [rad] within the reach."""

    @property
    def reach(self) -> Reach:
        """Where `polar` may be asked; wider than the stretch of the section."""


def shifted(phi_rad: Floats, middle_rad: float) -> Floats:
    """Return angles counted from a direction, -pi .. pi."""
    return np.asarray(np.mod(phi_rad - middle_rad + np.pi, 2 * np.pi) - np.pi, dtype=np.float64)


@dataclass(frozen=True)
class Line:
    """A straight side, MATHS.md (113)."""

    distance_mm: float  # of the line from the axis
    normal_rad: float  # direction of the foot

    @property
    def reach(self) -> Reach:
        """See `Curve.reach`."""
        half = _REACH * HALF_TURN_RAD / 2
        return Reach(self.normal_rad - half, self.normal_rad + half)

    def polar(self, phi_rad: Floats) -> Polar:
        """See `Curve.polar`."""
        beta = shifted(phi_rad, self.normal_rad)
        r, t = self.distance_mm / np.cos(beta), np.tan(beta)
        return Polar(r, r * t, r * (2 * t**2 + 1), r * t * (6 * t**2 + 5))


@dataclass(frozen=True)
class CornerArc:
    """A circle round a centre that may lie off the axis, MATHS.md (114)."""

    centre_mm: float  # distance of the centre
    centre_rad: float  # and its direction
    radius_mm: float  # of the circle; the axis lies inside, or the far side of the circle is meant

    @property
    def reach(self) -> Reach:
        """See `Curve.reach`."""
        half = HALF_TURN_RAD
        if self.centre_mm > self.radius_mm:
            half = float(np.arcsin(self.radius_mm / self.centre_mm))
        return Reach(self.centre_rad - half, self.centre_rad + half)

    def polar(self, phi_rad: Floats) -> Polar:
        """See `Curve.polar`."""
        beta, d = shifted(phi_rad, self.centre_rad), self.centre_mm
        sin, cos = np.sin(beta), np.cos(beta)
        q = np.sqrt(self.radius_mm**2 - (d * sin) ** 2)
        q1 = -(d**2) * sin * cos / q
        q2 = (-(d**2) * (cos**2 - sin**2) - q1**2) / q
        q3 = (4 * d**2 * sin * cos - 3 * q1 * q2) / q
        return Polar(d * cos + q, q1 - d * sin, q2 - d * cos, q3 + d * sin)


@dataclass(frozen=True)
class Flank:
    """The contour of the standards, given by its distance from the axis, MATHS.md (115), (116).

    p(alpha) = mean - eccentricity cos(n alpha) is the distance of the tangent whose normal has
    the direction alpha, counted from the middle of a side.
    """

    mean_mm: float  # mean distance of a tangent
    eccentricity_mm: float  # by how much it swings
    n: int  # number of sides
    middle_rad: float  # direction of the middle of a side

    @property
    def is_convex(self) -> bool:
        """Return whether the contour has no loops and needs no circle across its corners."""
        return self.mean_mm > (self.n**2 - 1) * self.eccentricity_mm

    @cached_property
    def _last_alpha(self) -> float:
        """Return the normal's direction up to which the angle grows with it."""
        if self.is_convex:
            return float(np.pi / self.n)
        return _REACH * float(np.arccos(-self.mean_mm / self._bend) / self.n)

    @property
    def _bend(self) -> float:
        return (self.n**2 - 1) * self.eccentricity_mm

    @property
    def reach(self) -> Reach:
        """See `Curve.reach`."""
        if self.is_convex:
            return Reach(self.middle_rad - HALF_TURN_RAD, self.middle_rad + HALF_TURN_RAD)
        half = min(float(self._angle(np.array([self._last_alpha]))[0]), HALF_TURN_RAD)
        return Reach(self.middle_rad - half, self.middle_rad + half)

    def support(self, alpha: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Return p and its derivatives by the normal's direction [mm]."""
        n, e = self.n, self.eccentricity_mm
        cos, sin = e * np.cos(n * alpha), e * np.sin(n * alpha)
        return self.mean_mm - cos, n * sin, n**2 * cos, -(n**3) * sin

    def _angle(self, alpha: Floats) -> Floats:
        p, p1, _, _ = self.support(alpha)
        return np.asarray(alpha + np.arctan2(p1, p), dtype=np.float64)

    def normal_at(self, beta: Floats) -> Floats:
        """Return the normal's direction at angles counted from the middle of a side, by Newton.

        The error left is rounding: the radius is exact to 1e-13 of itself.
        """
        grid = np.linspace(-self._last_alpha, self._last_alpha, _GRID)
        alpha = np.interp(beta, self._angle(grid), grid)
        for _ in range(_NEWTON_STEPS):
            p, p1, p2, _ = self.support(alpha)
            slope = p * (p + p2) / (p**2 + p1**2)
            alpha = alpha - (self._angle(alpha) - beta) / slope
        return np.asarray(alpha, dtype=np.float64)

    def polar(self, phi_rad: Floats) -> Polar:
        """See `Curve.polar`."""
        beta = shifted(phi_rad, self.middle_rad)
        if self.is_convex:
            pitch = 2 * np.pi / self.n
            beta = np.mod(beta + pitch / 2, pitch) - pitch / 2
        p, p1, p2, p3 = self.support(self.normal_at(beta))
        square, bend = p**2 + p1**2, p + p2
        top, bottom = (p * p2 - p1**2) * square, p**3 * bend
        top1 = (p * p3 - p1 * p2) * square + (p * p2 - p1**2) * 2 * p1 * bend
        bottom1 = 3 * p**2 * p1 * bend + p**3 * (p1 + p3)
        # derivatives of log r by the angle: dphi / dalpha = p (p + p'') / (p^2 + p'^2)
        g1, g2 = p1 / p, top / bottom
        g3 = (top1 - g2 * bottom1) / bottom * square / (p * bend)
        r = np.sqrt(square)
        return Polar(r, r * g1, r * (g1**2 + g2), r * (g1**3 + 3 * g1 * g2 + g3))
