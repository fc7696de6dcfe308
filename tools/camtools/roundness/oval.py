# SPDX-License-Identifier: Apache-2.0
"""Diameters of an oval section of evenly spaced points, MATHS.md (204).

>>> import numpy as np
>>> phi = 2 * np.pi * np.arange(3600) / 3600
>>> found = axes_of(46 + 0.05 * np.cos(2 * phi - np.radians(20)))
>>> f"{found.long_mm:.3f} {found.short_mm:.3f} {found.ovality_mm:.3f} {found.phase_deg:.2f}"
'92.100 91.900 0.200 10.00'
"""

from __future__ import annotations

from typing import NamedTuple

from camtools.base.quantities import Floats
from camtools.roundness.waves import harmonics


class OvalAxes(NamedTuple):
    """Two-point DIAMETERS [mm] of a section."""

    long_mm: float  # the largest
    short_mm: float  # the smallest
    phase_deg: float  # of the long axis by the second harmonic, -90 .. 90
    mean_mm: float  # of all diameters

    @property
    def ovality_mm(self) -> float:
        """Return the long less the short DIAMETER."""
        return self.long_mm - self.short_mm


def axes_of(radius_mm: Floats) -> OvalAxes:
    """Return the axes of a section.

    Parameters
    ----------
    radius_mm : ndarray, shape (n,)
        RADII at even angles of one turn, n even.
    """
    half = radius_mm.size // 2
    diameter_mm = radius_mm[:half] + radius_mm[half:]
    phase_deg = harmonics(radius_mm, 2)[1].phase_deg
    return OvalAxes(
        float(diameter_mm.max()),
        float(diameter_mm.min()),
        phase_deg - 180 if phase_deg > 90 else phase_deg,
        float(diameter_mm.mean()),
    )
