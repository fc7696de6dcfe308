# SPDX-License-Identifier: Apache-2.0
"""Closed profiles of evenly spaced points: Gaussian filter and harmonics, MATHS.md (201), (202).

>>> phi = 2 * np.pi * np.arange(3600) / 3600
>>> filtered = low_pass(np.cos(50 * phi), 50)
>>> f"{filtered[0]:.6f}"
'0.500000'
>>> second = harmonics(3 + 0.1 * np.cos(2 * (phi - np.radians(30))), 50)[1]
>>> f"{second.amplitude:.6f} {second.phase_deg:.6f}"
'0.100000 30.000000'
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camtools.base.quantities import Floats

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
    """Return the share of a wave that the low-pass filter of ISO 16610-21 lets through.

    >>> transmission(np.array([0.0, 15.0, 30.0]), 15).tolist()
    [1.0, 0.5, 0.0625]
    """
    return np.asarray(np.exp2(-((np.asarray(order) / cutoff_upr) ** 2)), dtype=np.float64)


def low_pass(profile: Floats, cutoff_upr: float) -> Floats:
    """Return a closed profile through the Gaussian filter; phases stay.

    Parameters
    ----------
    profile : ndarray, shape (n,)
        Values at even angles of one turn, of any unit.
    cutoff_upr : float
        Waves per turn (UPR) of which half is let through.
    """
    spectrum = np.fft.rfft(profile)
    passed = spectrum * transmission(np.arange(spectrum.size, dtype=np.float64), cutoff_upr)
    return np.asarray(np.fft.irfft(passed, profile.size), dtype=np.float64)


def harmonics(profile: Floats, most: int = MOST_HARMONICS) -> list[RoundWave]:
    """Return the waves 1 .. most of a closed profile of evenly spaced points."""
    spectrum = np.fft.rfft(profile) / profile.size
    found = []
    for order in range(1, most + 1):
        wave = 2 * spectrum[order]
        phase_deg = float(np.mod(-np.degrees(np.angle(wave)) / order, 360 / order))
        found.append(RoundWave(order, float(np.abs(wave)), phase_deg))
    return found
