"""What an axis needs between two lobes, where its lift falls to 0 and rises again: MATHS.md (88).

The firmware judges by the same sums at the same places (firmware/feasible/cam_feasible_inner.h).

>>> still = in_gap(Motion(8.0, 12.0, 40.0), GapChange(turns=100.0))
>>> f"{still.first:.3f} {still.second:.3f}"
'12.001 40.003'
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camtools.base.quantities import Floats

_PLACES = np.arange(21) / 20
_STEP = _PLACES**3 * (10 - 15 * _PLACES + 6 * _PLACES**2)
_STEP1 = 30 * _PLACES**2 * (1 - _PLACES) ** 2
_STEP2 = np.abs(60 * _PLACES * (1 - _PLACES) * (1 - 2 * _PLACES))
_BETWEEN = 1.01  # what lies between two places


class Motion(NamedTuple):
    """Largest magnitudes of an axis over the angle, at the speed ratio of the table."""

    most: float  # unit
    first: float  # unit/rad: speed over the mean speed
    second: float  # unit/rad^2: acceleration over its square


class GapChange(NamedTuple):
    """The shortest change between two lobes, from a whole lift to none."""

    turns: float  # that the feed takes for it
    ratio: float = 1.0  # largest speed over mean speed
    spindle_rad2: float = 0.0  # largest |r r'|
    n_set_points: int = 1  # of the axis from plan to plan: one takes the bend of all of them


def in_gap(motion: Motion, change: GapChange) -> Motion:
    """Return what the axis needs on the lobes and between them, never less than on them.

    The spindle's own acceleration is taken at its highest speed, a little more than there is.
    """
    x = change.ratio / (2 * np.pi * change.turns)
    more1 = motion.most * x * _STEP1
    swept = 2 * motion.first * x + change.n_set_points * motion.most * x * change.spindle_rad2
    more2 = swept * _STEP1 + change.n_set_points * motion.most * x**2 * _STEP2
    return Motion(motion.most, _largest(motion.first, more1), _largest(motion.second, more2))


def _largest(own: float, more: Floats) -> float:
    """Return the largest sum: the share of its own at the upper end of each interval."""
    return float((own * _STEP[1:] + _BETWEEN * np.maximum(more[1:], more[:-1])).max())
