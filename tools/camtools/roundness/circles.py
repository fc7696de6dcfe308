"""Reference circles of ISO 12181-1 and lines of ISO 12780, MATHS.md (198) .. (200), (205).

>>> phi = 2 * np.pi * np.arange(360) / 360
>>> profile = RoundProfile(phi, 46 + 2e-3 * np.cos(phi) + 1e-3 * np.cos(3 * phi))
>>> about = roundness(profile, least_squares(profile))
>>> f"{about.total_mm * 1e3:.3f} {about.q_mm * 1e3:.3f} {about.circle.x_mm * 1e3:.3f}"
'2.000 0.707 2.000'
>>> f"{minimum_zone(profile).width_mm * 1e3:.3f}"
'2.000'
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import linprog

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats, Ints

_BLOCKS = 48
_ROUNDING = 1e-13
_LEAST = 1e-6  # of the bounds, below which all of them are rounding
_TOLERANCE = 1e-10
_OPTIONS = {
    "presolve": False,
    "primal_feasibility_tolerance": _TOLERANCE,
    "dual_feasibility_tolerance": _TOLERANCE,
}
_MOST_ROUNDS = 30
_STILL_MM = 1e-12


def solve(rows: Floats, least: Floats, cost: Floats) -> Floats:
    """Return the y that minimises cost y with rows y >= least, kept to 1e-13 of the largest bound.

    Few of some thousand rows decide, and HiGHS takes long for all: it is given the row with the
    largest bound of each block, and then the most violated ones, too, until there are none.
    """
    scale = max(float(np.abs(least).max()), _LEAST)
    bounds = least / scale
    blocks = np.array_split(np.arange(bounds.size), min(_BLOCKS, bounds.size))

    def worst(short: Floats) -> Ints:
        return np.array([block[int(short[block].argmax())] for block in blocks])

    used = worst(bounds)
    while True:
        limits = {"A_ub": -rows[used], "b_ub": -bounds[used], "bounds": (None, None)}
        y = linprog(cost, **limits, options=_OPTIONS).x
        if y is None:
            problem = "a zone of the profile cannot be found"
            raise CamtoolsError([f"{problem}; report it with the file of the sections"])
        short = bounds - rows @ y
        broken = worst(short)
        broken = np.setdiff1d(broken[short[broken] > _ROUNDING], used)
        if not broken.size:
            return np.asarray(scale * y, dtype=np.float64)
        used = np.append(used, broken)


class RoundProfile(NamedTuple):
    """A closed profile about an axis: angles [rad], rising over a turn, and radii [mm]."""

    phi_rad: Floats
    radius_mm: Floats


class Circle(NamedTuple):
    """A circle: centre against the axis of the profile and RADIUS [mm]."""

    x_mm: float
    y_mm: float
    radius_mm: float


class Zone(NamedTuple):
    """Two concentric circles that enclose a profile; `circle` is the middle one."""

    circle: Circle
    width_mm: float  # RONt of MZCI


class Roundness(NamedTuple):
    """Parameters of ISO 12181-1 about a circle, all radial [mm]."""

    circle: Circle
    total_mm: float  # RONt: peak to valley
    peak_mm: float  # RONp: largest deviation outwards
    valley_mm: float  # RONv: largest deviation inwards, above 0
    q_mm: float  # RONq: root mean square


def about(profile: RoundProfile, x_mm: float, y_mm: float) -> RoundProfile:
    """Return a profile in polar coordinates about another centre."""
    x = profile.radius_mm * np.cos(profile.phi_rad) - x_mm
    y = profile.radius_mm * np.sin(profile.phi_rad) - y_mm
    return RoundProfile(np.arctan2(y, x), np.hypot(x, y))


def distances_mm(profile: RoundProfile, circle: Circle) -> Floats:
    """Return the distance of every point from a circle [mm], above 0 outside."""
    return about(profile, circle.x_mm, circle.y_mm).radius_mm - circle.radius_mm


def roundness(profile: RoundProfile, circle: Circle) -> Roundness:
    """Return the parameters of a profile about a circle; RONp to RONq are those of LSCI only."""
    off_mm = distances_mm(profile, circle)
    peak_mm, valley_mm = float(off_mm.max()), float(-off_mm.min())
    q_mm = float(np.sqrt(np.mean(off_mm**2)))
    return Roundness(circle, peak_mm + valley_mm, peak_mm, valley_mm, q_mm)


def _refined(profile: RoundProfile, step: Callable[[Floats, Floats], Floats]) -> Circle:
    """Return the circle that a step about its centre no longer moves.

    A step takes 1, cos and sin of the angles, shape (n, 3), and the radii less their mean; its
    first three values are changes of the radius and of x and y of the centre [mm].
    """
    x_mm = y_mm = 0.0
    for _ in range(_MOST_ROUNDS):
        phi, radius_mm = about(profile, x_mm, y_mm)
        mean_mm = float(radius_mm.mean())
        basis = np.stack([np.ones(phi.size), np.cos(phi), np.sin(phi)], axis=1)
        change_mm, dx_mm, dy_mm = (float(mm) for mm in step(basis, radius_mm - mean_mm)[:3])
        x_mm, y_mm = x_mm + dx_mm, y_mm + dy_mm
        if np.hypot(dx_mm, dy_mm) < _STILL_MM:
            break
    return Circle(x_mm, y_mm, mean_mm + change_mm)


def least_squares(profile: RoundProfile) -> Circle:
    """Return the circle with the least sum of squared distances (LSCI), by Gauss and Newton."""

    def step(basis: Floats, off_mm: Floats) -> Floats:
        return np.asarray(np.linalg.solve(basis.T @ basis, basis.T @ off_mm), dtype=np.float64)

    return _refined(profile, step)


def _strip(basis: Floats, off_mm: Floats) -> Floats:
    """Return the combination of a basis nearest to all values, and last its largest distance."""
    above, below = (np.column_stack([sign * basis, np.ones(off_mm.size)]) for sign in (1, -1))
    cost = np.append(np.zeros(basis.shape[1]), 1.0)
    return solve(np.concatenate([above, below]), np.concatenate([off_mm, -off_mm]), cost)


def minimum_zone(profile: RoundProfile) -> Zone:
    """Return the two concentric circles of the least distance that enclose a profile (MZCI)."""
    circle = _refined(profile, _strip)
    off_mm = distances_mm(profile, circle)
    middle_mm = circle.radius_mm + float(off_mm.max() + off_mm.min()) / 2
    return Zone(circle._replace(radius_mm=middle_mm), float(np.ptp(off_mm)))


def _one_sided(profile: RoundProfile, side: float) -> Circle:
    """Return the least circle outside (side 1) or the largest inside (-1) of a profile."""
    circle = _refined(
        profile, lambda basis, mm: solve(side * basis, side * mm, np.array([side, 0.0, 0.0]))
    )
    far_mm = about(profile, circle.x_mm, circle.y_mm).radius_mm
    return circle._replace(radius_mm=float(far_mm.max() if side > 0 else far_mm.min()))


def minimum_circumscribed(profile: RoundProfile) -> Circle:
    """Return the smallest circle around a profile (MCCI)."""
    return _one_sided(profile, 1.0)


def maximum_inscribed(profile: RoundProfile) -> Circle:
    """Return the largest circle within a profile (MICI)."""
    return _one_sided(profile, -1.0)


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
    """Return the straightness of radii, or of deviations of them, at 3 or more rising heights.

    >>> z_mm = np.linspace(0, 60, 601)
    >>> line = straightness(z_mm, 1e-3 * (z_mm / 60 + (z_mm / 30 - 1) ** 2))
    >>> f"{line.total_mm * 1e3:.3f} {line.zone_mm * 1e3:.3f} {line.slope * 60e3:.3f}"
    '1.000 1.000 1.000'
    """
    off_z_mm = z_mm - float(z_mm.mean())
    slope, level_mm = (float(value) for value in np.polyfit(off_z_mm, value_mm, 1))
    off_mm = value_mm - level_mm - slope * off_z_mm
    basis = np.column_stack([np.ones(z_mm.size), 2 * (z_mm - z_mm[0]) / np.ptp(z_mm) - 1])
    return Straightness(
        float(np.ptp(off_mm)),
        float(off_mm.max()),
        float(-off_mm.min()),
        float(np.sqrt(np.mean(off_mm**2))),
        float(np.ptp(off_mm - basis @ _strip(basis, off_mm)[:2])),
        level_mm,
        slope,
    )
