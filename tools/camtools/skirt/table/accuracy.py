"""From exact geometry to channels of a table, and how far those are from it.

>>> from camtools.skirt.geometry.skirt_geometry import make_geometry
>>> from camtools.skirt.part.part_file import example_part
>>> u_channel(make_geometry(example_part()), 3, 32).n_slices
32

What is measured here is bounded by MATHS.md (48) .. (50).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camtools.base.quantities import NM_PER_MM, Floats, Ints
from camtools.skirt.geometry.skirt_geometry import Geometry
from camtools.table.channel import KIND_U, KIND_X, Channel, segment_coefficients
from camtools.table.evaluate import (
    GRID_MARGIN,
    PLACES,
    ROUNDING_LSB,
    Values,
    evaluate_grid,
    evaluate_x,
    power_rows,
)
from camtools.table.quantise import quantise, slice_heights_mm


def height_range_nm(geometry: Geometry) -> tuple[int, int]:
    """Return the profile's height range in whole nanometres."""
    return round(geometry.z_first_mm * NM_PER_MM), round(geometry.z_last_mm * NM_PER_MM)


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
    half of that they err by half as much, MATHS.md (50). Returned are the reduction and two angle
    derivatives [mm, mm/rad, mm/rad^2], shape (3, n, n_phi), of n slices spacing_mm apart.
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
    return quantise(KIND_U, _as_stored(u, h) * NM_PER_MM, repeat, range_nm)


def _as_stored(u: Floats, h: float) -> Floats:
    """Return value and derivatives (3, ..) as a table with knots h [rad] apart stores them."""
    return np.stack([u[0], h * u[1], h**2 / 2 * u[2]], axis=-1)


def x_channel(geometry: Geometry, n_knots: int) -> Channel:
    """Return the quantised x channel of this size."""
    range_nm = height_range_nm(geometry)
    z_mm = slice_heights_mm(range_nm, n_knots)
    h_mm = (range_nm[1] - range_nm[0]) / NM_PER_MM / (n_knots - 1)
    triple = [geometry.radius_mm(z_mm, n) * h_mm**n / max(1, n) for n in range(3)]
    knots_nm = np.stack(triple, axis=-1)[:, None] * NM_PER_MM
    return quantise(KIND_X, knots_nm, 0, range_nm)


_W = np.array([0.0, 0.13, 0.27, 0.5, 0.71, 0.91])
_W_X = np.arange(32) / 32


class Accuracy(NamedTuple):
    """Largest errors against exact geometry; derivatives of u by angle, of x by height."""

    value_nm: float  # with the firmware's rounding
    first: float  # nm/rad, or nm/mm for x
    second: float  # nm/rad^2, or nm/mm^2 for x
    first_peak: float  # largest exact magnitude, same units
    second_peak: float
    lsb_nm: float

    @property
    def first_share(self) -> float:
        """Error of the first derivative as a share of its peak."""
        return self.first / self.first_peak if self.first_peak else 0.0

    @property
    def second_share(self) -> float:
        """Error of the second derivative as a share of its peak."""
        return self.second / self.second_peak if self.second_peak else 0.0

    @property
    def shares(self) -> tuple[float, float]:
        """Both."""
        return self.first_share, self.second_share


def _accuracy(channel: Channel, got: Values, exact: Values) -> Accuracy:
    errors = [float(np.abs(a - b).max()) for a, b in zip(got, exact, strict=True)]
    peaks = [float(np.abs(values).max()) for values in exact]
    value_nm, first, second = (GRID_MARGIN * error for error in errors)
    value_nm += ROUNDING_LSB * channel.lsb
    return Accuracy(value_nm, first, second, peaks[1], peaks[2], channel.lsb)


def _between(geometry: Geometry, n_slices: int, weights: Floats) -> Floats:
    """Return heights in every interval, at both ends and at every break of the splines [nm]."""
    range_nm = height_range_nm(geometry)
    slices = slice_heights_mm(range_nm, n_slices) * NM_PER_MM
    inside = slices[:-1, None] + np.diff(slices)[:, None] * weights
    heights = np.concatenate([inside.ravel(), slices[-1:], geometry.breaks_mm() * NM_PER_MM])
    return np.asarray(np.clip(heights, *range_nm), dtype=np.float64)


def measure_u(geometry: Geometry, channel: Channel, z_nm: Floats | None = None) -> Accuracy:
    """Return the error of a u channel at heights, by default a dense grid with all kinks."""
    z_nm = _between(geometry, channel.n_slices, _W) if z_nm is None else z_nm
    n_knots = channel.knots.shape[1]
    pattern = (np.arange(n_knots)[:, None] + PLACES).ravel() / n_knots
    phi_rad = pattern * (2 * np.pi / (1 << channel.log2_repeat))
    u = geometry.delta(phi_rad, z_nm[:, None] / NM_PER_MM)
    exact = Values(u.delta * NM_PER_MM, u.d1 * NM_PER_MM, u.d2 * NM_PER_MM)
    return _accuracy(channel, evaluate_grid(channel, z_nm, PLACES), exact)


def measure_x(geometry: Geometry, channel: Channel) -> Accuracy:
    """Return the error of an x channel on a dense grid with both ends and all breaks."""
    z_nm = _between(geometry, channel.n_slices, _W_X)
    a = [geometry.radius_mm(z_nm / NM_PER_MM, n) * NM_PER_MM for n in range(3)]
    got = evaluate_x(channel, z_nm)
    per_mm = Values(got.value, got.d1 * NM_PER_MM, got.d2 * NM_PER_MM**2)
    return _accuracy(channel, per_mm, Values(*a))


_ANGLES = 33
_PIECES = 24


class HeightError(NamedTuple):
    """What blending does to u between slices, from the exact geometry, MATHS.md (50)."""

    curvatures: Floats  # largest |d2u/dz2| of each piece, nm per nm^2, shape (n + 1,)
    worst_nm: Floats  # where that is, above the first slice, shape (n + 1,)
    kinks_nm: Floats  # heights of the breaks above the first slice, shape (n,)
    bends: Floats  # largest |jump of du/dz| there, shape (n,)
    span_nm: float
    largest_nm: float  # where the second angle derivative peaks, above the first slice
    peaks_mm: tuple[float, float]  # of the first and second angle derivative, mm/rad, mm/rad^2

    def estimate_nm(self, n_slices: Ints) -> Floats:
        """Return the larger of both kinds of error for each number of slices."""
        spacing = self.span_nm / (n_slices - 1)
        worst = self.curvatures.max() * spacing**2 / 16
        for kink_nm, bend in zip(self.kinks_nm, self.bends, strict=True):
            w = np.mod(kink_nm / spacing, 1.0)
            worst = np.maximum(worst, bend * w * (1 - w) * spacing)
        return np.asarray(worst, dtype=np.float64)

    def probes_nm(self, n_slices: int) -> Floats:
        """Return the heights above the first slice where the error should be worst."""
        spacing = self.span_nm / (n_slices - 1)
        i_slice = np.minimum(np.floor(self.worst_nm / spacing), n_slices - 2)
        return np.concatenate([(i_slice + 0.5) * spacing, self.kinks_nm, [self.largest_nm]])


def height_error(geometry: Geometry) -> HeightError:
    """Return curvature and kinks of u over height, the worst over the angle."""
    breaks = geometry.breaks_mm()
    share = np.arange(_PIECES + 1) / _PIECES
    step = np.diff(breaks)[:, None, None] / _PIECES
    along = np.diff(breaks)[:, None] * share
    z = breaks[:-1, None] + along
    pattern_rad = 2 * np.pi / (1 << geometry.surface.log2_repeat)
    u = geometry.delta(np.linspace(0, pattern_rad, _ANGLES), z[..., None])
    peaks = float(np.abs(u.d1).max()), float(np.abs(u.d2).max())
    largest_mm = float(z.ravel()[np.abs(u.d2).max(axis=2).argmax()])
    slopes = np.diff(u.delta, axis=1) / step
    curves = np.diff(slopes, axis=1) / step
    # slopes at the breaks themselves, extrapolated from inside the pieces
    upper = slopes[:, -1] + curves[:, -1] * step[:, 0] / 2
    lower = slopes[:, 0] - curves[:, 0] * step[:, 0] / 2
    bends = np.abs(lower[1:] - upper[:-1]).max(axis=1, initial=0)
    worst = np.abs(curves).max(axis=2)
    place = z[np.arange(worst.shape[0]), 1 + worst.argmax(axis=1)]
    first, last = height_range_nm(geometry)
    above = place * NM_PER_MM - first, breaks[1:-1] * NM_PER_MM - first
    return HeightError(
        worst.max(axis=1) / NM_PER_MM,
        *above,
        bends,
        last - first,
        largest_mm * NM_PER_MM - first,
        peaks,
    )


class Probe(NamedTuple):
    """Error of an unquantised table at its worst heights."""

    value_nm: float
    shares: tuple[float, float]  # errors of the first and second derivative over their peaks


def probe(
    geometry: Geometry,
    estimate: HeightError,
    log2_knots: int,
    n_slices: int,
    *,
    has_kinks: bool = False,
) -> Probe:
    """Return the error of an unquantised table of this size at its worst heights.

    Only the slices around these heights are made, so the cost does not grow with their number. The
    estimate may have missed the peak of a second derivative that has kinks.
    """
    probes_nm = estimate.probes_nm(n_slices)
    spacing, first_nm = estimate.span_nm / (n_slices - 1), height_range_nm(geometry)[0]
    i_slice = np.minimum(np.floor(probes_nm / spacing), n_slices - 2)
    weight = (probes_nm / spacing - i_slice)[:, None, None]
    h = 2 * np.pi / (1 << (log2_knots + geometry.surface.log2_repeat))
    knots = np.arange(1 << log2_knots, dtype=np.float64)
    around_mm = (first_nm + (i_slice + np.array([[0], [1]])) * spacing) / NM_PER_MM
    u = balanced(geometry, h * knots, around_mm.ravel(), spacing / NM_PER_MM)
    stored = _as_stored(u, h)
    below, above = stored.reshape(*around_mm.shape, *stored.shape[1:])
    blended = segment_coefficients((1 - weight) * below + weight * above, periodic=True)
    phi_rad = (h * (knots[:, None] + PLACES)).ravel()
    exact = geometry.delta(phi_rad, (first_nm + probes_nm[:, None]) / NM_PER_MM)
    got = np.einsum("zkc,dct->dzkt", blended, power_rows(PLACES)).reshape(3, *exact.delta.shape)
    errors = [float(np.abs(got[n] / h**n - exact[n]).max()) for n in range(3)]
    peaks = list(estimate.peaks_mm)
    if has_kinks:
        peaks = [max(peak, float(np.abs(exact[n]).max())) for n, peak in enumerate(peaks, 1)]
    first, second = (
        error / peak if peak else 0.0 for error, peak in zip(errors[1:], peaks, strict=True)
    )
    return Probe(errors[0] * NM_PER_MM, (first, second))
