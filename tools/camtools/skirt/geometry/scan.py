r"""Measured sections of a part file: read, checked between their heights, made a surface.

>>> rows = "".join(f"{angle},0,{angle % 180}\n" for angle in range(0, 360, 15))
>>> parse_scan("angle_deg,z_mm,reduction_um\n" + rows, "scan.csv").reduction_mm.shape
(1, 24)
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PPoly, make_interp_spline

from camtools.base.errors import GeometryError
from camtools.base.quantities import UM_PER_MM, Floats, rounded_up
from camtools.base.text import Json
from camtools.skirt.geometry.measured_sections import (
    MAX_REDUCTION_MM,
    MIN_ANGLES,
    Sections,
    overshoot_between,
    parse_sections,
    read_scan_text,
    surface_through,
)
from camtools.skirt.geometry.poly_surface import PolySurface
from camtools.skirt.geometry.profile import constant_spline
from camtools.skirt.part.curves import through
from camtools.skirt.part.section_keys import SectionShape

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
    if all(np.array_equal(one, first) for one in sections.angles_deg):
        return Scan(first, sections.z_mm, np.array(sections.values_mm)), 0.0
    pairs = list(zip(sections.angles_deg, sections.values_mm, strict=True))
    own = [Periodic(angle, values) for angle, values in pairs]
    n = max(angle.size for angle in sections.angles_deg)
    while True:
        grid = 360 * np.arange(n) / n
        sampled = [Periodic(grid, one(grid)) for one in own]
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
    return Scan(grid, sections.z_mm, np.stack([one(grid) for one in own])), off_mm


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
    values = tuple(a - one for a, one in zip(a_mm, sections.values_mm, strict=True))
    for z_mm, a, one in zip(sections.z_mm, a_mm, values, strict=True):
        worst = float(one[np.argmax(np.abs(one))])
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


_GAP_STEPS = 4.0  # a gap: so many mean steps without a point ..
_GAP_DEG = (10.0, 45.0)  # .. but not less than the first and not more than the second
_PER_GAP = 256  # places at which a gap is looked at


def measured_sections(
    section: SectionShape, ends_mm: tuple[float, float], radius: PPoly
) -> Sections:
    """Return the sections of a part's file as reductions of its profile.

    Raises CamtoolsError: the file is no good, or its heights do not cover the profile's.
    """
    assert section.csv is not None
    scan = read_scan_text(Path(section.csv))
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
    """Return what was measured, and the gaps in the angle that the curves bridge."""
    return {
        "heights_mm": sections.z_mm.tolist(),
        "points": sum(angle.size for angle in sections.angles_deg),
        "gaps": [gap._asdict() for gap in all_gaps(sections)],
    }


def gaps_of(z_mm: float, angle_deg: Floats, values_mm: Floats) -> Iterator[Gap]:
    """Find the gaps of a section, and how far its curve leaves the points at their ends."""
    steps = np.diff(angle_deg, append=angle_deg[0] + 360)
    wide = steps > np.clip(_GAP_STEPS * 360 / angle_deg.size, *_GAP_DEG)
    curve, after = Periodic(angle_deg, values_mm), np.roll(values_mm, -1)
    for i in np.flatnonzero(wide):
        at = angle_deg[i] + steps[i] * (np.arange(_PER_GAP) + 0.5) / _PER_GAP
        between, ends = curve(at), (values_mm[i], after[i])
        beyond = max(between.max() - max(ends), min(ends) - between.min(), 0.0)
        to_deg = float(np.mod(angle_deg[i] + steps[i], 360))
        yield Gap(UM_PER_MM * float(beyond), z_mm, float(angle_deg[i]), to_deg)


def check_scan(scan: Scan, section: SectionShape) -> None:
    """Refuse sections whose curves over the height leave the points of two heights too far."""
    values_um = scan.reduction_mm * UM_PER_MM
    kind = joined_by(scan, section.interpolation)
    worst, i = overshoot_between(scan.z_mm, values_um, kind)
    if worst.beyond > section.overshoot_um:
        problem = (
            f"between the heights {worst.low_mm:g} and {worst.high_mm:g} mm the section at "
            f"{scan.angle_deg[i]:g} degrees goes {worst.beyond:.4g} um beyond both, at height "
            f"{worst.z_mm:.6g} mm"
        )
        remedy = (
            'set interpolation = "pchip", measure more heights, or allow it: overshoot_um = '
            f"{rounded_up(worst.beyond):g}"
        )
        raise GeometryError("piston.section.interpolation", problem, remedy)
