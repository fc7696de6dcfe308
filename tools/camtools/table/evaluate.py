"""Reference evaluation of a quantised table in double by the firmware's formula, MATHS.md (46).

>>> coefficients = np.array([[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]])
>>> polynomial_bounds(coefficients)  # t^2 on 0 .. 1
(0.0, 1.0)
"""

from dataclasses import replace
from math import ceil, comb
from typing import NamedTuple

import numpy as np

from camtools.base.quantities import Floats, Ints
from camtools.table.channel import (
    OVER_HEIGHT,
    RATIO_ONE,
    Bounds,
    Channel,
    channel_coefficients,
    segment_coefficients,
)

_SUBDIVISIONS = 8


class Values(NamedTuple):
    """Value and two derivatives: in the unit of the channel, per rad; of x in nm, per nm."""

    value: Floats
    d1: Floats
    d2: Floats


def knot_interval(channel: Channel) -> float:
    """Return one knot interval h: rad for u, nm for x."""
    if channel.kind in OVER_HEIGHT:
        return (channel.z_last_nm - channel.z_first_nm) / (channel.n_slices - 1)
    return float(2 * np.pi / (1 << (channel.log2_knots + channel.log2_repeat)))


def locate(channel: Channel, z_nm: Floats) -> tuple[Ints, Floats]:
    """Return slice and weight of the next one at clamped heights, or numbers of patterns."""
    if channel.has_patterns:
        i_slice = np.minimum(z_nm.astype(np.int64), channel.n_slices - 2)
        return i_slice, z_nm - i_slice
    span = (z_nm - channel.z_first_nm) * (channel.slices_per_nm_q48 * 2.0**-48)
    place = np.clip(span, 0, channel.n_slices - 1)
    i_slice = np.minimum(place.astype(np.int64), channel.n_slices - 2)
    return i_slice, place - i_slice


def power_rows(t: Floats) -> Floats:
    """Return weights of c0 .. c5 for value, first and second derivative, shape (3, 6, n)."""
    n, zero = np.arange(6)[:, None], np.zeros_like(t)
    value = t**n
    first = np.vstack([zero, n[1:] * value[:-1]])
    second = np.vstack([zero, zero, n[2:] * n[1:-1] * value[:-2]])
    return np.stack([value, first, second])


def _scaled(channel: Channel, raw: Floats) -> Values:
    h, lsb = knot_interval(channel), channel.lsb
    return Values(channel.value_offset + raw[0] * lsb, raw[1] * (lsb / h), raw[2] * (lsb / h**2))


def evaluate_grid(channel: Channel, z_nm: Floats, t: Floats) -> Values:
    """Return a channel at heights and places 0 .. 1 of all segments, (n_z, n_knots * n_t)."""
    i_slice, weight = locate(channel, z_nm)
    w = weight[:, None, None]
    blended = (1 - w) * channel.knots[i_slice] + w * channel.knots[i_slice + 1]
    coefficients = segment_coefficients(blended, periodic=True)
    raw = np.einsum("zkc,dct->dzkt", coefficients, power_rows(t), optimize=True)
    return _scaled(channel, raw.reshape(3, z_nm.size, -1))


def evaluate_at(channel: Channel, turn: Floats, z_nm: Floats) -> Values:
    """Return a channel over angle at points of turn and height, shape (n,)."""
    place = np.mod(turn * (1 << channel.log2_repeat), 1.0) * channel.knots.shape[1]
    i_knot = np.minimum(place.astype(np.int64), channel.knots.shape[1] - 1)
    i_slice, weight = locate(channel, z_nm)
    coefficients = channel_coefficients(channel)
    blended = (1 - weight)[:, None] * coefficients[i_slice, i_knot]
    blended += weight[:, None] * coefficients[i_slice + 1, i_knot]
    return _scaled(channel, np.einsum("nc,dcn->dn", blended, power_rows(place - i_knot)))


def evaluate_x(channel: Channel, z_nm: Floats) -> Values:
    """Return the long half axis and its height derivatives at heights of shape (n,)."""
    i_knot, t = locate(channel, z_nm)
    coefficients = channel_coefficients(channel)[i_knot].astype(np.float64)
    return _scaled(channel, np.einsum("nc,dcn->dn", coefficients, power_rows(t)))


def _bernstein_rows(degree: int) -> Floats:
    """Return the matrix from power coefficients to control points of all sub-intervals."""
    n, m = degree + 1, _SUBDIVISIONS
    shift = np.zeros((m, n, n))  # c_i -> coefficient of tau^j in sub-interval s
    for s in range(m):
        for i in range(n):
            for j in range(i + 1):
                shift[s, i, j] = comb(i, j) * (s / m) ** (i - j) / m**j
    control = np.array([[comb(k, j) / comb(degree, j) for k in range(n)] for j in range(n)])
    return np.asarray(np.concatenate(list(shift @ control), axis=1), dtype=np.float64)


def polynomial_bounds(coefficients: Floats) -> tuple[float, float]:
    """Return true bounds of polynomials, lowest power first, on 0 .. 1, MATHS.md (51)."""
    points = coefficients @ _bernstein_rows(coefficients.shape[-1] - 1)
    return float(points.min()), float(points.max())


class Extent(NamedTuple):
    """Range of values in whole units of the channel."""

    low: int
    high: int


_WHOLE = 10 * _SUBDIVISIONS**5  # times this, control points of whole coefficients are whole


def _outwards(channel: Channel, low: int, high: int) -> Extent:
    """Return a range in LSB, and an LSB more, in whole units."""
    frac, offset = channel.frac_bits, channel.value_offset
    return Extent(offset + ((low - 1) >> frac), offset - ((-high - 1) >> frac))


def extent(channel: Channel) -> Extent:
    """Return what a channel takes, exactly as the controller finds it: cam_bounds.c."""
    rows = np.rint(_bernstein_rows(5) * _WHOLE).astype(np.int64)
    points = channel_coefficients(channel).astype(np.int64) @ rows
    low, high = int(points.min()) // _WHOLE, -(-int(points.max()) // _WHOLE)
    knots = _outwards(channel, channel.p_min, channel.p_max)
    found = _outwards(channel, low, high)
    return Extent(min(knots.low, found.low), max(knots.high, found.high))


class RawBounds(NamedTuple):
    """Bounds over all segments, in LSB: value, and magnitudes of the two t-derivatives."""

    low: float
    high: float
    first: float
    second: float


def raw_bounds(channel: Channel) -> RawBounds:
    """Return true bounds of a channel between its knots too; blended slices lie inside."""
    c = channel_coefficients(channel).astype(np.float64)
    first = c[..., 1:] * np.arange(1, 6)
    second = first[..., 1:] * np.arange(1, 5)
    low, high = polynomial_bounds(c)
    d1, d2 = polynomial_bounds(first), polynomial_bounds(second)
    return RawBounds(low, high, max(-d1[0], d1[1]), max(-d2[0], d2[1]))


class Continuity(NamedTuple):
    """Largest jumps between neighbouring segments, nm and per knot unit of angle or height."""

    value: float
    first: float
    second: float


_AT_END = np.array([[1, 1, 1, 1, 1, 1], [0, 1, 2, 3, 4, 5], [0, 0, 2, 6, 12, 20]])
_AT_START = np.array([[1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 2, 0, 0, 0]])


def jumps(channel: Channel) -> tuple[Continuity, Continuity]:
    """Return the jumps inside the pattern, and at its wrap (of x: 0), in exact integers."""
    c = channel_coefficients(channel)
    ends, starts = c @ _AT_END.T, np.roll(c, -1, axis=-2) @ _AT_START.T
    gap = np.abs(ends - starts).reshape(-1, c.shape[-2], 3).max(axis=0)
    h, lsb = knot_interval(channel), channel.lsb
    scale = np.array([lsb, lsb / h, lsb / h**2])
    inside = gap[:-1].max(axis=0, initial=0) * scale
    wrap = gap[-1] * scale if channel.kind not in OVER_HEIGHT else np.zeros(3)
    return Continuity(*map(float, inside)), Continuity(*map(float, wrap))


ROUNDING_LSB = 1.0  # what the firmware's arithmetic may add to the table's own error
GRID_MARGIN = 1.01  # the worst place may lie between the points of the grid
PLACES = np.array([0.0, 0.03, 0.11, 0.21, 0.31, 0.41, 0.5, 0.62, 0.73, 0.83, 0.93, 0.98])


_PLACES_PER_KNOT = 8
_PEAK_MARGIN = 1.002  # between the places, and the firmware's rounding
_HEIGHTS_BETWEEN = 4


class MotionPeaks(NamedTuple):
    """Peaks of a table with modulation, per mean speed and its square."""

    ratio: float
    spindle_rad2: float  # |r r'|
    first: float  # |y' r| of the other channel y, in its unit
    second: float  # |y'' r^2 + y' r r'|


def peaks_together(y: Channel, speed: Channel) -> MotionPeaks:
    """Return what a channel and the spindle's speed do together, on a fine grid."""
    n = _PLACES_PER_KNOT * max(y.knots.shape[1], speed.knots.shape[1])
    n_z = _HEIGHTS_BETWEEN * max(y.n_slices, speed.n_slices) + 1
    z_nm = np.linspace(y.z_first_nm, y.z_last_nm, n_z)
    if y.has_patterns:
        z_nm = np.arange(y.n_slices, dtype=np.float64)
    found = np.zeros(4)
    for some in np.array_split(z_nm, max(1, z_nm.size * n // 500_000)):
        per_knot = (n // channel.knots.shape[1] for channel in (y, speed))
        motion, ratio = (
            evaluate_grid(channel, some, np.arange(k) / k)
            for channel, k in zip((y, speed), per_knot, strict=True)
        )
        r, r1 = ratio.value / RATIO_ONE, ratio.d1 / RATIO_ONE
        here = (r, r * r1, motion.d1 * r, motion.d2 * r**2 + motion.d1 * r * r1)
        found = np.maximum(found, [float(np.abs(values).max()) for values in here])
    return MotionPeaks(*(float(peak) * _PEAK_MARGIN for peak in found))


def moving_bounds(uniform: Bounds, peaks: MotionPeaks) -> Bounds:
    """Return the bounds of u where the spindle is modulated: TABLE_FORMAT.md, header."""
    return replace(
        uniform,
        u1_peak_nm_per_rad=ceil(peaks.first),
        u2_peak_nm_per_rad2=ceil(peaks.second),
        spindle_peak_ppm_per_rad=ceil(peaks.spindle_rad2 * 1e6),
    )
