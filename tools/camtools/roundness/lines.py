# SPDX-License-Identifier: Apache-2.0
"""Straightness of profiles along the axis by ISO 12780, MATHS.md (205).

>>> z_mm = np.linspace(0, 60, 601)
>>> found = straightness(z_mm, 1e-3 * (z_mm / 60 + (z_mm / 30 - 1) ** 2))
>>> f"{found.total_mm * 1e3:.3f} {found.zone_mm * 1e3:.3f} {found.slope * 60e3:.3f}"
'1.000 1.000 1.000'
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camtools.base.quantities import Floats
from camtools.roundness.simplex import solve


class Straightness(NamedTuple):
    """Parameters of ISO 12780-1, all along the radius [mm]."""

    total_mm: float  # STRt about the least-squares line: peak to valley
    peak_mm: float  # STRp
    valley_mm: float  # STRv, above 0
    q_mm: float  # STRq: root mean square
    zone_mm: float  # STRt of the minimum zone
    middle_mm: float  # least-squares line at the mean height
    slope: float  # of that line, mm per mm


def straightness(z_mm: Floats, value_mm: Floats) -> Straightness:
    """Return the straightness of a profile of at least three heights.

    Parameters
    ----------
    z_mm, value_mm : ndarray, shape (n,)
        Heights, rising, and radii or deviations of them.
    """
    middle_mm = float(z_mm.mean())
    slope, level_mm = (float(one) for one in np.polyfit(z_mm - middle_mm, value_mm, 1))
    off_mm = value_mm - level_mm - slope * (z_mm - middle_mm)
    return Straightness(
        float(np.ptp(off_mm)),
        float(off_mm.max()),
        float(-off_mm.min()),
        float(np.sqrt(np.mean(off_mm**2))),
        _zone_mm(z_mm, off_mm),
        level_mm,
        slope,
    )


def _zone_mm(z_mm: Floats, off_mm: Floats) -> float:
    """Return the least distance, along the radius, of two parallel lines around a profile [mm]."""
    n = z_mm.size
    share = 2 * (z_mm - z_mm[0]) / (z_mm[-1] - z_mm[0]) - 1
    ones = np.ones(n)
    above = np.stack([ones, share, ones], axis=1)
    below = np.stack([-ones, -share, ones], axis=1)
    rows, least = np.concatenate([above, below]), np.concatenate([off_mm, -off_mm])
    begin = [0, n - 1, n + n // 2]
    level_mm, slope_mm, _ = solve(rows, least, np.array([0.0, 0.0, 1.0]), begin)
    return float(np.ptp(off_mm - level_mm - slope_mm * share))
