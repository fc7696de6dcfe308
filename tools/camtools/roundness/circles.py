# SPDX-License-Identifier: Apache-2.0
"""Reference circles of ISO 12181-1 and what a profile does about them, MATHS.md (198) .. (200).

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

from camtools.base.quantities import Floats
from camtools.roundness.simplex import solve

_MOST_ROUNDS = 30
_STILL_MM = 1e-12


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


def _refined(profile: RoundProfile, step: Callable[[RoundProfile], Floats]) -> Circle:
    """Return the circle that a step about a centre no longer moves.

    Parameters
    ----------
    step : callable
        Gives the first three unknowns of a profile: change of the radius [mm] against the mean,
        x and y of the centre.
    """
    x_mm = y_mm = 0.0
    for _ in range(_MOST_ROUNDS):
        here = about(profile, x_mm, y_mm)
        radius_mm, dx_mm, dy_mm = (float(one) for one in step(here)[:3])
        x_mm, y_mm = x_mm + dx_mm, y_mm + dy_mm
        if np.hypot(dx_mm, dy_mm) < _STILL_MM:
            break
    return Circle(x_mm, y_mm, radius_mm)


def _basis(profile: RoundProfile) -> Floats:
    """Return 1, cos and sin of every angle, shape (n, 3)."""
    ones = np.ones(profile.phi_rad.size)
    return np.stack([ones, np.cos(profile.phi_rad), np.sin(profile.phi_rad)], axis=1)


def least_squares(profile: RoundProfile) -> Circle:
    """Return the circle with the least sum of squared distances (LSCI), by Gauss and Newton."""

    def step(here: RoundProfile) -> Floats:
        basis = _basis(here)
        normal = np.linalg.solve(basis.T @ basis, basis.T @ here.radius_mm)
        return np.asarray(normal, dtype=np.float64)

    return _refined(profile, step)


def _nearest(profile: RoundProfile, n: int) -> list[int]:
    """Return the points nearest to n even angles from 0 on."""
    turn = np.mod(profile.phi_rad / (2 * np.pi), 1)
    apart = [np.abs(np.mod(turn - i / n + 0.5, 1) - 0.5) for i in range(n)]
    return [int(one.argmin()) for one in apart]


def minimum_zone(profile: RoundProfile) -> Zone:
    """Return the two concentric circles of the least distance that enclose a profile (MZCI)."""

    def step(here: RoundProfile) -> Floats:
        basis, ones = _basis(here), np.ones((here.phi_rad.size, 1))
        mean_mm = float(here.radius_mm.mean())
        off_mm = here.radius_mm - mean_mm
        rows = np.concatenate([np.hstack([basis, ones]), np.hstack([-basis, ones])])
        least = np.concatenate([off_mm, -off_mm])
        east, north, west, south = _nearest(here, 4)
        begin = [east, west, north + off_mm.size, south + off_mm.size]
        found = solve(rows, least, np.array([0.0, 0.0, 0.0, 1.0]), begin)
        return np.asarray(found + np.array([mean_mm, 0, 0, 0]), dtype=np.float64)

    circle = _refined(profile, step)
    off_mm = distances_mm(profile, circle)
    middle_mm = circle.radius_mm + float(off_mm.max() + off_mm.min()) / 2
    return Zone(Circle(circle.x_mm, circle.y_mm, middle_mm), float(np.ptp(off_mm)))


def _one_sided(profile: RoundProfile, side: float) -> Circle:
    def step(here: RoundProfile) -> Floats:
        mean_mm = float(here.radius_mm.mean())
        cost = np.array([side, 0.0, 0.0])
        least = side * (here.radius_mm - mean_mm)
        found = solve(side * _basis(here), least, cost, _nearest(here, 3))
        return np.asarray(found + np.array([mean_mm, 0, 0]), dtype=np.float64)

    circle = _refined(profile, step)
    far_mm = about(profile, circle.x_mm, circle.y_mm).radius_mm
    return circle._replace(radius_mm=float(far_mm.max() if side > 0 else far_mm.min()))


def minimum_circumscribed(profile: RoundProfile) -> Circle:
    """Return the smallest circle around a profile (MCCI)."""
    return _one_sided(profile, 1.0)


def maximum_inscribed(profile: RoundProfile) -> Circle:
    """Return the largest circle within a profile (MICI)."""
    return _one_sided(profile, -1.0)
