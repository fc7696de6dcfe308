"""Laws of lift: how far a lobe lifts the centre of its roller, over the follower's angle.

A new law is one class with `evaluate`.

>>> law = Poly345(8.0, np.radians(70.0))
>>> [f"{mm:.7f}" for mm in law.evaluate(np.radians([-60.0, 0.0, 80.0])).lift]
['0.1861129', '8.0000000', '0.0000000']
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from scipy.interpolate import BSpline, PPoly

from camtools.base.errors import GeometryError
from camtools.base.quantities import Floats, rounded_up
from camtools.lobe.listed_lift import (
    Smoothing,
    band_for,
    opened,
    periodic_spline,
    points_of,
    smooth_list,
)
from camtools.lobe.lobe_keys import RISES, Lobe, is_turn
from camtools.lobe.part import Camshaft
from camtools.lobe.rise_laws import RiseLaw
from camtools.part.model import SAME_MM
from camtools.table.points import PointedTurn, quintics_of

_STRAY_MM = 1e-3  # of a spline from what its points promise
_PER_PIECE = 64


class Lift(NamedTuple):
    """Lift of the roller's centre and its derivatives by the follower's angle."""

    lift: Floats  # mm
    d1: Floats  # mm/rad
    d2: Floats  # mm/rad^2
    d3: Floats  # mm/rad^3


class LiftLaw(Protocol):
    """A law of lift over one turn."""

    def evaluate(self, theta_rad: Floats) -> Lift:
        """Return lift and derivatives at angles [rad] of any size and shape."""


@dataclass(frozen=True)
class Poly345:
    """The 3-4-5 polynomial: speed and acceleration 0 at the ends and at the nose."""

    lift_mm: float  # at the nose, angle 0
    half_angle_rad: float  # from the nose to the base circle

    def evaluate(self, theta_rad: Floats) -> Lift:
        """See `LiftLaw.evaluate`. Source: MATHS.md (37)."""
        theta = np.mod(theta_rad + np.pi, 2 * np.pi) - np.pi
        u = np.clip(1 - np.abs(theta) / self.half_angle_rad, 0, 1)
        slope = -np.sign(theta) / self.half_angle_rad
        return Lift(
            self.lift_mm * u**3 * (10 - 15 * u + 6 * u**2),
            self.lift_mm * slope * 30 * u**2 * (1 - u) ** 2,
            self.lift_mm * slope**2 * 60 * u * (1 - u) * (1 - 2 * u),
            self.lift_mm * slope**3 * 60 * (1 - 6 * u + 6 * u**2) * (u > 0),
        )


@dataclass(frozen=True)
class Risen:
    """A rise, a dwell at the nose, a fall that is a rise of its own angle turned round."""

    rise: RiseLaw  # of the rising flank
    fall: RiseLaw  # of the falling flank
    lift_mm: float  # lift at the nose, whose middle is at angle 0
    rise_rad: float  # the three angles are a turn together at most
    dwell_rad: float  # of the nose
    fall_rad: float

    def evaluate(self, theta_rad: Floats) -> Lift:
        """See `LiftLaw.evaluate`. Source: MATHS.md (89)."""
        begin = self.dwell_rad / 2 + self.rise_rad
        at = np.mod(theta_rad + begin, 2 * np.pi)
        top, end = self.rise_rad + self.dwell_rad, begin + self.dwell_rad / 2 + self.fall_rad
        up = self.rise.evaluate(np.clip(at / self.rise_rad, 0, 1))
        down = self.fall.evaluate(np.clip((end - at) / self.fall_rad, 0, 1))
        is_up, is_down = at <= self.rise_rad, (at > top) & (at < end)
        is_top = (at > self.rise_rad) & (at <= top)
        lift = np.where(is_up, up.y, np.where(is_down, down.y, 0.0)) + 1.0 * is_top
        slopes = [
            np.where(is_up, one / self.rise_rad**n, 0.0)
            + np.where(is_down, other / (-self.fall_rad) ** n, 0.0)
            for n, (one, other) in enumerate(zip(up[1:], down[1:], strict=True), start=1)
        ]
        return Lift(self.lift_mm * lift, *(self.lift_mm * slope for slope in slopes))


@dataclass(frozen=True)
class Disc:
    """An eccentric disc: the roller's centre runs on a circle about the disc's centre."""

    reach_mm: float  # radius of the disc plus that of the roller
    offset_mm: float  # distance of the disc's centre from the axis, towards angle 0

    def evaluate(self, theta_rad: Floats) -> Lift:
        """See `LiftLaw.evaluate`. Source: MATHS.md (38), base radius reach - offset - r1."""
        e, sin, cos = self.offset_mm, np.sin(theta_rad), np.cos(theta_rad)
        root = np.sqrt(self.reach_mm**2 - (e * sin) ** 2)
        root1 = -(e**2) * sin * cos / root
        root2 = -(e**2 * (cos**2 - sin**2) + root1**2) / root
        root3 = (4 * e**2 * sin * cos - 3 * root1 * root2) / root
        # reach - root without cancellation, and offset (1 + cos) as it stands
        lift = e * (1 + cos) - (e * sin) ** 2 / (self.reach_mm + root)
        return Lift(lift, root1 - e * sin, root2 - e * cos, root3 + e * sin)


@dataclass(frozen=True, eq=False)
class Listed:
    """Points joined by a periodic curve of quintics: lift [mm] over the angle [rad].

    It is a spline of four continuous derivatives, or pieces through velocities and accelerations.
    """

    spline: BSpline | PPoly
    smoothing: Smoothing | None = None  # what the part file had done to the points
    needed: Smoothing | None = None  # what would rid them of much noise about which it did nothing

    def evaluate(self, theta_rad: Floats) -> Lift:
        """See `LiftLaw.evaluate`."""
        values = (np.asarray(self.spline(theta_rad, nu=n), dtype=np.float64) for n in range(4))
        return Lift(*values)


def pieces_of(points: PointedTurn) -> PPoly:
    """Return the periodic quintics through lift, velocity and acceleration of points."""
    x = np.radians(np.append(points.x_deg, points.x_deg[0] + 360))
    powers = quintics_of(points) / np.diff(x)[:, None] ** np.arange(6)
    return PPoly(powers.T[::-1], x, extrapolate="periodic")


def curve_of(law: Listed) -> PPoly:
    """Return the pieces of a list over one turn, whose breaks are its points."""
    if isinstance(law.spline, PPoly):
        return law.spline
    pieces, k = PPoly.from_spline(law.spline), law.spline.k
    return PPoly(pieces.c[:, k:-k], pieces.x[k:-k])  # as many knots at each end lie outside


def make_lift(cam: Camshaft, lobe: Lobe, field: str) -> LiftLaw:
    """Return the law of a lobe; refuse bad points, the lobe named by its dotted path `field`."""
    if lobe.law in RISES:
        return _risen(lobe, field)
    if lobe.law == "disc":
        assert lobe.disc_radius_mm is not None
        assert lobe.offset_mm is not None
        if cam.follower == "flat":  # the support function of a disc is e cos alpha above its radius
            half = RiseLaw("harmonic")
            return Risen(half, half, 2 * lobe.offset_mm, np.pi, 0.0, np.pi)
        return Disc(lobe.disc_radius_mm + cam.roller_radius_mm, lobe.offset_mm)
    return _listed(lobe, field)


def _rise(lobe: Lobe, angle_rad: float, field: str) -> RiseLaw:
    """Return the law of one flank; refuse a polydyne rise that would have to fall on its way."""
    if lobe.law != "polydyne":
        return RiseLaw(lobe.law)
    assert lobe.design_rpm is not None
    assert lobe.natural_hz is not None
    law = RiseLaw("polydyne", (lobe.design_rpm / 60 / lobe.natural_hz / angle_rad) ** 2)
    if float(law.evaluate(np.linspace(0, 1, 2001)).d1.min()) < -1e-9:
        problem = (
            f"at {lobe.design_rpm:g} r/min a follower of {lobe.natural_hz:g} Hz would need a lift "
            f"that falls on its rise over {np.degrees(angle_rad):g} degrees"
        )
        remedy = "give a lower design_rpm, a stiffer follower, or more degrees"
        raise GeometryError(f"{field}.design_rpm", problem, remedy)
    return law


def _risen(lobe: Lobe, field: str) -> LiftLaw:
    """Return a law of flanks and nose."""
    assert isinstance(lobe.lift_mm, float | int)
    if lobe.half_angle_deg is not None and lobe.law == "poly345":
        return Poly345(float(lobe.lift_mm), float(np.radians(lobe.half_angle_deg)))
    rise_deg, dwell_deg, fall_deg = lobe.angles_deg
    rise_rad, fall_rad = float(np.radians(rise_deg)), float(np.radians(fall_deg))
    rise, fall = (_rise(lobe, angle, field) for angle in (rise_rad, fall_rad))
    flanks = (rise_rad, float(np.radians(dwell_deg)), fall_rad)
    return Risen(rise, fall, float(lobe.lift_mm), *flanks)


def _listed(lobe: Lobe, field: str) -> LiftLaw:
    """Return the spline through the points of a lobe."""
    points = points_of(lobe, field)
    angle_deg, lift_mm = points.x_deg, points.y_mm
    if is_turn(angle_deg[-1] - angle_deg[0]) and abs(lift_mm[0] - lift_mm[-1]) > SAME_MM:
        problem = f"first and last point are a turn apart, {lift_mm[0]:g} and {lift_mm[-1]:g} mm"
        raise GeometryError(f"{field}.lift_mm", problem, "leave the last one out")
    law = _curve_through(opened(points), lobe.smooth_um, field)
    most_mm = float(lift_mm.max())
    if law.smoothing is not None:
        most_mm += float(law.smoothing.off_um.max()) / 1000
    _check_between(law, most_mm, f"{field}.{'csv' if lobe.csv else 'lift_mm'}")
    if lobe.ramp_height_mm is not None and lobe.ramp_um_per_deg is not None:
        _check_ramp(law, lobe.ramp_height_mm, lobe.ramp_um_per_deg, f"{field}.ramp_um_per_deg")
    return law


def _curve_through(points: PointedTurn, band_um: float | None, field: str) -> Listed:
    """Return the curve of a list, smoothed where a band is given."""
    if band_um is None:
        through = pieces_of(points) if points.v.size else periodic_spline(points.x_deg, points.y_mm)
        return Listed(through, needed=band_for(points))
    if points.v.size:
        problem = "the file has velocities and accelerations, which smoothing would contradict"
        raise GeometryError(f"{field}.smooth_um", problem, "remove these columns, or smooth_um")
    smoothing = smooth_list(points.x_deg, points.y_mm, band_um)
    return Listed(smoothing.after, smoothing)


def _between(law: Listed) -> Floats:
    """Return angles [rad] at and between the points of a list."""
    knots = curve_of(law).x
    return np.linspace(knots[:-1], knots[1:], _PER_PIECE, axis=-1).ravel()


def _check_ramp(law: Listed, height_mm: float, most_um_per_deg: float, field: str) -> None:
    """Refuse a list that opens or closes faster than allowed below the height of its ramps."""
    theta = _between(law)
    found = law.evaluate(theta)
    um_per_deg = np.where(found.lift <= height_mm, np.radians(found.d1) * 1000, 0.0)
    worst = int(np.abs(um_per_deg).argmax())
    most = abs(float(um_per_deg[worst]))
    if most > most_um_per_deg:
        problem = (
            f"the {'opening' if um_per_deg[worst] > 0 else 'closing'} ramp has {most:.4g} um per "
            f"degree of the cam at {np.degrees(theta[worst]):.5g} degrees, at a lift of "
            f"{found.lift[worst]:.4g} mm; at most {most_um_per_deg:g} are allowed"
        )
        remedy = f"list slower ramps, or allow it: ramp_um_per_deg = {rounded_up(most):g}"
        raise GeometryError(field, problem, remedy)


def _check_between(law: Listed, largest_mm: float, field: str) -> None:
    """Refuse a spline that leaves the range of its points: the drawing has no such lift."""
    pieces = _between(law)
    lift_mm = np.asarray(law.spline(pieces), dtype=np.float64)
    stray_mm = np.maximum(-lift_mm, lift_mm - largest_mm)
    worst = int(stray_mm.argmax())
    if stray_mm[worst] > _STRAY_MM:
        problem = (
            f"between the points the lift comes to {lift_mm[worst]:.4g} mm at "
            f"{np.degrees(pieces[worst]):.4g} degrees, but they give 0 .. {largest_mm:g} mm"
        )
        raise GeometryError(field, problem, "give more points there, the nose one of them")
