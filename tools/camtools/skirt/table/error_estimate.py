"""Cheap estimates of the error of u, so that only promising sizes are measured.

>>> from camtools.skirt.geometry.skirt_geometry import make_geometry
>>> from camtools.skirt.part.part_file import example_part
>>> estimate = height_error(make_geometry(example_part()))
>>> [float(nm) for nm in estimate.kinks_nm if estimate.bends[0] >= 0][1]
20000000.0
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camtools.base.quantities import NM_PER_MM, Floats, Ints
from camtools.skirt.geometry.skirt_geometry import Geometry
from camtools.skirt.table.channels import balanced, height_range_nm
from camtools.table.evaluate import PLACES, power_rows
from camtools.table.quintics import segment_coefficients

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

    Only the slices around these heights are made, so the cost does not grow with their number.

    Parameters
    ----------
    has_kinks : bool
        The second derivative has kinks, between which the estimate may have missed its peak.
    """
    probes_nm = estimate.probes_nm(n_slices)
    spacing, first_nm = estimate.span_nm / (n_slices - 1), height_range_nm(geometry)[0]
    i_slice = np.minimum(np.floor(probes_nm / spacing), n_slices - 2)
    weight = (probes_nm / spacing - i_slice)[:, None, None]
    h = 2 * np.pi / (1 << (log2_knots + geometry.surface.log2_repeat))
    knots = np.arange(1 << log2_knots, dtype=np.float64)
    around_mm = (first_nm + (i_slice + np.array([[0], [1]])) * spacing) / NM_PER_MM
    u = balanced(geometry, h * knots, around_mm.ravel(), spacing / NM_PER_MM)
    stored = np.stack([u[0], h * u[1], h**2 / 2 * u[2]], axis=-1)
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
