"""Splines over the height of a part: long half axis, ovality, and what else varies with it.

>>> from camtools.skirt.part import example_part
>>> f"{profile_spline(example_part().piston.profile)(5.0):.9f}"
'45.983096898'
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.interpolate import CubicSpline, PPoly

from camtools.base.quantities import Floats
from camtools.skirt.part import Ovality, Profile
from camtools.skirt.power_law import PeakOvality, PowerProfile


def profile_spline(profile: Profile | PowerProfile) -> PPoly:
    """Return the long half axis a(z) [mm] as a cubic spline, MATHS.md (6), or a formula, (98)."""
    if isinstance(profile, PowerProfile):
        return profile.curve()
    radius_mm = np.asarray(profile.diameter_mm) / 2
    ends: object = profile.spline
    if profile.end_slopes is not None:
        ends = ((1, profile.end_slopes[0]), (1, profile.end_slopes[1]))
    return CubicSpline(np.asarray(profile.height_mm, dtype=np.float64), radius_mm, bc_type=ends)


def polygon_or_spline(z_mm: Sequence[float] | Floats, values: Floats, interpolation: str) -> PPoly:
    """Return values over height: "linear" a polygon, "spline" a not-a-knot cubic, MATHS.md (6)."""
    heights = np.asarray(z_mm, dtype=np.float64)
    if interpolation == "spline":
        return CubicSpline(heights, values, bc_type="not-a-knot")
    zero = np.zeros(heights.size - 1)
    return PPoly(np.array([zero, zero, np.diff(values) / np.diff(heights), values[:-1]]), heights)


def constant_spline(value: float, first_mm: float, last_mm: float) -> PPoly:
    """Return one value for all heights."""
    return PPoly(np.array([[0.0], [0.0], [0.0], [value]]), np.array([first_mm, last_mm]))


def ovality_spline(ovality: Ovality | PeakOvality) -> PPoly:
    """Return G(z) [mm]: polygon or not-a-knot cubic spline, MATHS.md (6)."""
    g_mm = np.asarray(ovality.ovality_mm, dtype=np.float64)
    return polygon_or_spline(ovality.height_mm, g_mm, ovality.interpolation)


def magnified(spline: PPoly, factor: float, fixed_mm: float) -> PPoly:
    """Return fixed - factor (fixed - spline), the papers' demonstration, MATHS.md (7)."""
    coefficients = np.array(spline.c * factor)
    coefficients[-1] += fixed_mm * (1 - factor)
    return PPoly(coefficients, spline.x)
