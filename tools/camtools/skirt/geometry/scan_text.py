r"""The text of a scan: angle, height, and what was measured there.

The header names the unit, and shows by its separator how the lines are written: with commas, with
semicolons (then a decimal comma is read as well as a point), or with blanks or tabs.

>>> rows = "".join(f"{angle};0;0,{angle % 180:03d}\n" for angle in range(0, 361, 15))
>>> found = parse_sections("angle_deg;z_mm;reduction_mm\n" + rows, "scan.csv")
>>> found.angles_deg[0].size, float(found.values_mm[0][1]), found.is_radius
(24, 0.015, False)
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from camtools.base.columns import Columns
from camtools.base.errors import CamtoolsError, InputError, numbers_shown
from camtools.base.input_file import read_whole_table
from camtools.base.quantities import Floats

HEADER = "angle_deg,z_mm,reduction_um"
MIN_ANGLES, MAX_POINTS = 12, 200_000
MAX_REDUCTION_MM = 15.0
MAX_RADIUS_MM = 2000.0
_MM_PER_UNIT = {"reduction_um": 1e-3, "reduction_mm": 1.0, "radius_mm": 1.0}
_SAME_MM = 1e-6  # at 0 and at 360 degrees
_MAX_BYTES = 100 * MAX_POINTS  # a line of three numbers with all their digits


class Sections(NamedTuple):
    """Sections as they were measured, each at its own angles.

    Attributes
    ----------
    angles_deg, values_mm : tuple of ndarray
        Of each height: drawing's angles, rising, 0 <= angle < 360, and what was measured there.
    """

    z_mm: Floats  # shape (m,); heights, rising
    angles_deg: tuple[Floats, ...]
    values_mm: tuple[Floats, ...]
    is_radius: bool = False  # values are radii; else reductions of the profile's radius


class _Format(NamedTuple):
    """How the lines of a file are written."""

    columns: Columns
    per_unit: float
    is_radius: bool


def _wrong(file: str, line: int, value: str | None, problem: str, remedy: str) -> InputError:
    return InputError(file, f"line {line}", value, problem, remedy)


def _format_of(file: str, line: str) -> _Format:
    columns = Columns(line)
    names = columns.names
    if len(names) != 3 or names[:2] != ["angle_deg", "z_mm"] or names[2] not in _MM_PER_UNIT:
        others = ", ".join(list(_MM_PER_UNIT)[1:])
        remedy = f'write "{HEADER}", or {others} as the third name, with , or ; or blanks between'
        raise _wrong(file, 1, None, "wrong header", remedy)
    return _Format(columns, _MM_PER_UNIT[names[2]], names[2] == "radius_mm")


def _row(file: str, number: int, line: str, form: _Format) -> tuple[float, float, float]:
    """Return angle, height and value [mm] of a line."""
    try:
        angle, z_mm, value = form.columns.numbers(line)
    except ValueError as error:
        shown = numbers_shown(line)
        raise _wrong(
            file, number, shown, "not three numbers", "write as the header says"
        ) from error
    if not np.isfinite([angle, z_mm, value]).all() or not 0 <= angle <= 360:
        raise _wrong(file, number, line, "no angle of 0 .. 360", "give degrees from the long axis")
    value_mm = value * form.per_unit
    least_mm, most_mm = -MAX_REDUCTION_MM, MAX_REDUCTION_MM
    if form.is_radius:
        least_mm, most_mm = 0.0, MAX_RADIUS_MM
    if not least_mm <= value_mm <= most_mm or abs(z_mm) > 1000:
        problem = f"beyond {least_mm:g} .. {most_mm:g} mm or a height of 1000 mm"
        raise _wrong(file, number, line, problem, "give what the header names, the height in mm")
    return angle, z_mm, value_mm


def parse_sections(text: str, file: str) -> Sections:
    """Return the sections of a text.

    Raises
    ------
    InputError
        With the line: wrong header, no numbers, a point twice, too few at a height.
    """
    lines = text.splitlines()
    form = _format_of(file, lines[0].strip() if lines else "")
    if len(lines) > MAX_POINTS:
        problem = f"more than {MAX_POINTS} points"
        raise _wrong(file, MAX_POINTS, None, problem, "leave out points or heights")
    points: dict[float, dict[float, float]] = {}
    for number, line in enumerate(lines[1:], start=2):
        if not line.strip():
            continue
        angle, z_mm, value_mm = _row(file, number, line, form)
        section = points.setdefault(z_mm, {})
        if angle in section:
            raise _wrong(file, number, line, "this point appears twice", "remove one of them")
        section[angle] = value_mm
    for z_mm, section in points.items():
        _close(file, z_mm, section)
    return _sections(file, points, form)


def _close(file: str, z_mm: float, section: dict[float, float]) -> None:
    """Take 360 degrees as 0; both may be given where they agree."""
    if 360.0 not in section:
        return
    end_mm = section.pop(360.0)
    if abs(section.setdefault(0.0, end_mm) - end_mm) > _SAME_MM:
        off_um = (end_mm - section[0.0]) * 1000
        problem = f"360 degrees differ by {off_um:.6g} um from 0 degrees, which is the same point"
        raise InputError(file, f"height {z_mm:g} mm", None, problem, "remove the wrong one")


def _sections(file: str, points: dict[float, dict[float, float]], form: _Format) -> Sections:
    if not points:
        remedy = "measure more points per turn"
        raise InputError(
            file, "angle_deg", None, f"has 0 angles, needs at least {MIN_ANGLES}", remedy
        )
    heights = sorted(points)
    for z_mm in heights:
        if len(points[z_mm]) < MIN_ANGLES:
            problem = f"has {len(points[z_mm])} angles, needs at least {MIN_ANGLES}"
            place = f"height {z_mm:g} mm"
            raise InputError(file, place, None, problem, "measure more points per turn")
    angles = tuple(np.array(sorted(points[z_mm])) for z_mm in heights)
    values = tuple(
        np.array([points[z_mm][angle] for angle in of_height])
        for z_mm, of_height in zip(heights, angles, strict=True)
    )
    return Sections(np.array(heights), angles, values, form.is_radius)


def read_scan_text(path: Path) -> Sections:
    """Return the sections of a file.

    Raises
    ------
    CamtoolsError
        It cannot be read, is no file or too large, or see `parse_sections`.
    """
    try:
        text = read_whole_table(path, _MAX_BYTES)
    except InputError as error:
        raise CamtoolsError([f"piston.section.csv: {line}" for line in error.lines]) from error
    return parse_sections(text, path.name)
