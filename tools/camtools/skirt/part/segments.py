"""Lines and arcs over height, as drawings give profiles, MATHS.md (70), (71).

The plane is that of the height z and the value v, both in mm: v is the radius of a profile, and the
ovality itself of an ovality. An arc bulges towards larger values when its radius is above 0.

>>> cone = DrawnSegment(10.0, 45.0, "line", None, is_tangent=False)
>>> barrel = DrawnSegment(30.0, 45.0, "arc", 100.0, is_tangent=False)
>>> pieces = join(0.0, 44.9, (cone, barrel))
>>> f"{float(curve_of(pieces)(20.0)):.9f}"
'45.501256289'
"""

from __future__ import annotations

from math import atan, degrees, hypot, inf, isinf, sqrt
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicHermiteSpline, PPoly

MAX_KINK_DEG = 0.01  # between segments that the drawing calls tangent
ARC_ERROR_MM = 5e-11  # largest distance of the cubics from an arc: half of 1e-4 nm
_MAX_HALVINGS = 12


class SegmentError(Exception):
    """A segment that cannot be drawn: `index` counts from 0, `key` is what to change."""

    def __init__(self, index: int, key: str, problem: str, remedy: str) -> None:
        self.index, self.key, self.problem, self.remedy = index, key, problem, remedy
        super().__init__(problem)


class DrawnSegment(NamedTuple):
    """A segment as drawn; what is None follows from the rest."""

    to_mm: float
    value_mm: float | None  # at its end
    kind: str  # line | arc
    radius_mm: float | None
    is_tangent: bool  # to the segment before


class Piece(NamedTuple):
    """A segment with all its numbers: a line, or an arc about a centre."""

    from_mm: float
    from_value_mm: float
    to_mm: float
    value_mm: float
    radius_mm: float  # above 0: bulges outwards; infinite: a line
    is_derived: bool  # an arc whose radius was not given
    kink_deg: float  # turn against the segment before, 0 for the first

    @property
    def chord(self) -> tuple[float, float]:
        """Return its width and rise [mm]."""
        return self.to_mm - self.from_mm, self.value_mm - self.from_value_mm

    def centre(self) -> tuple[float, float]:
        """Return height and value of an arc's centre [mm], MATHS.md (70)."""
        dz, dv = self.chord
        length = hypot(dz, dv)
        away = sqrt(max(0.0, self.radius_mm**2 - length**2 / 4)) / length
        away = away if self.radius_mm > 0 else -away
        return self.from_mm + dz / 2 + dv * away, self.from_value_mm + dv / 2 - dz * away

    def slope(self, z_mm: float) -> float:
        """Return dv/dz at one of its heights."""
        if isinf(self.radius_mm):
            dz, dv = self.chord
            return dv / dz
        off = z_mm - self.centre()[0]
        root = sqrt(max(1e-300, self.radius_mm**2 - off**2))
        return (-off if self.radius_mm > 0 else off) / root

    def value(self, z_mm: float) -> float:
        """Return the value at one of its heights [mm], without cancellation for large radii."""
        dz, dv = self.chord
        if isinf(self.radius_mm):
            return self.from_value_mm + (z_mm - self.from_mm) * dv / dz
        centre_mm, r2 = self.centre()[0], self.radius_mm**2
        start, here = self.from_mm - centre_mm, z_mm - centre_mm
        roots = sqrt(max(0.0, r2 - start**2)) + sqrt(max(0.0, r2 - here**2))
        rise = (self.from_mm - z_mm) * (start + here) / roots
        return self.from_value_mm + (rise if self.radius_mm > 0 else -rise)


def _radius_through(slope: float, dz: float, dv: float) -> float:
    """Return the radius of the arc that begins with a slope and has the chord (dz, dv), (70)."""
    cross = (dz * slope - dv) / hypot(1.0, slope)
    return (dz**2 + dv**2) / (2 * cross) if cross else inf


def _end_of_arc(index: int, step: DrawnSegment, start: tuple[float, float], slope: float) -> float:
    """Return the value at the end of an arc of given radius that begins with a slope."""
    assert step.radius_mm is not None
    radius, across = step.radius_mm, hypot(1.0, slope)
    centre = start[0] + radius * slope / across, start[1] - radius / across
    room = radius**2 - (step.to_mm - centre[0]) ** 2
    if room <= 0:
        reach_mm = centre[0] + abs(radius)
        problem = f"the arc of radius {abs(radius):g} mm reaches {reach_mm:.6g} mm of height only"
        raise SegmentError(index, "radius_mm", problem, "give a larger radius, or a lower to_mm")
    return centre[1] + (sqrt(room) if radius > 0 else -sqrt(room))


def _end(index: int, step: DrawnSegment, start: tuple[float, float], slope: float) -> float:
    """Return the value at the end of a segment, given or derived [mm]."""
    if step.value_mm is not None:
        return step.value_mm
    if step.kind == "line":
        return start[1] + slope * (step.to_mm - start[0])
    return _end_of_arc(index, step, start, slope)


def _check_arc(index: int, piece: Piece) -> None:
    """Refuse an arc that cannot span its ends, or that turns back over height."""
    chord_mm, radius_mm = hypot(*piece.chord), abs(piece.radius_mm)
    if 2 * radius_mm < chord_mm:
        problem = f"an arc of radius {radius_mm:.6g} mm cannot span its chord of {chord_mm:.6g} mm"
        remedy = f"give at least {chord_mm / 2:.6g} mm, or other ends"
        raise SegmentError(index, "radius_mm", problem, remedy)
    centre_z, centre_v = piece.centre()
    sign = 1.0 if piece.radius_mm > 0 else -1.0
    ends = (piece.from_mm, piece.from_value_mm), (piece.to_mm, piece.value_mm)
    if any(sign * (v - centre_v) <= 0 or abs(z - centre_z) >= radius_mm for z, v in ends):
        problem = f"an arc of radius {radius_mm:.6g} mm would turn back over height between its "
        raise SegmentError(
            index, "radius_mm", f"{problem}ends", "give a larger radius, or other ends"
        )


def _kink_deg(index: int, step: DrawnSegment, piece: Piece, slope: float) -> float:
    """Return by how much the contour turns where a segment begins; refuse what is not tangent."""
    kink_deg = degrees(atan(piece.slope(piece.from_mm)) - atan(slope))
    if not step.is_tangent or abs(kink_deg) <= MAX_KINK_DEG:
        return kink_deg
    problem = (
        f"the contour turns by {kink_deg:.4g} degrees at {piece.from_mm:g} mm of height, more than "
        f"the {MAX_KINK_DEG:g} of a tangent"
    )
    follows = "radius_mm" if step.kind == "arc" else "the value at its end"
    remedy = f"leave out {follows}, which then follows, or leave out tangent"
    raise SegmentError(index, "tangent", problem, remedy)


def _piece(
    index: int, step: DrawnSegment, start: tuple[float, float], before: Piece | None
) -> Piece:
    """Return a segment with all its numbers."""
    slope = before.slope(before.to_mm) if before else 0.0
    end_mm, radius_mm = _end(index, step, start, slope), inf
    if step.kind == "arc":
        dz, dv = step.to_mm - start[0], end_mm - start[1]
        radius_mm = step.radius_mm or _radius_through(slope, dz, dv)
    is_derived = step.kind == "arc" and step.radius_mm is None
    piece = Piece(*start, step.to_mm, end_mm, radius_mm, is_derived, 0.0)
    if not isinf(radius_mm):
        _check_arc(index, piece)
    if before is None:
        return piece
    return piece._replace(kink_deg=_kink_deg(index, step, piece, slope))


def join(start_mm: float, value_mm: float, steps: tuple[DrawnSegment, ...]) -> tuple[Piece, ...]:
    """Return the segments of a drawing with all their numbers, one after the other.

    Raises SegmentError: an arc is too small, or a segment is not tangent where it should be.
    """
    pieces: list[Piece] = []
    place = (start_mm, value_mm)
    for index, step in enumerate(steps):
        pieces.append(_piece(index, step, place, pieces[-1] if pieces else None))
        place = (step.to_mm, pieces[-1].value_mm)
    return tuple(pieces)


def _cubic_error_mm(piece: Piece, low_mm: float, high_mm: float) -> float:
    """Return a bound of what a Hermite cubic is off an arc between two heights, MATHS.md (71)."""
    centre_mm, r2 = piece.centre()[0], piece.radius_mm**2
    off2 = max(abs(low_mm - centre_mm), abs(high_mm - centre_mm)) ** 2
    fourth = 3 * r2 * (r2 + 4 * off2) / max(1e-300, r2 - off2) ** 3.5
    return float((high_mm - low_mm) ** 4 / 384 * fourth)


def breaks_of(piece: Piece) -> list[float]:
    """Return rising heights, without the last, between which cubics follow a segment [mm]."""
    todo, found = [(piece.from_mm, piece.to_mm, 0)], []
    while todo:
        low, high, n_halved = todo.pop()
        is_arc = not isinf(piece.radius_mm) and n_halved < _MAX_HALVINGS
        if is_arc and _cubic_error_mm(piece, low, high) > ARC_ERROR_MM:
            middle = (low + high) / 2
            todo += [(middle, high, n_halved + 1), (low, middle, n_halved + 1)]
        else:
            found.append(low)
    return found


def curve_of(pieces: tuple[Piece, ...]) -> PPoly:
    """Return segments as cubics that follow their arcs to 1e-4 nm; kinks stay kinks."""
    heights: list[float] = []
    cubics = []
    for piece in pieces:
        z = np.array([*breaks_of(piece), piece.to_mm])
        values = np.array([piece.value(float(one)) for one in z])
        slopes = np.array([piece.slope(float(one)) for one in z])
        values[-1] = piece.value_mm
        cubics.append(CubicHermiteSpline(z, values, slopes).c)
        heights += z[:-1].tolist()
    return PPoly(np.concatenate(cubics, axis=1), np.array([*heights, pieces[-1].to_mm]))
