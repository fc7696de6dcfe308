r"""A lift as a list of points: read from the part file or another one, and smoothed within a band.

>>> angle_deg = np.arange(0.0, 360.0)
>>> lift_mm = np.round(4 - 4 * np.cos(np.radians(angle_deg)), 3)
>>> found = smooth_list(angle_deg, lift_mm, 0.5)
>>> f"{found.largest_um:.2f}", f"{peaks_of(found.before).acceleration:.2f}"
('0.50', '12.58')
>>> f"{peaks_of(found.after).acceleration:.2f}"
'4.00'
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from camtools.base.errors import GeometryError, InputError, numbers_shown
from camtools.base.files import read_whole_table
from camtools.base.quantities import UM_PER_MM, Floats
from camtools.lobe.lobe_keys import (
    CRANK_HINT,
    MAX_LIFT_MM,
    MIN_POINTS,
    MIN_STEP_DEG,
    Lobe,
    fits_turn,
    is_step,
    is_turn,
)
from camtools.part.file import MAX_FILE_BYTES
from camtools.part.model import SAME_MM
from camtools.part.smoothing import bands_um, first_enough, smoothed
from camtools.table.points import MM_PER_INCH, PointedTurn, Units
from camtools.table.points import parse_points as foreign_points

CSV_HEADER = "angle_deg,lift_mm"
_MAX_ROWS = 10_000


def parse_points(text: str, file: str, turns: int = 1) -> tuple[Floats, Floats]:
    """Return angles [degrees of the cam] and lifts [mm] of a CSV text.

    Its angle turns once or twice for one of the cam. Raises InputError with the line: wrong header,
    no two numbers, angles that do not rise, lifts out of range.
    """
    lines = text.splitlines()
    if not lines or lines[0].strip() != CSV_HEADER:
        raise InputError(file, "line 1", None, "wrong header", f'write "{CSV_HEADER}"')
    rows: list[tuple[float, float]] = []
    for number, line in enumerate(lines[1 : _MAX_ROWS + 1], start=2):
        if line.strip():
            rows.append(_row(file, number, line, rows, turns))
    if len(rows) < MIN_POINTS or len(lines) > _MAX_ROWS + 1:
        problem = f"has {len(lines) - 1} points, must have {MIN_POINTS} .. {_MAX_ROWS}"
        raise InputError(file, "angle_deg", None, problem, "list one turn of the cam")
    angle_deg, lift_mm = np.array(rows).T
    return angle_deg, lift_mm


def _row(
    file: str, number: int, line: str, before: list[tuple[float, float]], turns: int
) -> tuple[float, float]:
    """Return a row that follows the ones before."""
    place = f"line {number}"
    try:
        angle, lift_mm = (float(cell) for cell in line.split(","))
    except ValueError as error:
        problem = "not two numbers"
        shown = numbers_shown(line)
        raise InputError(file, place, shown, problem, f"write {CSV_HEADER}") from error
    if not (-360 <= angle <= 720 and 0 <= lift_mm <= MAX_LIFT_MM):
        problem = f"angle not -360 .. 720 or lift not 0 .. {MAX_LIFT_MM:g}"
        raise InputError(file, place, line, problem, "give degrees and mm above the base circle")
    angle /= turns
    if before and not (is_step(angle - before[-1][0]) and fits_turn(angle - before[0][0])):
        problem = f"angles must rise by at least {MIN_STEP_DEG} degrees within one turn"
        is_longer = angle - before[0][0] > 360
        remedy = "sort the points" + CRANK_HINT[turns] * is_longer
        raise InputError(file, place, line, problem, remedy)
    return angle, lift_mm


def _points_of_file(text: str, file: str, lobe: Lobe) -> PointedTurn:
    """Return the points of a text: with our own header, or of another system."""
    inch_mm = MM_PER_INCH if lobe.lift_unit == "inch" else None
    turns, most_mm = lobe.turns_listed, lobe.largest_lift_mm or MAX_LIFT_MM
    units = Units(turns, lobe.largest_lift_mm or inch_mm, CRANK_HINT[turns])
    if text.lstrip()[: len(CSV_HEADER)] == CSV_HEADER and units.value_mm is None:
        angle_deg, lift_mm = parse_points(text, file, units.turns)
        return PointedTurn(angle_deg, lift_mm, *np.zeros((2, 0)))
    found = foreign_points(text, file, units)
    turn = found.sections[0]
    if len(found.sections) > 1:
        problem = f"has {len(found.sections)} heights"
        raise InputError(file, "Z_mm", None, problem, "give the points of one lobe")
    low, high = float(turn.y_mm.min()), float(turn.y_mm.max())
    if low < -SAME_MM or high > most_mm + SAME_MM:
        problem = f"lifts of {low:g} .. {high:g} mm, not 0 .. {most_mm:g}"
        remedy = "give mm above the base circle"
        if lobe.largest_lift_mm:
            problem = f"shares of {low / most_mm:g} .. {high / most_mm:g}, not 0 .. 1"
            remedy = "give shares of 0 .. 1 of largest_lift_mm, or remove it"
        raise InputError(file, "Y_mm", None, problem, remedy)
    return turn if found.has_motion else turn._replace(v=turn.v[:0], a=turn.a[:0])


def opened(points: PointedTurn) -> PointedTurn:
    """Return points of a turn without a repeated end."""
    n = points.x_deg.size - is_turn(points.x_deg[-1] - points.x_deg[0])
    return PointedTurn(*(column[:n] for column in points))


def points_of(lobe: Lobe, field: str) -> PointedTurn:
    """Return the points of a listed lobe, from the part file or from its file.

    Without velocity and acceleration those columns are empty. Raises GeometryError, which names the
    lobe by `field`, where the file is no good.
    """
    if lobe.csv is None:
        assert lobe.angle_deg is not None
        angle_deg = np.asarray(lobe.angle_deg, dtype=float) / lobe.turns_listed
        return PointedTurn(angle_deg, np.asarray(lobe.lift_mm, dtype=float), *np.zeros((2, 0)))
    path = Path(lobe.csv)
    try:
        return _points_of_file(read_whole_table(path, MAX_FILE_BYTES), path.name, lobe)
    except InputError as error:
        problem, _, remedy = error.lines[0].rpartition("; ")
        raise GeometryError(f"{field}.csv", problem, remedy) from error


_PER_STEP = 16  # angles between two points at which peaks are sought


class PeaksOfList(NamedTuple):
    """Largest magnitudes over a turn."""

    acceleration: float  # mm/rad^2
    jerk: float  # mm/rad^3


class Smoothing(NamedTuple):
    """A list within its band, and the curves through it."""

    band_um: float
    angle_deg: Floats  # of the points, degrees of the cam
    off_um: Floats  # smoothed less listed lift
    before: BSpline  # lift [mm] over the angle [rad] through the listed points
    after: BSpline  # through the smoothed ones

    @property
    def largest_um(self) -> float:
        """Return the largest residual."""
        return float(np.abs(self.off_um).max())


def periodic_spline(angle_deg: Floats, lift_mm: Floats) -> BSpline:
    """Return the periodic quintic spline through points whose angles span a turn at most.

    Where they span it, both ends have the same lift.
    """
    n = lift_mm.size - is_turn(angle_deg[-1] - angle_deg[0])
    # the end is made from the beginning: written out, both differ in the last digits
    angle_deg = np.append(angle_deg[:n], angle_deg[0] + 360)
    lift_mm = np.append(lift_mm[:n], lift_mm[0])
    return make_interp_spline(np.radians(angle_deg), lift_mm, k=5, bc_type="periodic")


def smooth_list(angle_deg: Floats, lift_mm: Floats, band_um: float) -> Smoothing:
    """Return a list with the least third derivative within a band to either side of its lifts.

    Points of lift 0 stay 0; the end of the turn is not repeated.
    """
    held = lift_mm == 0
    found_mm = smoothed(angle_deg, lift_mm, band_um / UM_PER_MM, period=360.0, held=held)
    off_um = (found_mm - lift_mm) * UM_PER_MM
    curves = (periodic_spline(angle_deg, mm) for mm in (lift_mm, found_mm))
    return Smoothing(band_um, angle_deg, off_um, *curves)


def peaks_of(curve: BSpline) -> PeaksOfList:
    """Return the peaks of a periodic quintic."""
    knots = curve.t[curve.k : -curve.k]
    x = np.linspace(knots[:-1], knots[1:], _PER_STEP, axis=-1).ravel()
    return PeaksOfList(*(float(np.abs(curve(x, nu=n)).max()) for n in (2, 3)))


def bands_of(points: PointedTurn) -> list[float]:
    """Return bands [um] that may remove the noise of a list, rising; none without noise."""
    return [] if points.v.size else bands_um(points.x_deg, points.y_mm, 360.0)


def band_for(points: PointedTurn) -> Smoothing | None:
    """Return the smoothing that a list without one needs; None where it needs none."""

    def peaks(one: Smoothing) -> tuple[float, float]:
        return peaks_of(one.before).acceleration, peaks_of(one.after).acceleration

    def smooth(band_um: float) -> Smoothing:
        return smooth_list(points.x_deg, points.y_mm, band_um)

    return first_enough(bands_of(points), smooth, peaks)
