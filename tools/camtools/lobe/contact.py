"""Where a lobe is touched, by round and flat followers, and whether a wheel can make it at all.

The frame is fixed to the lobe; angles run as the follower runs round it. A tool that
swings about the roller's centre, and a wheel that grinds the same lobe, are followers of different
radius: the same equations give both.

>>> from camtools.lobe.lift import Disc
>>> law = Disc(35.0, 5.0)
>>> touch = contact(law, 20.0, 10.0, np.radians([30.0]))
>>> path = follow(touch, 200.0)
>>> f"{path.lift[0]:.8f} {np.degrees(path.phi[0]):.7f} {path.ds_dphi[0]:.7f}"
'9.15763756 33.3952211 25.4638646'

A flat face stands across the direction alpha and touches the lobe where its normal has that
direction. A tool that swings about a centre, and a wheel, touch it there as well: they are round
followers of the same contacts.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from camtools.base.errors import GeometryError
from camtools.base.quantities import Floats
from camtools.base.solvers import inverted
from camtools.lobe.lift import LiftLaw

_ANGLE_ERROR_RAD = 1e-13


class Contact(NamedTuple):
    """Contacts of a lobe with its roller, each of the shape of the angles asked for.

    All members are functions of the direction theta of the follower's line.
    """

    theta: Floats  # rad
    base: float  # mm, radius of the base circle
    roller: float  # mm, radius of the roller
    lift: Floats  # mm
    p: Floats  # mm, distance of the roller's centre from the axis
    p1: Floats  # mm/rad, its derivative, that of the lift
    p2: Floats  # mm/rad^2
    gamma: Floats  # rad, pressure angle; the contact's normal points to theta - gamma
    gamma1: Floats  # 1, by theta
    gamma2: Floats  # 1/rad
    foot: Floats  # mm, OQ: distance of the axis from the normal
    reach: Floats  # mm, QC: from that foot along the normal to the contact
    radius: Floats  # mm, OC: of the profile
    alpha: Floats  # rad, polar angle of the contact
    ds: Floats  # mm/rad, travel of the contact along the profile
    curvature: Floats  # 1/mm, of the profile, positive where it is convex


def contact(law: LiftLaw, base_mm: float, roller_mm: float, theta_rad: Floats) -> Contact:
    """Return the contacts of a lobe with its roller, by its direction, MATHS.md (30), (31)."""
    lift, p1, p2, p3 = law.evaluate(theta_rad)
    p = base_mm + roller_mm + lift
    square = p**2 + p1**2
    gamma, bend = np.arctan2(p1, p), p2 * p - p1**2
    gamma1 = bend / square
    gamma2 = ((p3 * p - p1 * p2) * square - bend * 2 * p1 * (p + p2)) / square**2
    foot, reach = p * np.sin(gamma), p * np.cos(gamma) - roller_mm
    ds = np.sqrt(square) - roller_mm * (1 - gamma1)
    with np.errstate(divide="ignore"):
        curvature = (1 - gamma1) / ds
    alpha = theta_rad - gamma + np.arctan2(foot, reach)
    of_profile = (foot, reach, np.hypot(foot, reach), alpha, ds, curvature)
    centre = (lift, p, p1, p2, gamma, gamma1, gamma2)
    return Contact(theta_rad, base_mm, roller_mm, *centre, *of_profile)


class Follower(NamedTuple):
    """The path of a round follower's centre, and its derivatives by the lobe's angle."""

    phi: Floats  # rad, lobe angle: direction of the follower's centre
    centre: Floats  # mm, its distance from the axis
    lift: Floats  # mm, of the centre above where it is on the base circle
    d1: Floats  # mm/rad
    d2: Floats  # mm/rad^2
    angle: Floats  # rad, between the line of centres and the normal at the contact
    angle1: Floats  # 1, by phi
    angle2: Floats  # 1/rad
    ds_dphi: Floats  # mm/rad, travel of the contact along the profile
    phi1: Floats  # 1, dphi/dtheta


def follow(touch: Contact, radius_mm: float) -> Follower:
    """Return the path of a follower of another radius, in contact at the same places as the roller.

    Of the roller's own radius phi is theta and the angle is gamma. Source: MATHS.md (33) .. (35).
    """
    t, more = touch, radius_mm - touch.roller
    sin, cos = np.sin(t.gamma), np.cos(t.gamma)
    along = t.reach + radius_mm  # QO1
    foot1 = t.p1 * sin + t.p * cos * t.gamma1
    along1 = t.p1 * cos - t.p * sin * t.gamma1
    bend = t.p2 - t.p * t.gamma1**2
    turn = 2 * t.p1 * t.gamma1 + t.p * t.gamma2
    foot2, along2 = bend * sin + turn * cos, bend * cos - turn * sin
    square = t.foot**2 + along**2
    centre = np.sqrt(square)
    angle = np.arctan2(t.foot, along)
    by_theta = (foot1 * along - t.foot * along1) / square
    growth = 2 * (t.foot * foot1 + along * along1) / square
    twice = (foot2 * along - t.foot * along2) / square - by_theta * growth
    phi1, phi2 = 1 - t.gamma1 + by_theta, twice - t.gamma2
    angle1 = by_theta / phi1
    angle2 = (twice - angle1 * phi2) / phi1**2
    tan = t.foot / along
    d1 = centre * tan
    # centre - (base + radius) without cancellation for a large wheel
    sagged = t.lift - 2 * t.p * np.sin(t.gamma / 2) ** 2  # p cos(gamma) - (base + roller)
    lift = (t.lift * (2 * (t.base + t.roller) + t.lift) + 2 * more * sagged) / (
        centre + t.base + radius_mm
    )
    return Follower(
        *(t.theta - t.gamma + angle, centre, lift, d1),
        *(d1 * tan + centre * (1 + tan**2) * angle1, angle, angle1, angle2, t.ds / phi1, phi1),
    )


def solved_at(
    touch_at: Callable[[Floats], tuple[Contact, Follower]], phi_rad: Floats
) -> tuple[Contact, Follower]:
    """Return contacts and path of a follower at given lobe angles.

    `touch_at` gives them at directions of the lobe's own follower [rad]; dphi/dtheta must be above
    0 all round. phi(theta) is inverted to 1e-13 rad; raises CamtoolsError where it is not.
    """
    half = np.pi / 2
    theta = inverted(
        lambda theta_rad: touch_at(theta_rad)[1].phi,
        phi_rad,
        (phi_rad - half, phi_rad + half),
        _ANGLE_ERROR_RAD,
        "cam.lobe: contact of the follower",
    )
    return touch_at(theta)


def flat_contact(law: LiftLaw, base_mm: float, roller_mm: float, alpha_rad: Floats) -> Contact:
    """Return the contacts of a lobe with its flat face, across the directions alpha, MATHS.md (93).

    On the circle of radius `roller_mm` runs the tip of a swung tool; theta is the direction of its
    centre, p and gamma are those of it, derivatives are by alpha.
    """
    lift, s1, s2, s3 = law.evaluate(alpha_rad)
    s = base_mm + lift
    along, square = s + roller_mm, (s + roller_mm) ** 2 + s1**2
    p, gamma, bend = np.sqrt(square), np.arctan2(s1, along), s2 * along - s1**2
    gamma1 = bend / square
    gamma2 = ((s3 * along - s1 * s2) * square - bend * 2 * s1 * (along + s2)) / square**2
    p1 = s1 * (along + s2) / p
    p2 = (s2 * (along + s2) + s1 * (s1 + s3) - p1**2) / p
    ds = s + s2
    with np.errstate(divide="ignore"):
        curvature = 1 / ds
    of_profile = (s1, s, np.hypot(s, s1), alpha_rad + np.arctan2(s1, s), ds, curvature)
    centre = (lift, p, p1, p2, gamma, gamma1, gamma2)
    return Contact(alpha_rad + gamma, base_mm, roller_mm, *centre, *of_profile)


def follow_flat(law: LiftLaw, touch: Contact, radius_mm: float) -> Follower:
    """Return the path of a round follower, in contact at the same places, MATHS.md (94).

    `radius_mm` is that of the wheel, or of the circle on which the tip of the tool runs.
    """
    t, (_, s1, s2, s3) = touch, law.evaluate(touch.theta - touch.gamma)
    along = t.reach + radius_mm
    square = along**2 + s1**2
    centre, angle, tan = np.sqrt(square), np.arctan2(s1, along), s1 / along
    slope = (s2 * along - s1**2) / square
    twice = (s3 * along - s1 * s2) / square - slope * 2 * s1 * (along + s2) / square
    phi1 = 1 + slope
    angle1 = slope / phi1
    angle2 = (twice - angle1 * twice) / phi1**2
    d1 = centre * tan
    # centre - (base + radius) without cancellation for a large wheel
    lift = (t.lift * (2 * (t.base + radius_mm) + t.lift) + s1**2) / (centre + t.base + radius_mm)
    d2 = d1 * tan + centre * (1 + tan**2) * angle1
    both = (angle, angle1, angle2, t.ds / phi1, phi1)
    return Follower(t.theta - t.gamma + angle, centre, lift, d1, d2, *both)


_N_ANGLES = 72_000
_N_WHEELS = 720
_HIDDEN_MM = 1e-6


class Shape(NamedTuple):
    """Extremes of a lobe all round."""

    least_radius_mm: float  # of the convex curvature
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
    least, most = float(touch.curvature.min()), float(touch.curvature.max())
    hollow_mm = -1 / least if least < 0 else float("inf")
    return Shape(1 / most, hollow_mm, float(np.degrees(np.abs(touch.gamma).max())))


def check_follower(touch: Contact, field: str, *, is_flat: bool = False) -> None:
    """Refuse a lift that its follower, touching all round, cannot have on any profile.

    Raises GeometryError, which names the lobe by `field`: the roller's centre reaches the axis, or
    the radius of curvature falls to 0 where the profile is convex, MATHS.md (39), (93).
    """
    lowest, worst = int(touch.lift.argmin()), int(touch.ds.argmin())
    if not is_flat and touch.lift[lowest] <= -touch.base:
        problem = f"the spline falls to {touch.lift[lowest]:.6g} mm"
        raise GeometryError(f"{field}.lift_mm", problem, "give more points")
    if touch.ds[worst] > 0:
        return
    problem = f"undercut at {np.degrees(touch.theta[worst]):.4g} degrees of the lobe: "
    remedy = "a larger base circle, or less lift over more degrees"
    if is_flat:
        problem += (
            f"base radius, lift and its second derivative are {touch.ds[worst]:.6g} mm together, "
            "the radius of curvature under a flat face"
        )
    else:
        centre_mm = np.hypot(touch.p, touch.p1)[worst] / (1 - touch.gamma1[worst])
        problem += (
            f"the path of the roller's centre has a radius of curvature of {centre_mm:.6g} mm "
            f"there, the roller {touch.roller:g} mm"
        )
        remedy = f"a smaller roller, {remedy}"
    raise GeometryError(f"{field}.lift_mm", problem, f"give {remedy}")


def check_wheel(touch: Contact, wheel_mm: float, field: str) -> None:
    """Refuse a lobe that a wheel of this radius cannot grind; `touch` all round, not undercut.

    Raises GeometryError, which names the lobe by `field`: a hollow flank is more curved than the
    wheel, the lobe would have to turn back, or the wheel would cut elsewhere.
    """
    curved = int(touch.curvature.argmin())
    hollow_mm = float(-1 / touch.curvature[curved]) if touch.curvature[curved] < 0 else np.inf
    if hollow_mm <= wheel_mm:
        problem = (
            f"the flank of {field} is hollow with a radius of {hollow_mm:.6g} mm at "
            f"{np.degrees(touch.theta[curved]):.4g} degrees: the wheel does not reach it"
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
