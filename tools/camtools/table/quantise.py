"""From exact functions to channels of integers; their error is that of MATHS.md (49).

>>> from camtools.table.channel import KIND_U
>>> knots = np.array([[[0.0, 0, 0], [1000.0, 0, 0], [0, 0, 0], [1000.0, 0, 0]]])
>>> channel = quantise(KIND_U, knots, 1, (0, 1_000_000))
>>> channel.value_offset, channel.frac_bits
(500, 6)
"""

from dataclasses import replace
from math import ceil, floor, log2

import numpy as np

from camtools.base.quantities import NM_PER_MM, Floats
from camtools.table.channel import (
    MAX_FRAC_BITS,
    SUM_LIMIT,
    Channel,
    channel_coefficients,
    in_sense,
    largest_sum,
)
from camtools.table.evaluate import raw_bounds


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
    return max(largest_sum(channel_coefficients(one)) for one in senses)


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
