"""The outlines of the part file: polygons of the standards, and polygons with rounded corners.

Sources of the sizes: tools/docs/POLYGONS.md.

>>> outline = p3g(25.0, 0.8, 0.0)
>>> [f"{mm:.6f}" for mm in outline.polar(np.radians([0.0, 60.0])).r]
['13.300000', '11.700000']
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import brentq

from camtools.base.errors import GeometryError
from camtools.base.quantities import Floats
from camtools.polygon.outline import TURN_RAD, CornerArc, Curve, Flank, Line, Outline

_SIDES_P3G, _SIDES_P4C = 3, 4
_SAME_MM = 1e-9
_STEEPEST_RAD = float(np.radians(80.0))


def p3g(mean_diameter_mm: float, eccentricity_mm: float, phase_rad: float) -> Outline:
    """Return the outline of DIN 32711, a corner at the phase, MATHS.md (115); its sides convex."""
    middle = phase_rad + np.pi / _SIDES_P3G
    flank = Flank(mean_diameter_mm / 2, eccentricity_mm, _SIDES_P3G, middle)
    if not flank.is_convex:
        most = mean_diameter_mm / (2 * (_SIDES_P3G**2 - 1))
        problem = f"{eccentricity_mm:g} makes loops at the corners"
        raise GeometryError(
            "polygon.eccentricity_mm", problem, f"give less than {most:.6g}, a 16th of the mean"
        )
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
        problem = (
            f"the side that follows {given[i].tolist()} rises {np.degrees(steep[i]):.3g} degrees"
        )
        remedy = (
            f"give sides that rise at most {np.degrees(_STEEPEST_RAD):g} degrees off the circle"
        )
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
        if off < _SAME_MM and np.array_equal(np.roll(radii, -step), radii):
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
    return Outline(tuple(float(one) for one in rising), tuple(curves), repeat)


def _angle(point: Floats) -> float:
    return float(np.arctan2(point[1], point[0]))


def _check_room(length: Floats, taken: Floats, radii: Floats) -> None:
    left = length - taken - np.roll(taken, -1)
    i = int(left.argmin())
    if left[i] <= _SAME_MM:
        problem = f"{radii[i]:g}: the arcs use up the whole following side of {length[i]:.6g} mm"
        raise GeometryError("polygon.corner_radius_mm", problem, "give smaller radii")
