"""From exact functions to channels of integers, MATHS.md (49), and to the header of their table.

>>> from camtools.part.common import MachineLimits
>>> image_limits(MachineLimits()).u_speed_um_per_s
400000
"""

from dataclasses import replace
from math import ceil, floor, log2
from typing import Protocol

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import NM_PER_MM, Floats
from camtools.part.common import MachineLimits, PartFile
from camtools.table.channel import (
    MAX_FRAC_BITS,
    SUM_LIMIT,
    Bounds,
    Channel,
    ImageLimits,
    channel_coefficients,
    in_sense,
    largest_sum,
)
from camtools.table.evaluate import extent, knot_interval, raw_bounds
from camtools.table.image import Table


class TooLargeError(Exception):
    """No frac_bits of 0 .. 8 keeps the bound of TABLE_FORMAT.md."""


def _integers(
    kind: int, exact: Floats, log2_repeat: int, range_nm: tuple[int, int], frac_bits: int
) -> Channel:
    """Return the channel for given frac_bits; its bounds are not filled in."""
    p = exact[..., 0]
    value_offset = round((float(p.max()) + float(p.min())) / 2)
    scaled = (exact - np.array([value_offset, 0, 0])) * 2.0**frac_bits
    if np.abs(scaled).max() > SUM_LIMIT:
        raise TooLargeError
    knots = np.rint(scaled).astype(np.int32)
    return Channel(kind, knots, log2_repeat, frac_bits, *range_nm, value_offset, 0, 0, 0, 0)


def _largest_sum(channel: Channel) -> int:
    """Return the largest sum of both senses: a table must not depend on M3 or M4."""
    senses = (in_sense(channel, direction) for direction in (1, -1))
    return max(largest_sum(channel_coefficients(sense)) for sense in senses)


def quantise(kind: int, exact: Floats, log2_repeat: int, range_nm: tuple[int, int]) -> Channel:
    """Return a channel of (value, h value', h^2 value''/2) with all fraction bits that fit."""
    # Begin with frac_bits from the size of the numbers, at most one too many.
    coarse = _integers(kind, exact / 2**16, 0, (0, 1), 8)
    size = max(1, _largest_sum(coarse)) * 2.0**8
    for frac_bits in range(min(MAX_FRAC_BITS, floor(log2(SUM_LIMIT / size)) + 1), -1, -1):
        try:
            channel = _integers(kind, exact, log2_repeat, range_nm, frac_bits)
        except TooLargeError:
            continue
        if _largest_sum(channel) <= SUM_LIMIT:
            return channel
    raise TooLargeError


def with_bounds(channel: Channel) -> Channel:
    """Return the channel with true bounds, between its knots too, rounded outwards."""
    bounds = raw_bounds(channel)
    return replace(
        channel,
        p_min=floor(bounds.low),
        p_max=ceil(bounds.high),
        v_max=ceil(bounds.first),
        a_max=ceil(bounds.second / 2),
    )


def slice_heights_mm(range_nm: tuple[int, int], n_slices: int) -> Floats:
    """Return the heights of equally spaced slices, shape (n_slices,)."""
    return np.linspace(range_nm[0], range_nm[1], n_slices) / NM_PER_MM


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
