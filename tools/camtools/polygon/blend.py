"""Blends: what replaces the joints of an outline, so that U's acceleration does not jump.

Where two curves meet the slope of the radius jumps (two sides without a corner radius, flank and
circle of DIN 32712) or its second derivative does (side and corner arc). Over a window around the
joint one curve goes over into the other with five continuous derivatives, MATHS.md (117); outside
of the windows the outline is the drawing's.

>>> f"{float(_ramp(np.array([0.0]))[0, 0]):.6f}"
'0.123047'
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.polynomial.polynomial import Polynomial

from camtools.base.quantities import UM_PER_MM, Floats
from camtools.polygon.outline import (
    Curve,
    Outline,
    OutlineJoint,
    Polar,
    Reach,
    all_around,
    is_smooth,
)

_BUMP = Polynomial([1.0, 0.0, -1.0]) ** 4 * (315 / 256)  # area 1 over -1 .. 1
_STEP = _BUMP.integ(lbnd=-1)
_RAMP = _STEP.integ(lbnd=-1)  # 0 below -1, x above 1
_RAMPS = (_RAMP, _STEP, _BUMP, _BUMP.deriv())
_NEAR = 0.2  # share of the window in which the quotient is a polynomial
_NODES = 16  # of it; even, so that none lies at the joint
_ROOM = 0.49  # of the shorter curve that a window takes
_SHARE_OF_REACH = 0.8  # that a window takes
_LOOKED_AT = np.linspace(-1, 1, 801)
_STEPS, _SAME, _ROUNDING = 60, 1e-8, 1e-9
_SLIGHT = 1e-3


def _ramp(x: Floats) -> Floats:
    """Return the ramp and three derivatives by x, shape (4, n)."""
    inside = np.clip(x, -1, 1)
    found = np.stack([one(inside) for one in _RAMPS])
    found[0] += np.maximum(x - 1, 0)
    return found


@dataclass(frozen=True, eq=False)
class Blend:
    """A curve that goes over from one curve into another of the same radius at the joint."""

    before: Curve
    behind: Curve
    joint_rad: float  # middle of the window
    half_rad: float  # half its width

    @property
    def reach(self) -> Reach:
        """See `Curve.reach`."""
        return Reach(self.joint_rad - self.half_rad, self.joint_rad + self.half_rad)

    def _difference(self, y: Floats) -> Floats:
        """Return the curve behind minus the one before, with derivatives, shape (4, n)."""
        phi = self.joint_rad + y
        return np.stack(self.behind.polar(phi)) - np.stack(self.before.polar(phi))

    @cached_property
    def _middle(self) -> list[chebyshev.Chebyshev]:
        """Return the difference over y, and derivatives, as polynomials near the joint."""
        near = _NEAR * self.half_rad
        nodes = near * np.cos(np.pi * (np.arange(_NODES) + 0.5) / _NODES)
        values = self._difference(nodes)[0] / nodes
        fit = chebyshev.Chebyshev.fit(nodes, values, _NODES - 1, domain=[-near, near])
        return [fit, *(fit.deriv(n) for n in (1, 2, 3))]

    def _quotient(self, y: Floats) -> Floats:
        """Return the difference over y and three derivatives, shape (4, n)."""
        is_near = np.abs(y) < _NEAR * self.half_rad
        found = np.empty((4, y.size))
        found[:, is_near] = np.stack([one(y[is_near]) for one in self._middle])
        far = y[~is_near]
        d = self._difference(far)
        found[0, ~is_near] = g = d[0] / far
        for n in (1, 2, 3):
            g = (d[n] - n * g) / far
            found[n, ~is_near] = g
        return found

    def polar(self, phi_rad: Floats) -> Polar:
        """See `Curve.polar`."""
        y = np.asarray(np.mod(phi_rad - self.joint_rad + np.pi, 2 * np.pi) - np.pi)
        w = self.half_rad
        p = _ramp(y / w) * w ** (1 - np.arange(4.0))[:, None]
        g, before = self._quotient(y), self.before.polar(phi_rad)
        return Polar(
            before.r + p[0] * g[0],
            before.d1 + p[1] * g[0] + p[0] * g[1],
            before.d2 + p[2] * g[0] + 2 * p[1] * g[1] + p[0] * g[2],
            before.d3 + p[3] * g[0] + 3 * p[2] * g[1] + 3 * p[1] * g[2] + p[0] * g[3],
        )

    def looked_at(self) -> Floats:
        """Return angles all over the window."""
        return self.joint_rad + self.half_rad * _LOOKED_AT

    def deviation_mm(self) -> float:
        """Return the largest distance from the two curves."""
        phi = self.looked_at()
        drawn = np.where(phi < self.joint_rad, self.before.polar(phi).r, self.behind.polar(phi).r)
        return float(np.abs(self.polar(phi).r - drawn).max())

    def acceleration_mm(self) -> float:
        """Return the largest second derivative [mm/rad^2]."""
        return float(np.abs(self.polar(self.looked_at()).d2).max())


class Blended(NamedTuple):
    """An outline whose joints are blended."""

    outline: Outline
    blends: tuple[Blend, ...]
    is_squeezed: bool  # a window has no room for all of the deviation

    @property
    def deviation_um(self) -> float:
        """Return the largest deviation from the drawing [um]."""
        return max((one.deviation_mm() for one in self.blends), default=0.0) * UM_PER_MM


def bend_of(one: Blended) -> float:
    """Return the largest second derivative of the radius all around [mm/rad^2]."""
    around = float(np.abs(one.outline.polar(all_around(one.outline)).d2).max())
    return max(around, *(blend.acceleration_mm() for blend in one.blends), 0.0)


def widest_rad(joint: OutlineJoint) -> float:
    """Return the largest half width of a window at a joint."""
    below = joint.angle_rad - joint.behind.reach.first
    above = joint.before.reach.last - joint.angle_rad
    reach = min(float(np.mod(one + _ROUNDING, 2 * np.pi)) for one in (below, above))
    return min(_ROOM * joint.room_rad, _SHARE_OF_REACH * reach)


def blend_of(joint: OutlineJoint, deviation_mm: float) -> Blend:
    """Return the widest blend of a joint whose deviation is within a limit."""

    def blend(half: float) -> Blend:
        return Blend(joint.before, joint.behind, joint.angle_rad, half)

    high = widest_rad(joint)
    widest = blend(high)
    if (found := widest.deviation_mm()) <= deviation_mm:
        return widest
    # the deviation is about a power of the width, so few steps are enough; halving keeps it safe
    power = 2 if abs(joint.slope_mm) < _SLIGHT * abs(joint.bend_mm) * high else 1
    low, at = 0.0, high
    for _ in range(_STEPS):
        guess = at * (deviation_mm / found) ** (1 / power) * (1 - _ROUNDING)
        at = guess if low < guess < high else (low + high) / 2
        found = blend(at).deviation_mm()
        low, high = (at, high) if found <= deviation_mm else (low, at)
        if deviation_mm * (1 - _SAME) < found <= deviation_mm:
            break
    return blend(low)


def blended(outline: Outline, deviation_um: float) -> Blended:
    """Return an outline with all joints blended, as wide as a deviation allows."""
    deviation_mm = deviation_um / UM_PER_MM
    joints = [one for one in outline.joints() if not is_smooth(one)]
    if not joints:
        return Blended(outline, (), False)
    first = joints[: max(1, len(joints) // outline.repeat)]
    found = [blend_of(joint, deviation_mm) for joint in first]
    widths = [one.half_rad for one in found]
    squeezed = any(
        one.half_rad >= widest_rad(joint) for one, joint in zip(found, first, strict=True)
    )
    blends = tuple(
        Blend(joint.before, joint.behind, joint.angle_rad, widths[i % len(widths)])
        for i, joint in enumerate(joints)
    )
    return Blended(_with(outline, joints, blends), blends, squeezed)


def _with(outline: Outline, joints: list[OutlineJoint], blends: tuple[Blend, ...]) -> Outline:
    """Return the outline whose joints are replaced."""
    starts: list[float] = []
    curves: list[Curve] = []
    of = {joint.i: blend for joint, blend in zip(joints, blends, strict=True)}
    for i, (start, curve) in enumerate(zip(outline.starts_rad, outline.curves, strict=True)):
        blend = of.get(i)
        if blend is not None:
            starts.append(start - blend.half_rad)
            curves.append(blend)
            start += blend.half_rad
        starts.append(start)
        curves.append(curve)
    return Outline(tuple(starts), tuple(curves), outline.repeat)
