"""Reference circles of ISO 12181-1 and lines of ISO 12780, MATHS.md (198) .. (200), (205).

HiGHS (scipy.optimize.linprog) finds the same to 1e-15 but takes 15 times as long, which the 200
programs of a report would show.

>>> rows = np.array([[1.0, 1.0], [-1.0, 1.0], [0.5, 1.0]])  # y + x >= 1, y - x >= 0, y + x / 2 >= 0
>>> solve(rows, np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0]), [0, 1]).round(12).tolist()
[0.5, 0.5]

>>> phi = 2 * np.pi * np.arange(360) / 360
>>> profile = RoundProfile(phi, 46 + 2e-3 * np.cos(phi) + 1e-3 * np.cos(3 * phi))
>>> about = roundness(profile, least_squares(profile))
>>> f"{about.total_mm * 1e3:.3f} {about.q_mm * 1e3:.3f} {about.circle.x_mm * 1e3:.3f}"
'2.000 0.707 2.000'
>>> f"{minimum_zone(profile).width_mm * 1e3:.3f}"
'2.000'

>>> z_mm = np.linspace(0, 60, 601)
>>> found = straightness(z_mm, 1e-3 * (z_mm / 60 + (z_mm / 30 - 1) ** 2))
>>> f"{found.total_mm * 1e3:.3f} {found.zone_mm * 1e3:.3f} {found.slope * 60e3:.3f}"
'1.000 1.000 1.000'
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats

_MOST_STEPS = 1000
_ROUNDING = 1e-13
_LEAST = 1e-6  # of the bounds, below which all of them are rounding


def solve(rows: Floats, least: Floats, cost: Floats, begin: list[int]) -> Floats:
    """Return the y that minimises cost y with rows y >= least.

    Each step takes the row that is violated most and lets go of the one that keeps the
    multipliers of all others from becoming negative; the cost never falls.

    Parameters
    ----------
    rows : ndarray, shape (m, n)
        In numbers near 1; m may be some thousands, n is 3 or 4.
    least : ndarray, shape (m,)
        Bounds.
    cost : ndarray, shape (n,)
        What each unknown costs.
    begin : list of int, n of them
        Rows of which cost is a combination with weights of at least 0.

    Returns
    -------
    ndarray, shape (n,)
        The unknowns; rows are kept within 1e-13 of the largest bound.

    Raises
    ------
    CamtoolsError
        It came to no end, which happens for values that are no profile.
    """
    basis = list(begin)
    allowed = _ROUNDING * max(float(np.abs(least).max()), _LEAST)
    for _ in range(_MOST_STEPS):
        held = rows[basis]
        y = np.linalg.solve(held, least[basis])
        short = least - rows @ y
        worst = int(short.argmax())
        if short[worst] <= allowed or worst in basis:
            return np.asarray(y, dtype=np.float64)
        weights = np.linalg.solve(held.T, np.stack([cost, rows[worst]], axis=1))
        basis[_leaving(weights[:, 0], weights[:, 1])] = worst
    problem = "a zone of the profile cannot be found"
    raise CamtoolsError([f"{problem}; report it with the file of the sections"])


def _leaving(multiplier: Floats, change: Floats) -> int:
    """Return which row of the basis a new one replaces: the first to lose its multiplier."""
    grows = change > _ROUNDING
    ratio = np.full(change.size, np.inf)
    ratio[grows] = np.maximum(multiplier[grows], 0) / change[grows]
    return int(ratio.argmin())


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
