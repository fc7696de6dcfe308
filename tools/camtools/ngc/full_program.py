"""C-X-Z-U program of the papers: all axes point by point, the spindle as axis C.

Each block takes the same time (G93). Uniform turning has equal angles between its points,
equal-volume turning equal areas of the section at the height of the turn. Written turn by turn.
"""

from collections.abc import Callable, Iterator
from itertools import pairwise
from math import ceil
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline, PPoly

from camtools.base.quantities import Floats
from camtools.cut.feasibility import Peaks, check_feasible
from camtools.cut.path import ToolPath
from camtools.cut.removal import TURN_RAD, equal_volume_angles
from camtools.cut.speed_law import full, uniform
from camtools.ngc.gcode_words import (
    ANGLE_DECIMALS,
    ENGAGE_TURNS,
    LENGTH_DECIMALS,
    ProgramJob,
    blocks,
    envelope,
    head,
    length,
    lines,
)
from camtools.skirt.geometry.skirt_geometry import blank_radius_mm, dense_heights_mm, section_cut
from camtools.skirt.table.generate import refuse_corner
from camtools.skirt.table.speed import load_at
from camtools.skirt.tool.turning import path_of

_QUARTERS = 4
_BLOCKS_AT_ONCE = 30_000
_PER_PIECE = 8  # intervals of height between breaks
_BETWEEN = 8  # places between two points where the chord error is looked for
_FEED_DECIMALS = 4

Shares = Callable[[Floats], Floats]
"""From heights, shape (n,), to where the blocks of a turn end [turns], shape (n, N), last 1."""


class Points(NamedTuple):
    """Axes at the ends of blocks, all of one shape."""

    turns: Floats  # since the start of the path
    x_mm: Floats  # radius
    z_mm: Floats
    u_mm: Floats


def points_per_turn(job: ProgramJob) -> int:
    """Return the number of blocks of a turn."""
    return _QUARTERS * job.part.process.parts


def _equal_area(job: ProgramJob) -> Shares:
    """Return the borders of equal areas: cubic over height between the breaks of the shape."""
    n = points_per_turn(job)
    breaks = job.geometry.breaks_mm()
    inside = breaks[(breaks > job.z_first_mm) & (breaks < job.z_last_mm)]
    borders = np.concatenate([[job.z_first_mm], inside, [job.z_last_mm]])
    pieces = []
    for low, high in pairwise(borders):
        z_mm = np.linspace(low, high, _PER_PIECE + 1)
        cuts = [section_cut(job.geometry, job.part.process.depth_mm, float(z)) for z in z_mm]
        angles = [equal_volume_angles(cut, n // cut.n_patterns, 1)[1:] for cut in cuts]
        pieces.append(CubicSpline(z_mm, np.array(angles) / TURN_RAD))
    x = np.concatenate([[job.z_first_mm], *(piece.x[1:] for piece in pieces)])
    spline = PPoly(np.concatenate([piece.c for piece in pieces], axis=1), x)
    return lambda z_mm: np.asarray(spline(z_mm), dtype=np.float64)


def _counted_down(shares: Shares) -> Shares:
    """Return the same borders in the order in which M4 passes them."""

    def borders(z_mm: Floats) -> Floats:
        inside = shares(z_mm)[:, :-1]
        return np.hstack([1 - inside[:, ::-1], np.ones((z_mm.size, 1))])

    return borders


def drawing_rad(job: ProgramJob, turns: Floats) -> Floats:
    """Return the drawing's angle [rad, within a turn] before the tool after so many turns."""
    return np.asarray(TURN_RAD * np.mod(job.part.process.direction * turns, 1), dtype=np.float64)


def shares_of(job: ProgramJob) -> Shares:
    """Return where the blocks of a turn end, by its height."""
    process = job.part.process
    if process.mode == "equal-volume":
        return _equal_area(job) if process.direction == 1 else _counted_down(_equal_area(job))
    n = points_per_turn(job)
    equal = np.arange(1, n + 1) / n  # the same for both senses
    return lambda z_mm: np.broadcast_to(equal, (z_mm.size, n))


def points_at(job: ProgramJob, path: ToolPath, turns: Floats) -> Points:
    """Return the axes at turns since the start of the path, engaging and retracting included."""
    z = path.height_mm(turns)
    middle = job.middle_mm
    a = job.geometry.radius_mm(z) - middle
    depth = envelope(path, turns)
    u = job.geometry.delta(drawing_rad(job, turns), z).delta - middle
    return Points(turns, a + (1 - depth) * (job.clear_mm - a), z, depth * u)


def n_blocks(job: ProgramJob, path: ToolPath) -> int:
    """Return the number of blocks that move."""
    return (ceil(path.turns) + 2 * ENGAGE_TURNS) * points_per_turn(job)


def chord_error_mm(job: ProgramJob, path: ToolPath, shares: Shares) -> float:
    """Return the largest distance of U between two points from the section, at break heights."""
    t = np.arange(1, _BETWEEN) / _BETWEEN
    worst = 0.0
    for z_mm in np.append(job.geometry.breaks_mm(), path.z_last_mm):
        if not path.z_first_mm <= z_mm <= path.z_last_mm:
            continue
        ends = np.append(0.0, shares(np.array([z_mm]))[0])
        u = job.geometry.delta(drawing_rad(job, ends), float(z_mm)).delta
        middle = ends[:-1, None] + np.diff(ends)[:, None] * t
        chord = u[:-1, None] + np.diff(u)[:, None] * t
        exact = job.geometry.delta(drawing_rad(job, middle.ravel()), float(z_mm)).delta
        worst = max(worst, float(np.abs(chord.ravel() - exact).max()))
    return worst


def _check(job: ProgramJob) -> float:
    """Return the spindle's highest speed over its mean; refuse what the machine cannot follow."""
    part, geometry = job.part, job.geometry
    refuse_corner(geometry)
    blank_mm = blank_radius_mm(geometry, part.process.depth_mm)
    heights = dense_heights_mm(geometry, 2)
    heights = heights[(heights >= job.z_first_mm) & (heights <= job.z_last_mm)]
    heights = np.union1d(heights, [job.z_first_mm, job.z_last_mm])
    law = full if part.process.mode == "equal-volume" else uniform
    found = [law(load_at(geometry, blank_mm, float(z))).peaks for z in heights]
    alpha, ratio, speed, motion = (float(peak) for peak in np.max(found, axis=0))
    deepest = max(geometry.deepest_mm(float(z)) for z in heights)
    stroke = 2 * max(job.middle_mm, deepest - job.middle_mm)
    peaks = Peaks(stroke, speed, motion, ratio, alpha if law is full else 0.0)
    check_feasible(peaks, part.machine.limits, part.process.spindle_rpm)
    return ratio


def _notes(job: ProgramJob, path: ToolPath, shares: Shares) -> list[str]:
    process, n = job.part.process, points_per_turn(job)
    error_um = chord_error_mm(job, path, shares) * 1000
    return [
        "C: spindle as an axis, the drawing's angle in degrees, unwrapped, 0 where the path begins",
        "U: reduction of the radius",
        f"{process.mode}, {path.kind}, feed {process.feed_mm:g} mm per turn"
        + (f", steps of {path.step:.9f} turns" if path.step else "")
        + (f", ramps of {path.ramp:.6f} turns" if path.ramp and not path.step else ""),
        f"{n_blocks(job, path)} blocks, {n} per turn, {n * process.spindle_rpm / 60:.1f} per s",
        f"chord error of U between points {error_um:.4f} um",
    ]


def full_program(job: ProgramJob) -> Iterator[bytes]:
    """Return the program in pieces, made one by one; refuse what the machine cannot follow."""
    path = path_of(job.part, job.z_first_mm, job.z_last_mm, _check(job))
    return _pieces(job, path, shares_of(job))


def _pieces(job: ProgramJob, path: ToolPath, shares: Shares) -> Iterator[bytes]:
    process, n = job.part.process, points_per_turn(job)
    clear = length("X", job.clear_mm * job.x_factor)
    first_deg = -360 * ENGAGE_TURNS * process.direction
    start = [
        f"G0 {clear}",
        f"G0 {length('Z', job.z_first_mm)} {length('U', 0)} C{first_deg:.{ANGLE_DECIMALS}f}",
        "G93",
    ]
    yield lines([*head(job, _notes(job, path, shares)), *start])
    yield from _moves(job, path, shares, process.spindle_rpm * n)
    yield lines([f"G94 G0 {clear}", "M2"])


def _moves(job: ProgramJob, path: ToolPath, shares: Shares, per_min: float) -> Iterator[bytes]:
    sign = 360 * job.part.process.direction
    micro = LENGTH_DECIMALS
    words = [("G1 C", ANGLE_DECIMALS), ("X", micro), ("Z", micro), ("U", micro)]
    words.append(("F", _FEED_DECIMALS))
    at_once = max(1, _BLOCKS_AT_ONCE // points_per_turn(job))
    for first in range(-ENGAGE_TURNS, ceil(path.turns) + ENGAGE_TURNS, at_once):
        last = min(first + at_once, ceil(path.turns) + ENGAGE_TURNS)
        whole = np.arange(first, last, dtype=np.float64)
        turns = (whole[:, None] + shares(path.height_mm(whole + 0.5))).ravel()
        at = points_at(job, path, turns)
        columns = (sign * turns, at.x_mm * job.x_factor, at.z_mm, at.u_mm)
        yield blocks(words, np.stack([*columns, np.full(turns.size, per_min)], axis=1))
