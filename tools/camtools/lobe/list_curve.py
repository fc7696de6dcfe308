"""The curve through a list whose acceleration steps between points, as where arcs of circles join.

A spline of four continuous derivatives rings about such a step: over some points its curvature is
far from that of both arcs. Where a list has a step, the curve has one.

>>> deg = np.arange(360.0)
>>> law = spline_through(deg, 2 * np.clip(np.radians(np.abs(deg - 180.4) - 90), 0, None) ** 2)
>>> [f"{abs(law(np.radians(at), nu=2)):.3f}" for at in (90, 91, 180, 270, 271)]
['4.000', '0.000', '0.000', '0.000', '4.000']
"""

from typing import NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from scipy.interpolate import BSpline, make_interp_spline
from scipy.sparse import csc_array
from scipy.sparse.linalg import spsolve

from camtools.base.quantities import Bools, Floats
from camtools.base.solvers import unsolved
from camtools.lobe.part import is_turn
from camtools.part.smoothing import noise_of

_K = 5
_SIDE = _K + 1  # points on either side, by which a step is found
_FREE = 2  # points on either side of a step that are no knots
_CALM = 10.0  # a step is so many times what the acceleration changes by from point to point
_NOISE = 100.0  # and, times the square of the points' distance, the noise of the lifts
_WIDTH = 0.005  # of what is no step: half the variance of the points' distances that it takes
_SLACK = 0.1  # of that distance: where a step may be beside its two points
_UNEVEN = 2.0


class Step(NamedTuple):
    """A step of the acceleration, between the points `after` and the next one."""

    after: int
    place: float  # of the angle, in units of the list
    doubt: float  # 0 of a step, 1 at the limit


def steps_of(x: Floats, y: Floats, period: float) -> list[Step]:
    """Return the steps of the second derivative of periodic points, rising."""
    if x.size < 4 * _SIDE:
        return []
    h = np.diff(x, append=x[0] + period)
    slopes = np.diff(y, append=y[0]) / h
    bends = 2 * (slopes - np.roll(slopes, 1)) / (h + np.roll(h, 1))
    is_candidate = _candidates(bends, h, _NOISE * noise_of(x, y, period))
    found = [_step(x, y, int(i), period) for i in np.flatnonzero(is_candidate)]
    best: list[Step] = []
    for step in sorted((step for step in found if step is not None), key=lambda step: step.doubt):
        off = [(step.after - other.after) % x.size for other in best]
        if all(_SIDE <= n <= x.size - _SIDE for n in off):
            best.append(step)
    return sorted(best)


def _candidates(bends: Floats, h: Floats, least: float) -> Bools:
    """Return the points after which the acceleration changes suddenly, calm before and after.

    Over the square of the points' distance it changes by more than a `least` lift.
    """

    def at(values: Floats, by: int) -> Floats:
        return np.roll(values, -by)

    changes = np.abs(np.diff(bends, append=bends[0]))
    calm = np.max([at(changes, by) for by in (-3, -2, 2, 3)], axis=0)
    near = np.stack([at(h, by) for by in range(1 - _SIDE, _SIDE)])
    is_even = near.max(axis=0) <= _UNEVEN * near.min(axis=0)
    size = np.abs(at(bends, 2) - at(bends, -1))
    return np.asarray((size > _CALM * calm) & (size * h**2 > least) & is_even)


def _step(x: Floats, y: Floats, i: int, period: float) -> Step | None:
    """Return the step after a point, if the curves on either side have one tangent there."""
    near = np.arange(i + 1 - _SIDE, i + 1 + _SIDE)
    unit = float((x[(i + 1) % x.size] - x[i]) % period)
    u = ((x[near % x.size] - x[i] + period / 2) % period - period / 2) / unit
    values = y[near % x.size]
    before, after = (
        Polynomial(np.polynomial.polynomial.polyfit(u[side], values[side], _K))
        for side in (slice(None, _SIDE), slice(_SIDE, None))
    )
    gap = after - before
    roots = gap.deriv().roots()
    inside = roots[np.isreal(roots)].real
    inside = inside[(inside >= -_SLACK) & (inside <= 1 + _SLACK)]
    if inside.size != 1:
        return None
    at = float(inside[0])
    left, most = abs(float(gap(at))), _WIDTH * abs(float(gap.deriv(2)(at)))
    return Step(i, float(x[i] + at * unit), left / most) if left < most else None


def periodic_spline(angle_deg: Floats, lift_mm: Floats) -> BSpline:
    """Return the periodic quintic spline through points whose angles span a turn at most.

    Where they span it, both ends have the same lift.
    """
    n = lift_mm.size - is_turn(angle_deg[-1] - angle_deg[0])
    # the end is made from the beginning: written out, both differ in the last digits
    angle_deg = np.append(angle_deg[:n], angle_deg[0] + 360)
    lift_mm = np.append(lift_mm[:n], lift_mm[0])
    return make_interp_spline(np.radians(angle_deg), lift_mm, k=5, bc_type="periodic")


def spline_through(angle_deg: Floats, lift_mm: Floats) -> BSpline:
    """Return `periodic_spline` through points of a turn, its end not repeated, with their steps.

    At a step value and slope are continuous; the points next to it are no knots. Raises
    CamtoolsError where the points and knots allow no such curve.
    """
    x = np.radians(angle_deg)
    steps = steps_of(x, lift_mm, 2 * np.pi)
    if not steps:
        return periodic_spline(angle_deg, lift_mm)
    free = [(step.after + by) % x.size for step in steps for by in range(1 - _FREE, 1 + _FREE)]
    places = [step.place for step in steps for _ in range(_K - 1)]
    knots = np.sort(np.append(np.delete(x, free), places))
    n = knots.size
    around = np.arange(-_K, n + _K + 1)
    t = knots[around % n] + 2 * np.pi * (around // n)
    at = np.where(x < knots[0], x + 2 * np.pi, x)
    rows = BSpline.design_matrix(at, t, _K).tocoo()
    matrix = csc_array((rows.data, (rows.row, rows.col % n)), shape=(n, n))
    c = spsolve(matrix, lift_mm)
    if not np.isfinite(c).all():
        raise unsolved("cam.lobe: curve of the list")
    return BSpline(t, np.append(c, c[:_K]), _K, extrapolate="periodic")
