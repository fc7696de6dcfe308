"""From a part to its table, checked against the exact geometry and the machine's limits.

>>> from camtools.skirt.part import example_part
>>> result = generate(example_part(), tolerance_nm=1.0)
>>> result.accuracy_u.value_nm < 1.0, result.accuracy_x.value_nm < 1.0
(True, True)
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil, floor

from camtools.base.errors import CamtoolsError, GeometryError
from camtools.cut.feasibility import (
    HighestSpeed,
    Peaks,
    check_feasible,
    drift_of,
    highest_speed,
    peaks_of,
)
from camtools.cut.path import path_of
from camtools.lobe.part import CamPart
from camtools.part.file import height_mm, is_feed_within
from camtools.skirt.accuracy import Accuracy
from camtools.skirt.corner import Corner
from camtools.skirt.geometry import NM_PER_MM, Geometry, make_geometry
from camtools.skirt.part import Limits as MachineLimits
from camtools.skirt.part import Part
from camtools.skirt.search import choose_u, choose_x
from camtools.skirt.speed import MotionPeaks, SpeedTable, make_speed
from camtools.table.evaluate import knot_interval, raw_bounds
from camtools.table.image import Bounds, Channel, Limits, Table
from camtools.table.quantise import with_bounds

DEFAULT_TOLERANCE_NM = 1.0
REFIT_TOLERANCE_NM = 5.0  # of u, where a spline replaces a corner
MAX_TOLERANCE_NM = 1_000_000.0
_ROUNDING_LSB = (1, 2, 8)  # the firmware's, of value and derivatives per interval: cam_eval.h


@dataclass(frozen=True, eq=False)
class Generated:
    """A table and everything that is known about it."""

    part: Part
    geometry: Geometry
    tolerance_nm: float
    table: Table
    accuracy_u: Accuracy
    accuracy_x: Accuracy
    highest_speed: HighestSpeed
    speed: SpeedTable | None = None


def u_bounds(channel: Channel, error_nm: float) -> Bounds:
    """Return true bounds of u, the firmware's rounding included."""
    raw, h, lsb = raw_bounds(channel), knot_interval(channel), channel.lsb_nm
    return Bounds(
        u_min_nm=floor(channel.offset_nm + (raw.low - _ROUNDING_LSB[0]) * lsb),
        u_max_nm=ceil(channel.offset_nm + (raw.high + _ROUNDING_LSB[0]) * lsb),
        u1_peak_nm_per_rad=ceil((raw.first + _ROUNDING_LSB[1]) * lsb / h),
        u2_peak_nm_per_rad2=ceil((raw.second + _ROUNDING_LSB[2]) * lsb / h**2),
        error_pm=ceil(error_nm * 1000),
    )


def image_limits(limits: MachineLimits) -> Limits:
    """Return the machine's limits in the image's units, rounded down."""
    return Limits(
        u_stroke_nm=_units(limits.u_stroke_mm, NM_PER_MM),
        u_speed_um_s=_units(limits.u_speed_mm_s, 1000),
        u_acceleration_mm_s2=_units(limits.u_acceleration_mm_s2, 1),
        spindle_mrpm=_units(limits.spindle_rpm, 1000),
    )


def _units(value: float, per_unit: int) -> int:
    """Return value * per_unit rounded down, forgiving the last digit of a decimal fraction."""
    return floor(value * per_unit * (1 + 1e-12))


def moving_bounds(uniform: Bounds, peaks: MotionPeaks) -> Bounds:
    """Return the bounds of u where the spindle is modulated: TABLE_FORMAT.md, header."""
    return replace(
        uniform,
        u1_peak_nm_per_rad=ceil(peaks.u1_mm * NM_PER_MM),
        u2_peak_nm_per_rad2=ceil(peaks.u2_mm * NM_PER_MM),
        spindle_peak_ppm=ceil(peaks.spindle_rad2 * 1e6),
    )


def make_table(
    part: Part, u: Channel, x: Channel, error_nm: float, speed: SpeedTable | None = None
) -> Table:
    """Return the table of a part with its channels, bounds filled in."""
    bounds = u_bounds(u, error_nm)
    channels: tuple[Channel, ...] = (with_bounds(u), with_bounds(x))
    if speed is not None:
        bounds, channels = moving_bounds(bounds, speed.peaks), (*channels, speed.channel)
    table = table_of(part, part.process.spindle_rpm, bounds, channels)
    return replace(table, is_ring_helix=part.process.path == "ring-helix")


def table_of(
    part: Part | CamPart, spindle_rpm: float, bounds: Bounds, channels: tuple[Channel, ...]
) -> Table:
    """Return a table with the header of a part; u comes first, `spindle_rpm` is the mean speed."""
    process, u = part.process, channels[0]
    return Table(
        part.part.name,
        u.z_first_nm,
        u.z_last_nm,
        process.direction,
        round(spindle_rpm * 1000),
        round(process.feed_mm * NM_PER_MM),
        round(process.depth_mm * NM_PER_MM),
        image_limits(part.machine.limits),
        bounds,
        channels,
    )


def check_tolerance(tolerance_nm: float) -> None:
    """Refuse a tolerance that is not a length.

    Raises
    ------
    CamtoolsError
        Not above 0, not at most MAX_TOLERANCE_NM, or not a number.
    """
    if not 0 < tolerance_nm <= MAX_TOLERANCE_NM:
        problem = f"must be above 0 and at most {MAX_TOLERANCE_NM:g}"
        raise CamtoolsError([f"tolerance_nm = {tolerance_nm:g}: {problem}; give nanometres"])


def check_feed(part: Part | CamPart) -> None:
    """Refuse a feed beyond the height of the part: the firmware would not cut its table.

    Raises
    ------
    CamtoolsError
        With the highest feed that would do.
    """
    feed_mm = part.process.feed_mm
    if not is_feed_within(part, feed_mm):
        problem = f"must be at most {height_mm(part):.9g}, the height of the part"
        raise CamtoolsError([f"process.feed_mm = {feed_mm:.9g}: {problem}; give mm per turn"])


def refuse_corner(geometry: Geometry) -> None:
    """Refuse a composite section whose corner nobody smoothed: no axis can follow it."""
    corner = geometry.corner
    if corner is None or corner.recipe is not None:
        return
    jump = float(corner.joint(corner.worst_mm).corner_mm_rad())
    angle_deg = float(corner.joint_deg(corner.worst_mm))
    problem = (
        f"is missing: the slope jumps by {jump:.4g} mm/rad at {angle_deg:g} degrees (height "
        f"{corner.worst_mm:.4g} mm), so U would need infinite acceleration"
    )
    raise GeometryError("piston.section.refit", problem, "add the table [piston.section.refit]")


def default_tolerance_nm(geometry: Geometry) -> float:
    """Return the tolerance of u that applies when none is asked for [nm]."""
    return DEFAULT_TOLERANCE_NM if geometry.corner is None else REFIT_TOLERANCE_NM


def generate(part: Part, tolerance_nm: float | None = None) -> Generated:
    """Return the smallest table of a part that keeps the tolerance.

    Parameters
    ----------
    part : Part
        A validated part.
    tolerance_nm : float, optional
        Largest error of u and of x anywhere on the skirt [nm], the firmware's rounding included;
        by default 1 nm, for u of a refitted composite section 5 nm.

    Raises
    ------
    CamtoolsError
        The shape is impossible, the tolerance is out of reach, or the machine is too weak.
    """
    if tolerance_nm is not None:
        check_tolerance(tolerance_nm)
    check_feed(part)
    geometry = make_geometry(part)
    path_of(part, geometry.z_first_mm, geometry.z_last_mm)  # or refuse: Z cannot follow it
    refuse_corner(geometry)
    tolerance_u_nm = tolerance_nm or default_tolerance_nm(geometry)
    u, accuracy_u = choose_u(geometry, tolerance_u_nm)
    x, accuracy_x = choose_x(geometry, tolerance_nm or DEFAULT_TOLERANCE_NM)
    error_nm = max(accuracy_u.value_nm, accuracy_x.value_nm)
    speed = _modulation(part, geometry, u, error_nm)
    table = make_table(part, u, x, error_nm, speed)
    best = _judge(part, geometry, peaks_of_table(table, speed))
    return Generated(part, geometry, tolerance_u_nm, table, accuracy_u, accuracy_x, best, speed)


def _modulation(part: Part, geometry: Geometry, u: Channel, error_nm: float) -> SpeedTable | None:
    """Return the speed channel of a part that is turned with an even removal rate."""
    if part.process.mode == "uniform":
        return None
    uniform = highest_speed(peaks_of(u_bounds(u, error_nm)), part.machine.limits)
    return make_speed(part, geometry, u, uniform.rpm)


def peaks_of_table(table: Table, speed: SpeedTable | None) -> Peaks:
    """Return what the axes need of the table of a skirt."""
    ratio, feed_mm = speed.peaks.ratio if speed else 1.0, table.feed_nm / NM_PER_MM
    drift = drift_of(table.channels[0], 1 / NM_PER_MM, feed_mm)
    return peaks_of(table.bounds, ratio)._replace(u_drift=drift.at(ratio), feed_mm=feed_mm)


def _judge(part: Part, geometry: Geometry, peaks: Peaks) -> HighestSpeed:
    """Return the highest speed, or refuse; of a corner tell what another refit would need."""
    try:
        return check_feasible(peaks, part.machine.limits, part.process.spindle_rpm)
    except CamtoolsError as error:
        if geometry.corner is None or not any("u_acceleration" in line for line in error.lines):
            raise
        raise CamtoolsError([*error.lines, _corner_hint(geometry.corner)]) from error


def _corner_hint(corner: Corner) -> str:
    best = min(corner.candidates, key=lambda one: one.acceleration_mm_s2)
    return (
        f"piston.section.refit.delete: the corner decides; of all deletions [{best.s1}, {best.s2}] "
        f"needs least, {best.acceleration_mm_s2:.6g} mm/s2 at this speed; trim less or turn slower"
    )
