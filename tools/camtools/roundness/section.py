# SPDX-License-Identifier: Apache-2.0
"""What a section of a non-circular part is told by, MATHS.md (203).

>>> phi = 2 * np.pi * np.arange(3600) / 3600
>>> drawn_mm = 46 - 0.1 * np.sin(phi) ** 2
>>> found = section_of(drawn_mm, 1e-4 * np.cos(5 * phi), 50)
>>> f"{found.off.total_mm * 1e6:.1f} nm, {found.whole.total_mm * 1e3:.1f} um"
'198.6 nm, 100.1 um'
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camtools.base.quantities import Floats
from camtools.roundness.circles import (
    Circle,
    Roundness,
    RoundProfile,
    Zone,
    least_squares,
    maximum_inscribed,
    minimum_circumscribed,
    minimum_zone,
    roundness,
)
from camtools.roundness.oval import OvalAxes, axes_of
from camtools.roundness.waves import RoundWave, harmonics, low_pass


class SectionFigures(NamedTuple):
    """Figures of a section of n even angles; every length is along the radius [mm].

    Attributes
    ----------
    drawn_mm, raw_mm, filtered_mm : ndarray, shape (n,)
        Radius of the drawing, deviation from it, and that through the filter.
    off, off_zone : Roundness, Zone
        Of the filtered deviation, laid on a circle with the mean radius of the drawing: about the
        least-squares circle, and the minimum zone.
    """

    drawn_mm: Floats
    raw_mm: Floats
    filtered_mm: Floats
    largest_mm: float  # deviation of the largest size, unfiltered, with its sign
    largest_deg: float  # its angle
    off: Roundness
    off_zone: Zone
    whole: Roundness  # the same of the section as it is, drawing and filtered deviation
    whole_zone: Zone
    circumscribed: Circle
    inscribed: Circle
    drawn_axes: OvalAxes  # DIAMETERS of the drawing
    cut_axes: OvalAxes  # DIAMETERS of the section as it is
    off_waves: list[RoundWave]  # of the deviation, unfiltered
    whole_waves: list[RoundWave]  # of the section, unfiltered

    @property
    def cut_mm(self) -> Floats:
        """Return the radius of the section as it is."""
        return self.drawn_mm + self.filtered_mm


def section_of(drawn_mm: Floats, deviation_mm: Floats, cutoff_upr: float) -> SectionFigures:
    """Return the figures of a section.

    Parameters
    ----------
    drawn_mm, deviation_mm : ndarray, shape (n,)
        Radius of the drawing about its axis and deviation from it at n even angles from 0 on, n
        even.
    cutoff_upr : float
        Of the Gaussian filter, which takes the deviation only: a drawing is not rounded off.
    """
    phi = 2 * np.pi * np.arange(drawn_mm.size) / drawn_mm.size
    filtered_mm = low_pass(deviation_mm, cutoff_upr)
    off = RoundProfile(phi, float(drawn_mm.mean()) + filtered_mm)
    whole = RoundProfile(phi, drawn_mm + filtered_mm)
    worst = int(np.abs(deviation_mm).argmax())
    return SectionFigures(
        drawn_mm,
        deviation_mm,
        filtered_mm,
        float(deviation_mm[worst]),
        360 * worst / drawn_mm.size,
        roundness(off, least_squares(off)),
        minimum_zone(off),
        roundness(whole, least_squares(whole)),
        minimum_zone(whole),
        minimum_circumscribed(whole),
        maximum_inscribed(whole),
        axes_of(drawn_mm),
        axes_of(whole.radius_mm),
        harmonics(deviation_mm),
        harmonics(drawn_mm + deviation_mm),
    )
