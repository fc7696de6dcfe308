"""Cold and hot, bare and coated: what is turned of a drawing, and its room in the bore.

A hot radius is the cold one times a factor, plus a shift, MATHS.md (245), (246). A part is coated
cold. What is turned follows the equations within 0.1 um of a corner of the profile, elsewhere
within a few nanometres, since cubics through 65 heights carry it.

>>> from camtools.skirt.part.fit import Bore
>>> law = {"drawn": "hot", "expansion_per_k": 21e-6, "height_mm": [0, 60]}
>>> hot = expansion(Growth(**law, temperature_c=[120, 120]), np.array([0.0]), np.array([30.0]))
>>> f"{1000 * (float(hot.factor[0]) - 1) * 46:.1f} um"
'96.6 um'
>>> bore = Bore(diameter_mm=92, temperature_c=110)
>>> [f"{mm:.5f}" for mm in (bore_mm(bore, None), bore_mm(bore, 20.0))]
['46.00000', '46.04554']
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PPoly

from camtools.base.quantities import UM_PER_MM, Floats, FloatsLike
from camtools.cut.correction import MAX_ORDER, Correction, nodes_of
from camtools.skirt.geometry.profile import constant_spline
from camtools.skirt.part.curves import through
from camtools.skirt.part.fit import Bore, Coating, Growth
from camtools.skirt.part.part_file import Piston

_N_ANGLES = 256
_LEAST_MM = 1e-8  # of a wave that is kept
# A step from 0 to 1 in three cubics of equal width, with continuous curvature.
_STEP = np.array([[1, -2, 1], [0, 3, -3], [0, 3, 3], [0, 1, 5]]) / 6


class Expansion(NamedTuple):
    """How a cold radius grows: times a factor, plus a shift [mm]; shapes as broadcast."""

    factor: FloatsLike
    shift_mm: FloatsLike

    def hot_mm(self, cold_mm: Floats) -> Floats:
        """Return hot radii."""
        return np.asarray(cold_mm * self.factor + self.shift_mm, dtype=np.float64)

    def cold_mm(self, hot_mm: Floats) -> Floats:
        """Return cold radii."""
        return np.asarray((hot_mm - self.shift_mm) / self.factor, dtype=np.float64)


def expansion(growth: Growth, thrust_phi_rad: FloatsLike, z_mm: FloatsLike) -> Expansion:
    """Return the growth at angles from the thrust direction [rad] and heights [mm]."""
    if growth.temperature_c is None:
        thrust_um, pin_um = (
            None if cold is None or hot is None else np.subtract(cold, hot).tolist()
            for cold, hot in (
                (growth.cold_drop_um, growth.hot_drop_um),
                (growth.pin_cold_drop_um, growth.pin_hot_drop_um),
            )
        )
        shift_um = _around(growth, (thrust_um, pin_um, None), thrust_phi_rad, z_mm)
        return Expansion(1.0, shift_um / UM_PER_MM)
    lists = growth.temperature_c, growth.pin_temperature_c, growth.antithrust_temperature_c
    above_k = _around(growth, lists, thrust_phi_rad, z_mm) - growth.reference_c
    assert growth.expansion_per_k is not None
    return Expansion(1 + growth.expansion_per_k * above_k, 0.0)


def _around(
    growth: Growth,
    lists: tuple[list[float] | None, list[float] | None, list[float] | None],
    phi_rad: FloatsLike,
    z_mm: FloatsLike,
) -> Floats:
    """Return what lists along thrust, pin and antithrust direction have between, (246)."""

    def over(values: list[float]) -> Floats:
        return np.asarray(through(growth.height_mm, values, "pchip")(z_mm), dtype=np.float64)

    along_thrust, along_pin, opposite = lists
    assert along_thrust is not None
    thrust = over(along_thrust)
    antithrust = thrust if opposite is None else over(opposite)
    mean, cos = (thrust + antithrust) / 2, np.cos(phi_rad)
    pin = mean if along_pin is None else over(along_pin)
    return np.asarray(pin + (mean - pin) * cos**2 + (thrust - antithrust) / 2 * cos)


def thrust_rad(piston: Piston) -> float:
    """Return the drawing's angle of the thrust direction."""
    meets_long = piston.antithrust is not None and piston.antithrust.meet == "long-axis"
    return np.pi / 2 if meets_long else 0.0


def shrinkage(
    piston: Piston, ends_mm: tuple[float, float], hot_mm: Callable[[Floats, Floats], Floats]
) -> Correction:
    """Return what the cold part has less of radius than a hot drawing, without waves if nothing.

    `hot_mm` returns the drawing's radius at angles [rad] and heights [mm], broadcast.
    """
    assert piston.growth is not None
    phi, z = 2 * np.pi * np.arange(_N_ANGLES) / _N_ANGLES, nodes_of(ends_mm)[:, None]
    hot = hot_mm(phi, z)
    less = hot - expansion(piston.growth, phi - thrust_rad(piston), z).cold_mm(hot)
    found = np.asarray(np.conj(np.fft.rfft(less)) * 2 / _N_ANGLES, dtype=np.complex128)
    found[:, 0] /= 2
    kept = np.flatnonzero(np.abs(found).max(axis=0)[: MAX_ORDER + 1] > _LEAST_MM)
    return Correction(ends_mm, {int(order): found[:, order] for order in kept})


def thickness(coating: Coating, ends_mm: tuple[float, float]) -> PPoly:
    """Return a coating over the height between two ends [mm]."""
    if not coating.points:
        assert not isinstance(coating.thickness_um, list)
        return constant_spline(coating.thickness_um / UM_PER_MM, *ends_mm)
    heights, um = (list(column) for column in zip(*coating.points, strict=True))
    z = np.array([min(heights[0], ends_mm[0]) - 1, *heights, max(heights[-1], ends_mm[1]) + 1])
    mm = np.array([um[0], *um, um[-1]]) / UM_PER_MM
    width = np.repeat(np.diff(z) / 3, 3)
    columns = np.repeat(np.diff(mm), 3) * np.tile(_STEP, z.size - 1)
    columns[3] += np.repeat(mm[:-1], 3)
    columns[:3] /= width ** np.array([[3], [2], [1]])
    return PPoly(columns, np.append(z[0], z[0] + np.cumsum(width)))


def bore_mm(bore: Bore, reference_c: float | None) -> float:
    """Return the radius of the bore; with the temperature at which it was measured that hot."""
    warmer_k = 0.0
    if reference_c is not None and bore.temperature_c is not None:
        warmer_k = bore.temperature_c - reference_c
    return bore.diameter_mm / 2 * (1 + bore.expansion_per_k * warmer_k)


class State(NamedTuple):
    """A state of the skirt, in the order in which it comes about."""

    radius_mm: Floats  # over heights and angles
    bore_mm: float | None  # radius of the bore

    @property
    def clearance_um(self) -> Floats:
        """Return the radial clearance, below 0 where skirt and bore overlap."""
        assert self.bore_mm is not None
        return np.asarray((self.bore_mm - self.radius_mm) * UM_PER_MM)


def states_of(piston: Piston, cold_mm: Floats, phi_rad: Floats, z_mm: Floats) -> dict[str, State]:
    """Return the states of a skirt: cold as turned, coated cold, hot; those that it has.

    Radii as turned have the shape (z_mm.size, phi_rad.size).
    """
    bore, growth, coating = piston.bore, piston.growth, piston.coating
    cold_bore_mm = None if bore is None else bore_mm(bore, None)
    found, radius = {"cold": State(cold_mm, cold_bore_mm)}, cold_mm
    if coating is not None:
        curve = thickness(coating, (float(z_mm[0]), float(z_mm[-1])))
        radius = radius + np.asarray(curve(z_mm))[:, None]
        found["coated"] = State(radius, cold_bore_mm)
    if growth is not None:
        grown = expansion(growth, phi_rad - thrust_rad(piston), z_mm[:, None])
        hot_bore_mm = None if bore is None else bore_mm(bore, growth.reference_c)
        found["hot"] = State(grown.hot_mm(radius), hot_bore_mm)
    return found
