"""The outline of a section: curves one after the other round the axis, and the surface they make.

A new curve is one class with `polar` and `reach`; nothing else has to know it.

Outlines are those of the standards (sizes: tools/docs/POLYGONS.md) or have rounded corners.

>>> line = Line(10.0, 0.0)
>>> [f"{mm:.6f}" for mm in line.polar(np.radians([-30.0, 0.0, 60.0])).r]
['11.547005', '10.000000', '20.000000']

All sections are similar: the radius at a height is that of the first height times a factor that
grows linearly, 1 without a taper, MATHS.md (118).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple, Protocol

import numpy as np
from scipy.optimize import brentq
from scipy.optimize.elementwise import find_minimum

from camtools.base.errors import GeometryError
from camtools.base.quantities import Floats, Ints
from camtools.base.solvers import converged, inverted, neighbours
from camtools.skirt.geometry.poly_surface import N_ANGLE, N_HEIGHT, TURN_RAD, PolySurface
from camtools.table.channel import MAX_LOG2_REPEAT, segment_coefficients

HALF_TURN_RAD = np.pi
_REACH = 0.999  # share of the angle at which a curve turns its back to the axis
_GRID = 2049


class Polar(NamedTuple):
    """Radius and its derivatives by the angle, shapes as the angles."""

    r: Floats  # mm
    d1: Floats  # mm/rad
    d2: Floats  # mm/rad^2
    d3: Floats  # mm/rad^3


class Reach(NamedTuple):
    """Angles [rad] between which a curve has one radius."""

    first: float
    last: float


class Curve(Protocol):
    """A smooth curve round the axis, or a piece of one."""

    def polar(self, phi_rad: Floats) -> Polar:
        """Return radius and derivatives at angles [rad] within the reach."""

    @property
    def reach(self) -> Reach:
        """Where `polar` may be asked; wider than the stretch of the section."""


def shifted(phi_rad: Floats, middle_rad: float) -> Floats:
    """Return angles counted from a direction, -pi .. pi."""
    return np.asarray(np.mod(phi_rad - middle_rad + np.pi, 2 * np.pi) - np.pi, dtype=np.float64)


@dataclass(frozen=True)
class Line:
    """A straight side, MATHS.md (113)."""

    distance_mm: float  # of the line from the axis
    normal_rad: float  # direction of the foot

    @property
    def reach(self) -> Reach:
        """See `Curve.reach`."""
        half = _REACH * HALF_TURN_RAD / 2
        return Reach(self.normal_rad - half, self.normal_rad + half)

    def polar(self, phi_rad: Floats) -> Polar:
        """See `Curve.polar`."""
        beta = shifted(phi_rad, self.normal_rad)
        r, t = self.distance_mm / np.cos(beta), np.tan(beta)
        return Polar(r, r * t, r * (2 * t**2 + 1), r * t * (6 * t**2 + 5))


@dataclass(frozen=True)
class CornerArc:
    """A circle round a centre that may lie off the axis, MATHS.md (114)."""

    centre_mm: float  # distance of the centre
    centre_rad: float  # and its direction
    radius_mm: float  # of the circle; the axis lies inside, or the far side of the circle is meant

    @property
    def reach(self) -> Reach:
        """See `Curve.reach`."""
        half = HALF_TURN_RAD
        if self.centre_mm > self.radius_mm:
            half = float(np.arcsin(self.radius_mm / self.centre_mm))
        return Reach(self.centre_rad - half, self.centre_rad + half)

    def polar(self, phi_rad: Floats) -> Polar:
        """See `Curve.polar`."""
        beta, d = shifted(phi_rad, self.centre_rad), self.centre_mm
        sin, cos = np.sin(beta), np.cos(beta)
        q = np.sqrt(self.radius_mm**2 - (d * sin) ** 2)
        q1 = -(d**2) * sin * cos / q
        q2 = (-(d**2) * (cos**2 - sin**2) - q1**2) / q
        q3 = (4 * d**2 * sin * cos - 3 * q1 * q2) / q
        return Polar(d * cos + q, q1 - d * sin, q2 - d * cos, q3 + d * sin)


@dataclass(frozen=True)
class Flank:
    """The contour of the standards, given by its distance from the axis, MATHS.md (115), (116).

    p(alpha) = mean - eccentricity cos(n alpha) is the distance of the tangent whose normal has
    the direction alpha, counted from the middle of a side.
    """

    mean_mm: float  # mean distance of a tangent
    eccentricity_mm: float  # by how much it swings
    n: int  # number of sides
    middle_rad: float  # direction of the middle of a side

    @property
    def is_convex(self) -> bool:
        """Return whether the contour has no loops and needs no circle across its corners."""
        return self.mean_mm > self._bend

    @cached_property
    def _last_alpha(self) -> float:
        """Return the normal's direction up to which the angle grows with it."""
        if self.is_convex:
            return float(np.pi / self.n)
        return _REACH * float(np.arccos(-self.mean_mm / self._bend) / self.n)

    @property
    def _bend(self) -> float:
        return (self.n**2 - 1) * self.eccentricity_mm

    @property
    def reach(self) -> Reach:
        """See `Curve.reach`."""
        if self.is_convex:
            return Reach(self.middle_rad - HALF_TURN_RAD, self.middle_rad + HALF_TURN_RAD)
        half = min(float(self._angle(np.array([self._last_alpha]))[0]), HALF_TURN_RAD)
        return Reach(self.middle_rad - half, self.middle_rad + half)

    def support(self, alpha: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Return p and its derivatives by the normal's direction [mm]."""
        n, e = self.n, self.eccentricity_mm
        cos, sin = e * np.cos(n * alpha), e * np.sin(n * alpha)
        return self.mean_mm - cos, n * sin, n**2 * cos, -(n**3) * sin

    def _angle(self, alpha: Floats) -> Floats:
        p, p1, _, _ = self.support(alpha)
        return np.asarray(alpha + np.arctan2(p1, p), dtype=np.float64)

    @cached_property
    def _sampled(self) -> tuple[Floats, Floats]:
        """Return rising directions of the normal, and the angles of the contour there."""
        alpha = np.linspace(-self._last_alpha, self._last_alpha, _GRID)
        return alpha, self._angle(alpha)

    def normal_at(self, beta: Floats) -> Floats:
        """Return the normal's direction at angles within reach, from the middle of a side on.

        The error left is rounding: the radius is exact to 1e-13 of itself.
        """
        alpha, angle = self._sampled
        beta = np.clip(beta, angle[0], angle[-1])
        bounds = neighbours(alpha, angle, beta)
        return inverted(self._angle, beta, bounds, 0.0, "polygon: flank")

    def polar(self, phi_rad: Floats) -> Polar:
        """See `Curve.polar`."""
        beta = shifted(phi_rad, self.middle_rad)
        if self.is_convex:
            pitch = 2 * np.pi / self.n
            beta = np.mod(beta + pitch / 2, pitch) - pitch / 2
        p, p1, p2, p3 = self.support(self.normal_at(beta))
        square, bend = p**2 + p1**2, p + p2
        top, bottom = (p * p2 - p1**2) * square, p**3 * bend
        top1 = (p * p3 - p1 * p2) * square + (p * p2 - p1**2) * 2 * p1 * bend
        bottom1 = 3 * p**2 * p1 * bend + p**3 * (p1 + p3)
        # derivatives of log r by the angle: dphi / dalpha = p (p + p'') / (p^2 + p'^2)
        g1, g2 = p1 / p, top / bottom
        g3 = (top1 - g2 * bottom1) / bottom * square / (p * bend)
        r = np.sqrt(square)
        return Polar(r, r * g1, r * (g1**2 + g2), r * (g1**3 + 3 * g1 * g2 + g3))


_MEASURED = 20_160  # angles; a multiple of all numbers of sides up to 10
_SAME_MM, _SAME_BEND_MM = 1e-9, 1e-6  # slopes and bends that differ by less are the same


class OutlineJoint(NamedTuple):
    """Where two curves of an outline meet."""

    i: int  # of the curve behind
    angle_rad: float
    before: Curve
    behind: Curve
    slope_mm: float  # jump of r' [mm/rad]
    bend_mm: float  # jump of r'' [mm/rad^2]
    room_rad: float  # to the nearer end of both curves


@dataclass(frozen=True, eq=False)
class Outline:
    """A closed outline: curves that begin at rising angles within one turn."""

    starts_rad: tuple[float, ...]
    curves: tuple[Curve, ...]  # as many
    repeat: int  # how many times the outline repeats per turn

    def _piece(self, phi: Floats) -> Ints:
        first = self.starts_rad[0]
        place = np.mod(phi - first, TURN_RAD) + first
        found = np.searchsorted(self.starts_rad, place, side="right") - 1
        return np.clip(found, 0, len(self.curves) - 1)

    def polar(self, phi_rad: Floats) -> Polar:
        """Return radius and derivatives at angles [rad] of any size, shape (n,)."""
        found, piece = np.empty((4, phi_rad.size)), self._piece(phi_rad)
        for i in np.unique(piece):
            here = piece == i
            found[:, here] = np.stack(self.curves[i].polar(phi_rad[here]))
        return Polar(*found)

    def curve_at(self, angle_rad: float) -> Curve:
        """Return the curve at an angle."""
        return self.curves[int(self._piece(np.array([angle_rad]))[0])]

    def joints(self) -> Iterator[OutlineJoint]:
        """Yield where curves meet; a curve that goes on smoothly all around has no joint."""
        widths = np.diff([*self.starts_rad, self.starts_rad[0] + TURN_RAD]).tolist()
        for i, start in enumerate(self.starts_rad):
            before, behind = self.curves[i - 1], self.curves[i]
            if before is behind:
                continue
            here = np.array([start])
            low, high = before.polar(here), behind.polar(here)
            slope, bend = (float((getattr(high, d) - getattr(low, d))[0]) for d in ("d1", "d2"))
            room = min(widths[i - 1], widths[i])
            yield OutlineJoint(i, start, before, behind, slope, bend, room)


def extremes_of(outline: Outline) -> tuple[float, float]:
    """Return the least and the largest radius [mm], sought next to those of samples."""
    phi = all_around(outline)
    r = outline.polar(phi).r
    i, sign = np.array([r.argmin(), r.argmax()]), np.array([1.0, -1.0])
    near = np.unwrap(phi[[i - 1, i, (i + 1) % phi.size]], axis=0)
    found = find_minimum(lambda at, sign: sign * outline.polar(at).r, tuple(near), args=(sign,))
    least, largest = sign * converged(found, "polygon: extreme radius").f_x
    return float(least), float(largest)


class Measures(NamedTuple):
    """What a drawing and an inspector say of a section [mm]."""

    inner_circle_mm: float  # diameter of the largest circle round the axis inside
    outer_circle_mm: float  # diameter of the smallest one outside
    least_width_mm: float  # between two parallel planes, as a calliper measures
    largest_width_mm: float
    area_mm2: float


def all_around(outline: Outline) -> Floats:
    """Return angles all around, the joints among them."""
    grid = TURN_RAD * np.arange(_MEASURED) / _MEASURED
    return np.union1d(grid, np.mod(outline.starts_rad, TURN_RAD))


def measures_of(outline: Outline) -> Measures:
    """Return the measures of a section; widths of 362 directions."""
    phi = all_around(outline)
    r = outline.polar(phi).r
    grid = TURN_RAD * np.arange(360) / 720
    normals = np.concatenate([grid, phi[[int(r.argmax()), int(r.argmin())]]])
    x, y = r * np.cos(phi), r * np.sin(phi)
    width = np.array([float(np.ptp(x * np.cos(a) + y * np.sin(a))) for a in normals])
    closed = np.append(phi, phi[0] + TURN_RAD)
    area = float(np.trapezoid(np.append(r, r[0]) ** 2, closed)) / 2
    least, largest = extremes_of(outline)
    circles = 2 * least, 2 * largest
    return Measures(*circles, float(width.min()), float(width.max()), area)


def is_smooth(joint: OutlineJoint) -> bool:
    """Return whether nothing jumps at a joint but rounding."""
    return abs(joint.slope_mm) < _SAME_MM and abs(joint.bend_mm) < _SAME_BEND_MM


_FIT_MM = 1e-10  # a ten-thousandth of a nanometre
_MAX_HALVINGS = 16
_BETWEEN = np.array([0.2, 0.5, 0.8])
_LEAST_RAD = 1e-12


def _quintics(curve: Curve, first: Floats, last: Floats) -> tuple[Floats, Floats]:
    """Return quintics (n, 6) through the ends of stretches of a curve, and how far each is off."""
    h = last - first
    at = curve.polar(np.concatenate([first, last]))
    r, d1, d2 = (column.reshape(2, -1) for column in (at.r, at.d1, at.d2))
    knots = np.stack([r, h * d1, h**2 / 2 * d2], axis=-1).transpose(1, 0, 2)
    quintics = np.asarray(segment_coefficients(knots, periodic=False)[:, 0], dtype=np.float64)
    exact = curve.polar((first[:, None] + h[:, None] * _BETWEEN).ravel()).r
    off = quintics @ _BETWEEN ** np.arange(N_ANGLE)[:, None] - exact.reshape(first.size, -1)
    return quintics, np.asarray(np.abs(off).max(axis=1), dtype=np.float64)


def _fitted(outline: Outline, first_rad: float, last_rad: float) -> tuple[Floats, Floats]:
    """Return left ends [rad] and quintics (n, 6) of the radius between two neighbouring joints.

    Stretches are halved until their quintics fit.
    """
    curve = outline.curve_at((first_rad + last_rad) / 2)
    first, last = np.array([first_rad]), np.array([last_rad])
    starts, found = [], []
    for _ in range(_MAX_HALVINGS):
        quintics, off = _quintics(curve, first, last)
        is_close = off <= _FIT_MM
        starts.append(first[is_close])
        found.append(quintics[is_close])
        low, high = first[~is_close], last[~is_close]
        if not low.size:
            break
        middle = (low + high) / 2
        first, last = np.concatenate([low, middle]), np.concatenate([middle, high])
    else:
        where = f"at {np.degrees(float(low[0])):.4g} degrees"
        problem = f"is too small: {where} the outline bends too sharply"
        raise GeometryError("polygon.blend_um", problem, "allow more deviation")
    left = np.concatenate(starts)
    order = np.argsort(left)
    return left[order], np.concatenate(found)[order]


def prism_of(
    outline: Outline,
    largest_mm: float,
    heights_mm: tuple[float, float],
    factors: tuple[float, float],
) -> PolySurface:
    """Return the surface of an outline, its sections at both heights larger by the factors.

    The reduction of the radius counts from `largest_mm`.
    """
    joints = np.mod(np.array(outline.starts_rad), TURN_RAD)
    borders = np.unique(np.concatenate([[0.0, TURN_RAD], joints]))
    keep = np.append(np.diff(borders) > _LEAST_RAD, True)
    borders = borders[keep]
    borders[0], borders[-1] = 0.0, TURN_RAD
    found = [_fitted(outline, a, b) for a, b in pairwise(borders)]
    breaks = np.concatenate([*(starts for starts, _ in found), [TURN_RAD]]) / TURN_RAD
    quintics = -np.concatenate([pieces for _, pieces in found])
    quintics[:, 0] += largest_mm
    coefficients = np.zeros((1, quintics.shape[0], N_ANGLE, N_HEIGHT))
    coefficients[0, ..., 0] = factors[0] * quintics
    coefficients[0, ..., 1] = (factors[1] - factors[0]) * quintics
    log2 = min(MAX_LOG2_REPEAT, (outline.repeat & -outline.repeat).bit_length() - 1)
    heights = np.asarray(heights_mm, dtype=np.float64)
    return PolySurface(breaks, heights, coefficients, log2_alike=log2)


_SIDES_P3G, _SIDES_P4C = 3, 4
_SAME_PLACE_MM = 1e-9
_STEEPEST_RAD = float(np.radians(80.0))


def p3g(mean_diameter_mm: float, eccentricity_mm: float, phase_rad: float) -> Outline:
    """Return the outline of DIN 32711, a corner at the phase, MATHS.md (115); its sides convex."""
    middle = phase_rad + np.pi / _SIDES_P3G
    flank = Flank(mean_diameter_mm / 2, eccentricity_mm, _SIDES_P3G, middle)
    if not flank.is_convex:
        most = mean_diameter_mm / (2 * (_SIDES_P3G**2 - 1))
        problem = f"{eccentricity_mm:g} makes loops at the corners"
        remedy = f"give less than {most:.6g}, a 16th of the mean"
        raise GeometryError("polygon.eccentricity_mm", problem, remedy)
    return Outline((0.0,), (flank,), _SIDES_P3G)


def _crossing_rad(flank: Flank, radius_mm: float) -> float:
    """Return the angle from the middle of a side at which the flank meets a circle."""

    def outside(alpha: float) -> float:
        p, p1, _, _ = flank.support(np.array([alpha]))
        return float(np.hypot(p, p1)[0]) - radius_mm

    last = float(flank.normal_at(np.array([flank.reach.last - flank.middle_rad]))[0])
    if outside(last) <= 0:
        raise _no_crossing(radius_mm)
    alpha = brentq(outside, 0.0, last, xtol=1e-15, rtol=1e-15)
    p, p1, _, _ = flank.support(np.array([alpha]))
    return float(alpha + np.arctan2(p1, p)[0])


def _no_crossing(radius_mm: float) -> GeometryError:
    problem = f"{2 * radius_mm:g}: the sides meet inside of this circle"
    remedy = "give a smaller outer diameter, or a larger eccentricity"
    return GeometryError("polygon.outer_diameter_mm", problem, remedy)


def p4c(outer_mm: float, inner_mm: float, eccentricity_mm: float, phase_rad: float) -> Outline:
    """Return the outline of DIN 32712, a corner's arc at the phase, MATHS.md (116)."""
    if inner_mm >= outer_mm:
        problem = f"{inner_mm:g} is not below outer_diameter_mm, {outer_mm:g}"
        raise GeometryError("polygon.inner_diameter_mm", problem, "give the inner circle")
    circle = CornerArc(0.0, 0.0, outer_mm / 2)
    pitch = TURN_RAD / _SIDES_P4C
    starts: list[float] = []
    curves: list[Curve] = []
    for k in range(_SIDES_P4C):
        corner = phase_rad + k * pitch
        mean = inner_mm / 2 + eccentricity_mm
        flank = Flank(mean, eccentricity_mm, _SIDES_P4C, corner + pitch / 2)
        half = pitch / 2 - _crossing_rad(flank, outer_mm / 2)
        if half <= 0:
            raise _no_crossing(outer_mm / 2)
        starts += [corner - half, corner + half]
        curves += [circle, flank]
    return Outline(tuple(starts), tuple(curves), _SIDES_P4C)


def regular(sides: int, across_flats_mm: float, corner_mm: float, phase_rad: float) -> Outline:
    """Return a regular polygon, a corner at the phase; a corner of radius 0 is sharp."""
    out = across_flats_mm / 2 / np.cos(np.pi / sides)
    angles = phase_rad + TURN_RAD * np.arange(sides) / sides
    corners = out * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    if corner_mm >= across_flats_mm / 2:
        problem = f"{corner_mm:g} leaves nothing of the sides"
        remedy = f"give less than {across_flats_mm / 2:g}, half of across_flats_mm"
        raise GeometryError("polygon.corner_radius_mm", problem, remedy)
    return _rounded(corners, np.full(sides, corner_mm), sides)


def cornered(
    corners_mm: Sequence[Sequence[float]], corner_mm: Sequence[float], phase_rad: float
) -> Outline:
    """Return a convex polygon of given corners [mm], turned by the phase.

    Raises GeometryError where it is not convex, not counter-clockwise or too steep, where the axis
    lies outside or radii are too large.
    """
    given, radii = np.asarray(corners_mm, dtype=np.float64), np.asarray(corner_mm, dtype=float)
    cos, sin = np.cos(phase_rad), np.sin(phase_rad)
    corners = given @ np.array([[cos, sin], [-sin, cos]])
    side = np.roll(corners, -1, axis=0) - corners
    before = np.roll(side, 1, axis=0)
    bend = before[:, 0] * side[:, 1] - before[:, 1] * side[:, 0]
    area = corners[:, 0] * side[:, 1] - corners[:, 1] * side[:, 0]
    if (bend <= 0).any():
        i = int(bend.argmin())
        problem = f"at {given[i].tolist()} the outline does not turn left"
        remedy = "list a convex outline counter-clockwise, no corner on a straight side"
        raise GeometryError("polygon.corners_mm", problem, remedy)
    if (area <= 0).any():
        i = int(area.argmin())
        problem = f"the axis, [0, 0], is outside of the side that follows {given[i].tolist()}"
        raise GeometryError("polygon.corners_mm", problem, "count the corners from the axis")
    _check_steepness(corners, given)
    return _rounded(corners, radii, _repeat_of(corners, radii))


def _check_steepness(corners: Floats, given: Floats) -> None:
    """Refuse sides that run almost towards the axis: no tool follows them."""
    side = np.roll(corners, -1, axis=0) - corners
    area = corners[:, 0] * side[:, 1] - corners[:, 1] * side[:, 0]
    distance, out = area / np.hypot(*side.T), np.hypot(*corners.T)
    steep = np.arccos(np.minimum(1.0, distance / np.maximum(out, np.roll(out, -1))))
    i = int(steep.argmax())
    if steep[i] > _STEEPEST_RAD:
        after, found_deg, most_deg = given[i].tolist(), *np.degrees([steep[i], _STEEPEST_RAD])
        problem = f"the side that follows {after} rises {found_deg:.3g} degrees"
        remedy = f"give sides that rise at most {most_deg:g} degrees off the circle"
        raise GeometryError("polygon.corners_mm", problem, remedy)


def _repeat_of(corners: Floats, radii: Floats) -> int:
    """Return how many times an outline repeats per turn."""
    n = radii.size
    for repeat in range(n, 1, -1):
        if n % repeat:
            continue
        turn, step = TURN_RAD / repeat, n // repeat
        cos, sin = np.cos(turn), np.sin(turn)
        turned = corners @ np.array([[cos, sin], [-sin, cos]])
        off = np.abs(np.roll(corners, -step, axis=0) - turned).max()
        if off < _SAME_PLACE_MM and np.array_equal(np.roll(radii, -step), radii):
            return repeat
    return 1


def _rounded(corners: Floats, radii: Floats, repeat: int) -> Outline:
    """Return the outline of a convex polygon round the axis with rounded corners."""
    side = np.roll(corners, -1, axis=0) - corners
    length = np.hypot(side[:, 0], side[:, 1])
    along = side / length[:, None]
    normal = np.stack([along[:, 1], -along[:, 0]], axis=-1)
    distance = (corners * normal).sum(axis=1)
    # Half of the angle by which the outline turns at each corner [rad].
    before = np.roll(along, 1, axis=0)
    cross = before[:, 0] * along[:, 1] - before[:, 1] * along[:, 0]
    dot = (before * along).sum(axis=1)
    taken = radii * np.tan(np.arctan2(cross, dot) / 2)  # of both sides of a corner
    _check_room(length, taken, radii)
    starts: list[float] = []
    curves: list[Curve] = []
    for i in range(radii.size):
        line = Line(float(distance[i]), float(np.arctan2(normal[i, 1], normal[i, 0])))
        if radii[i] > 0:
            inward = -radii[i] * normal[i] + taken[i] * along[i]
            centre = corners[i] + inward
            radius, where = float(np.hypot(*centre)), float(np.arctan2(centre[1], centre[0]))
            starts.append(_angle(corners[i] - taken[i] * along[i - 1]))
            curves.append(CornerArc(radius, where, float(radii[i])))
        starts.append(_angle(corners[i] + taken[i] * along[i]))
        curves.append(line)
    rising = np.unwrap(starts)
    return Outline(tuple(float(angle) for angle in rising), tuple(curves), repeat)


def _angle(point: Floats) -> float:
    return float(np.arctan2(point[1], point[0]))


def _check_room(length: Floats, taken: Floats, radii: Floats) -> None:
    left = length - taken - np.roll(taken, -1)
    i = int(left.argmin())
    if left[i] <= _SAME_PLACE_MM:
        problem = f"{radii[i]:g}: the arcs use up the whole following side of {length[i]:.6g} mm"
        raise GeometryError("polygon.corner_radius_mm", problem, "give smaller radii")
