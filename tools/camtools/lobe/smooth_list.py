# SPDX-License-Identifier: Apache-2.0
"""Lists of lift that are smoothed within a band, and how to find the band that a list needs.

>>> angle_deg = np.arange(0.0, 360.0)
>>> lift_mm = np.round(4 - 4 * np.cos(np.radians(angle_deg)), 3)
>>> found = smooth_list(angle_deg, lift_mm, 0.5)
>>> f"{found.largest_um:.2f}", f"{peaks_of(found.before).acceleration:.2f}"
('0.50', '12.58')
>>> f"{peaks_of(found.after).acceleration:.2f}"
'4.00'
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from camtools.base.quantities import Floats
from camtools.lobe.lobe_keys import is_turn
from camtools.part.smoothing import bands_um, first_enough, smoothed
from camtools.table.points import PointedTurn

_UM_PER_MM = 1000.0
_PER_STEP = 16  # angles between two points at which peaks are sought


class PeaksOfList(NamedTuple):
    """Largest magnitudes over a turn."""

    acceleration: float  # mm/rad^2
    jerk: float  # mm/rad^3


class Smoothing(NamedTuple):
    """A list within its band, and the curves through it."""

    band_um: float
    angle_deg: Floats  # of the points, degrees of the cam
    off_um: Floats  # smoothed less listed lift
    before: BSpline  # lift [mm] over the angle [rad] through the listed points
    after: BSpline  # through the smoothed ones

    @property
    def largest_um(self) -> float:
        """Return the largest residual."""
        return float(np.abs(self.off_um).max())


def periodic_spline(angle_deg: Floats, lift_mm: Floats) -> BSpline:
    """Return the periodic quintic spline through points of one turn.

    Parameters
    ----------
    angle_deg, lift_mm : ndarray, shape (n,)
        Rising angles that span at most a turn; where they span it, both ends have the same lift.
    """
    n = lift_mm.size - is_turn(angle_deg[-1] - angle_deg[0])
    # the end is made from the beginning: written out, both differ in the last digits
    angle_deg = np.append(angle_deg[:n], angle_deg[0] + 360)
    lift_mm = np.append(lift_mm[:n], lift_mm[0])
    return make_interp_spline(np.radians(angle_deg), lift_mm, k=5, bc_type="periodic")


def smooth_list(angle_deg: Floats, lift_mm: Floats, band_um: float) -> Smoothing:
    """Return a list with the least third derivative within a band; points of lift 0 stay 0.

    Parameters
    ----------
    angle_deg, lift_mm : ndarray, shape (n,)
        Points of one turn without a repeated end.
    band_um : float
        How far a lift may move to either side.
    """
    held = lift_mm == 0
    found_mm = smoothed(angle_deg, lift_mm, band_um / _UM_PER_MM, period=360.0, held=held)
    off_um = (found_mm - lift_mm) * _UM_PER_MM
    curves = (periodic_spline(angle_deg, mm) for mm in (lift_mm, found_mm))
    return Smoothing(band_um, angle_deg, off_um, *curves)


def peaks_of(curve: BSpline) -> PeaksOfList:
    """Return the peaks of a periodic quintic."""
    knots = curve.t[curve.k : -curve.k]
    x = np.linspace(knots[:-1], knots[1:], _PER_STEP, axis=-1).ravel()
    return PeaksOfList(*(float(np.abs(curve(x, nu=n)).max()) for n in (2, 3)))


def bands_of(points: PointedTurn) -> list[float]:
    """Return bands [um] that may remove the noise of a list, rising; none without noise."""
    return [] if points.v.size else bands_um(points.x_deg, points.y_mm, 360.0)


def band_for(points: PointedTurn) -> Smoothing | None:
    """Return the smoothing that a list without one needs; None where it needs none."""

    def peaks(one: Smoothing) -> tuple[float, float]:
        return peaks_of(one.before).acceleration, peaks_of(one.after).acceleration

    def smooth(band_um: float) -> Smoothing:
        return smooth_list(points.x_deg, points.y_mm, band_um)

    return first_enough(bands_of(points), smooth, peaks)
