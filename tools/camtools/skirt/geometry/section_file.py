r"""Files of measured sections: points by angle and radius, or outlines in Cartesian coordinates.

The header of a file names the columns and their units.

>>> rows = "".join(f"{angle},0,{angle % 180}\n" for angle in range(0, 360, 15))
>>> found = parse_sections("angle_deg,z_mm,reduction_um\n" + rows, "scan.csv")
>>> found.z_mm.tolist(), found.angles_deg[0].size, found.is_radius
([0.0], 24, False)
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from camtools.base.errors import CamtoolsError, InputError
from camtools.base.number_table import NumberTable, read_whole_table
from camtools.base.quantities import Floats, Ints
from camtools.part.model import MAX_HEIGHT_MM
from camtools.skirt.geometry.outline import is_outline, polar_points
from camtools.table.points import check_apart

HEADER = "angle_deg,z_mm,reduction_um"
MIN_ANGLES, MAX_POINTS = 12, 200_000
MAX_REDUCTION_MM = 15.0
MAX_RADIUS_MM = 2000.0
_RADIUS = "radius_mm"
_MM_PER_UNIT = {"reduction_um": 1e-3, "reduction_mm": 1.0, _RADIUS: 1.0}
_SAME_MM = 1e-6  # at 0 and at 360 degrees
_MAX_BYTES = 100 * MAX_POINTS  # a line of three numbers with all their digits


class Sections(NamedTuple):
    """Sections as they were measured, each at its own angles."""

    z_mm: Floats  # shape (m,); heights, rising
    angles_deg: tuple[Floats, ...]  # of each height the drawing's angles, rising, 0 .. 360
    values_mm: tuple[Floats, ...]  # .. and what was measured there
    is_radius: bool = False  # values are radii; else reductions of the profile's radius


def parse_sections(text: str, file: str, centre_mm: tuple[float, float] | None = None) -> Sections:
    """Return the sections of a text; `centre_mm` is the axis in the coordinates of its outlines.

    Raises InputError: with the line: wrong header, no numbers, a point twice, too few at a height.
    """
    table = NumberTable(text, file, MAX_POINTS)
    is_radius, values, rows = _polar(table, centre_mm)
    points: dict[float, dict[float, float]] = {}
    for row, (angle, z_mm, value_mm) in zip(rows.tolist(), values.T.tolist(), strict=True):
        section = points.setdefault(z_mm, {})
        if angle in section:
            raise table.refusal(row, "this point appears twice", "remove one of them")
        section[angle] = value_mm
    for z_mm, section in points.items():
        _close(file, z_mm, section)
    return _sections(file, points, is_radius=is_radius)


def _polar(table: NumberTable, centre_mm: tuple[float, float] | None) -> tuple[bool, Floats, Ints]:
    """Return whether values are radii; angle, height and value; the row of each point."""
    if is_outline(table):
        values, rows = polar_points(table, centre_mm or (0.0, 0.0))
        _check_ranges(values, rows, table, is_radius=True)
        return True, values, rows
    kinds = {"angle": {"angle_deg": 1.0}, "height": {"z_mm": 1.0}, "value": _MM_PER_UNIT}
    columns = table.columns(kinds, HEADER)
    if centre_mm is not None:
        problem = "has angles, which are about the part's axis: no centre_mm belongs to them"
        remedy = "remove piston.section.centre_mm, or give columns x_mm and y_mm"
        raise InputError(table.file, table.place, None, problem, remedy)
    is_radius, values = columns[2].name == _RADIUS, table.values(columns)
    check_apart(values[1], table.file)
    rows = np.arange(len(table.rows))
    _check_ranges(values, rows, table, is_radius=is_radius)
    return is_radius, values, rows


def _check_ranges(values: Floats, rows: Ints, table: NumberTable, *, is_radius: bool) -> None:
    angle_deg, z_mm, value_mm = values
    is_wrong = (angle_deg < 0) | (angle_deg > 360)
    if is_wrong.any():
        problem, remedy = "no angle of 0 .. 360", "give degrees from the long axis"
        raise table.refusal(int(rows[is_wrong.argmax()]), problem, remedy)
    least_mm, most_mm = (0.0, MAX_RADIUS_MM) if is_radius else (-MAX_REDUCTION_MM, MAX_REDUCTION_MM)
    is_wrong = (value_mm < least_mm) | (value_mm > most_mm) | (np.abs(z_mm) > MAX_HEIGHT_MM)
    if is_wrong.any():
        problem = f"beyond {least_mm:g} .. {most_mm:g} mm or a height of {MAX_HEIGHT_MM:g} mm"
        remedy = "give what the header names, the height in mm"
        raise table.refusal(int(rows[is_wrong.argmax()]), problem, remedy)


def _close(file: str, z_mm: float, section: dict[float, float]) -> None:
    """Take 360 degrees as 0; both may be given where they agree."""
    if 360.0 not in section:
        return
    end_mm = section.pop(360.0)
    if abs(section.setdefault(0.0, end_mm) - end_mm) > _SAME_MM:
        off_um = (end_mm - section[0.0]) * 1000
        problem = f"360 degrees differ by {off_um:.6g} um from 0 degrees, which is the same point"
        raise InputError(file, f"height {z_mm:g} mm", None, problem, "remove the wrong one")


def _sections(file: str, points: dict[float, dict[float, float]], *, is_radius: bool) -> Sections:
    counts = [(f"height {z_mm:g} mm", len(points[z_mm])) for z_mm in sorted(points)]
    for place, n in counts or [("angle_deg", 0)]:
        if n < MIN_ANGLES:
            problem = f"has {n} angles, needs at least {MIN_ANGLES}"
            raise InputError(file, place, None, problem, "measure more points per turn")
    rows = [np.array(sorted(points[z_mm].items())).T for z_mm in sorted(points)]
    angles, values = (tuple(row[k] for row in rows) for k in (0, 1))
    return Sections(np.array(sorted(points)), angles, values, is_radius)


def read_scan_text(path: Path, centre_mm: tuple[float, float] | None = None) -> Sections:
    """Return the sections of a file.

    Raises CamtoolsError: it cannot be read, is no file or too large, or see `parse_sections`.
    """
    try:
        text = read_whole_table(path, _MAX_BYTES)
    except InputError as error:
        raise CamtoolsError([f"piston.section.csv: {line}" for line in error.lines]) from error
    return parse_sections(text, path.name, centre_mm)
