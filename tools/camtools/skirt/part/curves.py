"""Curves over height: through points, or by formula, MATHS.md (98), (99).

linear   a polygon
pchip    monotone between any two points, continuous slope, MATHS.md (72)
akima    close to the polygon, continuous slope, little overshoot
spline   cubic, continuous curvature, not-a-knot unless told otherwise, MATHS.md (6)

Segments are lines and arcs, as drawings give profiles, MATHS.md (70), (71). Their plane is that of
the height z and the value v, both in mm: v is the radius of a profile, and the ovality itself of an
ovality. An arc bulges towards larger values when its radius is above 0.

>>> round(overshoot(through([0, 2, 10, 20], [91, 91.95, 91.985, 92], "spline")).beyond, 3)
0.776
>>> overshoot(through([0, 2, 10, 20], [91, 91.95, 91.985, 92], "pchip")).beyond
0.0

>>> law = PowerProfile(
...     law="power", range_mm=[0, 62], peak_height_mm=20, peak_diameter_mm=92,
...     coefficient=7.4546e-05, exponent=2,
... )
>>> law.height_mm, [f"{mm:.3f}" for mm in law.diameter_mm]
([0.0, 20.0, 62.0], ['91.940', '92.000', '91.737'])
>>> f"{float(law.curve()(5.0)):.9f}"
'45.983227150'
"""

from collections.abc import Sequence
from math import atan, copysign, degrees, hypot, inf, isinf, sqrt
from typing import Annotated, Literal, NamedTuple, Self

import numpy as np
from pydantic import AfterValidator, Discriminator, Field, model_validator
from scipy.interpolate import (
    Akima1DInterpolator,
    CubicHermiteSpline,
    CubicSpline,
    PchipInterpolator,
    PPoly,
)

from camtools.base.quantities import Floats
from camtools.base.solvers import unsolved
from camtools.part.model import MIN_STEP_MM, HeightMm, TomlTable, rising, wrong

Interpolation = Literal["linear", "pchip", "akima", "spline"]


class Overshoot(NamedTuple):
    """Where a curve leaves the values of its two neighbouring points most."""

    beyond: float  # unit of the curve; 0: nowhere
    z_mm: float
    low_mm: float  # the two points
    high_mm: float


def through(
    z_mm: Sequence[float] | Floats,
    values: Sequence[float] | Floats,
    interpolation: str,
    ends: object = "not-a-knot",
) -> PPoly:
    """Return the curve through points as cubics over height; ends as `CubicSpline` takes them."""
    z, v = np.asarray(z_mm, dtype=np.float64), np.asarray(values, dtype=np.float64)
    if interpolation == "spline":
        return CubicSpline(z, v, bc_type=ends)
    if interpolation == "linear" or z.size == 2:
        zero = np.zeros(z.size - 1)
        return PPoly(np.array([zero, zero, np.diff(v) / np.diff(z), v[:-1]]), z)
    curve = {"pchip": PchipInterpolator, "akima": Akima1DInterpolator}[interpolation](z, v)
    return PPoly(curve.c, curve.x)


def overshoot(curve: PPoly, points_mm: Floats | None = None) -> Overshoot:
    """Return where a curve leaves the values of two neighbouring points most, MATHS.md (73).

    The heights of the points rise; by default they are the ends of the curve's pieces.
    """
    z = np.asarray(curve.x if points_mm is None else points_mm, dtype=np.float64)
    turning = curve.derivative().roots(extrapolate=False)
    places = turning[np.isfinite(turning) & (turning > z[0]) & (turning < z[-1])]
    if not places.size:
        return Overshoot(0.0, float(z[0]), float(z[0]), float(z[-1]))
    i = np.clip(np.searchsorted(z, places, side="right") - 1, 0, z.size - 2)
    at_points, there = curve(z), curve(places)
    above = there - np.maximum(at_points[i], at_points[i + 1])
    below = np.minimum(at_points[i], at_points[i + 1]) - there
    beyond = np.maximum(above, below)
    worst = int(np.argmax(beyond))
    around = float(z[i[worst]]), float(z[i[worst] + 1])
    return Overshoot(max(0.0, float(beyond[worst])), float(places[worst]), *around)


LAW_ERROR_MM = 1e-9  # of the cubic pieces from the formula: a thousandth of a nanometre
_HERMITE = 384.0  # a cubic through values and slopes errs by h^4 max|f''''| / 384
_LEAST_STEP_MM = 1e-3
_MAX_DROP = 0.5  # of the peak's half axis: beyond it the formula is no skirt


def _law_or_points(value: object) -> str:
    has_law = "law" in value if isinstance(value, dict) else hasattr(value, "law")
    return "(law)" if has_law else "(points)"


LAW_OR_POINTS = Discriminator(_law_or_points)  # members have these tags: findings leave them out


class _Law(TomlTable):
    """What both formulas have: the range in which they hold and the height of the peak."""

    range_mm: Annotated[
        list[HeightMm], Field(min_length=2, max_length=2), AfterValidator(rising)
    ] = Field(description="heights between which the formula holds")
    peak_height_mm: HeightMm = Field(description="h0")

    @property
    def height_mm(self) -> list[float]:
        """Return the ends of the range, and the peak where it lies inside, rising."""
        first, last = (float(end) for end in self.range_mm)
        is_inside = first + MIN_STEP_MM <= self.peak_height_mm <= last - MIN_STEP_MM
        return [first, float(self.peak_height_mm), last] if is_inside else [first, last]

    def _from_peak_mm(self) -> Floats:
        return np.abs(np.array(self.height_mm) - self.peak_height_mm)


class PowerProfile(_Law):
    """[piston.profile]: by formula, a(h) = a0 - K |h - h0|^m, MATHS.md (98)."""

    law: Literal["power"]
    peak_diameter_mm: float = Field(ge=1, le=4000, description="2 a0")
    coefficient: float = Field(ge=0, le=1, description="K, mm of the radius per mm^m")
    exponent: float = Field(2.0, ge=2, le=8, description="m")  # below 2 X would jump

    @model_validator(mode="after")
    def _check_drop(self) -> Self:
        peak_mm = self.peak_diameter_mm / 2
        drop_mm = self.coefficient * float(self._from_peak_mm().max()) ** self.exponent
        if drop_mm > _MAX_DROP * peak_mm:
            problem = f"makes the half axis {drop_mm:.6g} of {peak_mm:g} mm smaller at an end"
            context = {"field": "coefficient", "value": self.coefficient}
            raise wrong("drop", problem, "give mm of radius per mm of height^exponent", **context)
        return self

    @property
    def diameter_mm(self) -> list[float]:
        """Return the diameters at `height_mm`."""
        drop = self.coefficient * self._from_peak_mm() ** self.exponent
        return [float(mm) for mm in self.peak_diameter_mm - 2 * drop]

    def curve(self) -> PPoly:
        """Return a(h) [mm] in cubic pieces: exact for exponents 2 and 3, else to LAW_ERROR_MM."""
        first, last = (float(end) for end in self.range_mm)
        below = self._breaks(max(0.0, self.peak_height_mm - last), self.peak_height_mm - first)
        above = self._breaks(max(0.0, first - self.peak_height_mm), last - self.peak_height_mm)
        z_mm = np.concatenate([self.peak_height_mm - below[::-1], self.peak_height_mm + above])
        z_mm = np.unique(np.clip(z_mm, first, last))
        return self._hermite(z_mm[np.append(True, np.diff(z_mm) > _LEAST_STEP_MM / 2)])

    def _breaks(self, near_mm: float, far_mm: float) -> Floats:
        """Return distances from the peak between which a cubic keeps the error, rising."""
        if far_mm <= near_mm:
            return np.array([])
        k, m = self.coefficient, self.exponent
        fourth = k * m * (m - 1) * (m - 2) * abs(m - 3)
        if fourth == 0:
            return np.array([near_mm, far_mm])
        places = [far_mm]
        while places[-1] > near_mm:
            here = places[-1]
            step = here / 8  # where the fourth derivative grows inwards, it is that of here - step
            for _ in range(3):
                steepest = max(here ** (m - 4), max(here - step, _LEAST_STEP_MM) ** (m - 4))
                step = min(here / 2, (_HERMITE * LAW_ERROR_MM / (fourth * steepest)) ** 0.25)
            places.append(max(near_mm, here - step) if here > _LEAST_STEP_MM else near_mm)
        return np.array(places[::-1])

    def _hermite(self, z_mm: Floats) -> PPoly:
        """Return the cubics through values and slopes of the formula at rising heights."""
        off = z_mm - self.peak_height_mm
        k, m = self.coefficient, self.exponent
        a = self.peak_diameter_mm / 2 - k * np.abs(off) ** m
        slope = -k * m * np.sign(off) * np.abs(off) ** (m - 1)
        return CubicHermiteSpline(z_mm, a, slope)


class PeakOvality(_Law):
    """[piston.ovality]: by formula, G(h) = p (G0 - kG |h - h0|), MATHS.md (99)."""

    law: Literal["peak"]
    peak_ovality_mm: float = Field(ge=0, le=4000, description="G0")
    fall_mm_per_mm: float = Field(ge=-100, le=100, description="kG; below 0 the peak is the least")
    is_oval: bool = Field(True, description="p; false makes a round skirt")
    interpolation: Literal["linear"] = Field("linear", description="of lists of the section")

    @model_validator(mode="after")
    def _check_least(self) -> Self:
        least = min(self.ovality_mm)
        if least < 0:
            problem = f"makes the ovality fall to {least:.6g} mm at an end"
            context = {"field": "fall_mm_per_mm", "value": self.fall_mm_per_mm}
            raise wrong("least", problem, "give less of it, or more peak_ovality_mm", **context)
        return self

    @property
    def ovality_mm(self) -> list[float]:
        """Return the ovalities at `height_mm`."""
        g = self.peak_ovality_mm - self.fall_mm_per_mm * self._from_peak_mm()
        return [float(mm) for mm in (g if self.is_oval else 0.0 * g)]


MAX_KINK_DEG = 0.01  # between segments that the drawing calls tangent
ARC_ERROR_MM = 5e-11  # largest distance of the cubics from an arc: half of 1e-4 nm
_MAX_HALVINGS = 40


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
        away = copysign(sqrt(max(0.0, self.radius_mm**2 - length**2 / 4)) / length, self.radius_mm)
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
    if step.value_mm is not None:
        return step.value_mm
    if step.kind == "line":
        return start[1] + slope * (step.to_mm - start[0])
    return _end_of_arc(index, step, start, slope)


def _check_arc(index: int, piece: Piece) -> None:
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
        if not isinf(piece.radius_mm) and _cubic_error_mm(piece, low, high) > ARC_ERROR_MM:
            if n_halved == _MAX_HALVINGS:
                raise unsolved(f"piston.profile: arc of radius_mm = {piece.radius_mm:g}")
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
        values = np.array([piece.value(float(mm)) for mm in z])
        slopes = np.array([piece.slope(float(mm)) for mm in z])
        values[-1] = piece.value_mm
        cubics.append(CubicHermiteSpline(z, values, slopes).c)
        heights += z[:-1].tolist()
    return PPoly(np.concatenate(cubics, axis=1), np.array([*heights, pieces[-1].to_mm]))
