"""Numbers and units that every package shares.

>>> f"{omega_rad_s(60.0):.6f}"
'6.283185'
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


FloatsLike = Floats | float


NM_PER_MM = 1_000_000


def omega_rad_s(spindle_rpm: float) -> float:
    """Return the angular speed [rad/s] of a spindle speed [r/min]."""
    return 2 * np.pi * spindle_rpm / 60


class SectionValues(NamedTuple):
    """Radius reduction and its derivatives with respect to the angle; shapes as broadcast."""

    delta: Floats  # mm, 0 at the long axis
    d1: Floats  # mm/rad
    d2: Floats  # mm/rad^2
    d3: Floats  # mm/rad^3


Ints = npt.NDArray[np.int64]
