"""Exact geometry of a piston skirt and the motion that cuts it, in double.

>>> from camtools.part import example_part
>>> geometry = make_geometry(example_part())
>>> [f"{mm:.9f}" for mm in geometry.radius_mm([5.0, 35.0])]
['45.983096898', '45.983079419']
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline, PPoly

from camtools.errors import GeometryError
from camtools.part import Ovality, Part, Profile
from camtools.sections import Floats, FloatsLike, Section, SectionValues, make_section

NM_PER_MM = 1_000_000
_CHECKS_PER_PIECE = 64


@dataclass(frozen=True)
class Geometry:
    """The part's exact surface: tool tip radius = radius_mm(z) - delta(phi, z).

    Attributes
    ----------
    radius, ovality : scipy.interpolate.PPoly
        Long half axis a(z) and diametral ovality G(z) [mm] over height [mm], magnified already.
    section : Section
        Shape of every cross-section.
    z_first_mm, z_last_mm : float
        Height range, that of the profile.
    """

    radius: PPoly
    ovality: PPoly
    section: Section
    z_first_mm: float
    z_last_mm: float

    def radius_mm(self, z_mm: FloatsLike | Sequence[float], derivative: int = 0) -> Floats:
        """Return a(z), a'(z) or a''(z) [mm, mm/mm, mm/mm^2] with the shape of z_mm."""
        return np.asarray(self.radius(z_mm, nu=derivative), dtype=np.float64)

    def ovality_mm(self, z_mm: FloatsLike | Sequence[float]) -> Floats:
        """Return G(z) [mm] with the shape of z_mm."""
        return np.asarray(self.ovality(z_mm), dtype=np.float64)

    def delta(self, phi_rad: FloatsLike, z_mm: FloatsLike) -> SectionValues:
        """Return radius reduction and angle derivatives at fixed height [mm, mm/rad^n].

        Parameters
        ----------
        phi_rad, z_mm : float or ndarray
            Angle from the long axis [rad] and height [mm]; broadcast against each other.
        """
        return self.section.evaluate(phi_rad, self.radius_mm(z_mm), self.ovality_mm(z_mm))

    def breaks_mm(self) -> Floats:
        """Return the heights where a piece of a(z) or G(z) ends, rising, both ends included."""
        heights = np.union1d(self.radius.x, self.ovality.x)
        inside = (heights > self.z_first_mm) & (heights < self.z_last_mm)
        return np.concatenate(([self.z_first_mm], heights[inside], [self.z_last_mm]))


class Motion(NamedTuple):
    """Set-points of uniform turning, all of the shape of the turns asked for."""

    c_rad: Floats
    z_mm: Floats
    x_mm: Floats
    u_mm: Floats
    velocity_mm_s: Floats
    acceleration_mm_s2: Floats
    jerk_mm_s3: Floats


def profile_spline(profile: Profile) -> PPoly:
    """Return the long half axis a(z) [mm] as a cubic spline (maths.md 2.1)."""
    radius_mm = np.asarray(profile.diameter_mm) / 2
    ends: object = profile.spline
    if profile.end_slopes is not None:
        ends = ((1, profile.end_slopes[0]), (1, profile.end_slopes[1]))
    return CubicSpline(np.asarray(profile.height_mm, dtype=np.float64), radius_mm, bc_type=ends)


def ovality_spline(ovality: Ovality) -> PPoly:
    """Return G(z) [mm]: polygon or not-a-knot cubic spline (maths.md 2.2)."""
    z_mm = np.asarray(ovality.height_mm, dtype=np.float64)
    g_mm = np.asarray(ovality.ovality_mm, dtype=np.float64)
    if ovality.interpolation == "spline":
        return CubicSpline(z_mm, g_mm, bc_type="not-a-knot")
    zero = np.zeros(z_mm.size - 1)
    return PPoly(np.array([zero, zero, np.diff(g_mm) / np.diff(z_mm), g_mm[:-1]]), z_mm)


def magnified(spline: PPoly, factor: float, fixed_mm: float) -> PPoly:
    """Return fixed - factor (fixed - spline), the papers' demonstration (maths.md 10.8)."""
    coefficients = np.array(spline.c * factor)
    coefficients[-1] += fixed_mm * (1 - factor)
    return PPoly(coefficients, spline.x)


def make_geometry(part: Part) -> Geometry:
    """Return the exact geometry of a part.

    Raises
    ------
    GeometryError
        A spline overshoots into ovality below 0 or half axes not above 0.
    """
    piston = part.piston
    factor = part.magnify.factor if part.magnify else 1.0
    largest_mm = max(piston.profile.diameter_mm) / 2
    heights = piston.profile.height_mm
    geometry = Geometry(
        magnified(profile_spline(piston.profile), factor, largest_mm),
        magnified(ovality_spline(piston.ovality), factor, 0.0),
        make_section(piston.section.shape, piston.section.beta),
        float(heights[0]),
        float(heights[-1]),
    )
    _check_shape(geometry, factor)
    return geometry


def dense_heights_mm(geometry: Geometry, per_piece: int) -> Floats:
    """Return heights inside every polynomial piece and at all its ends, rising."""
    breaks = geometry.breaks_mm()
    inside = breaks[:-1, None] + np.diff(breaks)[:, None] * np.arange(per_piece) / per_piece
    return np.append(inside.ravel(), breaks[-1])


def _check_shape(geometry: Geometry, factor: float) -> None:
    z_mm = dense_heights_mm(geometry, _CHECKS_PER_PIECE)
    g_mm, a_mm = geometry.ovality_mm(z_mm), geometry.radius_mm(z_mm)
    lowest, thinnest = int(np.argmin(g_mm)), int(np.argmin(a_mm - g_mm / 2))
    if g_mm[lowest] < 0:
        problem = f"the spline falls to {g_mm[lowest]:.6g} mm at height {z_mm[lowest]:.6g} mm"
        raise GeometryError("piston.ovality.interpolation", problem, 'use "linear" or more points')
    half_axis_mm = a_mm[thinnest] - g_mm[thinnest] / 2
    if half_axis_mm <= 0:
        field = "magnify.factor" if factor > 1 else "piston.profile.spline"
        at = f"at height {z_mm[thinnest]:.6g} mm"
        problem = f"the short half axis becomes {half_axis_mm:.6g} mm {at}"
        raise GeometryError(field, problem, "magnify less, or give points without such a step")


def omega_rad_s(spindle_rpm: float) -> float:
    """Return the angular speed [rad/s] of a spindle speed [r/min]."""
    return 2 * np.pi * spindle_rpm / 60


def turning_at(geometry: Geometry, spindle_rpm: float, z_mm: FloatsLike, turns: Floats) -> Motion:
    """Return the axes of turning at constant speed, at given angles and heights.

    Parameters
    ----------
    spindle_rpm : float
        Speed [r/min].
    z_mm : float or ndarray, shape (n,)
        Height(s) [mm].
    turns : ndarray, shape (n,)
        Spindle angle from the long axis, in turns.

    Returns
    -------
    Motion
        Velocity, acceleration and jerk of U at fixed height; the feed adds dU/dz feed n/60.
    """
    c_rad, omega = 2 * np.pi * turns, omega_rad_s(spindle_rpm)
    u = geometry.delta(c_rad, z_mm)
    z_all_mm = np.broadcast_to(np.asarray(z_mm, dtype=np.float64), c_rad.shape)
    x_mm = geometry.radius_mm(z_all_mm)
    return Motion(c_rad, z_all_mm, x_mm, u.delta, u.d1 * omega, u.d2 * omega**2, u.d3 * omega**3)


def uniform_turning(
    geometry: Geometry, spindle_rpm: float, feed_mm: float, turns: Floats
) -> Motion:
    """Return the axes of uniform four-axis turning from the lowest height up (maths.md 3).

    Parameters
    ----------
    spindle_rpm, feed_mm : float
        Speed [r/min] and feed per turn [mm].
    turns : ndarray, shape (n,)
        Spindle angle since the lowest height, in turns; Z follows the angle.
    """
    return turning_at(geometry, spindle_rpm, geometry.z_first_mm + feed_mm * turns, turns)
