"""Curves over the height that go on beyond an end, and those of a skirt with its ring belt.

>>> from camtools.skirt.geometry.profile import constant_spline
>>> land = PPoly(np.array([[0.0], [0.0], [-0.1], [45.0]]), [12.0, 14.0])
>>> both = belted([constant_spline(46.0, 0.0, 10.0), land])
>>> both.x.tolist(), [round(float(both(z)), 3) for z in (10.5, 11.5, 13.0)]
([0.0, 10.0, 11.0, 12.0, 14.0], [46.0, 45.05, 44.9])
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from scipy.interpolate import PPoly

from camtools.base.quantities import Floats
from camtools.skirt.geometry.corrected import piece_from

PLACES = 65  # of a run, where it is looked at


def _fading(spline: PPoly, end_mm: float, run_mm: float) -> Floats:
    """Return the run's cubic from its lower end on: tangent, its curvature fades to 0, (102)."""
    value, slope, bend = (float(spline(end_mm, nu=n)) for n in range(3))
    run = abs(run_mm)
    d = np.poly1d([1.0, min(run_mm, 0.0)])  # from the end, over the height above the lower end
    sign = 1.0 if run_mm > 0 else -1.0
    found = value + slope * d + bend * (d**2 / 2 - sign * d**3 / (6 * run))
    return np.pad(found.coeffs, (4 - len(found.coeffs), 0))


def on_heights(spline: PPoly, ends_mm: tuple[float, float]) -> PPoly:
    """Return a curve between two heights that it covers, as cubics."""
    inside = (spline.x > ends_mm[0]) & (spline.x < ends_mm[1])
    x = np.concatenate([ends_mm[:1], spline.x[inside], ends_mm[1:]])
    return PPoly(np.array([piece_from(spline, float(low)) for low in x[:-1]]).T, x)


def continued(
    spline: PPoly,
    ends_mm: tuple[float, float],
    runs_mm: Sequence[float],
    *,
    is_ovality: bool = False,
) -> PPoly:
    """Return a curve over height, continued beyond its ends.

    Tangentially, with a curvature that fades; an ovality that would fall below 0 stays.
    """
    own = on_heights(spline, ends_mm)
    x, columns = own.x, list(own.c.T)
    for end_mm, run_mm in zip(ends_mm, (-runs_mm[0], runs_mm[1]), strict=True):
        if run_mm == 0:
            continue
        piece = _fading(spline, end_mm, run_mm)
        along_mm = np.linspace(0, abs(run_mm), PLACES)
        if is_ovality and np.polyval(piece, along_mm).min() < 0:
            piece = np.array([0.0, 0.0, 0.0, float(spline(end_mm))])
        x = np.append(x, end_mm + run_mm) if run_mm > 0 else np.append(end_mm + run_mm, x)
        columns = [*columns, piece] if run_mm > 0 else [piece, *columns]
    return PPoly(np.array(columns).T, x)


def belted(bands: Sequence[PPoly], *, is_ovality: bool = False) -> PPoly:
    """Return a curve of several bands, rising, each continued to the middle of the grooves.

    It jumps there. Each band is a cubic spline over its own heights.
    """
    ends = [(float(band.x[0]), float(band.x[-1])) for band in bands]
    halves = [(above[0] - below[1]) / 2 for below, above in pairwise(ends)]
    runs = zip([0.0, *halves], [*halves, 0.0], strict=True)
    grown = [
        continued(band, end, run, is_ovality=is_ovality)
        for band, end, run in zip(bands, ends, runs, strict=True)
    ]
    x = np.concatenate([*(band.x[:-1] for band in grown), grown[-1].x[-1:]])
    return PPoly(np.concatenate([band.c for band in grown], axis=1), x)
