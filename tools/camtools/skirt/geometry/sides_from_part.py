"""From a part file to the ovals of its sides, and to the angle by which its sections are turned.

>>> from camtools.skirt.part.part_file import example_part
>>> is_plain(example_part().piston)
True
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import PPoly

from camtools.base.errors import GeometryError
from camtools.base.quantities import Floats
from camtools.skirt.geometry.profile import (
    Allowance,
    check_overshoot,
    constant_spline,
    in_um,
    magnified,
)
from camtools.skirt.geometry.sides import OvalSide, SidesSurface
from camtools.skirt.part.curves import through
from camtools.skirt.part.part_file import Piston
from camtools.skirt.part.power_law import PeakOvality
from camtools.skirt.part.section_keys import PARAMETERS, Antithrust

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
    turn_deg = _over_ovality(phase_deg, piston)
    allowed = Allowance("the angle", 1.0, "degrees", _FREE_DEG, None)
    _check(turn_deg, allowed, piston)
    return _scaled(turn_deg, float(np.radians(1)))


def sides_of(
    piston: Piston, radius: PPoly, ovality: PPoly, factors: tuple[float, float]
) -> SidesSurface:
    """Return the reduction of the radius of ovals that differ over height or from side to side.

    Parameters
    ----------
    radius, ovality : PPoly
        Of the thrust side [mm], magnified already.
    factors : tuple of float
        By which ovality and profile are magnified.

    Raises
    ------
    GeometryError
        A curve leaves its points, or the ovality of the other side would be below 0.
    """
    section, other = piston.section, piston.antithrust
    shape = section.shape
    key = PARAMETERS.get(shape, "beta")
    parameter = _over_ovality(getattr(section, key), piston)
    _check(parameter, Allowance(key, 1.0, "", _FREE, None), piston)
    none = constant_spline(0.0, *_ends(piston))
    thrust = OvalSide(shape, radius, ovality, none, parameter, none)
    if other is None:
        return SidesSurface(thrust)
    drop = _over(other, other.drop_mm or [0.0] * len(other.height_mm), "drop_mm", 1000.0)
    drop = magnified(drop, factors[1], 0.0)
    if other.ovality_mm is None:
        breaks = np.union1d(ovality.x, drop.x)  # G - 2 drop leaves the short half axis as it is
        its_ovality = PPoly(_on(ovality, breaks) - 2 * _on(drop, breaks), breaks)
    else:
        its_ovality = magnified(_over(other, other.ovality_mm, "ovality_mm", 1000.0), factors[0], 0)
    _check_least(its_ovality, _ends(piston))
    own = getattr(other, key)
    side = OvalSide(
        shape,
        radius,
        its_ovality,
        drop,
        parameter if own is None else _over(other, own, key, 1.0),
        _scaled(_over(other, other.phase_deg, "phase_deg", 1.0), float(np.radians(1))),
    )
    return SidesSurface(thrust, side, other.meet, float(np.radians(other.blend_deg)))


def _ends(piston: Piston) -> tuple[float, float]:
    return float(piston.profile.height_mm[0]), float(piston.profile.height_mm[-1])


def _scaled(curve: PPoly, factor: float) -> PPoly:
    return PPoly(curve.c * factor, curve.x)


def _over_ovality(value: list[float] | float, piston: Piston) -> PPoly:
    """Return a number, or a list over the ovality's heights, as cubics."""
    assert piston.ovality is not None
    heights_mm = piston.ovality.height_mm
    if isinstance(value, list):
        # As the ovality is joined.
        kind = "linear" if piston.ovality is None else piston.ovality.interpolation
        return through(heights_mm, value, "linear" if kind == "segments" else kind)
    return constant_spline(value, heights_mm[0], heights_mm[-1])


def _over(other: Antithrust, value: list[float] | float, name: str, scale: float) -> PPoly:
    """Return a number, or a list over the heights of the other side, as cubics."""
    heights_mm = other.height_mm
    if not isinstance(value, list):
        return constant_spline(value, heights_mm[0], heights_mm[-1])
    curve = through(heights_mm, value, other.interpolation)
    allowed = Allowance(name, 1.0, "", _FREE, None)
    if name.endswith("_mm"):
        allowed = in_um(other.overshoot_um, name, scale / 1000.0)
    check_overshoot("piston.antithrust.interpolation", curve, allowed, np.array(heights_mm))
    return curve


def _check(curve: PPoly, allowed: Allowance, piston: Piston) -> None:
    """Refuse a list whose curve leaves its points: it is interpolated as the ovality is."""
    if piston.ovality is not None and not isinstance(piston.ovality, PeakOvality):
        heights_mm = np.asarray(piston.ovality.height_mm, dtype=np.float64)
        check_overshoot("piston.ovality.interpolation", curve, allowed, heights_mm)


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
