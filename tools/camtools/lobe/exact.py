# SPDX-License-Identifier: Apache-2.0
"""The exact shape of a camshaft and the motion of U along it.

>>> from camtools.lobe.motion import example_lobe
>>> shape = exact_lobes(example_lobe())
>>> f"{shape.turn_at(6.0, 8).radius_mm.max():.3f}", shape.heights_mm
('28.000', (0.0, 12.0))
"""

from __future__ import annotations

import numpy as np

from camtools.base.quantities import Floats
from camtools.lobe.channels import has_patterns, range_of
from camtools.lobe.motion import ShaftLobe, lobes_of
from camtools.lobe.part import LobePart
from camtools.pipeline.exact import (
    Exact,
    ExactTurn,
    HeightCurve,
    ProfileOver,
    SpeedRatio,
    even_angles,
    ratio_of,
)
from camtools.table.channel import Channel

_STEP_RAD = 1e-4
_EDGE_MM = 1e-6  # a lobe begins and ends within it, for a line over the height


class ExactLobes(Exact):
    """Lobes on their shaft."""

    def __init__(self, lobes: list[ShaftLobe]) -> None:
        self.heights_mm = lobes[0].z_mm[0], lobes[-1].z_mm[1]
        self._lobes = lobes
        self._rises: dict[int, float] = {}

    def lobe_at(self, z_mm: float) -> ShaftLobe:
        """Return the lobe at a height, between two of them the nearer one."""

        def off_mm(lobe: ShaftLobe) -> float:
            return max(lobe.z_mm[0] - z_mm, z_mm - lobe.z_mm[1], 0.0)

        return min(self._lobes, key=off_mm)

    def nearest_mm(self, z_mm: float) -> float:
        """See `Exact.nearest_mm`: between two lobes there is no section."""
        low, high = self.lobe_at(z_mm).z_mm
        return min(max(z_mm, low), high)

    def turn_at(self, z_mm: float, n: int) -> ExactTurn:
        """See `Exact.turn_at`; the third derivative is a central difference of the second."""
        lobe, phi = self.lobe_at(z_mm), even_angles(n)
        touch, path = lobe.contacts(phi)
        before, behind = lobe.at(phi - _STEP_RAD).d2, lobe.at(phi + _STEP_RAD).d2
        jerk = (behind - before) / (2 * _STEP_RAD)
        around = np.mod(touch.alpha + lobe.phase_rad, 2 * np.pi)
        order = np.argsort(around)
        radius = np.interp(phi, around[order], touch.radius[order], period=2 * np.pi)
        # U counts towards the axis, a lift away from it
        return ExactTurn(phi, radius, lobe.base_mm, -path.lift, -path.d1, -path.d2, -jerk)

    def profile(self) -> ProfileOver:
        """See `Exact.profile`: the highest and the lowest radius of each lobe."""
        z_mm, highest = [], []
        for lobe in self._lobes:
            low, high = lobe.z_mm
            rise = self._rise_mm(lobe)
            z_mm += [low - _EDGE_MM, low, high, high + _EDGE_MM]
            highest += [lobe.base_mm, lobe.base_mm + rise, lobe.base_mm + rise, lobe.base_mm]
        base = np.full(len(z_mm), self._lobes[0].base_mm)
        curves = HeightCurve("noses", np.array(highest)), HeightCurve("base circle", base)
        return ProfileOver(np.array(z_mm), curves)

    def _rise_mm(self, lobe: ShaftLobe) -> float:
        """Return by how much the nose of a lobe stands above its base circle [mm]."""
        if lobe.profile not in self._rises:
            touch, _ = lobe.contacts(even_angles(720) + lobe.phase_rad)
            self._rises[lobe.profile] = float(touch.radius.max()) - lobe.base_mm
        return self._rises[lobe.profile]

    def ratio_at(self, speed: Channel, phi_rad: Floats, z_mm: float) -> SpeedRatio:
        """See `Exact.ratio_at`: of the lobe at that height."""
        lobe = self.lobe_at(z_mm)
        if speed.has_patterns and has_patterns(self._lobes):
            return ratio_of(speed, phi_rad - lobe.phase_rad, float(lobe.profile))
        return ratio_of(speed, phi_rad, float(range_of(self._lobes)[0]))


def exact_lobes(part: LobePart) -> ExactLobes:
    """Return the exact shape of a camshaft.

    Raises
    ------
    CamtoolsError
        The numbers make no lobes.
    """
    return ExactLobes(lobes_of(part))
