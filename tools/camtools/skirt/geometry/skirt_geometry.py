"""Exact geometry of a piston skirt, in double, and of the blank it is turned from.

Points of one turn are what another controller plays, or an exported table. Between two points runs
the quintic through value, velocity and acceleration of both; between two heights the surface is
straight. So does a table, hence its export comes back as the same part.

>>> from camtools.skirt.part.part_file import example_part
>>> geometry = make_geometry(example_part())
>>> [f"{mm:.9f}" for mm in geometry.radius_mm([5.0, 35.0])]
['45.983096898', '45.983079419']
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PPoly, make_interp_spline

from camtools.base.errors import CamtoolsError, GeometryError, InputError
from camtools.base.quantities import DEG_PER_TURN, UM_PER_MM, Floats, FloatsLike, SectionValues
from camtools.cut.correction import Correction
from camtools.cut.removal import QUARTER_RAD, TURN_RAD, SectionCut
from camtools.skirt.geometry.belt import belted, on_heights
from camtools.skirt.geometry.corner import Corner, make_corner
from camtools.skirt.geometry.corrected import CorrectedSurface, minus
from camtools.skirt.geometry.growth import expansion, shrinkage, thickness, thrust_rad
from camtools.skirt.geometry.poly_surface import N_ANGLE, N_HEIGHT, PolySurface, angle_pieces
from camtools.skirt.geometry.profile import (
    check_drawn,
    check_smoothing,
    constant_spline,
    magnified,
    ovality_spline,
    profile_spline,
)
from camtools.skirt.geometry.scan import (
    Scan,
    check_heights,
    check_scan,
    gaps_of,
    joined,
    measured_sections,
    off_points_mm,
    ovality_of,
    scan_surface,
    waves_of,
)
from camtools.skirt.geometry.section_file import Sections
from camtools.skirt.geometry.sections import ALL_AROUND_RAD, Law, SkirtSurface, law_of
from camtools.skirt.geometry.sides import TurnedSurface, is_plain, sides_of, turn_of
from camtools.skirt.part.curves import through
from camtools.skirt.part.keys import PointsAt, SectionShape
from camtools.skirt.part.part_file import Piston, SkirtPart
from camtools.table.channel import MAX_LOG2_REPEAT
from camtools.table.points import PointedTurn, PointFile, quintics_of, read_points

MAX_REDUCTION_MM = 30.0
_SAME_DEG, _SAME = 1e-9, 1e-9
_MOST_BEYOND_UM = 1.0  # a curve beyond the points at both ends of a gap


def read_sections(section: SectionShape) -> PointFile:
    """Return the points of [piston.section], of one file or of a file for each height.

    Raises CamtoolsError: a file is no good, or the files do not belong together.
    """
    try:
        if section.csv is not None:
            return with_motion(read_points(Path(section.csv)))
        assert section.files is not None
        return _together([(entry, read_points(Path(entry.csv))) for entry in section.files])
    except InputError as error:
        key = "csv" if section.csv is not None else "files"
        raise CamtoolsError([f"piston.section.{key}: {line}" for line in error.lines]) from error


def _together(files: list[tuple[PointsAt, PointFile]]) -> PointFile:
    sections: list[PointedTurn] = []
    for at, file in files:
        name = Path(at.csv).name
        if file.z_mm is not None:
            problem = "gives heights, but the part file gives them too"
            raise InputError(name, "Z_mm", None, problem, "leave the column out, or give it as csv")
        sections.append(with_motion(file).sections[0])
    heights = np.array([at.z_mm for at, _ in files], dtype=np.float64)
    return PointFile(heights, tuple(sections), True)


def with_motion(file: PointFile) -> PointFile:
    """Return points with their motion; where it is missing that of a periodic quintic spline."""
    if file.has_motion:
        return file
    return PointFile(file.z_mm, tuple(_splined(turn) for turn in file.sections), True)


def _splined(turn: PointedTurn) -> PointedTurn:
    for gap in gaps_of(0.0, turn.x_deg, turn.y_mm):
        if gap.beyond_um > _MOST_BEYOND_UM:
            problem = (
                f"no points from {gap.from_deg:g} to {gap.to_deg:g} degrees, where the curve goes "
                f"{gap.beyond_um:.4g} um beyond both"
            )
            raise GeometryError("piston.section.csv", problem, "give points there, or V and A")
    x = np.append(turn.x_deg, turn.x_deg[0] + DEG_PER_TURN)
    y = np.append(turn.y_mm, turn.y_mm[0])
    spline = make_interp_spline(x, y, k=5, bc_type="periodic")
    v, a = (np.asarray(spline(turn.x_deg, nu=n), dtype=np.float64) for n in (1, 2))
    return PointedTurn(turn.x_deg, turn.y_mm, v, a)


def _check(file: PointFile) -> None:
    """Refuse heights with other angles than the first one, and lengths beyond all strokes."""
    first = file.sections[0]
    heights = np.zeros(1) if file.z_mm is None else file.z_mm
    for z_mm, turn in zip(heights, file.sections, strict=True):
        is_alike = turn.x_deg.size == first.x_deg.size
        if not is_alike or np.abs(turn.x_deg - first.x_deg).max() > _SAME_DEG:
            problem = f"the angles at height {z_mm:g} mm are not those of the first height"
            remedy = "give all heights at the same angles"
            raise GeometryError("piston.section.csv", problem, remedy)
        largest = float(np.abs(turn.y_mm).max())
        if largest > MAX_REDUCTION_MM:
            problem = f"Y comes to {largest:g} mm at height {z_mm:g} mm"
            remedy = f"give the reduction of the radius, at most {MAX_REDUCTION_MM:g} mm"
            raise GeometryError("piston.section.csv", problem, f"{remedy}, and its unit")


def _pieces(turn: PointedTurn) -> tuple[Floats, Floats]:
    """Return breaks [turn], 0 and 1 among them, and quintics of the pieces, (n, 6)."""
    quintics = quintics_of(turn)
    if abs(turn.x_deg[0]) < _SAME_DEG:
        return np.append(turn.x_deg, DEG_PER_TURN) / DEG_PER_TURN, quintics
    x = np.append(turn.x_deg, turn.x_deg[0] + DEG_PER_TURN) / DEG_PER_TURN
    powers = quintics / np.diff(x)[:, None] ** np.arange(N_ANGLE)
    curve = PPoly(powers.T[::-1], x)
    breaks = np.unique(np.concatenate([[0.0, 1.0], np.mod(turn.x_deg / DEG_PER_TURN, 1.0)]))
    shift = np.floor(curve.x[0])
    late = PPoly(curve.c, curve.x - shift)
    early = PPoly(curve.c, late.x - 1)
    is_early = breaks[1:] <= late.x[0] + 1e-12
    found = np.where(is_early[:, None], angle_pieces(early, breaks), angle_pieces(late, breaks))
    return breaks, np.asarray(found, dtype=np.float64)


def _log2_alike(sections: tuple[PointedTurn, ...]) -> int:
    """Return how often, as a power of two, all sections repeat per turn."""
    steps = sections[0].steps_deg
    if np.ptp(steps) > _SAME_DEG or abs(sections[0].x_deg[0]) > _SAME_DEG:
        return 0
    for log2 in range(MAX_LOG2_REPEAT, 0, -1):
        if steps.size % (1 << log2) == 0 and steps.size >> log2 and _repeats(sections, log2):
            return log2
    return 0


def _repeats(sections: tuple[PointedTurn, ...], log2: int) -> bool:
    n = sections[0].x_deg.size >> log2
    return all(
        np.abs(np.roll(row, n) - row).max() <= _SAME * max(1e-6, float(np.abs(row).max()))
        for turn in sections
        for row in (turn.y_mm, turn.v, turn.a)
    )


def point_surface(file: PointFile, factor: float = 1.0) -> PolySurface:
    """Return the surface through points, straight between heights; one height serves all.

    Raises GeometryError: the heights do not belong together, or are no reductions of a radius.
    """
    _check(file)
    made = [_pieces(turn) for turn in file.sections]
    breaks, columns = made[0][0], factor * np.stack([pieces for _, pieces in made])
    heights = np.array([-1.0, 1.0]) if file.z_mm is None else file.z_mm
    if heights.size == 1 or file.z_mm is None:
        heights, columns = heights[:1] + np.array([0.0, 1.0]), np.repeat(columns[:1], 2, axis=0)
    found = np.zeros((heights.size - 1, columns.shape[1], N_ANGLE, N_HEIGHT))
    found[..., 0], found[..., 1] = columns[:-1], np.diff(columns, axis=0)
    return PolySurface(breaks, heights, found, log2_alike=_log2_alike(file.sections))


def ovality_of_points(file: PointFile, surface: PolySurface) -> PPoly:
    """Return the largest minus the least diameter over height [mm], with a break at each height."""
    oval = []
    for z_mm in surface.breaks_mm:
        r = surface.delta(ALL_AROUND_RAD, float(z_mm)).delta
        oval.append(float(np.ptp(r + np.roll(r, r.size // 2))))
    if file.z_mm is None or file.z_mm.size == 1:
        return constant_spline(oval[0], *map(float, surface.breaks_mm))
    return through(surface.breaks_mm, np.array(oval), "linear")


_COLD_HEIGHTS, _COLD_RAD = 1025, 2 * np.pi * np.arange(16) / 16
_MOST_OFF_UM = 0.2  # of a cold radius; corners of a profile take half of it
_CHECKS_PER_PIECE = 64
_APART_MM = 1e-9  # heights that differ only by rounding are closer


@dataclass(frozen=True, eq=False)
class OvalSurface(SkirtSurface):
    """One law for all heights; only half axis and ovality change."""

    law: Law
    radius: PPoly
    ovality: PPoly

    def delta(self, phi_rad: FloatsLike, z_mm: FloatsLike) -> SectionValues:
        """See `SkirtSurface`."""
        return self.law(phi_rad, self.radius(z_mm), self.ovality(z_mm))


@dataclass(frozen=True, eq=False)
class Geometry:
    """The part's exact surface: tool tip radius = radius_mm(z) - delta(phi, z).

    Curves are over height [mm] and magnified already.
    """

    radius: PPoly  # long half axis a(z) [mm]
    ovality: PPoly  # diametral G(z) [mm]; of a measured part the largest less the least diameter
    surface: SkirtSurface  # reduction of the radius; of a refitted part that of the refit
    z_first_mm: float
    z_last_mm: float
    corner: Corner | None = None  # of shape "ellipse-arc": as drawn, and its refit
    off_points_um: float | None = None  # of a scan: how far the surface is from its points
    gauge_mm: tuple[float, float] | None = None  # ends of the skirt within a run-in or -out
    drawn: SkirtSurface | None = None  # the drawing without refit, filter or correction, if any
    joined_um: float = 0.0  # of a scan: common angles off splines through own ones
    measured: tuple[Sections, Scan] | None = None  # the points, and the same at common angles
    drawn_radius: PPoly | None = None  # the drawing's, where a correction changes it
    correction: Correction | None = None  # by a gauged part; in radius and surface already

    @property
    def ends_mm(self) -> tuple[float, float]:
        """Return the first and the last height [mm], with run-in and run-out."""
        return self.z_first_mm, self.z_last_mm

    @property
    def skirt_mm(self) -> tuple[float, float]:
        """Return the ends of the skirt [mm], without run-in and run-out."""
        return self.gauge_mm or self.ends_mm

    @property
    def drawing(self) -> SkirtSurface:
        """Return the reduction by which a part is judged."""
        return self.surface if self.drawn is None else self.drawn

    def drawn_mm(self, phi_rad: FloatsLike, z_mm: FloatsLike) -> Floats:
        """Return the radius by which a part is judged [mm], at angles and heights, broadcast."""
        radius = (self.drawn_radius or self.radius)(z_mm)
        return np.asarray(radius - self.drawing.delta(phi_rad, z_mm).delta, dtype=np.float64)

    @property
    def played_name(self) -> str:
        """Return what the table plays, in a word."""
        if self.drawn is None:
            return "drawing"
        if self.correction is not None:
            return "corrected drawing"
        return "refit" if self.corner is not None else "filtered points"

    def radius_mm(self, z_mm: FloatsLike | Sequence[float], derivative: int = 0) -> Floats:
        """Return a(z), a'(z) or a''(z) [mm, mm/mm, mm/mm^2] with the shape of z_mm."""
        return np.asarray(self.radius(z_mm, nu=derivative), dtype=np.float64)

    def ovality_mm(self, z_mm: FloatsLike | Sequence[float]) -> Floats:
        """Return G(z) [mm] with the shape of z_mm."""
        return np.asarray(self.ovality(z_mm), dtype=np.float64)

    def oval_words(self, z_mm: float) -> str:
        """Return the ovality of a section, and with its trim where it has one, for pictures."""
        g_um = float(self.ovality_mm(z_mm)) * UM_PER_MM
        if self.corner is None:
            return f"ovality {g_um:.0f} µm (diameter)"
        with_trim_um = g_um + 2 * float(self.corner.trim(z_mm)) * UM_PER_MM
        return f"ovality {g_um:.0f} µm (diameter), with trim {with_trim_um:.0f} µm"

    def delta(self, phi_rad: FloatsLike, z_mm: FloatsLike) -> SectionValues:
        """Return radius reduction and angle derivatives, see `SkirtSurface` [mm, mm/rad^n]."""
        return self.surface.delta(phi_rad, z_mm)

    def deepest_mm(self, z_mm: float) -> float:
        """Return the largest reduction of a section [mm], to the step of half a degree."""
        return float(self.delta(ALL_AROUND_RAD, z_mm).delta.max())

    def breaks_mm(self) -> Floats:
        """Return the heights where a piece of the shape ends, rising, both ends included."""
        heights = np.union1d(self.radius.x, self.ovality.x)
        heights = np.union1d(heights, self.surface.heights_mm())
        heights = heights[np.diff(heights, prepend=-np.inf) > _APART_MM]
        first_mm, last_mm = self.z_first_mm + _APART_MM, self.z_last_mm - _APART_MM
        inside = heights[(heights > first_mm) & (heights < last_mm)]
        return np.concatenate(([self.z_first_mm], inside, [self.z_last_mm]))


def make_geometry(part: SkirtPart) -> Geometry:
    """Return the exact geometry of a part.

    Raises CamtoolsError: a spline overshoots into ovality below 0 or half axes not above 0; the
    corner of a composite section is impossible; the file of a measured section is no good.
    """
    piston = part.piston
    check_smoothing(part)
    factor = part.magnify.factor if part.magnify else 1.0
    of_profile = part.magnify.profile_factor if part.magnify else 1.0
    largest_mm = max(piston.profile.diameter_mm) / 2
    drawn = profile_spline(piston.profile)
    check_drawn(piston.profile, drawn)
    radius = magnified(drawn, of_profile, largest_mm)
    ends = piston.ends_mm
    if piston.section.shape == "table":
        geometry = _measured(part, radius, factor)
    elif piston.section.shape == "points":
        geometry = _pointed(part, radius, factor)
    else:
        assert piston.ovality is not None
        curve = ovality_spline(piston.ovality)
        oval = magnified(curve, factor, 0.0)
        if piston.lands:
            radius, oval = _with_lands(piston, radius, oval)
        geometry = Geometry(radius, oval, _oval(piston, radius, oval, (factor, of_profile)), *ends)
        _check_ovality(geometry, factor)
        check_drawn(piston.ovality, curve)
    if piston.section.shape == "ellipse-arc":
        geometry = _with_corner(part, geometry)
    phase = turn_of(piston)
    if phase is not None:
        drawn_turned = geometry.drawn and TurnedSurface(geometry.drawn, phase)
        turned = TurnedSurface(geometry.surface, phase)
        geometry = replace(geometry, surface=turned, drawn=drawn_turned)
    geometry = _cold(geometry, piston)
    z_mm = dense_heights_mm(geometry, _CHECKS_PER_PIECE // 16)
    deepest_mm = np.array([geometry.deepest_mm(float(z)) for z in z_mm])
    _check_half_axis(z_mm, geometry.radius_mm(z_mm) - deepest_mm, factor)
    return geometry


def _with_lands(piston: Piston, radius: PPoly, oval: PPoly) -> tuple[PPoly, PPoly]:
    """Return half axis and ovality of skirt and lands; both jump in the middle of the grooves."""
    bands = [(on_heights(radius, piston.skirt_mm), on_heights(oval, piston.skirt_mm))]
    for land in piston.lands:
        slope = (land.upper_mm - land.diameter_mm) / 2 / (land.to_mm - land.from_mm)
        long_axis = np.array([[0.0], [0.0], [slope], [land.diameter_mm / 2]])
        ends = float(land.from_mm), float(land.to_mm)
        bands.append((PPoly(long_axis, ends), constant_spline(land.ovality_mm, *ends)))
    bands.sort(key=lambda band: float(band[0].x[0]))
    long_axes, ovals = zip(*bands, strict=True)
    return belted(long_axes), belted(ovals, is_ovality=True)


def _cold(geometry: Geometry, piston: Piston) -> Geometry:
    """Return what is turned of a drawing: the cold, bare skirt."""
    growth, coating = piston.growth, piston.coating
    if growth is not None and growth.drawn == "hot":
        shrunk = shrinkage(piston, geometry.ends_mm, geometry.drawn_mm)
        if shrunk.waves_mm:
            cold = replace(
                geometry,
                radius=minus(geometry.radius, shrunk.mean),
                surface=CorrectedSurface(geometry.surface, shrunk),
                drawn=geometry.drawn and CorrectedSurface(geometry.drawn, shrunk),
            )
            _check_cold(geometry, cold, piston)
            geometry = cold
    if coating is not None and coating.drawn == "coated":
        less = thickness(coating, geometry.ends_mm)
        geometry = replace(geometry, radius=minus(geometry.radius, less))
    return geometry


def _check_cold(hot: Geometry, cold: Geometry, piston: Piston) -> None:
    """Refuse growth that changes too fast over the height for the waves that carry it."""
    assert piston.growth is not None
    z_mm, phi = np.linspace(*hot.ends_mm, _COLD_HEIGHTS)[:, None], _COLD_RAD
    grown = expansion(piston.growth, phi - thrust_rad(piston), z_mm)
    off_mm = np.abs(cold.drawn_mm(phi, z_mm) - grown.cold_mm(hot.drawn_mm(phi, z_mm)))
    worst = int(off_mm.max(axis=1).argmax())
    off_um = float(off_mm[worst].max()) * UM_PER_MM
    if off_um > _MOST_OFF_UM:
        at = f"height {float(z_mm[worst, 0]):.4g} mm"
        problem = f"changes too fast near {at}: what is turned would be off by {off_um:.3g} um"
        remedy = "let it change over more height, or give fewer and smoother points"
        raise GeometryError("piston.growth", f"{problem}, {_MOST_OFF_UM:g} um are allowed", remedy)


def _oval(piston: Piston, radius: PPoly, oval: PPoly, factors: tuple[float, float]) -> SkirtSurface:
    """Return the surface of ovals; of a composite section that of its oval as an ellipse."""
    if not is_plain(piston):
        return sides_of(piston, radius, oval, factors)
    shape, beta = piston.section.shape, np.asarray(piston.section.beta, dtype=np.float64)
    law = law_of("ellipse" if shape == "ellipse-arc" else shape, beta)
    return OvalSurface(law, radius, oval)


def _measured(part: SkirtPart, radius: PPoly, factor: float) -> Geometry:
    section, heights = part.piston.section, part.piston.profile.height_mm
    ends = float(heights[0]), float(heights[-1])
    sections = measured_sections(section, ends, radius)
    scan, joined_mm = joined(sections)
    check_scan(scan, section, sections)
    drawn = scan_surface(scan, factor, section.interpolation)
    off_um = UM_PER_MM * off_points_mm(drawn, sections, factor)
    geometry = Geometry(
        radius,
        magnified(ovality_of(scan), factor, 0.0),
        drawn,
        *ends,
        off_points_um=off_um,
        joined_um=UM_PER_MM * factor * joined_mm,
        measured=(sections, scan),
    )
    if section.harmonics is None:
        return geometry
    return keeping(geometry, section.harmonics, factor, section.interpolation)


def keeping(
    geometry: Geometry, harmonics: int, factor: float, interpolation: str | None
) -> Geometry:
    """Return a measured part's geometry with so many waves kept, all points its drawing."""
    assert geometry.measured is not None
    sections = geometry.measured[0]
    surface = scan_surface(waves_of(sections, harmonics), factor, interpolation)
    off_um = UM_PER_MM * off_points_mm(surface, sections, factor)
    drawn = geometry.drawn or geometry.surface
    return replace(geometry, surface=surface, drawn=drawn, off_points_um=off_um)


def _pointed(part: SkirtPart, radius: PPoly, factor: float) -> Geometry:
    heights = part.piston.profile.height_mm
    ends = float(heights[0]), float(heights[-1])
    file = read_sections(part.piston.section)
    if file.z_mm is not None:
        check_heights(file.z_mm, ends, is_single=part.piston.section.single_height is True)
    surface = point_surface(file, factor)
    return Geometry(radius, ovality_of_points(file, surface), surface, *ends)


def _with_corner(part: SkirtPart, geometry: Geometry) -> Geometry:
    heights_mm = dense_heights_mm(geometry, _CHECKS_PER_PIECE)
    corner = make_corner(part, geometry.radius, geometry.ovality, heights_mm)
    if corner.recipe is None:
        return replace(geometry, surface=corner, corner=corner)
    surface = corner.surface(geometry.breaks_mm())
    return replace(geometry, surface=surface, corner=corner, drawn=corner)


def dense_heights_mm(geometry: Geometry, per_piece: int) -> Floats:
    """Return heights inside every polynomial piece and at all its ends, rising."""
    breaks = geometry.breaks_mm()
    inside = breaks[:-1, None] + np.diff(breaks)[:, None] * np.arange(per_piece) / per_piece
    return np.append(inside.ravel(), breaks[-1])


def _check_ovality(geometry: Geometry, factor: float) -> None:
    z_mm = dense_heights_mm(geometry, _CHECKS_PER_PIECE)
    g_mm = geometry.ovality_mm(z_mm)
    lowest = int(np.argmin(g_mm))
    if g_mm[lowest] < 0:
        problem = f"the spline falls to {g_mm[lowest]:.6g} mm at height {z_mm[lowest]:.6g} mm"
        raise GeometryError("piston.ovality.interpolation", problem, 'use "linear" or more points')
    _check_half_axis(z_mm, geometry.radius_mm(z_mm) - g_mm / 2, factor)


def _check_half_axis(z_mm: Floats, half_axis_mm: Floats, factor: float) -> None:
    thinnest = int(np.argmin(half_axis_mm))
    if half_axis_mm[thinnest] <= 0:
        field = "magnify.factor" if factor > 1 else "piston.profile.spline"
        at = f"at height {z_mm[thinnest]:.6g} mm"
        problem = f"the short half axis becomes {half_axis_mm[thinnest]:.6g} mm {at}"
        raise GeometryError(field, problem, "magnify less, or give points without such a step")


_SYMMETRIC_MM = 1e-9  # sections that differ by less are mirror images


def blank_radius_mm(geometry: Geometry, depth_mm: float) -> float:
    """Return the radius of the blank, a cylinder: largest long half axis plus cutting depth."""
    z_mm = np.linspace(*geometry.skirt_mm, 4097)
    return float(geometry.radius_mm(z_mm).max()) + depth_mm


def section_cut(geometry: Geometry, depth_mm: float, z_mm: float) -> SectionCut:
    """Return a part's section at a height [mm], out of a cylindrical blank."""

    def shaped(phi_rad: Floats) -> SectionValues:
        flat = geometry.delta(phi_rad.ravel(), z_mm)
        return SectionValues(*(values.reshape(phi_rad.shape) for values in flat))

    phi = np.linspace(0, QUARTER_RAD, 181)
    here = shaped(phi).delta
    mirrored = [shaped(angles).delta for angles in (np.pi - phi, phi + np.pi, -phi)]
    is_quarter = all(np.abs(reduction - here).max() < _SYMMETRIC_MM for reduction in mirrored)
    pattern = QUARTER_RAD if is_quarter else TURN_RAD
    a_mm, blank_mm = float(geometry.radius_mm(z_mm)), blank_radius_mm(geometry, depth_mm)
    return SectionCut(shaped, a_mm, blank_mm, pattern)


class Axes(NamedTuple):
    """Table 5: axis positions at the borders of the parts, from the long axis on."""

    t_s: Floats
    c_rad: Floats  # unwrapped
    z_mm: Floats
    x_mm: Floats
    u_mm: Floats


def axes_at(geometry: Geometry, z_mm: float, feed_mm: float, angles: Floats, t_s: Floats) -> Axes:
    """Return the axes, MATHS.md (8), at unwrapped angles [rad] and their times, Z from a height."""
    z = z_mm + feed_mm * angles / TURN_RAD
    u = geometry.delta(angles, z).delta
    return Axes(t_s, angles, z, geometry.radius_mm(z), u)
