"""Laws of lift: how far a lobe lifts the centre of its roller, over the follower's angle.

A new law is one class with `evaluate`.

The flanks of lobes are rises from the base circle to the nose, over 0 .. 1. A new rise is one
function in `_RISES`, which gives the derivatives up to the third. Peaks Cv of the speed and Ca of
the acceleration are those of the handbooks (Norton; Rothbart).

| rise | Cv | Ca | continuous at both ends |
|---|---|---|---|
| poly345 | 1.875 | 5.774 | acceleration; the jerk steps |
| cycloidal | 2 | 6.283 | acceleration; the jerk steps |
| modified-sine | 1.760 | 5.528 | acceleration; the jerk steps |
| modified-trapezoid | 2 | 4.888 | acceleration; the jerk steps |
| harmonic | 1.571 | 4.935 | speed; the acceleration steps |
| polydyne | 2.461 | 9.372 | acceleration; the jerk steps; of the driven mass alone |

A list of points is read from the part file or another one, and smoothed within a band.

>>> law = Poly345(8.0, np.radians(70.0))
>>> [f"{mm:.7f}" for mm in law.evaluate(np.radians([-60.0, 0.0, 80.0])).lift]
['0.1861129', '8.0000000', '0.0000000']
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
from numpy.polynomial import Polynomial
from scipy.interpolate import BSpline, PPoly

from camtools.base.errors import GeometryError, InputError
from camtools.base.number_table import read_whole_table
from camtools.base.quantities import UM_PER_MM, Floats, rounded_up
from camtools.lobe.list_curve import periodic_spline, spline_through
from camtools.lobe.part import (
    CRANK_HINT,
    MAX_LIFT_MM,
    RISES,
    Camshaft,
    Lobe,
    is_turn,
)
from camtools.part.model import SAME_MM
from camtools.part.smoothing import LEAST_UM, bands_um, first_enough, smoothed
from camtools.table.points import (
    MAX_BYTES,
    MM_PER_INCH,
    PointedTurn,
    Reading,
    gaps_after,
    most_step_deg,
    parse_points,
    quintics_of,
)

_ZERO_MM = 1e-3  # lifts that are less below the base circle are on it
_BASE_MM = 0.01  # above the least lift: of points that end the base circle


def _reading(lobe: Lobe) -> Reading:
    """Return how the file of a list is read, by the keys of its lobe."""
    value_mm = lobe.largest_lift_mm or (MM_PER_INCH if lobe.lift_unit == "inch" else None)
    if lobe.counts_per_mm is not None:
        value_mm = 1 / lobe.counts_per_mm
    hint = CRANK_HINT[lobe.turns_listed], ", or set counts_per_turn and counts_per_mm of counts"
    if lobe.counts_per_turn is not None:
        hint = ", or correct counts_per_turn", ", or correct counts_per_turn"
    return Reading(lobe.turns_listed, value_mm, lobe.counts_per_turn, *hint, is_lift=True)


def _points_of_file(text: str, file: str, lobe: Lobe) -> PointedTurn:
    """Return the points of a text, as they are; lifts no further below 0 count as 0: `_on_base`."""
    found = parse_points(text, file, _reading(lobe))
    turn = found.sections[0]
    if len(found.sections) > 1:
        problem = f"has {len(found.sections)} heights"
        raise InputError(file, "Z_mm", None, problem, "give the points of one lobe")
    low, high = float(turn.y_mm.min()), float(turn.y_mm.max())
    most_mm = lobe.largest_lift_mm or MAX_LIFT_MM
    if low < -_ZERO_MM or high > most_mm + SAME_MM:
        problem = f"lifts of {low:g} .. {high:g} mm, not 0 .. {most_mm:g}"
        change = "correct" if lobe.counts_per_mm else "set"
        remedy = f"give mm above the base circle, or {change} counts_per_mm"
        if lobe.largest_lift_mm:
            problem = f"shares of {low / most_mm:g} .. {high / most_mm:g}, not 0 .. 1"
            remedy = "give shares of 0 .. 1 of largest_lift_mm, or remove it"
        raise InputError(file, "Y_mm", None, problem, remedy)
    return turn if found.has_motion else turn._replace(v=turn.v[:0], a=turn.a[:0])


def opened(points: PointedTurn) -> PointedTurn:
    """Return points of a turn without a repeated end."""
    n = points.x_deg.size - is_turn(points.x_deg[-1] - points.x_deg[0])
    return PointedTurn(*(column[:n] for column in points))


def _given_points(lobe: Lobe, field: str) -> PointedTurn:
    """Return `points_of`, with lifts that are a little below 0 as they are given."""
    if lobe.csv is None:
        assert lobe.angle_deg is not None
        angle_deg = np.asarray(lobe.angle_deg, dtype=float) / lobe.turns_listed
        return PointedTurn(angle_deg, np.asarray(lobe.lift_mm, dtype=float), *np.zeros((2, 0)))
    path = Path(lobe.csv)
    try:
        return _points_of_file(read_whole_table(path, MAX_BYTES), path.name, lobe)
    except InputError as error:
        problem, _, remedy = error.lines[0].rpartition("; ")
        raise GeometryError(f"{field}.csv", problem, remedy) from error


def _on_base(points: PointedTurn) -> PointedTurn:
    return points._replace(y_mm=points.y_mm.clip(0))


def points_of(lobe: Lobe, field: str) -> PointedTurn:
    """Return the points of a listed lobe, from the part file or from its file.

    Without velocity and acceleration those columns are empty. Raises GeometryError, which names the
    lobe by `field`, where the file is no good.
    """
    return _on_base(_given_points(lobe, field))


def _check_gaps(points: PointedTurn, turns: int, field: str) -> None:
    """Refuse a gap that is not on the base circle; velocities and accelerations are complete."""
    if points.v.size:
        return
    lift_mm = points.y_mm
    is_above = np.maximum(lift_mm, np.roll(lift_mm, -1)) > lift_mm.min() + _BASE_MM
    gaps = [i for i in gaps_after(points.steps_deg) if is_above[i]]
    if not gaps:
        return
    i = max(gaps, key=lambda gap: float(points.steps_deg[gap]))
    start_deg, end_deg = points.x_deg[i], points.x_deg[i] + points.steps_deg[i]
    problem = (
        f"no points from {start_deg * turns:g} to {end_deg * turns:g} degrees, where the lift goes "
        f"from {lift_mm[i]:g} to {np.roll(lift_mm, -1)[i]:g} mm: the turn is not closed"
    )
    most_deg = most_step_deg(points.x_deg.size) * turns
    remedy = (
        "list all of the lobe, both flanks, points above the base circle at most "
        f"{most_deg:g} degrees apart"
    )
    raise GeometryError(field, problem, remedy)


def _check_crank(points: PointedTurn, turns: int, field: str) -> None:
    """Refuse one turn of the crank: its points may be a turn of the cam, or lack the base circle.

    A list of a turn lacks its repeated end, so its span may be a mean step less, or more.
    """
    span_deg = float(points.x_deg[-1] - points.x_deg[0]) * turns
    mean_step_deg = 360 / points.x_deg.size
    if turns > 1 and abs(span_deg - 360) <= mean_step_deg:
        whole_deg = 360 * turns
        problem = (
            f"the points span {span_deg:g} of {whole_deg} degrees of the crank: one turn of the "
            "cam?"
        )
        remedy = (
            f"add points of lift 0 up to {whole_deg} degrees; if the angles are of the cam, remove "
            'degrees_of = "crank"'
        )
        raise GeometryError(field, problem, remedy)


_PER_STEP = 16  # angles between two points at which peaks are sought


class PeaksOfList(NamedTuple):
    """Largest magnitudes over a turn."""

    acceleration: float  # mm/rad^2
    jerk: float  # mm/rad^3


class Smoothing(NamedTuple):
    """A list within its band, and the curves through it."""

    band_um: float
    angle_deg: Floats  # of the points, degrees of the cam
    off_um: Floats  # smoothed less listed lift
    before: BSpline  # lift [mm] over the angle [rad] through the listed points
    after: BSpline  # through the smoothed ones

    @property
    def largest_um(self) -> float:
        """Return the largest residual."""
        return float(np.abs(self.off_um).max())


def smooth_list(angle_deg: Floats, lift_mm: Floats, band_um: float) -> Smoothing:
    """Return a list with the least third derivative within a band to either side of its lifts.

    Points of lift 0 stay 0; the end of the turn is not repeated.
    """
    held = lift_mm == 0
    found_mm = smoothed(angle_deg, lift_mm, band_um / UM_PER_MM, period=360.0, held=held)
    off_um = (found_mm - lift_mm) * UM_PER_MM
    curves = (periodic_spline(angle_deg, mm) for mm in (lift_mm, found_mm))
    return Smoothing(band_um, angle_deg, off_um, *curves)


def peaks_of(curve: BSpline) -> PeaksOfList:
    """Return the peaks of a periodic quintic."""
    knots = curve.t[curve.k : -curve.k]
    x = np.linspace(knots[:-1], knots[1:], _PER_STEP, axis=-1).ravel()
    return PeaksOfList(*(float(np.abs(curve(x, nu=n)).max()) for n in (2, 3)))


def bands_of(points: PointedTurn, *, of_jerk: bool) -> list[float]:
    """Return bands [um] that may remove the noise of a list, rising; none without noise.

    Noise of the jerk may be less than the lifts show: the least band there is may remove it. Lists
    with velocities and accelerations are not smoothed.
    """
    if points.v.size:
        return []
    return bands_um(points.x_deg, points.y_mm, 360.0) or [LEAST_UM] * of_jerk


def band_for(points: PointedTurn, *, of_jerk: bool = False) -> Smoothing | None:
    """Return the smoothing that a list without one needs; None where it needs none.

    What it needs lowers the peak of the acceleration, or that of the jerk: a list of many points
    has noise in that which no rounding of its lifts shows.
    """
    name = "jerk" if of_jerk else "acceleration"

    def peaks(smoothing: Smoothing) -> tuple[float, float]:
        before, after = peaks_of(smoothing.before), peaks_of(smoothing.after)
        return getattr(before, name), getattr(after, name)

    smooth = partial(smooth_list, points.x_deg, points.y_mm)
    return first_enough(bands_of(points, of_jerk=of_jerk), smooth, peaks)


class Rise(NamedTuple):
    """A rise of height 1 and its derivatives by the share of its angle."""

    y: Floats
    d1: Floats
    d2: Floats
    d3: Floats


def _cycloidal(x: Floats) -> Rise:
    turn = 2 * np.pi * x
    sin, cos = np.sin(turn), np.cos(turn)
    return Rise(x - sin / (2 * np.pi), 1 - cos, 2 * np.pi * sin, 4 * np.pi**2 * cos)


def _harmonic(x: Floats) -> Rise:
    sin, cos = np.sin(np.pi * x), np.cos(np.pi * x)
    return Rise((1 - cos) / 2, np.pi / 2 * sin, np.pi**2 / 2 * cos, -(np.pi**3) / 2 * sin)


def _polynomial(x: Floats, law: Polynomial) -> Rise:
    return Rise(law(x), law.deriv(1)(x), law.deriv(2)(x), law.deriv(3)(x))


class _Wave(NamedTuple):
    """A piece of an acceleration: level + size sin(rate x + phase), up to an end."""

    end: float
    level: float
    size: float
    rate: float
    phase: float


def _integrated(x: Floats, waves: tuple[_Wave, ...]) -> Rise:
    """Return the rise whose acceleration is made of pieces, up to a factor that makes it end at 1.

    Speed and place of each piece continue those of the one before.
    """
    y, d1, d2, d3 = (np.zeros_like(x) for _ in range(4))
    begin = speed = place = 0.0
    for wave in waves:
        inside = (x >= begin) & (x <= wave.end)
        at = np.append(x[inside], wave.end)
        s, angle, before = at - begin, wave.rate * at + wave.phase, wave.rate * begin + wave.phase
        by = wave.size / wave.rate
        slope = speed + by * np.cos(before)
        rising = speed + wave.level * s - by * (np.cos(angle) - np.cos(before))
        risen = place + slope * s + wave.level * s**2 / 2
        risen -= by / wave.rate * (np.sin(angle) - np.sin(before))
        y[inside], d1[inside] = risen[:-1], rising[:-1]
        d2[inside] = wave.level + wave.size * np.sin(angle[:-1])
        d3[inside] = wave.size * wave.rate * np.cos(angle[:-1])
        begin, speed, place = wave.end, float(rising[-1]), float(risen[-1])
    return Rise(y / place, d1 / place, d2 / place, d3 / place)


_FAST, _SLOW = 4 * np.pi, 4 * np.pi / 3
_MODIFIED_SINE = (
    _Wave(0.125, 0, 1, _FAST, 0),
    _Wave(0.875, 0, 1, _SLOW, np.pi / 3),
    _Wave(1.0, 0, 1, _FAST, 0),
)
_MODIFIED_TRAPEZOID = (
    _Wave(0.125, 0, 1, _FAST, 0),
    _Wave(0.375, 1, 0, _FAST, 0),
    _Wave(0.625, 0, 1, _FAST, -np.pi),
    _Wave(0.875, -1, 0, _FAST, 0),
    _Wave(1.0, 0, 1, _FAST, 0),
)
_RISES: dict[str, Callable[[Floats], Rise]] = {  # MATHS.md (37), (89) .. (91)
    "poly345": partial(_polynomial, law=Polynomial([0, 0, 0, 10, -15, 6])),
    "cycloidal": _cycloidal,
    "harmonic": _harmonic,
    "modified-sine": partial(_integrated, waves=_MODIFIED_SINE),
    "modified-trapezoid": partial(_integrated, waves=_MODIFIED_TRAPEZOID),
}
_DRIVEN = Polynomial([0, 0, 0, 0, 0, 126, -420, 540, -315, 70])


@dataclass(frozen=True)
class RiseLaw:
    """A rise from 0 at 0 to 1 at 1, at rest at both ends.

    A polydyne rise lets an elastic follower move by a polynomial, MATHS.md (92). `deflection` is
    the lift that deflects the follower over the acceleration of its mass, in the square of the
    angle of the rise: (speed of the cam / natural frequency / angle of the rise)^2.
    """

    name: str
    deflection: float = 0.0

    def evaluate(self, x: Floats) -> Rise:
        """Return rise and derivatives at shares 0 .. 1."""
        if self.name == "polydyne":
            return _polynomial(x, _DRIVEN + self.deflection * _DRIVEN.deriv(2))
        return _RISES[self.name](x)


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
            np.where(is_up, rising / self.rise_rad**n, 0.0)
            + np.where(is_down, falling / (-self.fall_rad) ** n, 0.0)
            for n, (rising, falling) in enumerate(zip(up[1:], down[1:], strict=True), start=1)
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

    It is a spline, of four continuous derivatives where the acceleration of the points does not
    step, or pieces through velocities and accelerations.
    """

    spline: BSpline | PPoly
    smoothing: Smoothing | None = None  # what the part file had done to the points
    needed: Smoothing | None = None  # what would rid them of much noise about which it did nothing
    below_um: float = 0.0  # how far points were below the base circle, taken as on it
    points: PointedTurn | None = None  # without a repeated end

    def evaluate(self, theta_rad: Floats) -> Lift:
        """See `LiftLaw.evaluate`."""
        curve = self.spline
        ends = curve.x[[0, -1]] if isinstance(curve, PPoly) else curve.t[[curve.k, -curve.k - 1]]
        # a place that rounds to beyond the end of the turn would be nowhere on the curve
        at = np.clip(ends[0] + np.mod(theta_rad - ends[0], ends[1] - ends[0]), *ends)
        return Lift(*(np.asarray(curve(at, nu=n), dtype=np.float64) for n in range(4)))


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
    c, x = pieces.c[:, k:-k], pieces.x[k:-k]  # as many knots at each end lie outside
    is_piece = np.diff(x) > 0  # a step of the acceleration is several knots
    return PPoly(c[:, is_piece], x[np.append(is_piece, True)])


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
    assert isinstance(lobe.lift_mm, float | int)
    if lobe.half_angle_deg is not None and lobe.law == "poly345":
        return Poly345(float(lobe.lift_mm), float(np.radians(lobe.half_angle_deg)))
    rise_deg, dwell_deg, fall_deg = lobe.angles_deg
    rise_rad, fall_rad = float(np.radians(rise_deg)), float(np.radians(fall_deg))
    rise, fall = (_rise(lobe, angle, field) for angle in (rise_rad, fall_rad))
    flanks = (rise_rad, float(np.radians(dwell_deg)), fall_rad)
    return Risen(rise, fall, float(lobe.lift_mm), *flanks)


def _listed(lobe: Lobe, field: str) -> LiftLaw:
    given = _given_points(lobe, field)
    points = _on_base(given)
    angle_deg, lift_mm = points.x_deg, points.y_mm
    if is_turn(angle_deg[-1] - angle_deg[0]) and abs(lift_mm[0] - lift_mm[-1]) > SAME_MM:
        problem = f"first and last point are a turn apart, {lift_mm[0]:g} and {lift_mm[-1]:g} mm"
        raise GeometryError(f"{field}.lift_mm", problem, "leave the last one out")
    place = f"{field}.{'csv' if lobe.csv else 'angle_deg'}"
    _check_gaps(opened(points), lobe.turns_listed, place)
    _check_crank(points, lobe.turns_listed, place)
    law = _curve_through(opened(points), lobe.smooth_um, field)
    law = replace(law, below_um=max(0.0, -float(given.y_mm.min())) * UM_PER_MM)
    most_mm = float(lift_mm.max())
    if law.smoothing is not None:
        most_mm += float(law.smoothing.off_um.max()) / 1000
    _check_between(law, most_mm, f"{field}.{'csv' if lobe.csv else 'lift_mm'}")
    if lobe.ramp_height_mm is not None and lobe.ramp_um_per_deg is not None:
        _check_ramp(law, lobe.ramp_height_mm, lobe.ramp_um_per_deg, f"{field}.ramp_um_per_deg")
    return law


def _curve_through(points: PointedTurn, band_um: float | None, field: str) -> Listed:
    if band_um is None:
        through = pieces_of(points) if points.v.size else spline_through(points.x_deg, points.y_mm)
        return Listed(through, needed=band_for(points), points=points)
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
