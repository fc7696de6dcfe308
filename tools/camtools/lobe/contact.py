"""Where a lobe is touched: contact, pressure angle, curvature, and the path of a round follower.

The frame is fixed to the lobe; angles run as the follower runs round it. A tool that
swings about the roller's centre, and a wheel that grinds the same lobe, are followers of different
radius: the same equations give both.

>>> law = Disc(35.0, 5.0)
>>> touch = contact(law, 20.0, 10.0, np.radians([30.0]))
>>> path = follow(touch, 200.0)
>>> f"{path.lift[0]:.8f} {np.degrees(path.phi[0]):.7f} {path.ds_dphi[0]:.7f}"
'9.15763756 33.3952211 25.4638646'
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from camtools.base.quantities import Floats
from camtools.lobe.lift import Disc, LiftLaw

__all__ = ["Contact", "Disc", "Follower", "contact", "follow", "solved_at"]

_NEWTON_STEPS = 60
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
    """Return the contacts of a lobe with its roller.

    Parameters
    ----------
    base_mm, roller_mm : float
        Radii of base circle and roller.
    theta_rad : ndarray
        Directions of the follower's line [rad].

    Notes
    -----
    Source: MATHS.md (30), (31).
    """
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
    """Return the path of a follower of another radius, in contact at the same places.

    Parameters
    ----------
    touch : Contact
        Of the lobe with its own roller.
    radius_mm : float
        Of the wheel, or of the roller itself: then phi is theta and the angle is gamma.

    Notes
    -----
    Source: MATHS.md (33) .. (35).
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
    lift = (t.lift * (2 * (t.base + t.roller) + t.lift) + 2 * more * _sagged(t)) / (
        centre + t.base + radius_mm
    )
    return Follower(
        *(t.theta - t.gamma + angle, centre, lift, d1),
        *(d1 * tan + centre * (1 + tan**2) * angle1, angle, angle1, angle2, t.ds / phi1, phi1),
    )


def _sagged(t: Contact) -> Floats:
    """Return p cos(gamma) - (base + roller) [mm]."""
    return np.asarray(t.lift - 2 * t.p * np.sin(t.gamma / 2) ** 2, dtype=np.float64)


def solved_at(
    touch_at: Callable[[Floats], tuple[Contact, Follower]], phi_rad: Floats
) -> tuple[Contact, Follower]:
    """Return contacts and path of a follower at given lobe angles.

    Parameters
    ----------
    touch_at : callable
        Contacts and path at directions of the lobe's own follower [rad].
    phi_rad : ndarray, shape (n,)
        Angles of the lobe [rad]; dphi/dtheta must be above 0 all round (`camtools.lobe.undercut`).

    Notes
    -----
    phi(theta) is inverted by Newton's method inside a bracket, to 1e-13 rad.
    """
    low, high = phi_rad - np.pi / 2, phi_rad + np.pi / 2
    theta = phi_rad.copy()
    for _ in range(_NEWTON_STEPS):
        touch, path = touch_at(theta)
        off = path.phi - phi_rad
        if float(np.abs(off).max()) <= _ANGLE_ERROR_RAD:
            break
        low, high = np.where(off < 0, theta, low), np.where(off > 0, theta, high)
        guess = theta - off / path.phi1
        theta = np.where((guess > low) & (guess < high), guess, (low + high) / 2)
    return touch, path
