"""Whether a roller or a wheel can make a lobe at all: undercut, hollow flanks, hidden contacts.

>>> from camtools.lobe.lift import Poly345
>>> worst = shape_of(Poly345(8.0, float(np.radians(70.0))), 20.0, 10.0)
>>> f"{worst.least_radius_mm:.6f} at {worst.least_radius_deg:.0f}, {worst.largest_swing_deg:.6f}"
'10.679909 at 15, 19.967381'
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camtools.base.errors import GeometryError
from camtools.base.quantities import Floats
from camtools.lobe.contact import Contact, contact, follow
from camtools.lobe.flat_follower import flat_contact
from camtools.lobe.lift import LiftLaw

_N_ANGLES = 72_000
_N_WHEELS = 720
_HIDDEN_MM = 1e-6


class Shape(NamedTuple):
    """Extremes of a lobe all round."""

    least_radius_mm: float  # of the convex curvature
    least_radius_deg: float  # direction of the follower there
    hollow_radius_mm: float  # of the hollow curvature, infinite without any
    largest_swing_deg: float  # magnitude of the pressure angle


def touch_of(
    law: LiftLaw, base_mm: float, roller_mm: float, theta_rad: Floats, *, is_flat: bool
) -> Contact:
    """Return contacts of a lobe with its own follower, a roller or a flat face."""
    return (flat_contact if is_flat else contact)(law, base_mm, roller_mm, theta_rad)


def all_round(law: LiftLaw, base_mm: float, roller_mm: float, *, is_flat: bool = False) -> Contact:
    """Return contacts of a lobe on a dense grid of the follower's directions."""
    theta = 2 * np.pi * (np.arange(_N_ANGLES) / _N_ANGLES - 0.5)
    return touch_of(law, base_mm, roller_mm, theta, is_flat=is_flat)


def shape_of(law: LiftLaw, base_mm: float, roller_mm: float, *, is_flat: bool = False) -> Shape:
    """Return the extremes of a lobe that its follower does not undercut; radii in mm."""
    touch = all_round(law, base_mm, roller_mm, is_flat=is_flat)
    sharpest, hollowest = int(touch.curvature.argmax()), int(touch.curvature.argmin())
    swing = int(np.abs(touch.gamma).argmax())
    least = touch.curvature[hollowest]
    degrees = np.degrees(touch.theta)
    return Shape(
        1 / float(touch.curvature[sharpest]),
        abs(float(degrees[sharpest])),
        float(-1 / least) if least < 0 else float("inf"),
        abs(float(np.degrees(touch.gamma[swing]))),
    )


def check_follower(touch: Contact, field: str, *, is_flat: bool) -> None:
    """Refuse a lift that its follower cannot have on any profile."""
    (_check_face if is_flat else check_roller)(touch, field)


def _check_face(touch: Contact, field: str) -> None:
    """Refuse a lift that a flat face would have on edges only, MATHS.md (93)."""
    worst = int(touch.ds.argmin())
    if touch.ds[worst] <= 0:
        at = f"at {np.degrees(touch.theta[worst]):.4g} degrees of the lobe"
        problem = (
            f"undercut {at}: base radius, lift and its second derivative are "
            f"{touch.ds[worst]:.6g} mm together, the radius of curvature under a flat face"
        )
        remedy = "give a larger base circle, or less lift over more degrees"
        raise GeometryError(f"{field}.lift_mm", problem, remedy)


def check_roller(touch: Contact, field: str) -> None:
    """Refuse a lift that the roller cannot follow on any profile.

    Parameters
    ----------
    touch : Contact
        All round.
    field : str
        Dotted path of the lobe, for error messages.

    Raises
    ------
    GeometryError
        The roller's centre reaches the axis, or the profile is undercut: its radius of curvature
        falls to 0 where it is convex, MATHS.md (39).
    """
    lowest = int(touch.lift.argmin())
    if touch.lift[lowest] <= -touch.base:
        problem = f"the spline falls to {touch.lift[lowest]:.6g} mm"
        raise GeometryError(f"{field}.lift_mm", problem, "give more points")
    worst = int(touch.ds.argmin())
    if touch.ds[worst] <= 0:
        at = f"at {np.degrees(touch.theta[worst]):.4g} degrees of the lobe"
        centre_mm = np.hypot(touch.p, touch.p1)[worst] / (1 - touch.gamma1[worst])
        problem = (
            f"undercut {at}: the path of the roller's centre has a radius of curvature of "
            f"{centre_mm:.6g} mm there, the roller {touch.roller:g} mm"
        )
        remedy = "give a smaller roller, a larger base circle, or less lift over more degrees"
        raise GeometryError(f"{field}.lift_mm", problem, remedy)


def check_wheel(touch: Contact, wheel_mm: float, field: str) -> None:
    """Refuse a lobe that a wheel cannot grind.

    Parameters
    ----------
    touch : Contact
        All round, not undercut.
    wheel_mm : float
        Radius of the wheel.
    field : str
        Dotted path of the lobe, for error messages.

    Raises
    ------
    GeometryError
        A hollow flank is more curved than the wheel, the lobe would have to turn back, or the
        wheel would cut elsewhere.
    """
    curved = int(touch.curvature.argmin())
    hollow_mm = float(-1 / touch.curvature[curved]) if touch.curvature[curved] < 0 else np.inf
    if hollow_mm <= wheel_mm:
        at = f"at {np.degrees(touch.theta[curved]):.4g} degrees"
        problem = (
            f"the flank of {field} is hollow with a radius of {hollow_mm:.6g} mm {at}: "
            "the wheel does not reach it"
        )
        remedy = f"give a wheel below {hollow_mm:.4g} mm, or a lift with less acceleration"
        raise GeometryError(f"cam.wheel_radius_mm = {wheel_mm:g}", problem, remedy)
    path = follow(touch, wheel_mm)
    hidden = _deepest_elsewhere(touch, path.phi, path.centre, wheel_mm)
    if float(path.phi1.min()) <= 0 or hidden > _HIDDEN_MM:
        problem = f"the wheel would cut {hidden:.3g} mm into another place of {field}"
        if float(path.phi1.min()) <= 0:
            problem = f"the cam of {field} would have to turn back to stay in contact"
        remedy = "give a smaller wheel, or a lift with less acceleration"
        raise GeometryError(f"cam.wheel_radius_mm = {wheel_mm:g}", problem, remedy)


def _deepest_elsewhere(touch: Contact, phi: Floats, centre: Floats, wheel_mm: float) -> float:
    """Return how deep the wheel cuts into places that it does not touch [mm]."""
    profile = touch.radius[::10] * np.exp(1j * touch.alpha[::10])
    deepest = 0.0
    for i in range(0, phi.size, phi.size // _N_WHEELS):
        wheel = centre[i] * np.exp(1j * phi[i])
        deepest = max(deepest, wheel_mm - float(np.abs(profile - wheel).min()))
    return deepest
