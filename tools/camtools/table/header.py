"""The header of a table: limits of the machine, bounds of u, and what the part file says.

>>> from camtools.part.common import MachineLimits
>>> image_limits(MachineLimits()).u_speed_um_per_s
400000
"""

from math import ceil, floor
from typing import Protocol

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import NM_PER_MM
from camtools.part.common import MachineLimits, PartFile
from camtools.table.channel import Bounds, Channel, ImageLimits, in_sense
from camtools.table.evaluate import extent, knot_interval, raw_bounds
from camtools.table.image import Table

MAX_TOLERANCE_NM = 1_000_000.0
MAX_U_NM, MAX_PEAK_NM = 1 << 24, (1 << 31) - 1  # of the header


class MadeTable(Protocol):
    """The table of a part of any kind; a kind knows more about it."""

    @property
    def part(self) -> PartFile:
        """The part."""

    @property
    def table(self) -> Table:
        """Its table."""


_ROUNDING_LSB = (2, 8)  # the firmware's, of the derivatives per interval: cam_eval.h


def u_bounds(channel: Channel, error_nm: float) -> Bounds:
    """Return true bounds of u, the firmware's rounding included."""
    range_nm = extent(channel)
    raw, h, lsb = raw_bounds(channel), knot_interval(channel), channel.lsb
    return Bounds(
        u_min_nm=range_nm.low,
        u_max_nm=range_nm.high,
        u1_peak_nm_per_rad=ceil((raw.first + _ROUNDING_LSB[0]) * lsb / h),
        u2_peak_nm_per_rad2=ceil((raw.second + _ROUNDING_LSB[1]) * lsb / h**2),
        error_pm=ceil(error_nm * 1000),
    )


def image_limits(limits: MachineLimits) -> ImageLimits:
    """Return the machine's limits in the image's units, rounded down."""
    return ImageLimits(
        u_stroke_nm=_units(limits.u_stroke_mm, NM_PER_MM),
        u_speed_um_per_s=_units(limits.u_speed_mm_s, 1000),
        u_acceleration_mm_per_s2=_units(limits.u_acceleration_mm_s2, 1),
        spindle_mrpm=_units(limits.spindle_rpm, 1000),
    )


def _units(value: float, per_unit: int) -> int:
    """Return value * per_unit rounded down, forgiving the last digit of a decimal fraction."""
    return floor(value * per_unit * (1 + 1e-12))


def check_bounds(bounds: Bounds) -> None:
    """Refuse bounds of u that the header of an image does not hold, TABLE_FORMAT.md."""
    reach_nm = max(bounds.u_max_nm, -bounds.u_min_nm)
    lines = [
        f"u: {what} comes to {found / NM_PER_MM:.6g} {unit}, a table holds {most / NM_PER_MM:.6g}; "
        f"{remedy}"
        for what, found, most, unit, remedy in (
            ("its travel to one side", reach_nm, MAX_U_NM, "mm", "give a flatter shape"),
            ("u'", bounds.u1_peak_nm_per_rad, MAX_PEAK_NM, "mm/rad", "give a flatter shape"),
            ("u''", bounds.u2_peak_nm_per_rad2, MAX_PEAK_NM, "mm/rad2", "give a smoother shape"),
        )
        if found > most
    ]
    if lines:
        raise CamtoolsError(lines)


def table_of(
    part: PartFile, spindle_rpm: float, bounds: Bounds, channels: tuple[Channel, ...]
) -> Table:
    """Return a table of channels over the drawing's angle, u first, in the sense of cutting."""
    check_bounds(bounds)
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
        tuple(in_sense(channel, process.direction) for channel in channels),
    )


def check_tolerance(tolerance_nm: float) -> None:
    """Refuse a tolerance that is not a length of at most MAX_TOLERANCE_NM."""
    if not 0 < tolerance_nm <= MAX_TOLERANCE_NM:
        problem = f"must be above 0 and at most {MAX_TOLERANCE_NM:g}"
        raise CamtoolsError([f"tolerance_nm = {tolerance_nm:g}: {problem}; give nanometres"])
