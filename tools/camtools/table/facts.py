"""What the controller measures of a table when it takes it, in the controller's own integers.

The judgement of a cut (camtools.cut.demand) needs more than the header promises: how much u and
the swing change from slice to slice, how steep the profile of X is, what a modulated speed demands
of the spindle's loop. The functions here are those of firmware/table (cam_bounds, cam_peaks,
cam_x_slope, cam_spindle_demand), so that generator and controller judge by the same numbers.

>>> saturated(-1), saturated(1 << 40)
(0, 4294967295)
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from camtools.base.quantities import Ints
from camtools.table.channel import KIND_SPEED, KIND_SWING, KIND_U, KIND_X, RATIO_ONE, Channel
from camtools.table.evaluate import extent
from camtools.table.image import Table
from camtools.table.lobes import change_nm

_TURN_PER_RAD_Q20 = 166_887  # 2^20 / 2 pi, rounded up
_PER_RAD_Q24 = 2_670_176  # 2^24 / 2 pi
_MDEG_PER_TURN, _MDEG_PER_TURN_RAD, _MDEG_PER_TURN_RAD2 = 360_000, 57_296, 9_119
_UNIT_BITS = 26  # of an angle
_UINT32 = (1 << 32) - 1
_PPM = 1_000_000
_PER_SLICE = 4  # samples of a profile
_GUARD_BITS = 4
PACE_PLACES, PACE_PER_RAD = 33, 128


class SliceChange(NamedTuple):
    """How a channel changes from slice to slice, in its unit."""

    most: int
    per_rad: int
    kink: int


class SwingBounds(NamedTuple):
    """Bounds of the tool's swing, in thousandths of a degree and per rad."""

    most_mdeg: int
    first_mdeg_per_rad: int
    second_mdeg_per_rad2: int


class Pace(NamedTuple):
    """What a speed channel demands of the spindle's loop, MATHS.md (80)."""

    fall_ppm_per_rad: int
    set_q20: tuple[int, ...]
    rise_q20: int

    def set_at_q20(self, c_q16: int) -> int:
        """Return the bound of r + c r r' that the controller takes."""
        one_q16, last = (1 << 16) // PACE_PER_RAD, PACE_PLACES - 1
        k = 0
        while k < last and (k + 1) ** 2 * one_q16 <= c_q16:
            k += 1
        low, beyond_q16 = self.set_q20[k], c_q16 - k * k * one_q16
        if k == last:
            return low + ((self.rise_q20 * beyond_q16) >> 16) + 1
        rise = max(0, self.set_q20[k + 1] - low)
        return low + rise * beyond_q16 // ((2 * k + 1) * one_q16) + 1


class TableFacts(NamedTuple):
    """A table as the controller judges it: names and units of cam_table_t."""

    table: Table
    log2_knots: int  # of u, per turn
    u_spacing_nm: int
    angle_spacing_nm: int
    u_change: SliceChange
    is_lobe: bool
    is_swung: bool
    swing: SwingBounds
    swing_change: SliceChange
    is_modulated: bool
    ratio_max_q20: int
    pace: Pace
    x_slope_ppm: int
    x_bend_ppm_per_m: int
    least_change_nm: int  # of the lift between two lobes; 0 without lobes
    way_slope_ppm: int  # largest feed over its mean
    way_bend_ppm_per_m: int

    @property
    def span_nm(self) -> int:
        """Return the height over which Z feeds."""
        return self.table.z_last_nm - self.table.z_first_nm

    @property
    def rise_nm(self) -> int:
        """Return how far the surface rises above u = 0, a quarter added."""
        least = self.table.bounds.u_min_nm
        return -(least - (-least // 4)) if least < -1 else 0


def saturated(value: int) -> int:
    """Return a value limited to 32 bits without sign."""
    return min(max(value, 0), _UINT32)


def _spacing_nm(channel: Channel) -> int:
    return (channel.z_last_nm - channel.z_first_nm) // (channel.n_slices - 1)


def _wide(channel: Channel) -> Ints:
    return channel.knots.astype(np.int64)


class _Largest(NamedTuple):
    tenfold: int
    twice: int
    second_8192: int


def _largest(knots: Ints) -> _Largest:
    """Return the bounds of cam_bounds over all intervals of knots of shape (slices, n, 3)."""
    if knots.size == 0:
        return _Largest(0, 0, 0)
    p0, v0, a0 = np.moveaxis(knots, -1, 0)
    p1, v1, a1 = np.moveaxis(np.roll(knots, -1, axis=1), -1, 0)
    dp, dv, da = p1 - p0 - v0 - a0, v1 - v0 - 2 * a0, a1 - a0
    c3, c4, c5 = 10 * dp - 4 * dv + da, -15 * dp + 7 * dv - 2 * da, 6 * dp - 3 * dv + da
    tenfold = (
        *(10 * p0, 10 * p0 + 2 * v0, 10 * p0 + 4 * v0 + a0),
        *(10 * p1 - 4 * v1 + a1, 10 * p1 - 2 * v1),
    )
    twice = (2 * v0, 2 * v0 + a0, 2 * v0 + 2 * a0 + c3, 2 * v1 - a1)
    most = np.zeros_like(p0)
    for k in range(33):
        second = 16384 * a0 + 1536 * c3 * k + 96 * c4 * k**2 + 5 * c5 * k**3
        most = np.maximum(most, np.abs(second))
    most += np.maximum(np.abs(24 * c4), np.abs(24 * c4 + 120 * c5))
    return _Largest(
        max(int(np.abs(one).max()) for one in tenfold),
        max(int(np.abs(one).max()) for one in twice),
        int(most.max()),
    )


def change_of(channel: Channel) -> SliceChange:
    """Return how a channel changes over height: cam_peaks_of_change()."""
    steps = np.diff(_wide(channel), axis=0)
    step, bend = _largest(steps), _largest(np.diff(steps, axis=0))
    per_turn = 1 << (channel.log2_knots + channel.log2_repeat)
    slope_q20 = (step.twice + 1) // 2 * per_turn * _TURN_PER_RAD_Q20
    frac = channel.frac_bits

    def in_unit(lsb: int) -> int:
        return saturated((lsb + (1 << frac) - 1) >> frac)

    return SliceChange(
        in_unit((step.tenfold + 9) // 10),
        in_unit((slope_q20 + (1 << 20) - 1) >> 20),
        in_unit((bend.tenfold + 9) // 10),
    )


def swing_of(channel: Channel) -> SwingBounds:
    """Return the bounds of the swing: cam_peaks_of_swing()."""
    knots = _wide(channel)
    knots[..., 0] += channel.value_offset << channel.frac_bits
    bound, down = _largest(knots), _UNIT_BITS + channel.frac_bits
    per_turn = 1 << (channel.log2_knots + channel.log2_repeat)
    second = ((((bound.second_8192 >> 13) + 1) * per_turn * _MDEG_PER_TURN_RAD2) >> 13) + 1
    return SwingBounds(
        saturated((((bound.tenfold // 10 + 1) * _MDEG_PER_TURN) >> down) + 1),
        saturated(((bound.twice * per_turn * _MDEG_PER_TURN_RAD) >> (down + 1)) + 1),
        saturated(((second * per_turn) >> (down - 13)) + 1),
    )


def _per_rad(per_turn: Ints) -> Ints:
    """Return derivatives per turn as per rad, rounded away from 0."""
    magnitude = ((np.abs(per_turn) * _PER_RAD_Q24) >> 24) + 1
    return np.asarray(np.where(per_turn < 0, -magnitude, magnitude), dtype=np.int64)


def _truncated(value: Ints, by: int) -> Ints:
    return np.asarray(np.sign(value) * (np.abs(value) // by), dtype=np.int64)


def pace_of(channel: Channel | None) -> Pace:
    """Return what a speed channel demands of the spindle's loop: cam_spindle_demand_of()."""
    if channel is None:
        return Pace(0, (RATIO_ONE,) * PACE_PLACES, 0)
    knots, frac = _wide(channel), channel.frac_bits
    ratio_q28 = (channel.value_offset << 8) + (knots[..., 0] << (8 - frac))
    shift = channel.log2_knots + channel.log2_repeat
    slope_q20 = np.clip((knots[..., 1] << shift) >> frac, -(1 << 31), (1 << 31) - 1)
    product = _per_rad((ratio_q28 * slope_q20) >> 28)
    fall = (-_per_rad(slope_q20) * 1_000_000) >> 20
    told = [
        int(((ratio_q28 >> 8) + 1 + _truncated(product * k * k, PACE_PER_RAD)).max())
        for k in range(PACE_PLACES)
    ]
    set_q20 = tuple(max(one, RATIO_ONE) for one in told)
    return Pace(max(0, int(fall.max())), set_q20, max(0, int(product.max())))


def _rounded(value: Ints) -> Ints:
    return (value + (1 << (_GUARD_BITS - 1))) >> _GUARD_BITS


def _mul(c: Ints, a: Ints, b: Ints) -> Ints:
    return c + ((a * b + (1 << 31)) >> 32)


def _profile(channel: Channel, up_nm: list[int]) -> tuple[Ints, Ints]:
    """Return first and second derivative per slice spacing, in LSB: cam_eval_profile()."""
    last = channel.n_slices - 1
    slices = [up * channel.slices_per_nm_q48 for up in up_nm]
    low = np.array([min(one >> 48, last - 1) for one in slices])
    w_q31 = [(1 << 31) - 1 if one >> 48 >= last else (one >> 17) & 0x7FFFFFFF for one in slices]
    s_q32 = np.array([2 * w - (1 << 31) for w in w_q31], dtype=np.int64)
    knots = _wide(channel)[:, 0] << _GUARD_BITS
    (p0, v0, a0), (p1, v1, a1) = knots[low].T, knots[low + 1].T
    dp, dv = p1 - p0, v1 - v0
    w = v0 + v1 - 2 * dp
    o5 = a1 - a0 - 3 * w
    o3 = w - (o5 >> 1)
    o1 = dp - (o3 >> 2) - (o5 >> 4)
    e4 = (a0 + a1 - dv) >> 1
    e2 = (dv - e4) >> 1
    y = _mul(e4, o5, s_q32)
    d1 = _mul(y, o5, s_q32)
    d2 = _mul(d1, o5, s_q32)
    y = _mul(o3, y, s_q32)
    d1 = _mul(y, d1, s_q32)
    d2 = _mul(d1, d2, s_q32)
    y = _mul(e2, y, s_q32)
    d1 = _mul(y, d1, s_q32)
    d2 = _mul(d1, d2, s_q32)
    y = _mul(o1, y, s_q32)
    return _rounded(_mul(y, d1, s_q32)), _rounded(2 * d2)


class Barrel(NamedTuple):
    """Largest slope, rise [1e-6] and bend [1e-6 / m] of a channel over height."""

    slope_ppm: int
    rise_ppm: int
    bend_ppm_per_m: int


def barrel_of(channel: Channel) -> Barrel:
    """Return slope and bend of a channel over height: cam_x_slope_of()."""
    span_nm, n_slices = channel.z_last_nm - channel.z_first_nm, channel.n_slices - 1
    n = n_slices * _PER_SLICE
    d1, d2 = _profile(channel, [span_nm * i // n for i in range(n + 1)])

    def slope_ppm(per_slice: int) -> int:
        return ((abs(per_slice) * _PPM * n_slices) >> channel.frac_bits) // span_nm

    most_bend = slope_ppm(int(np.abs(d2).max()))
    bend = most_bend * 1_000_000_000 * n_slices // span_nm if most_bend < 1 << 21 else _UINT32
    return Barrel(
        saturated(slope_ppm(int(np.abs(d1).max()))),
        saturated(slope_ppm(max(0, int(d1.max())))),
        saturated(bend),
    )


def facts_of(table: Table) -> TableFacts:
    """Return what the controller measures of a table when it takes it."""
    u, speed, angle = table.channel(KIND_U), table.speed, table.angle
    is_swung = angle is not None and angle.kind == KIND_SWING
    changes = [change_nm(*two) for two in pairwise(table.lobes)]
    still = SliceChange(0, 0, 0)  # patterns are not next to each other
    swung = angle if is_swung else None
    barrel = barrel_of(table.channel(KIND_X))
    way = barrel_of(table.way) if table.way is not None else Barrel(0, 0, 0)
    ratio = RATIO_ONE
    if speed is not None:
        ratio = max(RATIO_ONE, extent(speed).high + 1)
    return TableFacts(
        table=table,
        log2_knots=u.log2_knots + u.log2_repeat,
        u_spacing_nm=_spacing_nm(u),
        angle_spacing_nm=_spacing_nm(angle) if angle is not None else 0,
        u_change=still if table.lobes else change_of(u),
        is_lobe=angle is not None,
        is_swung=is_swung,
        swing=swing_of(swung) if swung is not None else SwingBounds(0, 0, 0),
        swing_change=still if swung is None or table.lobes else change_of(swung),
        is_modulated=any(channel.kind == KIND_SPEED for channel in table.channels),
        ratio_max_q20=ratio,
        pace=pace_of(speed),
        x_slope_ppm=barrel.slope_ppm,
        x_bend_ppm_per_m=barrel.bend_ppm_per_m,
        least_change_nm=min(changes, default=0),
        way_slope_ppm=_PPM + min(way.rise_ppm, _UINT32 - _PPM),
        way_bend_ppm_per_m=way.bend_ppm_per_m,
    )
