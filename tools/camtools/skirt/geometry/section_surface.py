"""The surface through sections that are known at the same angles at every height.

Over the angle a periodic quintic spline runs through the values of each height; over the height
each angle's values are joined as `curves.through` joins points. Both are told by knots: value and
two derivatives by the turn at each break and height, and the same of the slope over the height,
from which every piece follows, MATHS.md (19).

>>> turn = np.arange(12) / 12
>>> flat = surface_through(turn, np.array([0.0, 10.0]), np.full((2, 12), 0.25), "linear")
>>> flat.delta(np.array([0.1, 2.0]), 5.0).delta.round(12).tolist()
[0.25, 0.25]
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import (
    Akima1DInterpolator,
    CubicSpline,
    PchipInterpolator,
    make_interp_spline,
)

from camtools.base.quantities import Floats
from camtools.skirt.geometry.poly_surface import N_ANGLE, N_HEIGHT, Knots, PolySurface
from camtools.skirt.part.curves import Overshoot

# a quintic by its value and two derivatives at both ends, and a cubic by value and slope
_QUINTIC = np.array(
    [
        [1, 0, 0, 0, 0, 0],
        [0, 1, 0, 0, 0, 0],
        [0, 0, 0.5, 0, 0, 0],
        [-10, -6, -1.5, 10, -4, 0.5],
        [15, 8, 1.5, -15, 7, -1],
        [-6, -3, -0.5, 6, -3, 0.5],
    ]
)
_CUBIC = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [-3, -2, 3, -1], [2, 1, -2, 1]])


def _slopes(z_mm: Floats, values: Floats, interpolation: str) -> Floats | None:
    """Return dv/dz at all heights for each angle; nothing for straight lines."""
    if interpolation == "linear":
        return None
    if interpolation == "spline":
        return np.asarray(CubicSpline(z_mm, values, axis=0)(z_mm, 1), dtype=np.float64)
    kind = PchipInterpolator if interpolation == "pchip" else Akima1DInterpolator
    return np.asarray(kind(z_mm, values, axis=0)(z_mm, 1), dtype=np.float64)


def _knots(turn: Floats, values: Floats, breaks: Floats) -> Floats:
    """Return value and two derivatives of periodic splines at breaks, shape (m, n, 3)."""
    closed = np.vstack([values.T, values[:, :1].T])
    spline = make_interp_spline(np.append(turn, turn[0] + 1), closed, k=5, bc_type="periodic")
    at = breaks[:-1] + (breaks[:-1] < turn[0])
    return np.stack([spline(at, nu=k).T for k in range(3)], axis=-1)


def _angle_pieces(knots: Floats, breaks: Floats) -> Floats:
    """Return quintics (m, n, 6) in t = 0 .. 1 between knots (m, n, 3)."""
    width = np.diff(breaks)[:, None]
    scale = width ** np.arange(3)
    ends = np.concatenate([knots * scale, np.roll(knots, -1, axis=1) * scale], axis=-1)
    return np.asarray(ends @ _QUINTIC.T, dtype=np.float64)


def _pieces(knots: Knots, breaks: Floats, z_mm: Floats) -> Floats:
    """Return all coefficients (m - 1, n, 6, 8)."""
    at = _angle_pieces(knots.values, breaks)
    found = np.zeros((z_mm.size - 1, breaks.size - 1, N_ANGLE, N_HEIGHT))
    if knots.slopes is None:
        found[..., 0], found[..., 1] = at[:-1], np.diff(at, axis=0)
        return found
    rising = _angle_pieces(knots.slopes, breaks)
    dz = np.diff(z_mm)[:, None, None]
    ends = np.stack([at[:-1], rising[:-1] * dz, at[1:], rising[1:] * dz], axis=-1)
    found[..., :4] = ends @ _CUBIC.T
    return found


def surface_through(
    turn: Floats, z_mm: Floats, values_mm: Floats, interpolation: str
) -> PolySurface:
    """Return the surface through values at angles and heights; one height serves all.

    Parameters
    ----------
    turn, z_mm : ndarray, shape (n,), (m,)
        Rising angles 0 .. 1 and heights.
    values_mm : ndarray, shape (m, n)
        Radius reductions.
    interpolation : str
        linear | pchip | akima | spline, between the heights.
    """
    if z_mm.size == 1:
        z_mm, interpolation = z_mm[0] + np.array([-1.0, 1.0]), "linear"
        values_mm = np.vstack([values_mm, values_mm])
    breaks = np.unique(np.concatenate([[0.0, 1.0], np.mod(turn, 1.0)]))
    slopes = _slopes(z_mm, values_mm, interpolation)
    knots = Knots(
        _knots(turn, values_mm, breaks), None if slopes is None else _knots(turn, slopes, breaks)
    )
    return PolySurface(breaks, z_mm, _pieces(knots, breaks, z_mm), knots=knots)


def overshoot_between(z_mm: Floats, values: Floats, interpolation: str) -> tuple[Overshoot, int]:
    """Return where values leave those of their two heights most, and at which angle's index.

    As `curves.overshoot`, for each angle; MATHS.md (73).
    """
    nowhere = Overshoot(0.0, float(z_mm[0]), float(z_mm[0]), float(z_mm[-1])), 0
    slopes = _slopes(z_mm, values, interpolation) if z_mm.size > 1 else None
    if slopes is None:
        return nowhere
    dz = np.diff(z_mm)[:, None]
    ends = np.stack([values[:-1], slopes[:-1] * dz, values[1:], slopes[1:] * dz], axis=-1)
    c = ends @ _CUBIC.T  # (m - 1, n, 4), rising powers
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(c[..., 2] ** 2 - 3 * c[..., 3] * c[..., 1])
        places = [-c[..., 1] / (c[..., 2] + sign * root) for sign in (-1, 1)]
    beyond = np.zeros((2, *c.shape[:2]))
    for found, place in zip(beyond, places, strict=True):
        w = np.where(np.isfinite(place) & (place > 0) & (place < 1), place, 0.0)
        there = ((c[..., 3] * w + c[..., 2]) * w + c[..., 1]) * w + c[..., 0]
        above = there - np.maximum(values[:-1], values[1:])
        found[:] = np.maximum(above, np.minimum(values[:-1], values[1:]) - there)
    k, j, i = (int(one) for one in np.unravel_index(int(np.argmax(beyond)), beyond.shape))
    at = float(z_mm[j] + places[k][j, i] * (z_mm[j + 1] - z_mm[j]))
    largest = max(0.0, float(beyond[k, j, i]))
    return Overshoot(largest, at, float(z_mm[j]), float(z_mm[j + 1])), i
