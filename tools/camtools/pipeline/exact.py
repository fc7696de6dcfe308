# SPDX-License-Identifier: Apache-2.0
"""The exact shape of a part of any kind, and what U does along it, before a table is made.

>>> from camtools.pipeline.registry import kinds
>>> from camtools.skirt.part.part_file import example_part
>>> turn = kinds()[0].exact(example_part()).turn_at(20.0, 4)
>>> [f"{mm:.3f}" for mm in turn.radius_mm]
['46.000', '45.900', '46.000', '45.900']
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np

from camtools.base.quantities import NM_PER_MM, Floats
from camtools.table.channel import RATIO_ONE, Channel
from camtools.table.evaluate import evaluate_at


class ExactTurn(NamedTuple):
    """One turn at a height; arrays of shape (n,) over the drawing's angle."""

    phi_rad: Floats
    radius_mm: Floats  # of the part, as drawn
    nominal_mm: float  # radius of the circle from which deviations count
    u_mm: Floats  # travel of U from the middle of its stroke, towards the axis
    d1: Floats  # mm/rad
    d2: Floats  # mm/rad^2
    d3: Floats  # mm/rad^3


class HeightCurve(NamedTuple):
    """A line of the profile over the height."""

    name: str
    radius_mm: Floats  # shape of the heights


class ProfileOver(NamedTuple):
    """Radii of the part over its height."""

    z_mm: Floats
    curves: tuple[HeightCurve, ...]


class SpeedRatio(NamedTuple):
    """Speed of the spindle over its mean, and two derivatives by the angle."""

    value: Floats
    d1: Floats
    d2: Floats


class Exact(ABC):
    """The exact geometry of a part.

    Attributes
    ----------
    heights_mm : tuple of float
        First and last height of the part [mm], without what the tool travels in the air.
    """

    heights_mm: tuple[float, float]

    def nearest_mm(self, z_mm: float) -> float:
        """Return the height of the part that is nearest to a height."""
        low, high = self.heights_mm
        return min(max(z_mm, low), high)

    @abstractmethod
    def turn_at(self, z_mm: float, n: int) -> ExactTurn:
        """Return the section at a height and U along it at n angles, evenly from 0 on."""

    @abstractmethod
    def profile(self) -> ProfileOver:
        """Return radii over the height."""

    def ratio_at(self, speed: Channel, phi_rad: Floats, z_mm: float) -> SpeedRatio:
        """Return the speed of a modulated spindle at a height."""
        return ratio_of(speed, phi_rad, z_mm * NM_PER_MM)


def ratio_of(speed: Channel, phi_rad: Floats, height: float) -> SpeedRatio:
    """Return a speed channel at angles; `height` in nm, or the number of a pattern."""
    turns = phi_rad / (2 * np.pi)
    law = evaluate_at(speed, turns, np.full(turns.size, height))
    return SpeedRatio(law.value / RATIO_ONE, law.d1 / RATIO_ONE, law.d2 / RATIO_ONE)


def even_angles(n: int) -> Floats:
    """Return n angles of a turn, from 0 on [rad]."""
    return 2 * np.pi * np.arange(n, dtype=np.float64) / n
