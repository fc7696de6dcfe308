"""Nominal sizes of the polygon profiles of DIN 32711 (P3G) and DIN 32712 (P4C), in mm.

Where the numbers come from, and how far they are confirmed: tools/docs/POLYGONS.md.

>>> P3G[25.0].outer_mm, P4C[35.0].inner_mm
(26.6, 30.0)
"""

from __future__ import annotations

from typing import NamedTuple


class P3GSize(NamedTuple):
    """Nominal size of DIN 32711."""

    mean_mm: float  # d1, the mean diameter, which a calliper finds in every direction
    eccentricity_mm: float  # e1

    @property
    def outer_mm(self) -> float:
        """Return d2, the diameter of the outer circle."""
        return round(self.mean_mm + 2 * self.eccentricity_mm, 6)

    @property
    def inner_mm(self) -> float:
        """Return d3, the diameter of the inner circle."""
        return round(self.mean_mm - 2 * self.eccentricity_mm, 6)


class P4CSize(NamedTuple):
    """Nominal size of DIN 32712."""

    outer_mm: float  # d1, the circle to which the corners are ground
    inner_mm: float  # d2, the inner circle, across the flats
    eccentricity_mm: float  # e


_P3G = (
    *((14, 0.44), (16, 0.5), (18, 0.56), (20, 0.63), (22, 0.7), (25, 0.8), (28, 0.9), (30, 1.0)),
    *((32, 1.12), (35, 1.25), (40, 1.4), (45, 1.6), (50, 1.8), (55, 2.0), (60, 2.25), (65, 2.45)),
    *((70, 2.8), (75, 3.15), (80, 3.35), (85, 3.55), (90, 4.0), (95, 4.25), (100, 4.5)),
)
_P4C = (
    *((14, 11, 1.6), (16, 13, 2), (18, 15, 2), (20, 17, 3), (22, 18, 3), (25, 21, 5)),
    *((28, 24, 5), (30, 25, 5), (32, 27, 5), (35, 30, 5), (40, 35, 6), (45, 40, 6)),
    *((50, 43, 6), (55, 48, 6), (60, 53, 6), (65, 58, 6), (70, 60, 6), (75, 65, 6)),
    *((80, 70, 8), (85, 75, 8), (90, 80, 8), (95, 85, 8), (100, 90, 8)),
)
P3G = {float(mean): P3GSize(float(mean), float(e)) for mean, e in _P3G}
P4C = {float(one[0]): P4CSize(*(float(mm) for mm in one)) for one in _P4C}
