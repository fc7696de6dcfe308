"""Curves through points over height, and how far they leave the values of their points.

linear   a polygon
pchip    monotone between any two points, continuous slope, MATHS.md (72)
akima    close to the polygon, continuous slope, little overshoot
spline   cubic, continuous curvature, not-a-knot unless told otherwise, MATHS.md (6)

>>> round(overshoot(through([0, 2, 10, 20], [91, 91.95, 91.985, 92], "spline")).beyond, 3)
0.776
>>> overshoot(through([0, 2, 10, 20], [91, 91.95, 91.985, 92], "pchip")).beyond
0.0
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np
from scipy.interpolate import Akima1DInterpolator, CubicSpline, PchipInterpolator, PPoly

from camtools.base.quantities import Floats

Interpolation = Literal["linear", "pchip", "akima", "spline"]


class Overshoot(NamedTuple):
    """Where a curve leaves the values of its two neighbouring points most."""

    beyond: float  # unit of the curve; 0: nowhere
    z_mm: float
    low_mm: float  # the two points
    high_mm: float


def through(
    z_mm: Sequence[float] | Floats,
    values: Sequence[float] | Floats,
    interpolation: str,
    ends: object = "not-a-knot",
) -> PPoly:
    """Return the curve through points as cubics over height.

    Parameters
    ----------
    ends : object
        End conditions of a spline, as `CubicSpline` takes them.
    """
    z, v = np.asarray(z_mm, dtype=np.float64), np.asarray(values, dtype=np.float64)
    if interpolation == "spline":
        return CubicSpline(z, v, bc_type=ends)
    if interpolation == "linear" or z.size == 2:
        zero = np.zeros(z.size - 1)
        return PPoly(np.array([zero, zero, np.diff(v) / np.diff(z), v[:-1]]), z)
    curve = {"pchip": PchipInterpolator, "akima": Akima1DInterpolator}[interpolation](z, v)
    return PPoly(curve.c, curve.x)


def overshoot(curve: PPoly, points_mm: Floats | None = None) -> Overshoot:
    """Return where a curve leaves the values of two neighbouring points most, MATHS.md (73).

    Parameters
    ----------
    points_mm : ndarray, optional
        Heights of the points, rising; by default the ends of the curve's pieces.
    """
    z = np.asarray(curve.x if points_mm is None else points_mm, dtype=np.float64)
    turning = curve.derivative().roots(extrapolate=False)
    places = turning[np.isfinite(turning) & (turning > z[0]) & (turning < z[-1])]
    if not places.size:
        return Overshoot(0.0, float(z[0]), float(z[0]), float(z[-1]))
    i = np.clip(np.searchsorted(z, places, side="right") - 1, 0, z.size - 2)
    at_points, there = curve(z), curve(places)
    above = there - np.maximum(at_points[i], at_points[i + 1])
    below = np.minimum(at_points[i], at_points[i + 1]) - there
    beyond = np.maximum(above, below)
    worst = int(np.argmax(beyond))
    around = float(z[i[worst]]), float(z[i[worst] + 1])
    return Overshoot(max(0.0, float(beyond[worst])), float(places[worst]), *around)
