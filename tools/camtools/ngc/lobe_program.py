"""C-X-Z program of a camshaft: X follows the lift over C, B swings the tool of a lathe.

The spindle is an axis. A turn has as many blocks as the chord error needs; their times (G93) are
those of a uniform cam, or of one that turns so that the contact travels as on the base circle, as
far as the spindle's acceleration allows. Each lobe is cut along a helix of its own.

>>> from camtools.lobe.motion import example_lobe
>>> job = LobeJob(example_lobe("grinding"), 0.001, False)
>>> turn = turn_of(job, make_lobes(job.part)[0])
>>> turn.error_mm <= 0.001, bool((np.diff(turn.share) > 0).all()), float(turn.share[-1])
(True, True, 1.0)
"""

from collections.abc import Iterator
from math import ceil
from typing import NamedTuple

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats, omega_rad_s
from camtools.cut.feasibility import check_feasible
from camtools.cut.path import ToolPath
from camtools.lobe.channels import N_GRID, SpindleLimits, acceleration_of, mean_of, surface_speed
from camtools.lobe.contact import Follower
from camtools.lobe.generate import peaks_along
from camtools.lobe.motion import ShaftLobe, make_lobes
from camtools.lobe.part import LobePart
from camtools.ngc.gcode_words import (
    ANGLE_DECIMALS,
    CLEARANCE_MM,
    ENGAGE_TURNS,
    LENGTH_DECIMALS,
    blocks,
    envelope,
    length,
    lines,
    opening,
)
from camtools.part.common import check_feed

_MOST_BLOCKS = 20_000  # of a turn
_LEAST_BLOCKS = 72
_SPEED_STEP = 0.02  # of the speed, from block to block
_BLOCKS_AT_ONCE = 30_000
_FEED_DECIMALS = 4
_TURN_RAD = 2 * np.pi
_SWING = (
    "B: swing of the tool about the roller's centre, degrees, above 0 where the lift rises with C"
)


class LobeJob(NamedTuple):
    """What a program of a camshaft is made of."""

    part: LobePart
    chord_mm: float  # largest distance of X between two points from the lift
    is_diameter: bool

    @property
    def is_swung(self) -> bool:
        """Return whether the tool swings."""
        return self.part.process.operation == "turning"


class Turn(NamedTuple):
    """The blocks of a turn, in the order in which the spindle passes them."""

    share: Floats  # of a turn of the spindle at the ends of the blocks, rising, the last is 1
    x_mm: Floats  # radius at these ends
    b_deg: Floats  # swing
    seconds: Floats  # of each block
    error_mm: float  # chord of X


def _speed(job: LobeJob, path: Follower) -> Floats:
    """Return the spindle's speed over a turn [rad/s] on the grid."""
    process, limits = job.part.process, job.part.machine.limits
    omega = omega_rad_s(process.spindle_rpm)
    if process.speed == "uniform":
        return np.full(N_GRID, omega)
    spindle = SpindleLimits(limits.alpha_rad_s2, omega_rad_s(limits.spindle_rpm))
    return surface_speed(path.ds_dphi, job.part.cam.base_radius_mm, omega, spindle)


def _check(job: LobeJob, path: Follower, speed: Floats) -> None:
    """Refuse what the machine cannot follow, with the numbers; see `check_feasible`."""
    mean = mean_of(speed)
    ratio = speed / mean
    peaks, bend = peaks_along(path, ratio), acceleration_of(ratio)
    if job.is_swung:
        peaks = peaks._replace(
            swing_deg=float(np.degrees(np.abs(path.angle).max())),
            swing1_deg=float(np.degrees(np.abs(path.angle1 * ratio).max())),
            swing2_deg=float(np.degrees(np.abs(path.angle2 * ratio**2 + path.angle1 * bend).max())),
        )
    check_feasible(peaks, job.part.machine.limits, mean * 60 / _TURN_RAD)


def _density(job: LobeJob, lobe: ShaftLobe, path: Follower, speed: Floats) -> Floats:
    """Return how many blocks per radian chord, swing and speed need, MATHS.md (45)."""
    chords = np.abs(path.d2)
    if job.is_swung:  # the tip runs on a circle about the roller's centre
        chords = np.maximum(chords, lobe.roller_mm * np.abs(path.angle2))
    by_speed = np.abs(acceleration_of(speed)) / speed**2 / _SPEED_STEP
    least = _LEAST_BLOCKS / _TURN_RAD
    return np.maximum(np.sqrt(chords / (8 * job.chord_mm)), np.maximum(by_speed, least))


def turn_of(job: LobeJob, lobe: ShaftLobe) -> Turn:
    """Return the blocks of a turn of a lobe.

    Raises CamtoolsError: the machine cannot follow, or a chord error needs more than 20000 blocks.
    """
    grid = np.arange(N_GRID + 1) / N_GRID
    path = lobe.at(_TURN_RAD * grid[:-1])
    speed = _speed(job, path)
    _check(job, path, speed)
    density = _closed(_density(job, lobe, path, speed))
    sums = np.concatenate([[0.0], np.cumsum((density[1:] + density[:-1]) * np.pi / N_GRID)])
    n = ceil(float(sums[-1]))
    while n <= _MOST_BLOCKS:
        borders = np.interp(sums[-1] * np.arange(n + 1) / n, sums, grid)
        found = _at_borders(job, lobe, borders, _closed(speed), _closed(path.lift))
        if found.error_mm <= job.chord_mm:
            return found
        n += 1 + n // 50
    problem = f"a chord error of {job.chord_mm * 1000:g} um needs more than {_MOST_BLOCKS} blocks"
    raise CamtoolsError([f"--chord-um {job.chord_mm * 1000:g}: {problem} a turn; give more"])


def _closed(values: Floats) -> Floats:
    return np.append(values, values[0])


def _at_borders(
    job: LobeJob, lobe: ShaftLobe, borders: Floats, speed: Floats, lift: Floats
) -> Turn:
    """Return the blocks between angles of the drawing [turns], turned round for M4."""
    grid = np.arange(N_GRID + 1) / N_GRID
    borders = np.round(borders * 360, ANGLE_DECIMALS) / 360
    at = lobe.at(_TURN_RAD * borders)
    slow = 1 / speed
    time = np.concatenate([[0.0], np.cumsum((slow[1:] + slow[:-1]) * np.pi / N_GRID)])
    seconds = np.diff(np.interp(borders, grid, time))
    error = float(np.abs(np.interp(grid, borders, at.lift) - lift).max())
    x_mm, b_deg = job.part.cam.base_radius_mm + at.lift, np.degrees(at.angle)
    if job.part.process.direction == 1:
        return Turn(borders[1:], x_mm[1:], b_deg[1:], seconds, error)
    back = 1 - borders[::-1]
    return Turn(back[1:], x_mm[::-1][1:], b_deg[::-1][1:], seconds[::-1], error)


def lobe_program(job: LobeJob) -> Iterator[bytes]:
    """Return the program in pieces, made one by one; errors as `make_lobes` and `turn_of`."""
    if job.part.process.is_plunge:
        problem = 'process.operation = "plunge-grinding": a program feeds Z over each lobe'
        raise CamtoolsError([f'{problem}; give "grinding"'])
    check_feed(job.part)
    lobes = make_lobes(job.part)
    return _pieces(job, lobes, [turn_of(job, lobe) for lobe in lobes])


def _notes(job: LobeJob, lobes: list[ShaftLobe], turns: list[Turn]) -> list[str]:
    process, cam = job.part.process, job.part.cam
    twice = "twice " if job.is_diameter else ""
    x = "the radius of the tool's tip when it does not swing: base circle and lift of the roller"
    if not job.is_swung:
        x = "the distance of the wheel's centre from the axis less its radius: base circle and lift"
    notes = [
        f"{job.part.part.name}: made by mkgcode for LinuxCNC, lengths in mm",
        f"X: {twice}{x}",
        "C: spindle as an axis, the drawing's angle in degrees, unwrapped",
        *([_SWING] if job.is_swung else []),
        f"follower: {cam.follower}, {'tip runs on' if cam.follower == 'flat' else 'radius'} "
        f"{cam.roller_radius_mm:g}; base circle {cam.base_radius_mm:g}"
        + ("" if job.is_swung else f", wheel {cam.wheel_radius_mm:g}"),
        f"{process.speed} speed, {process.spindle_rpm:g} r/min"
        + (" on the base circle" if process.speed != "uniform" else ""),
    ]
    for i, (lobe, turn) in enumerate(zip(lobes, turns, strict=True)):
        seconds = float(turn.seconds.sum())
        notes.append(
            f"lobe {i}, Z {lobe.z_mm[0]:g} .. {lobe.z_mm[1]:g}: {turn.share.size} blocks a turn of "
            f"{seconds:.6f} s, chord error of X {turn.error_mm * 1000:.4f} um"
        )
    return notes


def _pieces(job: LobeJob, lobes: list[ShaftLobe], turns: list[Turn]) -> Iterator[bytes]:
    notes = _notes(job, lobes, turns)
    yield lines(opening(notes, job.chord_mm, is_diameter=job.is_diameter))
    clear_mm = max(float(turn.x_mm.max()) for turn in turns)
    clear_mm += job.part.process.depth_mm + CLEARANCE_MM
    clear = f"G0 {length('X', clear_mm * (2 if job.is_diameter else 1))}"
    first_turn = -ENGAGE_TURNS
    for lobe, turn in zip(lobes, turns, strict=True):
        path = ToolPath("helix", *lobe.z_mm, job.part.process.feed_mm)
        c_deg = 360 * job.part.process.direction * first_turn
        start = f"G0 {length('Z', lobe.z_mm[0])} C{c_deg:.{ANGLE_DECIMALS}f}"
        if job.is_swung:
            start += f" B{turn.b_deg[-1]:z.{ANGLE_DECIMALS}f}"
        yield lines([clear, start, "G93"])
        yield from _moves(job, path, turn, first_turn, clear_mm)
        yield lines([f"G94 {clear}"])
        first_turn += ceil(path.turns) + 2 * ENGAGE_TURNS
    yield lines(["M2"])


def _moves(
    job: LobeJob, path: ToolPath, turn: Turn, first_turn: int, clear_mm: float
) -> Iterator[bytes]:
    """Return the blocks of one lobe; C goes on from the turn at which it begins."""
    micro = LENGTH_DECIMALS
    words = [("G1 C", ANGLE_DECIMALS), ("X", micro), ("Z", micro)]
    words += [("B", ANGLE_DECIMALS)] if job.is_swung else []
    words.append(("F", _FEED_DECIMALS))
    sign, factor = 360 * job.part.process.direction, 2 if job.is_diameter else 1
    n, at_once = turn.share.size, max(1, _BLOCKS_AT_ONCE // turn.share.size)
    end = ceil(path.turns) + ENGAGE_TURNS
    for first in range(-ENGAGE_TURNS, end, at_once):
        whole = np.arange(first, min(first + at_once, end), dtype=np.float64)
        turns = (whole[:, None] + turn.share).ravel()
        x = np.tile(turn.x_mm, whole.size)
        x += (1 - envelope(path, turns)) * (clear_mm - x)
        c_deg = sign * (turns + first_turn + ENGAGE_TURNS)
        columns = [c_deg, factor * x, path.height_mm(turns)]
        columns += [np.tile(turn.b_deg, whole.size)] if job.is_swung else []
        columns.append(np.tile(60 / turn.seconds, whole.size))
        assert columns[-1].size == n * whole.size
        yield blocks(words, np.stack(columns, axis=1))
