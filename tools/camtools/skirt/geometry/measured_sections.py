r"""Sections that were measured at heights: their text, and the surface through them.

The header names the unit, and shows by its separator how the lines are written: with commas, with
semicolons (then a decimal comma is read as well as a point), or with blanks or tabs.

>>> rows = "".join(f"{angle};0;0,{angle % 180:03d}\n" for angle in range(0, 361, 15))
>>> found = parse_sections("angle_deg;z_mm;reduction_mm\n" + rows, "scan.csv")
>>> found.angles_deg[0].size, float(found.values_mm[0][1]), found.is_radius
(24, 0.015, False)

Over the angle a periodic quintic spline runs through the values of each height; over the height
each angle's values are joined as `curves.through` joins points. Every piece follows from knots:
value and two derivatives by the turn at each break and height, and the same of the slope over the
height, MATHS.md (19).

>>> turn = np.arange(12) / 12
>>> flat = surface_through(turn, np.array([0.0, 10.0]), np.full((2, 12), 0.25), "linear")
>>> flat.delta(np.array([0.1, 2.0]), 5.0).delta.round(12).tolist()
[0.25, 0.25]
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.interpolate import (
    Akima1DInterpolator,
    CubicSpline,
    PchipInterpolator,
    make_interp_spline,
)

from camtools.base.errors import CamtoolsError, InputError, numbers_shown
from camtools.base.files import read_whole_table
from camtools.base.quantities import Floats
from camtools.base.text import NumberLines
from camtools.skirt.geometry.poly_surface import N_ANGLE, N_HEIGHT, Knots, PolySurface
from camtools.skirt.part.curves import Overshoot

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


def _wrong(file: str, line: int, value: str | None, problem: str, remedy: str) -> InputError:
    return InputError(file, f"line {line}", value, problem, remedy)


def _columns(file: str, line: str) -> NumberLines:
    columns = NumberLines(line)
    names = columns.names
    if len(names) != 3 or names[:2] != ["angle_deg", "z_mm"] or names[2] not in _MM_PER_UNIT:
        others = ", ".join(list(_MM_PER_UNIT)[1:])
        remedy = f'write "{HEADER}", or {others} as the third name, with , or ; or blanks between'
        raise _wrong(file, 1, None, "wrong header", remedy)
    return columns


def _row(file: str, number: int, line: str, columns: NumberLines) -> tuple[float, float, float]:
    """Return angle, height and value [mm] of a line."""
    try:
        angle, z_mm, value = columns.numbers(line)
    except ValueError as error:
        shown, remedy = numbers_shown(line), "write as the header says"
        raise _wrong(file, number, shown, "not three numbers", remedy) from error
    if not np.isfinite([angle, z_mm, value]).all() or not 0 <= angle <= 360:
        raise _wrong(file, number, line, "no angle of 0 .. 360", "give degrees from the long axis")
    unit = columns.names[2]
    value_mm = value * _MM_PER_UNIT[unit]
    is_radius = unit == _RADIUS
    least_mm, most_mm = (0.0, MAX_RADIUS_MM) if is_radius else (-MAX_REDUCTION_MM, MAX_REDUCTION_MM)
    if not least_mm <= value_mm <= most_mm or abs(z_mm) > 1000:
        problem = f"beyond {least_mm:g} .. {most_mm:g} mm or a height of 1000 mm"
        raise _wrong(file, number, line, problem, "give what the header names, the height in mm")
    return angle, z_mm, value_mm


def parse_sections(text: str, file: str) -> Sections:
    """Return the sections of a text.

    Raises InputError: with the line: wrong header, no numbers, a point twice, too few at a height.
    """
    lines = text.splitlines()
    columns = _columns(file, lines[0].strip() if lines else "")
    if len(lines) > MAX_POINTS:
        problem = f"more than {MAX_POINTS} points"
        raise _wrong(file, MAX_POINTS, None, problem, "leave out points or heights")
    points: dict[float, dict[float, float]] = {}
    for number, line in enumerate(lines[1:], start=2):
        if not line.strip():
            continue
        angle, z_mm, value_mm = _row(file, number, line, columns)
        section = points.setdefault(z_mm, {})
        if angle in section:
            raise _wrong(file, number, line, "this point appears twice", "remove one of them")
        section[angle] = value_mm
    for z_mm, section in points.items():
        _close(file, z_mm, section)
    return _sections(file, points, is_radius=columns.names[2] == _RADIUS)


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


def read_scan_text(path: Path) -> Sections:
    """Return the sections of a file.

    Raises CamtoolsError: it cannot be read, is no file or too large, or see `parse_sections`.
    """
    try:
        text = read_whole_table(path, _MAX_BYTES)
    except InputError as error:
        raise CamtoolsError([f"piston.section.csv: {line}" for line in error.lines]) from error
    return parse_sections(text, path.name)


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
    k, j, i = (int(one) for one in np.unravel_index(int(np.argmax(beyond)), beyond.shape))
    at = float(z_mm[j] + places[k][j, i] * (z_mm[j + 1] - z_mm[j]))
    largest = max(0.0, float(beyond[k, j, i]))
    return Overshoot(largest, at, float(z_mm[j]), float(z_mm[j + 1])), i
