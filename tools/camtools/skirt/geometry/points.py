"""Sections given by points of one turn: what another controller plays, or an exported table.

Between two points runs the quintic through value, velocity and acceleration of both; between two
heights the surface is straight. So does a table, hence its export comes back as the same part.

>>> turn = PointedTurn(np.array([0.0, 90, 180, 270]), *np.zeros((3, 4)))
>>> point_surface(PointFile(None, (turn,), True)).log2_repeat
2
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.interpolate import PPoly, make_interp_spline

from camtools.base.errors import CamtoolsError, GeometryError, InputError
from camtools.base.quantities import Floats
from camtools.skirt.geometry.poly_surface import N_ANGLE, N_HEIGHT, PolySurface, angle_pieces
from camtools.skirt.geometry.profile import constant_spline
from camtools.skirt.geometry.scan import gaps_of
from camtools.skirt.geometry.sections import ALL_AROUND_RAD
from camtools.skirt.part.curves import through
from camtools.skirt.part.section_keys import PointsAt, SectionShape
from camtools.table.channel import MAX_LOG2_REPEAT
from camtools.table.points import PointedTurn, PointFile, quintics_of, read_points

MAX_REDUCTION_MM = 30.0
_SAME_DEG, _SAME = 1e-9, 1e-9
_DEG_PER_TURN = 360.0
_MOST_BEYOND_UM = 1.0  # a curve beyond the points at both ends of a gap


def read_sections(section: SectionShape) -> PointFile:
    """Return the points of [piston.section], of one file or of a file for each height.

    Raises CamtoolsError: a file is no good, or the files do not belong together.
    """
    try:
        if section.csv is not None:
            return with_motion(read_points(Path(section.csv)))
        assert section.files is not None
        return _together([(one, read_points(Path(one.csv))) for one in section.files])
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
    x = np.append(turn.x_deg, turn.x_deg[0] + _DEG_PER_TURN)
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
        return np.append(turn.x_deg, _DEG_PER_TURN) / _DEG_PER_TURN, quintics
    x = np.append(turn.x_deg, turn.x_deg[0] + _DEG_PER_TURN) / _DEG_PER_TURN
    powers = quintics / np.diff(x)[:, None] ** np.arange(N_ANGLE)
    curve = PPoly(powers.T[::-1], x)
    breaks = np.unique(np.concatenate([[0.0, 1.0], np.mod(turn.x_deg / _DEG_PER_TURN, 1.0)]))
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
    breaks, columns = made[0][0], factor * np.stack([one[1] for one in made])
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
