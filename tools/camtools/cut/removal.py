"""Metal removed from one section: area, equal parts, speed law, forces, MATHS.md (20) .. (29).

>>> from camtools.skirt.geometry.sections import ellipse
>>> papers = SectionCut(lambda phi: ellipse(phi, 46.0, 0.2), 46.0, 46.1)
>>> f"{papers.total_mm2:.12f} mm2"
'10.846348636519 mm2'
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import ceil, floor
from typing import NamedTuple

import numpy as np

from camtools.base.quantities import Floats, SectionValues
from camtools.base.solvers import inverted, neighbours

QUARTER_RAD, TURN_RAD = np.pi / 2, 2 * np.pi
_CELLS = 720  # of the quadrature; eight places each
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
_AREA_ERROR = 1e-14  # of the whole area
_DENSE = 20_001


@dataclass(frozen=True)
class SectionCut:
    """A section, turned out of a blank; looked at over a pattern of it.

    That is a quarter turn of a two-fold, mirrored section, else the whole turn.
    """

    delta: Callable[[Floats], SectionValues]  # reduction of the radius at angles from the long axis
    a_mm: float  # long half axis
    blank_mm: float  # radius of the blank
    pattern_rad: float = QUARTER_RAD

    @property
    def n_patterns(self) -> int:
        """Return how often the pattern, or its mirror image, comes in a turn."""
        return round(TURN_RAD / self.pattern_rad)

    def depth_mm(self, phi_rad: Floats) -> Floats:
        """Return the depth of cut ap."""
        return np.asarray(self.blank_mm - self.a_mm + self.delta(phi_rad).delta, dtype=np.float64)

    def area_rate_mm2(self, phi_rad: Floats) -> Floats:
        """Return dA/dphi = ap (R0 - ap / 2) [mm2/rad], MATHS.md (20)."""
        depth = self.depth_mm(phi_rad)
        return np.asarray(depth * (self.blank_mm - depth / 2), dtype=np.float64)

    @cached_property
    def _cells(self) -> tuple[Floats, Floats]:
        """Return the borders of the cells and the area up to each."""
        borders = self.pattern_rad * np.arange(_CELLS + 1) / _CELLS
        return borders, np.concatenate([[0.0], np.cumsum(self._between(borders[:-1], borders[1:]))])

    def _between(self, low: Floats, high: Floats) -> Floats:
        """Return the areas between pairs of near angles by Gauss-Legendre quadrature."""
        half = (high - low) / 2
        phi = (low + high)[:, None] / 2 + half[:, None] * _NODES
        return np.asarray(half * (self.area_rate_mm2(phi) @ _WEIGHTS), dtype=np.float64)

    @property
    def total_mm2(self) -> float:
        """Return S, the area of the pattern."""
        return float(self._cells[1][-1])

    def area_mm2(self, phi_rad: Floats) -> Floats:
        """Return the area from angle 0 to angles 0 .. pattern; error below 1e-12 of it."""
        borders, sums = self._cells
        phi = np.asarray(phi_rad, dtype=np.float64)
        cell = np.clip((phi / self.pattern_rad * _CELLS).astype(np.int64), 0, _CELLS - 1)
        return np.asarray(sums[cell] + self._between(borders[cell], phi), dtype=np.float64)

    def angle_rad(self, area_mm2: Floats) -> Floats:
        """Return the angles up to which areas 0 .. S are cut, MATHS.md (22)."""
        borders, sums = self._cells
        bounds = neighbours(borders, sums, area_mm2)
        within = _AREA_ERROR * self.total_mm2
        return inverted(self.area_mm2, area_mm2, bounds, within, "process: removal of metal")

    def speed_ratio(self, phi_rad: Floats) -> Floats:
        """Return spindle speed over mean speed at constant removal rate, MATHS.md (24)."""
        mean = self.total_mm2 / self.pattern_rad
        return np.asarray(mean / self.area_rate_mm2(phi_rad), dtype=np.float64)


class Steps(NamedTuple):
    """Table 1: what is cut in equal steps of angle; intervals end at their angle."""

    phi_rad: Floats
    depth_mm: Floats
    change_mm: Floats
    area_mm2: Floats


def steps_of(cut: SectionCut, step_rad: float) -> Steps:
    """Return depth, its change and area of equal steps of angle over the pattern."""
    n = round(cut.pattern_rad / step_rad)
    phi = cut.pattern_rad * np.arange(n + 1) / n
    depth = cut.depth_mm(phi)
    return Steps(
        phi, depth, np.diff(depth, prepend=depth[0]), np.diff(cut.area_mm2(phi), prepend=0)
    )


class Parts(NamedTuple):
    """Table 4: n parts of equal area; intervals end at their angle."""

    phi_rad: Floats
    width_rad: Floats
    depth_mm: Floats
    change_mm: Floats
    speed_ratio: Floats  # mean speed of the part over that of the turn


def parts_of(cut: SectionCut, n: int) -> Parts:
    """Return the n parts of equal area of the pattern."""
    borders = cut.angle_rad(cut.total_mm2 * np.arange(n + 1) / n)
    depth, width = cut.depth_mm(borders), np.diff(borders)
    return Parts(borders[1:], width, depth[1:], np.diff(depth), width / (cut.pattern_rad / n))


class PartsRange(NamedTuple):
    """How many parts are possible."""

    least: int  # so that none removes more than allowed
    most: int  # so that none is shorter than the controller's cycle


def parts_range(
    cut: SectionCut, feed_mm: float, rpm: float, volume_mm3: float, cycle_s: float
) -> PartsRange:
    """Return the least and the most parts of a pattern, MATHS.md (23)."""
    return PartsRange(
        ceil(cut.total_mm2 * feed_mm / volume_mm3 - 1e-9),
        floor(60 / rpm / (cut.n_patterns * cycle_s) + 1e-9),
    )


class SpeedPeaks(NamedTuple):
    """Extremes at constant removal rate, per mean speed or its square, and where [rad]."""

    ratio_max: float
    ratio_min: float
    alpha: float  # |spindle acceleration| / mean^2
    alpha_rad: float
    u1_mm: float  # speed of U / mean
    u1_rad: float
    u2_max_mm: float  # acceleration of U / mean^2
    u2_min_mm: float
    u2_min_rad: float


def motion_at(cut: SectionCut, phi_rad: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Return r, r r', speed and acceleration of U per mean speed and its square."""
    u, ratio = cut.delta(phi_rad), cut.speed_ratio(phi_rad)
    rho = cut.a_mm - u.delta
    mean = cut.total_mm2 / cut.pattern_rad
    product = -(mean**2) * rho * u.d1 / cut.area_rate_mm2(phi_rad) ** 3
    return ratio, product, u.d1 * ratio, u.d2 * ratio**2 + u.d1 * product


def _peak(phi: Floats, values: Floats) -> tuple[float, float]:
    """Return the largest value and its place, refined by a parabola."""
    i = int(np.argmax(values))
    if i in (0, phi.size - 1):
        return float(values[i]), float(phi[i])
    low, here, high = (float(value) for value in values[i - 1 : i + 2])
    off = (low - high) / (2 * (low - 2 * here + high))
    return here - (low - high) * off / 4, float(phi[i] + off * (phi[1] - phi[0]))


def speed_peaks(cut: SectionCut) -> SpeedPeaks:
    """Return the extremes of the law of constant removal rate, MATHS.md (25)."""
    phi = cut.pattern_rad * np.arange(_DENSE) / (_DENSE - 1)
    ratio, product, speed, motion = motion_at(cut, phi)
    alpha, u1, least = _peak(phi, np.abs(product)), _peak(phi, np.abs(speed)), _peak(phi, -motion)
    highest = _peak(phi, motion)[0]
    return SpeedPeaks(
        float(ratio.max()), float(ratio.min()), *alpha, *u1, highest, -least[0], least[1]
    )


def mean_rpm_for(peaks: SpeedPeaks, alpha_rad_s2: float) -> float:
    """Return the highest mean speed that a spindle's acceleration allows [r/min]."""
    return float(np.sqrt(alpha_rad_s2 / peaks.alpha)) * 30 / np.pi


def harmonics_mm(cut: SectionCut, n: int) -> Floats:
    """Return cosine amplitudes of U against mean phase, harmonics 0 .. n of the spindle.

    Time runs with the area cut, so at constant removal rate U is no longer two waves per turn.
    """
    samples = 4096
    time = np.arange(samples) / samples * cut.n_patterns
    part, whole = np.modf(time)
    forward = (whole.astype(np.int64) % 2 == 0) | (cut.n_patterns == 1)
    share = np.where(forward, part, 1 - part)  # every second quarter is mirrored
    u_mm = cut.delta(cut.angle_rad(share * cut.total_mm2)).delta
    waves = np.fft.rfft(u_mm) / samples
    return np.asarray(np.real(waves[: n + 1]) * np.where(np.arange(n + 1) > 0, 2, 1))


class ChipForce(NamedTuple):
    """Specific cutting force, with Kienzle's size effect where it is given, MATHS.md (86)."""

    kc_n_mm2: float  # with a size effect kc1.1, that of a chip of 1 mm by 1 mm
    exponent: float = 0.0  # mc; 0: the same at any thickness
    nose_mm: float = 0.0  # radius along which the tool cuts; 0: an edge square to the feed

    def specific_n_mm2(self, depth_mm: Floats, feed_mm: float) -> Floats:
        """Return the force per area of a chip of depths above 0."""
        depth = np.asarray(depth_mm, dtype=np.float64)
        if self.exponent == 0:
            return np.full(depth.shape, self.kc_n_mm2)
        width = depth
        if self.nose_mm > 0:
            arc = np.minimum(depth, self.nose_mm)
            width = self.nose_mm * np.arccos(1 - arc / self.nose_mm) + depth - arc
        thick = depth * feed_mm / width
        return np.asarray(self.kc_n_mm2 * thick**-self.exponent, dtype=np.float64)

    def chip_n(self, depth_mm: Floats, feed_mm: float) -> Floats:
        """Return the force of the chip."""
        return self.specific_n_mm2(depth_mm, feed_mm) * depth_mm * feed_mm


class Rates(NamedTuple):
    """Removal rate and power at constant rate, and how much uniform turning varies."""

    rate_mm3_s: float
    power_w: float
    largest_to_least: float  # instantaneous rate of uniform turning
    ripple: float  # (largest - least) / mean
    steps_largest_to_least: float  # over the steps of a table
    steps_ripple: float


def rates_of(cut: SectionCut, steps: Steps, feed_mm: float, rpm: float, kc_n_mm2: float) -> Rates:
    """Return rates, power and ripple, MATHS.md (29)."""
    area = cut.area_rate_mm2(cut.pattern_rad * np.arange(_DENSE) / (_DENSE - 1))
    in_steps = steps.area_mm2[1:]
    rate = feed_mm * cut.n_patterns * cut.total_mm2 * rpm / 60
    mean = cut.total_mm2 / cut.pattern_rad
    return Rates(
        rate,
        kc_n_mm2 * rate / 1000,
        float(area.max() / area.min()),
        float(np.ptp(area)) / mean,
        float(in_steps.max() / in_steps.min()),
        float(np.ptp(in_steps) / in_steps.mean()),
    )


def equal_volume_angles(cut: SectionCut, n: int, n_turns: int) -> Floats:
    """Return the unwrapped angles of equal slices of time, n to a pattern."""
    borders = cut.angle_rad(cut.total_mm2 * np.arange(n + 1) / n)
    pattern = borders[:-1]
    if cut.n_patterns > 1:  # there and back
        pattern = np.concatenate([borders[:-1], 2 * QUARTER_RAD - borders[:0:-1]])
    length = cut.pattern_rad * (2 if cut.n_patterns > 1 else 1)
    repeats = round(n_turns * TURN_RAD / length)
    starts = length * np.arange(repeats)[:, None]
    return np.append((starts + pattern).ravel(), n_turns * TURN_RAD)
