"""A drawing and the smooth waves that are taken off as well: growth, or a gauged part's errors.

>>> from camtools.skirt.geometry.profile import constant_spline
>>> line = minus(constant_spline(46.0, 0.0, 60.0), constant_spline(0.5, 0.0, 90.0))
>>> line.x.tolist(), float(line(30.0))
([0.0, 60.0], 45.5)
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PPoly

from camtools.base.quantities import Floats, FloatsLike, SectionValues
from camtools.cut.correction import Correction
from camtools.skirt.geometry.sections import SkirtSurface
from camtools.table.channel import MAX_LOG2_REPEAT


@dataclass(frozen=True, eq=False)
class CorrectedSurface(SkirtSurface):
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
        return np.union1d(self.inner.heights_mm(), self.correction.nodes_mm)

    def delta(self, phi_rad: FloatsLike, z_mm: FloatsLike) -> SectionValues:
        """See `SkirtSurface`."""
        phi, z = np.asarray(phi_rad, dtype=np.float64), np.asarray(z_mm, dtype=np.float64)
        drawn, more = self.inner.delta(phi, z), self.correction.delta(phi, z)
        return SectionValues(*(a + b for a, b in zip(drawn, more, strict=True)))


def piece_from(curve: PPoly, low_mm: float) -> Floats:
    """Return the cubic of the piece above a height, in the distance from that height."""
    return np.array([curve(low_mm, nu=n) / max(1, n * (n - 1)) for n in (3, 2, 1, 0)])


def minus(curve: PPoly, less: PPoly) -> PPoly:
    """Return a curve over height, less another that covers it, as cubics."""
    inside = (less.x > curve.x[0]) & (less.x < curve.x[-1])
    x = np.union1d(curve.x, less.x[inside])
    columns = [piece_from(curve, float(low)) - piece_from(less, float(low)) for low in x[:-1]]
    return PPoly(np.array(columns).T, x)
