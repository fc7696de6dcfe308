r"""Measured sections of a part file: checked between their heights, made a surface.

Over the angle a periodic quintic spline runs through the values of each height; over the height
each angle's values are joined as `curves.through` joins points. Every piece follows from knots:
value and two derivatives by the turn at each break and height, and the same of the slope over the
height, MATHS.md (19).

>>> rows = "".join(f"{angle},0,{angle % 180}\n" for angle in range(0, 360, 15))
>>> parse_scan("angle_deg,z_mm,reduction_um\n" + rows, "scan.csv").reduction_mm.shape
(1, 24)
"""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.interpolate import (
    Akima1DInterpolator,
    CubicSpline,
    PchipInterpolator,
    PPoly,
    make_interp_spline,
)

from camtools.base.errors import GeometryError
from camtools.base.quantities import UM_PER_MM, Floats, rounded_up
from camtools.base.text import Json
from camtools.skirt.geometry.outliers import REMEDY_OF_OUTLIERS, outliers
from camtools.skirt.geometry.poly_surface import N_ANGLE, N_HEIGHT, Knots, PolySurface
from camtools.skirt.geometry.profile import constant_spline
from camtools.skirt.geometry.section_file import (
    MAX_REDUCTION_MM,
    MIN_ANGLES,
    Sections,
    parse_sections,
    read_scan_text,
)
from camtools.skirt.part.curves import Overshoot, through
from camtools.skirt.part.keys import SectionShape
from camtools.table.points import gaps_after

# a quintic by its value and two derivatives at both ends, and a cubic by value and slope
_QUINTIC = np.array(
    [
        [1, 0, 0, 0, 0, 0],
        [0, 1, 0, 0, 0, 0],
        [0, 0, 0.5, 0, 0, 0],
        [-10, -6, -1.5, 10, -4, 0.5],
        [15, 8, 1.5, -15, 7, -1],
        [-6, -3, -0.5, 6, -3, 0.5],
    ]
)
_CUBIC = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [-3, -2, 3, -1], [2, 1, -2, 1]])


def _slopes(z_mm: Floats, values: Floats, interpolation: str) -> Floats | None:
    """Return dv/dz at all heights for each angle; nothing for straight lines."""
    if interpolation == "linear":
        return None
    if interpolation == "spline":
        return np.asarray(CubicSpline(z_mm, values, axis=0)(z_mm, 1), dtype=np.float64)
    kind = PchipInterpolator if interpolation == "pchip" else Akima1DInterpolator
    return np.asarray(kind(z_mm, values, axis=0)(z_mm, 1), dtype=np.float64)


def _knots(turn: Floats, values: Floats, breaks: Floats) -> Floats:
    """Return value and two derivatives of periodic splines at breaks, shape (m, n, 3)."""
    closed = np.vstack([values.T, values[:, :1].T])
    spline = make_interp_spline(np.append(turn, turn[0] + 1), closed, k=5, bc_type="periodic")
    at = breaks[:-1] + (breaks[:-1] < turn[0])
    return np.stack([spline(at, nu=k).T for k in range(3)], axis=-1)


def _angle_pieces(knots: Floats, breaks: Floats) -> Floats:
    """Return quintics (m, n, 6) in t = 0 .. 1 between knots (m, n, 3)."""
    width = np.diff(breaks)[:, None]
    scale = width ** np.arange(3)
    ends = np.concatenate([knots * scale, np.roll(knots, -1, axis=1) * scale], axis=-1)
    return np.asarray(ends @ _QUINTIC.T, dtype=np.float64)


def _pieces(knots: Knots, breaks: Floats, z_mm: Floats) -> Floats:
    """Return all coefficients (m - 1, n, 6, 8)."""
    at = _angle_pieces(knots.values, breaks)
    found = np.zeros((z_mm.size - 1, breaks.size - 1, N_ANGLE, N_HEIGHT))
    if knots.slopes is None:
        found[..., 0], found[..., 1] = at[:-1], np.diff(at, axis=0)
        return found
    rising = _angle_pieces(knots.slopes, breaks)
    dz = np.diff(z_mm)[:, None, None]
    ends = np.stack([at[:-1], rising[:-1] * dz, at[1:], rising[1:] * dz], axis=-1)
    found[..., :4] = ends @ _CUBIC.T
    return found


def surface_through(
    turn: Floats, z_mm: Floats, values_mm: Floats, interpolation: str
) -> PolySurface:
    """Return the surface through reductions (m, n) at m heights and n rising angles 0 .. 1.

    One height serves all; between them linear | pchip | akima | spline.
    """
    if z_mm.size == 1:
        z_mm, interpolation = z_mm[0] + np.array([-1.0, 1.0]), "linear"
        values_mm = np.vstack([values_mm, values_mm])
    breaks = np.unique(np.concatenate([[0.0, 1.0], np.mod(turn, 1.0)]))
    slopes = _slopes(z_mm, values_mm, interpolation)
    knots = Knots(
        _knots(turn, values_mm, breaks), None if slopes is None else _knots(turn, slopes, breaks)
    )
    return PolySurface(breaks, z_mm, _pieces(knots, breaks, z_mm), knots=knots)


def overshoot_between(z_mm: Floats, values: Floats, interpolation: str) -> tuple[Overshoot, int]:
    """Return where values leave those of their two heights most, and at which angle's index.

    As `curves.overshoot`, for each angle; MATHS.md (73).
    """
    nowhere = Overshoot(0.0, float(z_mm[0]), float(z_mm[0]), float(z_mm[-1])), 0
    slopes = _slopes(z_mm, values, interpolation) if z_mm.size > 1 else None
    if slopes is None:
        return nowhere
    dz = np.diff(z_mm)[:, None]
    ends = np.stack([values[:-1], slopes[:-1] * dz, values[1:], slopes[1:] * dz], axis=-1)
    c = ends @ _CUBIC.T  # (m - 1, n, 4), rising powers
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(c[..., 2] ** 2 - 3 * c[..., 3] * c[..., 1])
        places = [-c[..., 1] / (c[..., 2] + sign * root) for sign in (-1, 1)]
    beyond = np.zeros((2, *c.shape[:2]))
    for found, place in zip(beyond, places, strict=True):
        w = np.where(np.isfinite(place) & (place > 0) & (place < 1), place, 0.0)
        there = ((c[..., 3] * w + c[..., 2]) * w + c[..., 1]) * w + c[..., 0]
        above = there - np.maximum(values[:-1], values[1:])
        found[:] = np.maximum(above, np.minimum(values[:-1], values[1:]) - there)
    k, j, i = (int(index) for index in np.unravel_index(int(np.argmax(beyond)), beyond.shape))
    at = float(z_mm[j] + places[k][j, i] * (z_mm[j + 1] - z_mm[j]))
    largest = max(0.0, float(beyond[k, j, i]))
    return Overshoot(largest, at, float(z_mm[j]), float(z_mm[j + 1])), i


_MIN_SPLINE_HEIGHTS = 4
_FILTERED_PER_HARMONIC = 8
MAX_SAMPLES = 5760  # of a section that is sampled anew: every sixteenth of a degree
_FINE_MM, _COARSE_MM = 1e-6, 1e-3


class Scan(NamedTuple):
    """Sections at the same angles at every height."""

    angle_deg: Floats  # (n,) rising, 0 .. 360
    z_mm: Floats  # (m,) rising
    reduction_mm: Floats  # (m, n)


def parse_scan(text: str, file: str) -> Scan:
    """Return the sections of a CSV text at common angles, see `parse_sections` and `joined`."""
    return joined(parse_sections(text, file))[0]


def joined(sections: Sections) -> tuple[Scan, float]:
    """Return sections at the same angles at every height, and what that costs [mm], MATHS.md (79).

    Sections that were measured at the same angles stay as they are. Otherwise a spline goes through
    the points of each, and all are sampled at equal distances, so finely that the surface through
    the samples keeps within a nanometre of them where that is possible. Raises GeometryError: not
    even the most samples keep within a micrometre.
    """
    first = sections.angles_deg[0]
    if all(np.array_equal(angles, first) for angles in sections.angles_deg):
        return Scan(first, sections.z_mm, np.array(sections.values_mm)), 0.0
    pairs = list(zip(sections.angles_deg, sections.values_mm, strict=True))
    own = [Periodic(angle, values) for angle, values in pairs]
    n = max(angle.size for angle in sections.angles_deg)
    while True:
        grid = 360 * np.arange(n) / n
        sampled = [Periodic(grid, spline(grid)) for spline in own]
        between = 360 * (np.arange(4 * n) + 0.5) / (4 * n)
        places = [np.concatenate([between, angle]) for angle, _ in pairs]
        off_mm = max(
            float(np.abs(a(at) - b(at)).max())
            for a, b, at in zip(own, sampled, places, strict=True)
        )
        if off_mm <= _FINE_MM or 2 * n > MAX_SAMPLES:
            break
        n *= 2
    if off_mm > _COARSE_MM:
        common = f"common ones deviate by {off_mm * 1e3:.3g} um"
        problem = f"the heights have different angles, and {common}"
        remedy = "measure all heights at the same angles"
        raise GeometryError("piston.section.csv", problem, remedy)
    return Scan(grid, sections.z_mm, np.stack([spline(grid) for spline in own])), off_mm


class Periodic:
    """The periodic quintic spline through a section."""

    def __init__(self, angle_deg: Floats, values: Floats) -> None:
        turn = np.append(angle_deg, angle_deg[0] + 360) / 360
        closed = np.append(values, values[0])
        self._first = float(turn[0])
        self._spline = make_interp_spline(turn, closed, k=5, bc_type="periodic")

    def __call__(self, angle_deg: Floats) -> Floats:
        """Return the section at angles [deg]."""
        at = self._first + np.mod(angle_deg / 360 - self._first, 1.0)
        return np.asarray(self._spline(at), dtype=np.float64)


def reductions(sections: Sections, radius_mm: Callable[[Floats], Floats]) -> Sections:
    """Return sections as reductions of the profile's radius, however they were measured.

    Raises GeometryError: radii are far from the profile's: they are diameters, or no radii at all.
    """
    if not sections.is_radius:
        return sections
    a_mm = radius_mm(sections.z_mm)
    values = tuple(a - reduction for a, reduction in zip(a_mm, sections.values_mm, strict=True))
    for z_mm, a, reduction in zip(sections.z_mm, a_mm, values, strict=True):
        worst = float(reduction[np.argmax(np.abs(reduction))])
        if abs(worst) > MAX_REDUCTION_MM:
            problem = f"height {z_mm:g} mm: a radius of {a - worst:g} mm, the profile has {a:g} mm"
            remedy = "give radii in mm, or name the column reduction_um or reduction_mm"
            raise GeometryError("piston.section.csv", problem, remedy)
    return sections._replace(values_mm=values, is_radius=False)


def off_points_mm(surface: PolySurface, sections: Sections, factor: float) -> float:
    """Return how far a surface is from the points of the sections, magnified by a factor."""
    worst = 0.0
    for z_mm, angle, values in zip(*sections[:3], strict=True):
        found = surface.delta(np.radians(angle), float(z_mm)).delta
        worst = max(worst, float(np.abs(found - factor * values).max()))
    return worst


def filtered(scan: Scan, harmonics: int) -> Scan:
    """Return the sections with harmonics 0 .. n of the turn only, on a uniform grid of angles.

    The waves are fitted to the points by least squares, as a roundness instrument's filter does,
    MATHS.md (18). Raises GeometryError: more waves than the points resolve.
    """
    n_points = scan.angle_deg.size
    if 2 * harmonics + 1 > n_points:
        problem = f"{n_points} points per turn are too few for {harmonics} waves"
        remedy = f"give at most {(n_points - 1) // 2}"
        raise GeometryError("piston.section.harmonics", problem, remedy)
    waves, *_ = np.linalg.lstsq(
        _basis(np.radians(scan.angle_deg), harmonics), scan.reduction_mm.T, rcond=None
    )
    n = max(MIN_ANGLES, _FILTERED_PER_HARMONIC * harmonics)
    grid = 360 * np.arange(n) / n
    return Scan(grid, scan.z_mm, (_basis(np.radians(grid), harmonics) @ waves).T)


def waves_of(sections: Sections, harmonics: int) -> Scan:
    """Return `filtered` of sections that may have angles of their own: points, not samples."""
    rows = [
        filtered(Scan(angle, np.zeros(1), values[None]), harmonics)
        for angle, values in zip(sections.angles_deg, sections.values_mm, strict=True)
    ]
    reduction_mm = np.concatenate([row.reduction_mm for row in rows])
    return Scan(rows[0].angle_deg, sections.z_mm, reduction_mm)


def _basis(phi: Floats, harmonics: int) -> Floats:
    n = np.arange(1, harmonics + 1)
    angles = phi[:, None] * n
    return np.hstack([np.ones((phi.size, 1)), np.cos(angles), np.sin(angles)])


def joined_by(scan: Scan, interpolation: str | None) -> str:
    """Return how heights are joined: by default up to three linearly, more by a spline."""
    return interpolation or ("spline" if scan.z_mm.size >= _MIN_SPLINE_HEIGHTS else "linear")


def scan_surface(scan: Scan, factor: float = 1.0, interpolation: str | None = None) -> PolySurface:
    """Return the surface through all points, see `surface_through`; one height serves all."""
    kind = joined_by(scan, interpolation)
    return surface_through(scan.angle_deg / 360, scan.z_mm, factor * scan.reduction_mm, kind)


def ovality_of(scan: Scan) -> PPoly:
    """Return the largest minus the least diameter over height [mm]."""
    n = scan.angle_deg.size
    opposite = np.interp(
        np.mod(scan.angle_deg + 180, 360),
        np.append(scan.angle_deg, scan.angle_deg[0] + 360),
        np.arange(n + 1),
    )
    low, weight = opposite.astype(np.int64) % n, opposite % 1
    facing = (1 - weight) * scan.reduction_mm[:, low]
    facing = facing + weight * scan.reduction_mm[:, (low + 1) % n]
    oval = np.ptp(scan.reduction_mm + facing, axis=1)
    if scan.z_mm.size == 1:
        return constant_spline(float(oval[0]), float(scan.z_mm[0]) - 1, float(scan.z_mm[0]) + 1)
    return through(scan.z_mm, oval, "linear")


_PER_GAP = 256  # places at which a gap is looked at


def measured_sections(
    section: SectionShape, ends_mm: tuple[float, float], radius: PPoly
) -> Sections:
    """Return the sections of a part's file as reductions of its profile.

    Raises CamtoolsError: the file is no good, or its heights do not cover the profile's.
    """
    assert section.csv is not None
    scan = read_scan_text(Path(section.csv), section.centre)
    check_heights(scan.z_mm, ends_mm, is_single=section.single_height is True)
    found = reductions(scan, lambda z: np.asarray(radius(z), dtype=np.float64))
    check_gaps(found, section.overshoot_um)
    return found


def check_heights(z_mm: Floats, ends_mm: tuple[float, float], *, is_single: bool) -> None:
    """Refuse heights that do not cover the profile; one height must be asked for.

    A file that was cut short has fewer heights than were measured, too.
    """
    place = "piston.section.single_height"
    if z_mm.size == 1 and not is_single:
        problem = f"the file has one height only, {z_mm[0]:g} mm"
        remedy = "measure more, or set single_height = true if it is to serve all heights"
        raise GeometryError(place, problem, remedy)
    if z_mm.size > 1 and is_single:
        problem = f"is true, but the file has {z_mm.size} heights"
        raise GeometryError(place, problem, "leave it out, or keep one of them")
    if z_mm.size > 1 and (z_mm[0] > ends_mm[0] or z_mm[-1] < ends_mm[1]):
        problem = f"heights {z_mm[0]:g} .. {z_mm[-1]:g} mm do not cover the profile's"
        remedy = f"measure {ends_mm[0]:g} .. {ends_mm[1]:g} mm"
        remedy += ", or one height with single_height = true"
        raise GeometryError("piston.section.csv", problem, remedy)


class Gap(NamedTuple):
    """An angle without points, and how far the curve leaves the points at its ends."""

    beyond_um: float
    z_mm: float
    from_deg: float
    to_deg: float


def check_gaps(sections: Sections, overshoot_um: float) -> None:
    """Refuse gaps in the angle over which the curve swings beyond the points at both ends."""
    worst = max(all_gaps(sections), default=Gap(0, 0, 0, 0))
    if worst.beyond_um > overshoot_um:
        problem = (
            f"height {worst.z_mm:g} mm: no points from {worst.from_deg:g} to {worst.to_deg:g} "
            f"degrees, where the curve goes {worst.beyond_um:.4g} um beyond both"
        )
        remedy = f"measure there, or allow it: overshoot_um = {rounded_up(worst.beyond_um):g}"
        raise GeometryError("piston.section.csv", problem, remedy)


def all_gaps(sections: Sections) -> list[Gap]:
    """Return the gaps of all heights."""
    return [
        gap
        for z_mm, angle, values in zip(*sections[:3], strict=True)
        for gap in gaps_of(float(z_mm), angle, values)
    ]


def coverage(sections: Sections) -> Json:
    """Return what was measured, the gaps in the angle that the curves bridge, and outliers."""
    return {
        "heights_mm": sections.z_mm.tolist(),
        "points": sum(angle.size for angle in sections.angles_deg),
        "gaps": [gap._asdict() for gap in all_gaps(sections)],
        "outliers": [outlier._asdict() for outlier in outliers(sections)],
    }


def gaps_of(z_mm: float, angle_deg: Floats, values_mm: Floats) -> Iterator[Gap]:
    """Find the gaps of a section, and how far its curve leaves the points at their ends."""
    steps = np.diff(angle_deg, append=angle_deg[0] + 360)
    curve, after = Periodic(angle_deg, values_mm), np.roll(values_mm, -1)
    for i in gaps_after(steps):
        at = angle_deg[i] + steps[i] * (np.arange(_PER_GAP) + 0.5) / _PER_GAP
        between, ends = curve(at), (values_mm[i], after[i])
        beyond = max(between.max() - max(ends), min(ends) - between.min(), 0.0)
        to_deg = float(np.mod(angle_deg[i] + steps[i], 360))
        yield Gap(UM_PER_MM * float(beyond), z_mm, float(angle_deg[i]), to_deg)


def check_scan(scan: Scan, section: SectionShape, sections: Sections) -> None:
    """Refuse sections whose curves over the height leave the points of two heights too far.

    `sections` are the points as they were measured; one that is off its neighbours is named.
    """
    values_um = scan.reduction_mm * UM_PER_MM
    kind = joined_by(scan, section.interpolation)
    worst, i = overshoot_between(scan.z_mm, values_um, kind)
    if worst.beyond <= section.overshoot_um:
        return
    problem = (
        f"between the heights {worst.low_mm:g} and {worst.high_mm:g} mm the section at "
        f"{scan.angle_deg[i]:g} degrees goes {worst.beyond:.4g} um beyond both, at height "
        f"{worst.z_mm:.6g} mm"
    )
    allowing = f"allow it: overshoot_um = {rounded_up(worst.beyond):g}"
    off = outliers(sections)
    if off:
        remedy = f"{REMEDY_OF_OUTLIERS}, or {allowing}"
        raise GeometryError("piston.section.csv", f"{off[0].words}, and {problem}", remedy)
    remedy = f'set interpolation = "pchip", measure more heights, or {allowing}'
    raise GeometryError("piston.section.interpolation", problem, remedy)
