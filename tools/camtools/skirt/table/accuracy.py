"""How far a quantised table is from the exact geometry, on dense grids off the knots.

What is measured here is bounded by MATHS.md (48) .. (50).

>>> from camtools.skirt.geometry.skirt_geometry import make_geometry
>>> from camtools.skirt.part.part_file import example_part
>>> from camtools.skirt.table.channels import u_channel
>>> geometry = make_geometry(example_part())
>>> accuracy = measure_u(geometry, u_channel(geometry, 3, 32))
>>> accuracy.value_nm < 1.0, accuracy.first_share < 1e-3, accuracy.second_share < 1e-3
(True, True, True)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camtools.base.quantities import NM_PER_MM, Floats
from camtools.skirt.geometry.skirt_geometry import Geometry
from camtools.skirt.table.channels import height_range_nm
from camtools.table.channel import Channel
from camtools.table.evaluate import (
    GRID_MARGIN,
    PLACES,
    ROUNDING_LSB,
    Values,
    evaluate_grid,
    evaluate_x,
)
from camtools.table.quantise import slice_heights_mm

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


def _accuracy(channel: Channel, got: Values, exact: Values) -> Accuracy:
    errors = [float(np.abs(a - b).max()) for a, b in zip(got, exact, strict=True)]
    peaks = [float(np.abs(values).max()) for values in exact]
    lsb_nm = channel.lsb
    value_nm = GRID_MARGIN * errors[0] + ROUNDING_LSB * lsb_nm
    first, second = GRID_MARGIN * errors[1], GRID_MARGIN * errors[2]
    return Accuracy(value_nm, first, second, peaks[1], peaks[2], lsb_nm)


def _between(geometry: Geometry, n_slices: int, weights: Floats) -> Floats:
    """Return heights in every interval, at both ends and at every break of the splines [nm]."""
    range_nm = height_range_nm(geometry)
    slices = slice_heights_mm(range_nm, n_slices) * NM_PER_MM
    inside = slices[:-1, None] + np.diff(slices)[:, None] * weights
    heights = np.concatenate([inside.ravel(), slices[-1:], geometry.breaks_mm() * NM_PER_MM])
    return np.asarray(np.clip(heights, *range_nm), dtype=np.float64)


def measure_u(geometry: Geometry, channel: Channel, z_nm: Floats | None = None) -> Accuracy:
    """Return the error of a u channel.

    Parameters
    ----------
    geometry : Geometry
        The truth.
    channel : Channel
        Of kind u, made from it.
    z_nm : ndarray, shape (n,), optional
        Heights to look at; the default is a dense grid with both ends and all kinks.
    """
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
