"""Ellipse and eccentric circle: the section of large-bore pistons, MATHS.md (10) .. (13).

From the long axis to the joint the contour is an oval; from there to the short axis it is a
circle about a point beyond the piston's centre. The circle is derived: it meets the oval at the
joint and lies `trim` below it at the short axis. For every trim above 0 the joint is a corner.

>>> joint = Joint(45.4645484572, 0.38, 0.4, np.radians(48.0), DoubleEllipse(0.0))
>>> arc = joint.arc()
>>> f"{arc.eccentricity_mm:.6f} {arc.radius_mm:.6f}"
'1.960000 46.834548'
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camtools.base.quantities import Floats, FloatsLike, SectionValues
from camtools.skirt.geometry.sections import DoubleEllipse, Section

QUARTER_RAD = np.pi / 2


class Arc(NamedTuple):
    """A circle about (0, -eccentricity), the short axis being y."""

    eccentricity_mm: Floats
    radius_mm: Floats

    def reduction(self, phi_rad: FloatsLike, a_mm: FloatsLike) -> SectionValues:
        """Return a - rho of the circle and its derivatives at angles 0 .. 90 degrees."""
        phi, e, a = np.asarray(phi_rad), self.eccentricity_mm, np.asarray(a_mm)
        sin, cos, sin2, cos2 = np.sin(phi), np.cos(phi), np.sin(2 * phi), np.cos(2 * phi)
        w1, w2, w3 = e**2 * sin2, 2 * e**2 * cos2, -4 * e**2 * sin2
        root = np.sqrt(self.radius_mm**2 - (e * cos) ** 2)
        return SectionValues(
            a + e * sin - root,
            e * cos - w1 / (2 * root),
            -e * sin - w2 / (2 * root) + w1**2 / (4 * root**3),
            -e * cos - w3 / (2 * root) + 3 * w1 * w2 / (4 * root**3) - 3 * w1**3 / (8 * root**5),
        )


class Joint(NamedTuple):
    """What decides a section: four lengths and angles that broadcast, and the oval's law."""

    a_mm: FloatsLike  # long half axis
    ovality_mm: FloatsLike  # G
    trim_mm: FloatsLike  # radial, below the oval at the short axis
    joint_rad: FloatsLike
    law: Section = DoubleEllipse(0.0)

    def _lengths(self) -> tuple[Floats, Floats, Floats]:
        """Return contour radius at the joint and at the short axis, and the joint's sine."""
        a = np.asarray(self.a_mm, dtype=np.float64)
        at_joint = a - self.law.evaluate(self.joint_rad, a, self.ovality_mm).delta
        short = a - np.asarray(self.ovality_mm) / 2 - np.asarray(self.trim_mm)
        return at_joint, short, np.sin(self.joint_rad)

    def room_mm(self) -> Floats:
        """Return how far the trimmed short half axis lies beyond the joint; 0 or less: no arc."""
        at_joint, short, sine = self._lengths()
        return np.asarray(short - at_joint * sine)

    def arc(self) -> Arc:
        """Return the circle that meets the oval at the joint, MATHS.md (11)."""
        at_joint, short, sine = self._lengths()
        e = (at_joint - short) * (at_joint + short) / (2 * (short - at_joint * sine))
        return Arc(e, short + e)

    def step_mm(self, eccentricity_mm: FloatsLike) -> Floats:
        """Return the step of the contour at the joint that another eccentricity would give.

        The circle keeps its place at the short axis. Above 0: a step inwards.
        """
        at_joint, short, _ = self._lengths()
        e = np.asarray(eccentricity_mm, dtype=np.float64)
        circle = Arc(e, short + e).reduction(self.joint_rad, self.a_mm)
        return np.asarray(circle.delta - (np.asarray(self.a_mm) - at_joint))

    def reduction(self, phi_rad: FloatsLike) -> SectionValues:
        """Return radius reduction and derivatives at any angle; at the joint those of the arc.

        Returns
        -------
        SectionValues
            Broadcast of angles and lengths; odd derivatives change sign with the quadrant.
        """
        phi, sign = fold(phi_rad)
        oval = self.law.evaluate(phi, self.a_mm, self.ovality_mm)
        circle = self.arc().reduction(phi, self.a_mm)
        is_oval = phi < self.joint_rad
        picked = (np.where(is_oval, a, b) for a, b in zip(oval, circle, strict=True))
        return SectionValues(
            *(odd * one for odd, one in zip((1, sign, 1, sign), picked, strict=True))
        )

    def corner_mm_rad(self) -> Floats:
        """Return the jump of the slope at the joint, circle minus oval [mm/rad]."""
        oval = self.law.evaluate(self.joint_rad, self.a_mm, self.ovality_mm)
        return np.asarray(self.arc().reduction(self.joint_rad, self.a_mm).d1 - oval.d1)


def fold(phi_rad: FloatsLike) -> tuple[Floats, Floats]:
    """Return the angle of the first quadrant that has the same radius, and the sense of rise.

    >>> angle, sign = fold(np.radians([10.0, 170.0, 190.0, 350.0]))
    >>> np.degrees(angle).round(9).tolist(), sign.tolist()
    ([10.0, 10.0, 10.0, 10.0], [1.0, -1.0, 1.0, -1.0])
    """
    half = np.mod(np.asarray(phi_rad, dtype=np.float64), np.pi)
    is_back = half > QUARTER_RAD
    return np.where(is_back, np.pi - half, half), np.where(is_back, -1.0, 1.0)
