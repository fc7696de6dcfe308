"""What u and the spindle speed of one table do together.

>>> MotionPeaks(1.0, 0.0, 0.15, 0.3).ratio
1.0
"""

from __future__ import annotations

from dataclasses import replace
from math import ceil
from typing import NamedTuple

import numpy as np

from camtools.base.quantities import Floats
from camtools.table.channel import RATIO_ONE, Bounds, Channel
from camtools.table.evaluate import evaluate_grid

_PLACES_PER_KNOT = 8
_PEAK_MARGIN = 1.002  # between the places, and the firmware's rounding
_HEIGHTS_BETWEEN = 4


class MotionPeaks(NamedTuple):
    """Peaks of a table with modulation, per mean speed and its square."""

    ratio: float
    spindle_rad2: float  # |r r'|
    first: float  # |y' r| of the other channel y, in its unit
    second: float  # |y'' r^2 + y' r r'|


def _common_grid(channel: Channel, n_places: int) -> Floats:
    per_knot = n_places // channel.knots.shape[1]
    return np.asarray(np.arange(per_knot) / per_knot, dtype=np.float64)


def peaks_together(y: Channel, speed: Channel) -> MotionPeaks:
    """Return what a channel of an axis and the spindle's speed do together.

    They are looked at on a grid finer than the knots of either.
    """
    n = _PLACES_PER_KNOT * max(y.knots.shape[1], speed.knots.shape[1])
    n_z = _HEIGHTS_BETWEEN * max(y.n_slices, speed.n_slices) + 1
    z_nm = np.linspace(y.z_first_nm, y.z_last_nm, n_z)
    if y.has_patterns:
        z_nm = np.arange(y.n_slices, dtype=np.float64)
    found = np.zeros(4)
    for some in np.array_split(z_nm, max(1, z_nm.size * n // 500_000)):
        motion = evaluate_grid(y, some, _common_grid(y, n))
        ratio = evaluate_grid(speed, some, _common_grid(speed, n))
        r, r1 = ratio.value / RATIO_ONE, ratio.d1 / RATIO_ONE
        here = (r, r * r1, motion.d1 * r, motion.d2 * r**2 + motion.d1 * r * r1)
        found = np.maximum(found, [float(np.abs(one).max()) for one in here])
    return MotionPeaks(*(float(one) * _PEAK_MARGIN for one in found))


def moving_bounds(uniform: Bounds, peaks: MotionPeaks) -> Bounds:
    """Return the bounds of u where the spindle is modulated: TABLE_FORMAT.md, header."""
    return replace(
        uniform,
        u1_peak_nm_per_rad=ceil(peaks.first),
        u2_peak_nm_per_rad2=ceil(peaks.second),
        spindle_peak_ppm_per_rad=ceil(peaks.spindle_rad2 * 1e6),
    )
