"""A flat-faced follower: its lift is the support function of the lobe less the base circle.

The face stands across the direction alpha and touches the lobe where its normal has that
direction. A tool that swings about a centre, and a wheel, touch it there as well: they are round
followers of the same contacts (`camtools.lobe.contact`).

>>> from camtools.lobe.lift import Poly345
>>> law = Poly345(8.0, float(np.radians(70.0)))
>>> touch = flat_contact(law, 40.0, 10.0, np.radians([0.0, 30.0]))
>>> [f"{mm:.6f}" for mm in touch.radius]
['48.000000', '46.571828']
"""

from __future__ import annotations

import numpy as np

from camtools.base.quantities import Floats
from camtools.lobe.contact import Contact, Follower
from camtools.lobe.lift import LiftLaw


def flat_contact(law: LiftLaw, base_mm: float, roller_mm: float, alpha_rad: Floats) -> Contact:
    """Return the contacts of a lobe with its flat face.

    Parameters
    ----------
    base_mm, roller_mm : float
        Radius of the base circle, and of the circle on which the tip of a swung tool runs: p and
        gamma are those of its centre.
    alpha_rad : ndarray
        Directions of the follower's line, across which its face stands [rad].

    Notes
    -----
    Source: MATHS.md (93). theta is the direction of that centre; derivatives are by alpha.
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
    """Return the path of a round follower, in contact at the same places.

    Parameters
    ----------
    radius_mm : float
        Of the wheel, or of the circle on which the tip of the tool runs.

    Notes
    -----
    Source: MATHS.md (94).
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
