"""From the exact geometry of a skirt to the channels of u and x, MATHS.md (49), (50).

>>> from camtools.skirt.geometry.skirt_geometry import make_geometry
>>> from camtools.skirt.part.part_file import example_part
>>> u_channel(make_geometry(example_part()), 3, 32).n_slices
32
"""

from __future__ import annotations

import numpy as np

from camtools.base.quantities import NM_PER_MM, Floats
from camtools.skirt.geometry.skirt_geometry import Geometry
from camtools.table.channel import KIND_U, KIND_X, Channel
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
