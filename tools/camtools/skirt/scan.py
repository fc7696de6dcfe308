r"""Measured sections: a CSV table of angle, height and radius reduction, "scan and replay".

>>> rows = "".join(f"{angle},0,{angle % 180}\n" for angle in range(0, 360, 15))
>>> parse_scan(HEADER + "\n" + rows, "scan.csv").reduction_mm.shape
(1, 24)
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.interpolate import PPoly, make_interp_spline

from camtools.base.errors import CamtoolsError, GeometryError, InputError
from camtools.base.input_file import read_limited
from camtools.base.quantities import Floats
from camtools.skirt.poly_surface import N_ANGLE, N_HEIGHT, PolySurface, angle_pieces
from camtools.skirt.profile import constant_spline, polygon_or_spline

HEADER = "angle_deg,z_mm,reduction_um"
MIN_ANGLES, MAX_POINTS = 12, 200_000
MAX_REDUCTION_UM = 15_000.0
_MM_PER_UM, _MIN_SPLINE_HEIGHTS = 1e-3, 4
_FILTERED_PER_HARMONIC = 8
_MAX_BYTES = 100 * MAX_POINTS  # a line of three numbers with all their digits


class Scan(NamedTuple):
    """Sections measured at the same angles at every height."""

    angle_deg: Floats  # (n,) rising, 0 .. 360
    z_mm: Floats  # (m,) rising
    reduction_mm: Floats  # (m, n)


def _wrong(file: str, line: int, value: str, problem: str, remedy: str) -> InputError:
    return InputError(file, f"line {line}", value, problem, remedy)


def _row(file: str, number: int, line: str) -> tuple[float, float, float]:
    try:
        angle, z_mm, um = (float(cell) for cell in line.split(","))
    except ValueError as error:
        raise _wrong(file, number, line, "not three numbers", f"write {HEADER}") from error
    is_finite = np.isfinite([angle, z_mm, um]).all()
    if not is_finite or not 0 <= angle < 360:
        raise _wrong(file, number, line, "no angle of 0 .. 360", "give degrees from the long axis")
    if abs(um) > MAX_REDUCTION_UM or abs(z_mm) > 1000:
        problem = f"beyond {MAX_REDUCTION_UM:g} um or 1000 mm"
        raise _wrong(file, number, line, problem, "give the reduction in um, the height in mm")
    return angle, z_mm, um


def parse_scan(text: str, file: str) -> Scan:
    """Return the sections of a CSV text.

    Raises
    ------
    InputError
        With the line: wrong header, no numbers, a point twice, or missing at a height.
    """
    lines = text.splitlines()
    if not lines or lines[0].strip() != HEADER:
        found = lines[0][:60] if lines else ""
        raise _wrong(file, 1, found, "wrong header", f'write "{HEADER}"')
    if len(lines) > MAX_POINTS:
        problem = f"more than {MAX_POINTS} points"
        raise _wrong(file, MAX_POINTS, lines[-1], problem, "leave out points or heights")
    points: dict[tuple[float, float], float] = {}
    for number, line in enumerate(lines[1:], start=2):
        if not line.strip():
            continue
        angle, z_mm, um = _row(file, number, line)
        if (z_mm, angle) in points:
            raise _wrong(file, number, line, "this point is there already", "remove one of them")
        points[z_mm, angle] = um
    return _grid(points, file)


def _grid(points: dict[tuple[float, float], float], file: str) -> Scan:
    heights = sorted({z_mm for z_mm, _ in points})
    angles = sorted({angle for _, angle in points})
    for z_mm in heights:
        missing = next((angle for angle in angles if (z_mm, angle) not in points), None)
        if missing is not None:
            problem = f"no point at {missing:g} degrees, which other heights have"
            remedy = "measure all heights at the same angles, or interpolate them"
            raise InputError(file, f"height {z_mm:g} mm", None, problem, remedy)
    if len(angles) < MIN_ANGLES:
        problem = f"has {len(angles)} angles, wants at least {MIN_ANGLES}"
        raise InputError(file, "angle_deg", None, problem, "measure more points per turn")
    values = np.array([[points[z_mm, angle] for angle in angles] for z_mm in heights])
    return Scan(np.array(angles), np.array(heights), values * _MM_PER_UM)


def read_scan(path: Path) -> Scan:
    """Return the sections of a CSV file.

    Raises
    ------
    CamtoolsError
        It cannot be read, is no file or too large, or see `parse_scan`.
    """
    try:
        text = read_limited(path, _MAX_BYTES).decode("utf-8-sig")  # spreadsheets mark it
    except (OSError, UnicodeDecodeError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "not UTF-8 text"
        remedy = "give a CSV file, its place seen from the part file"
        message = InputError(path.name, "", None, f"cannot be read: {reason}", remedy)
        raise CamtoolsError([f"piston.section.csv: {line}" for line in message.lines]) from error
    return parse_scan(text, path.name)


def filtered(scan: Scan, harmonics: int) -> Scan:
    """Return the sections with harmonics 0 .. n of the turn only, on a uniform grid of angles.

    The waves are fitted to the points by least squares, as a roundness instrument's filter does,
    MATHS.md (18).

    Raises
    ------
    GeometryError
        More waves than the points resolve.
    """
    n_points = scan.angle_deg.size
    if 2 * harmonics + 1 > n_points:
        problem = f"{n_points} points per turn cannot tell {harmonics} waves apart"
        remedy = f"give at most {(n_points - 1) // 2}"
        raise GeometryError("piston.section.harmonics", problem, remedy)
    waves, *_ = np.linalg.lstsq(
        _basis(np.radians(scan.angle_deg), harmonics), scan.reduction_mm.T, rcond=None
    )
    n = max(MIN_ANGLES, _FILTERED_PER_HARMONIC * harmonics)
    grid = 360 * np.arange(n) / n
    return Scan(grid, scan.z_mm, (_basis(np.radians(grid), harmonics) @ waves).T)


def _basis(phi: Floats, harmonics: int) -> Floats:
    n = np.arange(1, harmonics + 1)
    angles = phi[:, None] * n
    return np.hstack([np.ones((phi.size, 1)), np.cos(angles), np.sin(angles)])


def scan_surface(scan: Scan, factor: float = 1.0) -> PolySurface:
    """Return the surface through all points: periodic quintic over angle, smooth over height.

    One height serves all; up to three are joined linearly, more by a cubic spline.
    """
    turn = np.append(scan.angle_deg, scan.angle_deg[0] + 360) / 360
    values = factor * np.vstack([scan.reduction_mm.T, scan.reduction_mm[:, :1].T])
    spline = make_interp_spline(turn, values, k=5, bc_type="periodic")
    breaks = np.unique(np.concatenate([[0.0, 1.0], np.mod(scan.angle_deg / 360, 1.0)]))
    columns = [_column(spline.t, spline.c[:, i], breaks) for i in range(scan.z_mm.size)]
    heights, powers = _over_height(scan.z_mm, np.stack(columns, axis=-1))
    return PolySurface(breaks, heights, powers)


def _column(t: Floats, c: Floats, breaks: Floats) -> Floats:
    """Return one section's coefficients on pieces of the turn, shape (n, 6)."""
    curve = PPoly.from_spline((t, c, 5))
    first = float(t[5])
    inside = (np.diff(curve.x) > 0) & (curve.x[:-1] >= first) & (curve.x[1:] <= float(t[-6]))
    curve = PPoly(curve.c[:, inside], np.append(curve.x[:-1][inside], t[-6]))
    before = PPoly(curve.c, curve.x - 1)  # the same curve a turn earlier serves the wrap
    is_early = breaks[1:] <= first + 1e-12
    early, late = angle_pieces(before, breaks), angle_pieces(curve, breaks)
    return np.where(is_early[:, None], early, late)


def _over_height(z_mm: Floats, at_heights: Floats) -> tuple[Floats, Floats]:
    """Return heights and coefficients (m, n, 6, 8) of a spline through sections (n, 6, m)."""
    if z_mm.size == 1:
        ends = constant_spline(0.0, float(z_mm[0]) - 1, float(z_mm[0]) + 1)
        found = np.zeros((1, at_heights.shape[0], N_ANGLE, N_HEIGHT))
        found[0, ..., 0] = at_heights[..., 0]
        return np.asarray(ends.x), found
    kind = "spline" if z_mm.size >= _MIN_SPLINE_HEIGHTS else "linear"
    rows = at_heights.reshape(-1, z_mm.size)
    splines = [polygon_or_spline(z_mm, row, kind) for row in rows]
    powers = np.stack([spline.c[::-1] for spline in splines])  # (n * 6, 4, m - 1)
    scaled = powers * np.diff(z_mm) ** np.arange(4)[:, None]
    found = np.zeros((z_mm.size - 1, rows.shape[0], N_HEIGHT))
    found[..., :4] = scaled.transpose(2, 0, 1)
    return z_mm, found.reshape(z_mm.size - 1, -1, N_ANGLE, N_HEIGHT)


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
    return polygon_or_spline(scan.z_mm, oval, "linear")
