"""Ovals that differ from side to side, whose parameters change with height, that are turned.

>>> import numpy as np
>>> from camtools.skirt.geometry.profile import constant_spline
>>> a, g, none = (constant_spline(value, 0.0, 60.0) for value in (46.0, 0.2, 0.0))
>>> side = OvalSide("cosine", a, g, none, none, none)
>>> [f"{mm:.3f}" for mm in side.delta(np.radians([0.0, 90.0]), 30.0).delta]
['0.000', '0.100']
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import PPoly

from camtools.base.errors import GeometryError
from camtools.base.quantities import Floats, FloatsLike, SectionValues
from camtools.skirt.geometry.poly_surface import piecewise
from camtools.skirt.geometry.profile import (
    Allowance,
    check_overshoot,
    check_points,
    constant_spline,
    in_um,
    magnified,
    over_ovality,
)
from camtools.skirt.geometry.sections import SkirtSurface, law_of
from camtools.skirt.part.curves import through
from camtools.skirt.part.keys import PARAMETERS, Antithrust
from camtools.skirt.part.part_file import Piston

_MIDDLE_RAD = {"short-axis": np.pi, "long-axis": 1.5 * np.pi}  # of the antithrust side


@dataclass(frozen=True, eq=False)
class OvalSide(SkirtSurface):
    """The law of one side, all round, MATHS.md (76)."""

    shape: str  # of `law_of`
    radius: PPoly  # long half axis of the part [mm] over height [mm]
    ovality: PPoly  # diametral [mm]
    drop: PPoly  # of its half axis below the part's [mm]
    parameter: PPoly  # beta or the exponent of the law
    phase: PPoly  # how far its long axis is turned [rad]

    def delta(self, phi_rad: FloatsLike, z_mm: FloatsLike) -> SectionValues:
        """Return radius reduction and angle derivatives; see `Geometry.delta`."""
        z = np.asarray(z_mm, dtype=np.float64)
        drop = self.drop(z)
        law = law_of(self.shape, self.parameter(z))
        phi = np.asarray(phi_rad) - self.phase(z)
        found = law(phi, self.radius(z) - drop, self.ovality(z))
        return found._replace(delta=np.asarray(found.delta + drop, dtype=np.float64))

    def heights_mm(self) -> Floats:
        """Return the heights at which a curve of this side has a break."""
        curves = (self.ovality, self.drop, self.parameter, self.phase)
        return np.unique(np.concatenate([curve.x for curve in curves]))

    def document(self) -> dict[str, Any]:
        """Return what a gauge needs as JSON values (layout: host_sim/part/sim_surface.h)."""
        return {
            "law": self.shape,
            "ovality_mm": piecewise(self.ovality),
            "drop_mm": piecewise(self.drop),
            "parameter": piecewise(self.parameter),
            "phase_rad": piecewise(self.phase),
        }


@dataclass(frozen=True, eq=False)
class SidesSurface(SkirtSurface):
    """One side, or two that are blended where they meet, MATHS.md (77)."""

    thrust: OvalSide  # the side that the main tables describe
    antithrust: OvalSide | None = None  # the other one
    meet: str = "short-axis"  # "short-axis" or "long-axis": where they meet
    blend_rad: float = float(np.radians(30.0))  # width of each zone between them

    @property
    def log2_repeat(self) -> int:
        """Return 1 where both halves are the same, else 0."""
        return 1 if self.antithrust is None else 0

    def delta(self, phi_rad: FloatsLike, z_mm: FloatsLike) -> SectionValues:
        """Return radius reduction and angle derivatives; see `Geometry.delta`."""
        thrust = self.thrust.delta(phi_rad, z_mm)
        if self.antithrust is None:
            return thrust
        antithrust = self.antithrust.delta(phi_rad, z_mm)
        w = share_of(phi_rad, _MIDDLE_RAD[self.meet], self.blend_rad)
        d = [np.asarray(b - a) for a, b in zip(thrust, antithrust, strict=True)]
        return SectionValues(
            thrust.delta + w.delta * d[0],
            thrust.d1 + w.d1 * d[0] + w.delta * d[1],
            thrust.d2 + w.d2 * d[0] + 2 * w.d1 * d[1] + w.delta * d[2],
            thrust.d3 + w.d3 * d[0] + 3 * w.d2 * d[1] + 3 * w.d1 * d[2] + w.delta * d[3],
        )

    def heights_mm(self) -> Floats:
        """Return the heights at which a curve of the sides has a break."""
        first = self.thrust.heights_mm()
        return first if self.antithrust is None else np.union1d(first, self.antithrust.heights_mm())

    def step_mm(self, z_mm: Floats) -> float:
        """Return by how much the sides differ at most in the middle of the zones [mm]."""
        if self.antithrust is None:
            return 0.0
        middle = _MIDDLE_RAD[self.meet]
        phi = np.array([middle - np.pi / 2, middle + np.pi / 2])
        thrust = self.thrust.delta(phi, z_mm[:, None]).delta
        return float(np.abs(self.antithrust.delta(phi, z_mm[:, None]).delta - thrust).max())

    def document(self) -> dict[str, Any]:
        """Return what a gauge needs as JSON values (layout: host_sim/part/sim_surface.h)."""
        sides = [side.document() for side in (self.thrust, self.antithrust) if side is not None]
        middle_rad = _MIDDLE_RAD[self.meet]
        return {"sides": sides, "middle_rad": middle_rad, "blend_rad": self.blend_rad}


def share_of(phi_rad: FloatsLike, middle_rad: float, blend_rad: float) -> SectionValues:
    """Return the share of the side about an angle, and its derivatives by the angle.

    It is 1 within a quarter turn of the middle, less half the blend, 0 as far from the opposite,
    and rises between by a smooth step with three continuous derivatives.
    """
    off = np.mod(np.asarray(phi_rad) - middle_rad + np.pi, 2 * np.pi) - np.pi
    slope = -np.sign(off) / blend_rad
    s = np.clip((np.pi / 2 - np.abs(off)) / blend_rad + 0.5, 0.0, 1.0)
    return SectionValues(
        np.asarray(s**4 * (35 - 84 * s + 70 * s**2 - 20 * s**3)),
        np.asarray(140 * s**3 * (1 - s) ** 3 * slope),
        np.asarray(420 * s**2 * (1 - s) ** 2 * (1 - 2 * s) * slope**2),
        np.asarray(840 * s * (1 - s) * (1 - 5 * s + 5 * s**2) * slope**3),
    )


@dataclass(frozen=True, eq=False)
class TurnedSurface(SkirtSurface):
    """A surface whose sections are turned by an angle that changes with height, MATHS.md (78)."""

    surface: SkirtSurface  # as drawn before it is turned
    phase: PPoly  # angle [rad] over height [mm]; the section turns counter-clockwise with it

    @property
    def log2_repeat(self) -> int:
        """Return that of the surface: turning repeats no more and no less."""
        return self.surface.log2_repeat

    def heights_mm(self) -> Floats:
        """Return the heights at which a curve of the surface has a break."""
        return np.union1d(self.phase.x, self.surface.heights_mm())

    def delta(self, phi_rad: FloatsLike, z_mm: FloatsLike) -> SectionValues:
        """Return radius reduction and angle derivatives; see `Geometry.delta`."""
        phase = np.asarray(self.phase(np.asarray(z_mm, dtype=np.float64)))
        if phase.size and np.ptp(phase) == 0:
            phase = phase.ravel()[0]  # a surface is faster where all heights share their angles
        return self.surface.delta(np.asarray(phi_rad) - phase, z_mm)


_FREE = 0.05  # of beta and of the exponent, between two points beyond both
_FREE_DEG = 0.1  # of an angle
# Shapes that a report describes without sides: all that came before those.
_PLAIN = ("ellipse", "cosine", "double-ellipse", "ellipse-arc", "table", "points")


def is_plain(piston: Piston) -> bool:
    """Return whether one law with constant numbers describes both sides of a section."""
    section = piston.section
    is_one = piston.antithrust is None and not isinstance(section.beta, list)
    return is_one and section.shape in _PLAIN


def turn_of(piston: Piston) -> PPoly | None:
    """Return by how much the sections are turned [rad] over height, nothing when they are not."""
    phase_deg = piston.section.phase_deg
    if phase_deg == 0:
        return None
    if piston.ovality is None:
        heights_mm = piston.profile.height_mm
        assert not isinstance(phase_deg, list)
        return constant_spline(float(np.radians(phase_deg)), heights_mm[0], heights_mm[-1])
    turn_deg = over_ovality(phase_deg, piston.ovality)
    allowed = Allowance("the angle", 1.0, "degrees", _FREE_DEG, None)
    check_points("piston.ovality.interpolation", turn_deg, allowed, piston.ovality)
    return magnified(turn_deg, float(np.radians(1)), 0.0)


def sides_of(
    piston: Piston, radius: PPoly, ovality: PPoly, factors: tuple[float, float]
) -> SidesSurface:
    """Return the reduction of the radius of ovals that differ over height or from side to side.

    Curves of the thrust side are magnified already; the factors are those of ovality and profile.
    Raises GeometryError: a curve leaves its points, or the other side's ovality falls below 0.
    """
    antithrust, shape, drawn = piston.antithrust, piston.section.shape, piston.ovality
    assert drawn is not None
    key = PARAMETERS.get(shape, "beta")
    parameter = over_ovality(getattr(piston.section, key), drawn)
    allowed = Allowance(key, 1.0, "", _FREE, None)
    check_points("piston.ovality.interpolation", parameter, allowed, drawn)
    none = constant_spline(0.0, *_ends(piston))
    thrust = OvalSide(shape, radius, ovality, none, parameter, none)
    if antithrust is None:
        return SidesSurface(thrust)
    drop_mm = antithrust.drop_mm or [0.0] * len(antithrust.height_mm)
    drop = magnified(_over(antithrust, drop_mm, "drop_mm"), factors[1], 0.0)
    if antithrust.ovality_mm is None:
        breaks = np.union1d(ovality.x, drop.x)  # G - 2 drop leaves the short half axis as it is
        its_ovality = PPoly(_on(ovality, breaks) - 2 * _on(drop, breaks), breaks)
    else:
        its_ovality = _over(antithrust, antithrust.ovality_mm, "ovality_mm")
        its_ovality = magnified(its_ovality, factors[0], 0)
    _check_least(its_ovality, _ends(piston))
    own = getattr(antithrust, key)
    if own is not None:
        parameter = _over(antithrust, own, key)
    phase_deg = _over(antithrust, antithrust.phase_deg, "phase_deg")
    phase = magnified(phase_deg, float(np.radians(1)), 0.0)
    side = OvalSide(shape, radius, its_ovality, drop, parameter, phase)
    return SidesSurface(thrust, side, antithrust.meet, float(np.radians(antithrust.blend_deg)))


def _ends(piston: Piston) -> tuple[float, float]:
    return float(piston.profile.height_mm[0]), float(piston.profile.height_mm[-1])


def _over(antithrust: Antithrust, value: list[float] | float, name: str) -> PPoly:
    """Return a number, or a list over the heights of the antithrust side, as cubics."""
    heights_mm = antithrust.height_mm
    if not isinstance(value, list):
        return constant_spline(value, heights_mm[0], heights_mm[-1])
    curve = through(heights_mm, value, antithrust.interpolation)
    allowed = Allowance(name, 1.0, "", _FREE, None)
    if name.endswith("_mm"):
        allowed = in_um(antithrust.overshoot_um, name)
    check_overshoot("piston.antithrust.interpolation", curve, allowed, np.array(heights_mm))
    return curve


def _on(curve: PPoly, breaks: Floats) -> Floats:
    """Return the cubic coefficients of a curve on finer breaks."""
    middle = (breaks[1:] + breaks[:-1]) / 2
    local = breaks[:-1] - middle  # derivatives in the middle belong to one piece for certain
    d = [np.asarray(curve(middle, nu=n), dtype=np.float64) for n in range(4)]
    return np.stack(
        [
            d[3] / 6,
            d[2] / 2 + d[3] * local / 2,
            d[1] + d[2] * local + d[3] * local**2 / 2,
            d[0] + d[1] * local + d[2] * local**2 / 2 + d[3] * local**3 / 6,
        ]
    )


def _check_least(ovality: PPoly, ends_mm: tuple[float, float]) -> None:
    z_mm = np.linspace(*ends_mm, 2001)
    g_mm = np.asarray(ovality(z_mm))
    least = int(np.argmin(g_mm))
    if g_mm[least] < -1e-12:
        problem = f"leaves an ovality of {g_mm[least]:.6g} mm at height {z_mm[least]:.6g} mm"
        remedy = "drop less than half of the thrust side's ovality, or give ovality_mm"
        raise GeometryError("piston.antithrust.drop_mm", problem, remedy)
