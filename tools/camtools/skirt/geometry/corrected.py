"""A skirt as its table plays it when a gauged part has shown where the drawing is missed.

The correction is part of the surface that a nose leaves, MATHS.md (161).

>>> from camtools.cut.correction import N_NODES
>>> from camtools.skirt.geometry.skirt_geometry import make_geometry
>>> from camtools.skirt.part.part_file import example_part
>>> drawn = make_geometry(example_part())
>>> waves = {0: np.full(N_NODES, 2e-3 + 0j), 2: np.full(N_NODES, 1e-3 + 0j)}
>>> played = corrected(drawn, Correction(drawn.skirt_mm, waves))
>>> off = drawn.radius_mm(20.0) - played.radius_mm(20.0), played.delta(0.0, 20.0).delta
>>> [f"{float(mm):.4f}" for mm in off], played.surface.log2_repeat
(['0.0020', '0.0010'], 1)
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import PPoly

from camtools.base.quantities import Floats, FloatsLike, SectionValues
from camtools.cut.correction import Correction
from camtools.skirt.geometry.sides import heights_of
from camtools.skirt.geometry.skirt_geometry import Geometry, SkirtSurface
from camtools.table.channel import MAX_LOG2_REPEAT


@dataclass(frozen=True, eq=False)
class CorrectedSurface:
    """A surface with the waves of a correction taken off as well, by the drawing's angle."""

    inner: SkirtSurface
    correction: Correction

    @property
    def log2_repeat(self) -> int:
        """Return how often both repeat."""
        n = self.correction.repeats
        own = (n & -n).bit_length() - 1 if n else MAX_LOG2_REPEAT
        return min(self.inner.log2_repeat, own)

    def heights_mm(self) -> Floats:
        """Return the heights at which a curve of the surface has a break, rising."""
        return np.union1d(heights_of(self.inner), self.correction.nodes_mm)

    def delta(self, phi_rad: FloatsLike, z_mm: FloatsLike) -> SectionValues:
        """See `SkirtSurface`."""
        phi, z = np.asarray(phi_rad, dtype=np.float64), np.asarray(z_mm, dtype=np.float64)
        drawn, more = self.inner.delta(phi, z), self.correction.delta(phi, z)
        return SectionValues(*(a + b for a, b in zip(drawn, more, strict=True)))


def _piece_from(curve: PPoly, low_mm: float) -> Floats:
    """Return the cubic of the piece above a height, in the distance from that height."""
    return np.array([curve(low_mm, nu=n) / max(1, n * (n - 1)) for n in (3, 2, 1, 0)])


def _less(curve: PPoly, other: PPoly) -> PPoly:
    """Return the difference of two curves of cubics between the same ends."""
    inside = (other.x > curve.x[0]) & (other.x < curve.x[-1])
    x = np.union1d(curve.x, other.x[inside])
    columns = [_piece_from(curve, float(low)) - _piece_from(other, float(low)) for low in x[:-1]]
    return PPoly(np.array(columns).T, x)


def corrected(geometry: Geometry, correction: Correction) -> Geometry:
    """Return the geometry that the table plays; the drawing by which it is judged stays.

    Parameters
    ----------
    geometry : Geometry
        Of the part alone, without run-in and run-out.
    """
    return replace(
        geometry,
        radius=_less(geometry.radius, correction.mean),
        surface=CorrectedSurface(geometry.surface, correction),
        drawn=geometry.drawing,
        drawn_radius=geometry.radius,
        correction=correction,
    )
