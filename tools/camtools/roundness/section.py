"""A section of a non-circular part: filter, harmonics, diameters, MATHS.md (201) .. (204).

>>> phi = 2 * np.pi * np.arange(3600) / 3600
>>> second = harmonics(3 + 0.1 * np.cos(2 * (phi - np.radians(30))), 50)[1]
>>> f"{second.amplitude:.6f} {second.phase_deg:.6f}"
'0.100000 30.000000'
>>> figures = section_of(46 - 0.1 * np.sin(phi) ** 2, 1e-4 * np.cos(5 * phi), 50)
>>> f"{figures.off.total_mm * 1e6:.1f} nm, {figures.whole.total_mm * 1e3:.1f} um"
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

UPR_CHOICES = (15, 50, 150, 500)
DEFAULT_UPR = 50
MOST_HARMONICS = 50
POINTS_PER_WAVE = 7  # ISO 12181-2


class RoundWave(NamedTuple):
    """A wave of a profile: amplitude cos(order (phi - phase))."""

    order: int
    amplitude: float  # of the radius, half of peak to valley, in the unit of the profile
    phase_deg: float  # angle of its first crest, 0 .. 360 / order


def transmission(order: Floats | float, cutoff_upr: float) -> Floats:
    """Return the share of a wave that the low-pass filter of ISO 16610-21 lets through."""
    return np.asarray(np.exp2(-((np.asarray(order) / cutoff_upr) ** 2)), dtype=np.float64)


def low_pass(profile: Floats, cutoff_upr: float) -> Floats:
    """Return a closed profile at even angles through the Gaussian filter; phases stay.

    Of waves with cutoff_upr waves per turn (UPR) half is let through.
    """
    spectrum = np.fft.rfft(profile)
    passed = spectrum * transmission(np.arange(spectrum.size, dtype=np.float64), cutoff_upr)
    return np.asarray(np.fft.irfft(passed, profile.size), dtype=np.float64)


def harmonics(profile: Floats, most: int = MOST_HARMONICS) -> list[RoundWave]:
    """Return the waves 1 .. most of a closed profile of evenly spaced points."""
    spectrum = np.fft.rfft(profile) / profile.size
    order = np.arange(1, most + 1)
    phase_deg = np.mod(-np.degrees(np.angle(spectrum[order])) / order, 360 / order)
    amplitude = 2 * np.abs(spectrum[order])
    return list(map(RoundWave, order.tolist(), amplitude.tolist(), phase_deg.tolist()))


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
    """Return the axes of a section by its RADII at an even number of even angles."""
    half = radius_mm.size // 2
    diameter_mm = radius_mm[:half] + radius_mm[half:]
    phase_deg = harmonics(radius_mm, 2)[1].phase_deg
    return OvalAxes(
        float(diameter_mm.max()),
        float(diameter_mm.min()),
        phase_deg - 180 if phase_deg > 90 else phase_deg,
        float(diameter_mm.mean()),
    )


class SectionFigures(NamedTuple):
    """Figures of a section of n even angles; every length is along the radius [mm]."""

    drawn_mm: Floats  # (n,) radius of the drawing
    raw_mm: Floats  # (n,) deviation from it
    filtered_mm: Floats  # (n,) that through the filter
    largest_mm: float  # deviation of the largest size, unfiltered, with its sign
    largest_deg: float  # its angle
    off: Roundness  # of the filtered deviation on a circle with the mean radius of the drawing
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
    """Return the figures of a section by its drawing and deviation at even angles from 0 on.

    The Gaussian filter takes the deviation only: a drawing is not rounded off.
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
