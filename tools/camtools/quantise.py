"""From exact functions to channels of integers; their error is that of MATHS.md (49).

>>> import numpy as np
>>> knots = np.array([[[0.0, 0, 0], [1000.0, 0, 0], [0, 0, 0], [1000.0, 0, 0]]])
>>> channel = quantise(KIND_U, knots, 1, (0, 1_000_000))
>>> channel.offset_nm, channel.frac_bits
(500, 6)
"""

from __future__ import annotations

from dataclasses import replace
from math import ceil, floor, log2

import numpy as np

from camtools.evaluate import raw_bounds
from camtools.geometry import NM_PER_MM, Geometry
from camtools.image import (
    KIND_U,
    KIND_X,
    MAX_FRAC_BITS,
    SUM_LIMIT,
    Channel,
    channel_coefficients,
    largest_sum,
)
from camtools.sections import Floats


class TooLargeError(Exception):
    """No frac_bits of 0 .. 8 keeps the bound of TABLE_FORMAT.md."""


def _integers(
    kind: int, knots_nm: Floats, log2_repeat: int, range_nm: tuple[int, int], frac_bits: int
) -> Channel:
    """Return the channel for given frac_bits; its bounds are not filled in."""
    p = knots_nm[..., 0]
    offset_nm = round((float(p.max()) + float(p.min())) / 2)
    scaled = (knots_nm - np.array([offset_nm, 0, 0])) * 2.0**frac_bits
    if np.abs(scaled).max() > SUM_LIMIT:
        raise TooLargeError
    knots = np.rint(scaled).astype(np.int32)
    return Channel(kind, knots, log2_repeat, frac_bits, *range_nm, offset_nm, 0, 0, 0, 0)


def _start_bits(kind: int, knots_nm: Floats) -> int:
    """Return frac_bits from the size of the numbers, at most one too many."""
    coarse = _integers(kind, knots_nm / 2**16, 0, (0, 1), 8)
    size = max(1, largest_sum(channel_coefficients(coarse))) * 2.0**8
    return min(MAX_FRAC_BITS, floor(log2(SUM_LIMIT / size)) + 1)


def quantise(kind: int, knots_nm: Floats, log2_repeat: int, range_nm: tuple[int, int]) -> Channel:
    """Return a channel with as many fraction bits as the format's bound allows.

    Parameters
    ----------
    kind : int
        KIND_U or KIND_X.
    knots_nm : ndarray, shape (n_slices, n_knots, 3)
        Exact triples (value, h value', h^2 value'' / 2) [nm].
    log2_repeat : int
        Of the channel.
    range_nm : (int, int)
        Height of the first and of the last slice.

    Raises
    ------
    TooLargeError
        Even whole nanometres are too fine.
    """
    for frac_bits in range(_start_bits(kind, knots_nm), -1, -1):
        try:
            channel = _integers(kind, knots_nm, log2_repeat, range_nm, frac_bits)
        except TooLargeError:
            continue
        if largest_sum(channel_coefficients(channel)) <= SUM_LIMIT:
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


def height_range_nm(geometry: Geometry) -> tuple[int, int]:
    """Return the profile's height range in whole nanometres."""
    return round(geometry.z_first_mm * NM_PER_MM), round(geometry.z_last_mm * NM_PER_MM)


def slice_heights_mm(range_nm: tuple[int, int], n_slices: int) -> Floats:
    """Return the heights of equally spaced slices, shape (n_slices,)."""
    return np.linspace(range_nm[0], range_nm[1], n_slices) / NM_PER_MM


def _curvature(geometry: Geometry, phi_rad: Floats, z_mm: Floats, spacing_mm: float) -> Floats:
    """Return d2/dz2 of (delta, d1, d2), shape (3, n, n_phi), inside one piece of the shape."""
    breaks = geometry.breaks_mm()
    piece = np.clip(np.searchsorted(breaks, z_mm, side="right") - 1, 0, breaks.size - 2)
    step = np.minimum(spacing_mm, np.diff(breaks)[piece]) / 4
    middle = np.clip(z_mm, breaks[piece] + step, breaks[piece + 1] - step)
    below, here, above = (
        np.stack(geometry.delta(phi_rad, (middle + k * step)[:, None])[:3]) for k in (-1, 0, 1)
    )
    return np.asarray((below - 2 * here + above) / step[:, None] ** 2, dtype=np.float64)


def balanced(geometry: Geometry, phi_rad: Floats, z_mm: Floats, spacing_mm: float) -> Floats:
    """Return what slices store so that blending errs to both sides alike.

    Chords between points of a curve err to one side by spacing^2 / 8 of its curvature; moved by
    half of that they err by half as much, MATHS.md (50).

    Parameters
    ----------
    phi_rad : ndarray, shape (n_phi,)
        Angles [rad].
    z_mm : ndarray, shape (n,)
        Heights of slices [mm], neighbours spacing_mm apart.

    Returns
    -------
    ndarray, shape (3, n, n_phi)
        Reduction and two angle derivatives [mm, mm/rad, mm/rad^2].
    """
    exact = np.stack(geometry.delta(phi_rad, z_mm[:, None])[:3])
    curvature = _curvature(geometry, phi_rad, z_mm, spacing_mm)
    return np.asarray(exact - curvature * (spacing_mm**2 / 16), dtype=np.float64)


def u_channel(
    geometry: Geometry, log2_knots: int, n_slices: int, *, is_balanced: bool = True
) -> Channel:
    """Return the quantised u channel of this size; unbalanced slices are exact themselves."""
    range_nm, repeat = height_range_nm(geometry), geometry.surface.log2_repeat
    h = 2 * np.pi / (1 << (log2_knots + repeat))
    z_mm = slice_heights_mm(range_nm, n_slices)
    spacing_mm = (range_nm[1] - range_nm[0]) / NM_PER_MM / (n_slices - 1)
    phi_rad = h * np.arange(1 << log2_knots, dtype=np.float64)
    if is_balanced:
        u = balanced(geometry, phi_rad, z_mm, spacing_mm)
    else:
        u = np.stack(geometry.delta(phi_rad, z_mm[:, None])[:3])
    knots_nm = np.stack([u[0], h * u[1], h**2 / 2 * u[2]], axis=-1) * NM_PER_MM
    return quantise(KIND_U, knots_nm, repeat, range_nm)


def x_channel(geometry: Geometry, n_knots: int) -> Channel:
    """Return the quantised x channel of this size."""
    range_nm = height_range_nm(geometry)
    z_mm = slice_heights_mm(range_nm, n_knots)
    h_mm = (range_nm[1] - range_nm[0]) / NM_PER_MM / (n_knots - 1)
    triple = [geometry.radius_mm(z_mm, n) * h_mm**n / max(1, n) for n in range(3)]
    knots_nm = np.stack(triple, axis=-1)[:, None] * NM_PER_MM
    return quantise(KIND_X, knots_nm, 0, range_nm)
