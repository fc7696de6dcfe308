"""Cross-sections of a skirt: radius reduction over the spindle angle, exact, in double.

The angle is the polar angle from the long axis, MATHS.md (1), which is the spindle angle.

>>> values = ellipse(np.radians([0.0, 45.0, 90.0]), 46.0, 0.2)
>>> [f"{mm:.9f}" for mm in values.delta]
['0.000000000', '0.050081610', '0.100000000']

From the long axis to the joint the contour is an oval; from there to the short axis it is a
circle about a point beyond the piston's centre. The circle is derived: it meets the oval at the
joint and lies `trim` below it at the short axis. For every trim above 0 the joint is a corner.

>>> joint = Joint(45.4645484572, 0.38, 0.4, np.radians(48.0))
>>> arc = joint.arc()
>>> f"{arc.eccentricity_mm:.6f} {arc.radius_mm:.6f}"
'1.960000 46.834548'
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple, Protocol

import numpy as np

from camtools.base.quantities import Floats, FloatsLike, SectionValues


class SkirtSurface(Protocol):
    """The reduction of the radius over the whole skirt."""

    @property
    def log2_repeat(self) -> int:
        """The pattern repeats 2^log2_repeat times per turn, exactly."""
        return 1

    def heights_mm(self) -> Floats:
        """Return the heights at which a curve of the surface itself has a break, rising."""
        return np.empty(0)

    def delta(self, phi_rad: FloatsLike, z_mm: FloatsLike) -> SectionValues:
        """Return radius reduction and derivatives by the angle [rad] at fixed height [mm].

        Both are broadcast against each other.
        """


Law = Callable[[FloatsLike, FloatsLike, FloatsLike], SectionValues]
"""Reduction and derivatives of a family of closed curves, two-fold, all arguments broadcast.

They are the angle from the long axis [rad], the long half axis a and the diametral ovality
G = 2a - 2b [mm].
"""


def ellipse(phi_rad: FloatsLike, radius_mm: FloatsLike, ovality_mm: FloatsLike) -> SectionValues:
    """Return the exact ellipse without cancellation, MATHS.md (2), (5)."""
    phi, a, g = np.asarray(phi_rad), np.asarray(radius_mm), np.asarray(ovality_mm)
    b = a - g / 2
    k = (g / 2) * (a + b) / b**2
    sin2 = np.sin(phi) ** 2
    w1, w2 = k * np.sin(2 * phi), 2 * k * np.cos(2 * phi)
    root = np.sqrt(1 + k * sin2)
    r3, r5, r7 = root**-3, root**-5, root**-7
    return SectionValues(
        a * k * sin2 / (root * (root + 1)),
        a * r3 * w1 / 2,
        a * (r3 * w2 / 2 - 0.75 * r5 * w1**2),
        a * (-2 * r3 * w1 - 2.25 * r5 * w1 * w2 + 1.875 * r7 * w1**3),
    )


def double_ellipse(
    phi_rad: FloatsLike, radius_mm: FloatsLike, ovality_mm: FloatsLike, beta: FloatsLike = 0.0
) -> SectionValues:
    """Return two harmonics, the quadratic ellipse, MATHS.md (4); beta = 0 is the cosine form, (3).

    The flank is monotone for |beta| <= 6.25; the long half axis only sets the shape.
    """
    phi, g = np.asarray(phi_rad), np.asarray(ovality_mm)
    half_g = g / 2 + 0 * np.asarray(radius_mm)
    q = 4 * np.asarray(beta) / 25
    sin2, cos2 = np.sin(2 * phi), np.cos(2 * phi)
    return SectionValues(
        half_g * (np.sin(phi) ** 2 + q / 4 * sin2**2),
        half_g * sin2 * (1 + q * cos2),
        half_g * (2 * cos2 + 2 * q * (cos2**2 - sin2**2)),
        half_g * (-4 * sin2 - 16 * q * sin2 * cos2),
    )


def power_oval(
    phi_rad: FloatsLike, radius_mm: FloatsLike, ovality_mm: FloatsLike, exponent: FloatsLike = 2.0
) -> SectionValues:
    """Return an oval whose reduction rises with a power of the sine, 2 .. 8, MATHS.md (75).

    With 2 it is the cosine form; the larger it is, the longer the contact at the long axis.
    """
    phi, g = np.asarray(phi_rad), np.asarray(ovality_mm)
    half_g = g / 2 + 0 * np.asarray(radius_mm)
    t, t1, t2 = np.sin(phi) ** 2, np.sin(2 * phi), 2 * np.cos(2 * phi)
    t3 = -4 * t1
    f, f1, f2, f3 = power_of_square(t, np.asarray(exponent, dtype=np.float64) / 2)
    return SectionValues(
        half_g * f,
        half_g * f1 * t1,
        half_g * (f2 * t1**2 + f1 * t2),
        half_g * (f3 * t1**3 + 3 * f2 * t1 * t2 + f1 * t3),
    )


SMOOTH_DEG = 15.0  # from the long axis up to here a power is made smooth
_SMOOTH = float(np.sin(np.radians(SMOOTH_DEG)) ** 2)


def power_of_square(t: Floats, power: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Return f(t) and three derivatives: t^m, but a polynomial below sin^2 15 deg, MATHS.md (75).

    t is sin^2 of the angle from the long axis, m half of the exponent, 1 .. 4.
    """
    t, m = np.broadcast_arrays(t, power)
    x = t / _SMOOTH
    weights = [
        -(m - 2) * (m - 3) * (m - 4) / 6,
        (m - 1) * (m - 3) * (m - 4) / 2,
        -(m - 1) * (m - 2) * (m - 4) / 2,
        (m - 1) * (m - 2) * (m - 3) / 6,
    ]
    far = np.maximum(x, 1.0)
    found = []
    falling = np.ones_like(m)  # m (m - 1) .. of the derivative
    for n in range(4):
        power_law = falling * far ** (m - n)
        near = np.zeros_like(m)
        for k, weight in enumerate(weights, start=1):
            if k >= n:
                near = near + weight * np.prod(np.arange(k - n + 1, k + 1)) * x ** (k - n)
        found.append(np.where(x < 1, near, power_law) * _SMOOTH ** (m - n))
        falling = falling * (m - n)
    return found[0], found[1], found[2], found[3]


def law_of(shape: str, parameter: FloatsLike) -> Law:
    """Return the law of a part file's `shape`; the parameter is its beta or its exponent."""
    if shape == "double-ellipse":
        return partial(double_ellipse, beta=parameter)
    if shape == "power":
        return partial(power_oval, exponent=parameter)
    return {"ellipse": ellipse, "cosine": double_ellipse}[shape]


QUARTER_RAD = np.pi / 2
ALL_AROUND_RAD = np.radians(np.arange(0, 360, 0.5))


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
    """What decides a section, MATHS.md (10), (12): lengths and angles that broadcast, a law."""

    a_mm: FloatsLike  # long half axis
    ovality_mm: FloatsLike  # G
    trim_mm: FloatsLike  # radial, below the oval at the short axis
    joint_rad: FloatsLike
    law: Law = double_ellipse

    def _lengths(self) -> tuple[Floats, Floats, Floats]:
        """Return contour radius at the joint and at the short axis, and the joint's sine."""
        a = np.asarray(self.a_mm, dtype=np.float64)
        at_joint = a - self.law(self.joint_rad, a, self.ovality_mm).delta
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

        Odd derivatives change sign with the quadrant.
        """
        phi, sign = fold(phi_rad)
        oval = self.law(phi, self.a_mm, self.ovality_mm)
        circle = self.arc().reduction(phi, self.a_mm)
        is_oval = phi < self.joint_rad
        both = zip((1, sign, 1, sign), oval, circle, strict=True)
        return SectionValues(*(odd * np.where(is_oval, a, b) for odd, a, b in both))

    def corner_mm_rad(self) -> Floats:
        """Return the jump of the slope at the joint, circle minus oval [mm/rad]."""
        oval = self.law(self.joint_rad, self.a_mm, self.ovality_mm)
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
