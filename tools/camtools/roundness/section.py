"""Roundness, straightness and harmonics of a section of a non-circular part.

Reference circles of ISO 12181-1 and lines of ISO 12780, MATHS.md (198) .. (200), (205); filter,
harmonics and diameters, MATHS.md (201) .. (204).

>>> phi = 2 * np.pi * np.arange(360) / 360
>>> profile = RoundProfile(phi, 46 + 2e-3 * np.cos(phi) + 1e-3 * np.cos(3 * phi))
>>> about = roundness(profile, least_squares(profile))
>>> f"{about.total_mm * 1e3:.3f} {about.q_mm * 1e3:.3f} {about.circle.x_mm * 1e3:.3f}"
'2.000 0.707 2.000'
>>> phi = 2 * np.pi * np.arange(3600) / 3600
>>> drawn_mm, deviation_mm = 46 - 0.1 * np.sin(phi) ** 2, 1e-4 * np.cos(5 * phi)
>>> figures = section_of(drawn_mm, deviation_mm, np.ones(3600, np.bool_), 50)
>>> f"{figures.off.total_mm * 1e6:.1f} nm, {figures.whole.total_mm * 1e3:.1f} um"
'198.6 nm, 100.1 um'
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.optimize import linprog

from camtools.base.quantities import Bools, Floats, FloatsLike, Ints
from camtools.base.solvers import unsolved

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
_STILL_MM = 1e-9  # of its square over the radius nothing is left
_CHANGE_COST = 1e-6


def solve(rows: Floats, least: Floats, cost: Floats, lowest: FloatsLike = -np.inf) -> Floats:
    """Return the y that minimises cost y with rows y >= least, kept to 1e-13 of the largest bound.

    No part of y is below `lowest`.

    Few of some thousand rows decide, and HiGHS takes long for all: it is given the row with the
    largest bound of each block, and then the most violated ones, too, until there are none.
    """
    scale = max(float(np.abs(least).max()), _LEAST)
    bounds = least / scale
    blocks = np.array_split(np.arange(bounds.size), min(_BLOCKS, bounds.size))

    def worst(short: Floats) -> Ints:
        return np.array([block[int(short[block].argmax())] for block in blocks])

    used, highest = worst(bounds), np.full(cost.size, np.inf)
    ranges = np.column_stack(np.broadcast_arrays(lowest, highest))
    while True:
        limits = {"A_ub": -rows[used], "b_ub": -bounds[used], "bounds": ranges}
        y = linprog(cost, **limits, options=_OPTIONS).x
        if y is None:
            raise unsolved("zone of the profile")
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
            return Circle(x_mm, y_mm, mean_mm + change_mm)
    raise unsolved("circle of a section")


def least_squares(profile: RoundProfile) -> Circle:
    """Return the circle with the least sum of squared distances (LSCI), by Gauss and Newton."""

    def step(basis: Floats, off_mm: Floats) -> Floats:
        return np.asarray(np.linalg.solve(basis.T @ basis, basis.T @ off_mm), dtype=np.float64)

    return _refined(profile, step)


def _shortest(rows: Floats, least: Floats, cost: Floats) -> Floats:
    """Return `solve`, of equal solutions that with the least changes of what has no cost.

    Only two points of an oval touch the circle around it: across them its centre is free. Such a
    change is the difference of two numbers, none negative and each of a small cost.
    """
    n, is_free = cost.size, cost == 0
    both = np.column_stack([rows, -rows[:, is_free]])
    is_positive = np.pad(is_free, (0, both.shape[1] - n), constant_values=True)
    costs = np.where(is_positive, _CHANGE_COST, np.resize(cost, is_positive.size))
    y = solve(both, least, costs, np.where(is_positive, 0.0, -np.inf))
    y[:n][is_free] -= y[n:]
    return y[:n]


def _strip(basis: Floats, off_mm: Floats) -> Floats:
    """Return the combination of a basis nearest to all values, and last its largest distance."""
    above, below = (np.column_stack([sign * basis, np.ones(off_mm.size)]) for sign in (1, -1))
    cost = np.append(np.zeros(basis.shape[1]), 1.0)
    return _shortest(np.concatenate([above, below]), np.concatenate([off_mm, -off_mm]), cost)


def minimum_zone(profile: RoundProfile) -> Zone:
    """Return the two concentric circles of the least distance that enclose a profile (MZCI)."""
    circle = _refined(profile, _strip)
    off_mm = distances_mm(profile, circle)
    middle_mm = circle.radius_mm + float(off_mm.max() + off_mm.min()) / 2
    return Zone(circle._replace(radius_mm=middle_mm), float(np.ptp(off_mm)))


def _one_sided(profile: RoundProfile, side: float) -> Circle:
    """Return the least circle outside (side 1) or the largest inside (-1) of a profile."""
    circle = _refined(
        profile, lambda basis, mm: _shortest(side * basis, side * mm, np.array([side, 0.0, 0.0]))
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
        float(np.sqrt(np.mean(off_mm**2))),
        float(np.ptp(off_mm - basis @ _strip(basis, off_mm)[:2])),
        level_mm,
        slope,
    )


UPR_CHOICES = (15, 50, 150, 500)
DEFAULT_UPR = 50
MOST_HARMONICS = 50
POINTS_PER_WAVE = 7  # ISO 12181-2


class RoundWave(NamedTuple):
    """A wave of a profile: amplitude cos(order (phi - phase))."""

    order: int
    amplitude: float  # of the radius, half of peak to valley, in the unit of the profile
    phase_deg: float  # angle of its first crest, 0 .. 360 / order


def transmission(order: Floats | float, cutoff_upr: float) -> Floats:
    """Return the share of a wave that the low-pass filter of ISO 16610-21 lets through."""
    return np.asarray(np.exp2(-((np.asarray(order) / cutoff_upr) ** 2)), dtype=np.float64)


def low_pass(profile: Floats, cutoff_upr: float) -> Floats:
    """Return a closed profile at even angles through the Gaussian filter; phases stay.

    Of waves with cutoff_upr waves per turn (UPR) half is let through.
    """
    spectrum = np.fft.rfft(profile)
    passed = spectrum * transmission(np.arange(spectrum.size, dtype=np.float64), cutoff_upr)
    return np.asarray(np.fft.irfft(passed, profile.size), dtype=np.float64)


def harmonics(profile: Floats, most: int = MOST_HARMONICS) -> list[RoundWave]:
    """Return the waves 1 .. most of a closed profile of evenly spaced points."""
    spectrum = np.fft.rfft(profile) / profile.size
    order = np.arange(1, most + 1)
    phase_deg = np.mod(-np.degrees(np.angle(spectrum[order])) / order, 360 / order)
    amplitude = 2 * np.abs(spectrum[order])
    return list(map(RoundWave, order.tolist(), amplitude.tolist(), phase_deg.tolist()))


class OvalAxes(NamedTuple):
    """Two-point DIAMETERS [mm] of a section."""

    long_mm: float  # the largest
    short_mm: float  # the smallest
    phase_deg: float  # of the long axis by the second harmonic, -90 .. 90
    mean_mm: float  # of all diameters

    @property
    def ovality_mm(self) -> float:
        """Return the long less the short DIAMETER."""
        return self.long_mm - self.short_mm


def axes_of(radius_mm: Floats, is_measured: Bools | None = None) -> OvalAxes:
    """Return the axes of a section by its RADII at an even number of even angles.

    Diameters count where both their ends were measured.
    """
    half = radius_mm.size // 2
    diameter_mm = radius_mm[:half] + radius_mm[half:]
    if is_measured is not None:
        diameter_mm = diameter_mm[is_measured[:half] & is_measured[half:]]
    phase_deg = harmonics(radius_mm, 2)[1].phase_deg
    return OvalAxes(
        float(diameter_mm.max()),
        float(diameter_mm.min()),
        phase_deg - 180 if phase_deg > 90 else phase_deg,
        float(diameter_mm.mean()),
    )


class SectionFigures(NamedTuple):
    """Figures of a section of n even angles; every length is along the radius [mm]."""

    drawn_mm: Floats  # (n,) radius of the drawing
    raw_mm: Floats  # (n,) deviation from it
    filtered_mm: Floats  # (n,) that through the filter
    largest_mm: float  # deviation of the largest size, unfiltered, with its sign
    largest_deg: float  # its angle
    off: Roundness  # of the filtered deviation on a circle with the mean radius of the drawing
    off_zone: Zone
    whole: Roundness  # the same of the section as it is, drawing and filtered deviation
    whole_zone: Zone
    circumscribed: Circle
    inscribed: Circle
    drawn_axes: OvalAxes  # DIAMETERS of the drawing
    cut_axes: OvalAxes  # DIAMETERS of the section as it is
    off_waves: list[RoundWave]  # of the deviation, unfiltered
    whole_waves: list[RoundWave]  # of the section, unfiltered
    is_measured: Bools  # (n,); elsewhere there is no material, and lines bridge the deviation

    @property
    def cut_mm(self) -> Floats:
        """Return the radius of the section as it is."""
        return self.drawn_mm + self.filtered_mm


def bridged(deviation_mm: Floats, is_measured: Bools) -> Floats:
    """Return a closed profile with straight lines over the angles that were not measured.

    >>> bridged(np.array([0.0, np.nan, 2.0, 1.0]), np.array([True, False, True, True])).tolist()
    [0.0, 1.0, 2.0, 1.0]
    """
    n, at = deviation_mm.size, np.flatnonzero(is_measured)
    found = np.interp(np.arange(n), at, deviation_mm[at], period=n)
    return np.asarray(found, dtype=np.float64)


def section_of(
    drawn_mm: Floats, deviation_mm: Floats, is_measured: Bools, cutoff_upr: float
) -> SectionFigures:
    """Return the figures of a section by its drawing and deviation at even angles from 0 on.

    The Gaussian filter takes the deviation only: a drawing is not rounded off. Filter and waves are
    of the bridged deviation; circles, zones and axes are of the angles that were measured.
    """
    phi = 2 * np.pi * np.arange(drawn_mm.size) / drawn_mm.size
    deviation_mm = bridged(deviation_mm, is_measured)
    filtered_mm = low_pass(deviation_mm, cutoff_upr)
    cut_mm = drawn_mm + filtered_mm
    off = RoundProfile(phi[is_measured], float(drawn_mm.mean()) + filtered_mm[is_measured])
    whole = RoundProfile(phi[is_measured], cut_mm[is_measured])
    worst = int(np.where(is_measured, np.abs(deviation_mm), 0.0).argmax())
    return SectionFigures(
        drawn_mm,
        deviation_mm,
        filtered_mm,
        float(deviation_mm[worst]),
        360 * worst / drawn_mm.size,
        roundness(off, least_squares(off)),
        minimum_zone(off),
        roundness(whole, least_squares(whole)),
        minimum_zone(whole),
        minimum_circumscribed(whole),
        maximum_inscribed(whole),
        axes_of(drawn_mm, is_measured),
        axes_of(cut_mm, is_measured),
        harmonics(deviation_mm),
        harmonics(drawn_mm + deviation_mm),
        is_measured,
    )
