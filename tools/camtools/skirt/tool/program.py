"""A skirt and its ring belt in one program of turns: Z and X over a station, MATHS.md (248).

The station counts the turns (TABLE_FORMAT.md, "Stations"). In each pass over each band, upwards,

    come in    Z stands below the band while X comes in
    run in     the feed rises from 0
    cut        Z feeds through the band, X and U follow its surface
    run out    the feed falls to 0, above the band
    go off     Z stands while X goes off, clear of all bands and of the blank
    move       Z moves to the next pass, up or back, while U blends into its section

The program begins and ends where the coarsest pass of its first and of its last band stands. All of
them take multiples of five turns, so that few slices and knots lie at their ends. The
controller itself comes in before the first pass and goes off after the last one.

>>> band = Band("land", 52.0, 56.0, (BandPass(0.1, 0.15), BandPass(0.0, 0.1)))
>>> [(step.turns, f"{step.run_mm:.3f}") for step in steps_of([band])[0]]
[(30, '0.333'), (40, '0.250')]
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from itertools import chain, count
from math import ceil, sqrt
from typing import NamedTuple

import numpy as np

from camtools.base.errors import CamtoolsError, GeometryError
from camtools.base.quantities import NM_PER_MM, Floats, FloatsLike, Ints, SectionValues
from camtools.base.text import Json
from camtools.cut.stretch import Stretch, is_gentle, over_turns, sampled
from camtools.part.common import Tool, check_tracks
from camtools.skirt.geometry.run_in import with_run
from camtools.skirt.geometry.sections import SkirtSurface
from camtools.skirt.geometry.skirt_geometry import Geometry
from camtools.skirt.part.land import Band, BandPass
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.tool.nose import tip_geometry
from camtools.table.channel import (
    KIND_WAY,
    KIND_X,
    MAX_HEIGHT_NM,
    MAX_SLICES,
    MIN_SPACING_NM,
    Channel,
)
from camtools.table.header import TooLargeError

CLEAR_MM = 1.0  # of X from the blank while Z moves
_EVERY_TURNS = 5
_APART_MM = 0.02  # a break that the nose shifts from the end of a band is nearer
_LEAST_FEED_NM = MIN_SPACING_NM // _EVERY_TURNS + 1  # of the station, with a knot in five turns
_FEEDS = sorted(range(-40, 41), key=abs)  # of the station that are tried, powers of 1.1


class Step(NamedTuple):
    """A pass over a band."""

    band: int
    low_mm: float
    high_mm: float
    allowance_mm: float
    turns: int  # between the ends of the band

    @property
    def feed_mm(self) -> float:
        """Return the feed per turn."""
        return (self.high_mm - self.low_mm) / self.turns

    @property
    def run_mm(self) -> float:
        """Return how far beyond the band Z stands: what it takes to gather the feed."""
        return self.feed_mm * _EVERY_TURNS / 2


def _fives(turns: float) -> int:
    """Return at least as many turns, in multiples of `_EVERY_TURNS`."""
    return _EVERY_TURNS * max(1, ceil(turns / _EVERY_TURNS - 1e-9))


def steps_of(bands: Sequence[Band]) -> list[list[Step]]:
    """Return the passes of each band in their order."""

    def step(i: int, band: Band, own: BandPass) -> Step:
        turns = _fives((band.high_mm - band.low_mm) / own.feed_mm)
        return Step(i, band.low_mm, band.high_mm, own.allowance_mm, turns)

    return [[step(i, band, own) for own in band.passes] for i, band in enumerate(bands)]


def bands_document(bands: Sequence[Band]) -> list[Json]:
    """Return bands as the gauge reads them, host_sim/part/sim_band.h, with their names."""
    return [
        {
            "name": band.name,
            "low_mm": band.low_mm,
            "high_mm": band.high_mm,
            "run_mm": min(step.run_mm for step in own),
            "allowance_mm": [step.allowance_mm for step in own],
            "feed_mm": [step.feed_mm for step in own],
        }
        for band, own in zip(bands, steps_of(bands), strict=True)
    ]


class Piece(NamedTuple):
    """Whole turns of the program."""

    step: Step
    z: Stretch
    x: Stretch | None  # without one the tool follows the surface
    to: Step | None = None  # in a move: the next pass, into whose first section U blends


@dataclass(frozen=True, eq=False)
class Program:
    """The program over the turns."""

    tips: tuple[Geometry, ...]  # what the tool's tip follows, of each band with its runs
    pieces: tuple[Piece, ...]
    feed_nm: int  # of the station per turn
    per_knot: int  # turns between two knots of X and Z
    first_nm: int  # where Z, and so the station, begins

    @property
    def turns(self) -> int:
        """Return the length."""
        last = self.pieces[-1].z
        return int(last.at + last.turns)

    @property
    def range_nm(self) -> tuple[int, int]:
        """Return the first and the last station."""
        return self.first_nm, self.first_nm + self.turns * self.feed_nm

    def turn_of(self, station_mm: Floats) -> Floats:
        """Return the turns at stations."""
        turn = (station_mm * NM_PER_MM - self.first_nm) / self.feed_nm
        return np.asarray(np.clip(turn, 0, self.turns), dtype=np.float64)

    def z(self, turn: Floats) -> Floats:
        """Return Z and two derivatives per turn [mm], shape (n, 3)."""
        return sampled([piece.z for piece in self.pieces], turn)

    def which(self, turn: Floats) -> Ints:
        """Return the number of the piece at turns."""
        starts = [piece.z.at for piece in self.pieces]
        return np.asarray(np.searchsorted(starts, turn, side="right") - 1, dtype=np.int64)

    def x(self, turn: Floats) -> Floats:
        """Return X and two derivatives per turn [mm], shape (n, 3)."""
        found, which, z = np.zeros((turn.size, 3)), self.which(turn), self.z(turn)
        for i, piece in enumerate(self.pieces):
            at = which == i
            if piece.x is not None:
                found[at] = piece.x.values(turn[at])
            elif at.any():
                tip = self.tips[piece.step.band]
                height, v, a = z[at].T
                r, slope, bend = (tip.radius_mm(height, n) for n in range(3))
                chain = [r + piece.step.allowance_mm, slope * v, bend * v**2 + slope * a]
                found[at] = np.stack(chain, axis=-1)
        return found

    def breaks_turn(self) -> Floats:
        """Return the turns at which a piece ends, or its surface has a break; both ends too."""
        found = [piece.z.at for piece in self.pieces] + [self.turns]
        for piece in self.pieces:
            if piece.x is None and piece.z.low[1] == piece.z.high[1] > 0:
                heights = self.tips[piece.step.band].breaks_mm()
                low_mm, high_mm = piece.step.low_mm + _APART_MM, piece.step.high_mm - _APART_MM
                inner = (heights > low_mm) & (heights < high_mm)
                rise = (heights[inner] - piece.z.low[0]) / piece.z.low[1]
                found += (piece.z.at + rise).tolist()
        return np.unique(found)

    def geometry(self) -> "StationGeometry":
        """Return what a table over the station follows."""
        tip, ends = self.tips[0], np.array(self.range_nm) / NM_PER_MM
        own = {member.name: getattr(tip, member.name) for member in fields(Geometry)}
        own |= {"z_first_mm": float(ends[0]), "z_last_mm": float(ends[1]), "gauge_mm": None}
        return StationGeometry(**own | {"surface": _StationSurface(self)}, program=self)

    def knots_turn(self) -> Floats:
        """Return the turns at the knots of X and Z."""
        return np.arange(0.0, self.turns + 1.0, self.per_knot)

    def ahead(self, turn: Floats) -> Floats:
        """Return how far Z is ahead of the station, and two derivatives per turn [mm], (n, 3)."""
        found = self.z(turn)
        found[:, 0] -= (self.first_nm + turn * self.feed_nm) / NM_PER_MM
        found[:, 1] -= self.feed_nm / NM_PER_MM
        return found

    @property
    def fits(self) -> bool:
        """Whether a table holds the program."""
        n_knots, spacing_nm = self.turns // self.per_knot + 1, self.per_knot * self.feed_nm
        is_short = n_knots <= MAX_SLICES and max(map(abs, self.range_nm)) <= MAX_HEIGHT_NM
        if not is_short or spacing_nm < MIN_SPACING_NM:
            return False
        try:
            return bool(self.x_channel and self.way_channel)
        except TooLargeError:
            return False

    @cached_property
    def x_channel(self) -> Channel:
        """Return X over the station."""
        exact = self.x(self.knots_turn()) * NM_PER_MM
        return over_turns(KIND_X, exact, 1 / self.per_knot, self.range_nm)

    @cached_property
    def way_channel(self) -> Channel:
        """Return how far Z is ahead of the station."""
        exact = self.ahead(self.knots_turn())
        exact[0, 0] = 0.0  # but for the rounding of the first station
        return over_turns(KIND_WAY, exact * NM_PER_MM, 1 / self.per_knot, self.range_nm)


Ends = tuple[tuple[float, float], tuple[float, float]]  # value and slope per turn


def _turns_for(size_mm: float, feed_mm: float) -> int:
    """Return the turns in which X or Z moves by a length."""
    turns = count(_EVERY_TURNS, _EVERY_TURNS)
    spacing_mm = _EVERY_TURNS * feed_mm
    return next(n for n in turns if is_gentle(abs(size_mm), n, feed_mm, spacing_mm))


def _pieces(
    steps: Sequence[Step], tips: Sequence[Geometry], clear_mm: float, feed_mm: float
) -> tuple[Piece, ...]:
    """Return the program of passes, with X clear at a radius and the feed of the station [mm]."""
    made: list[Piece] = []

    def add(step: Step, turns: int, z: Ends, x: Ends | None = None, to: Step | None = None) -> None:
        at = made[-1].z.at + made[-1].z.turns if made else 0
        made.append(Piece(step, Stretch(at, turns, *z), x and Stretch(at, turns, *x), to))

    clear, (lowest_mm, highest_mm) = (clear_mm, 0.0), _ends_mm(steps)
    for step, after in zip(steps, [*steps[1:], None], strict=True):
        low, high = (step.low_mm, step.feed_mm), (step.high_mm, step.feed_mm)
        below, above = (step.low_mm - step.run_mm, 0.0), (step.high_mm + step.run_mm, 0.0)
        tip, stock_mm = tips[step.band], step.allowance_mm
        x_in, x_off = ((float(tip.radius_mm(z)) + stock_mm, 0.0) for z, _ in (below, above))
        if made:
            add(step, _turns_for(clear_mm - x_in[0], feed_mm), (below, below), (clear, x_in))
        elif lowest_mm < below[0]:
            add(step, _EVERY_TURNS, ((lowest_mm, 0.0), below))
        add(step, _EVERY_TURNS, (below, low))
        add(step, step.turns, (low, high))
        add(step, _EVERY_TURNS, (high, above))
        if after is not None:
            to = after.low_mm - after.run_mm, 0.0
            add(step, _turns_for(clear_mm - x_off[0], feed_mm), (above, above), (x_off, clear))
            moves = _turns_for(abs(to[0] - above[0]), feed_mm)
            add(step, moves, (above, to), (clear, clear), after)
        elif highest_mm > above[0]:
            add(step, _EVERY_TURNS, (above, (highest_mm, 0.0)))
    return tuple(made)


def _ends_mm(steps: Sequence[Step]) -> tuple[float, float]:
    """Return the lowest and the highest place of Z."""
    lows, highs = zip(*((s.low_mm - s.run_mm, s.high_mm + s.run_mm) for s in steps), strict=True)
    return min(lows), max(highs)


def _tip(geometry: Geometry, band: Band, run_mm: float, tool: Tool) -> Geometry:
    """Return what the tip follows in a band and its runs."""
    own = replace(geometry, z_first_mm=band.low_mm, z_last_mm=band.high_mm)
    return tip_geometry(with_run(own, run_mm, run_mm), tool)


_ANGLES_RAD = 2 * np.pi * np.arange(360) / 360


def _reach_mm(
    own: Geometry, other: Geometry, own_mm: float, other_mm: float, nose_mm: float
) -> float:
    """Return how far from the end of a band a nose stands clear of it, on another's surface."""
    stands = own.radius_mm(own_mm) - own.delta(_ANGLES_RAD, own_mm).delta
    edge = other.radius_mm(other_mm) - other.delta(_ANGLES_RAD, other_mm).delta
    above_mm = min(max(0.0, float((edge - stands).max())), nose_mm)
    return sqrt(above_mm * (2 * nose_mm - above_mm))


def _check_grooves(
    bands: Sequence[Band], tips: Sequence[Geometry], runs: list[float], nose_mm: float
) -> None:
    """Refuse a groove in which the tool does not stand clear of the other band."""
    for i in range(len(bands) - 1):
        low_mm, high_mm = bands[i].high_mm, bands[i + 1].low_mm
        places = (i, i + 1, low_mm, high_mm), (i + 1, i, high_mm, low_mm)
        for own, other, own_mm, other_mm in places:
            reach_mm = _reach_mm(tips[own], tips[other], own_mm, other_mm, nose_mm)
            if runs[own] + reach_mm >= high_mm - low_mm:
                problem = (
                    f"in the groove from {low_mm:g} to {high_mm:g} mm the tool runs {runs[own]:.4g}"
                    f" mm beyond {bands[own].name}"
                )
                problem += f", and its nose needs {reach_mm:.4g} mm more" if reach_mm else ""
                remedy = "feed less there, give a smaller nose or a wider groove"
                raise GeometryError("piston.land", problem, remedy)


def program_of(part: SkirtPart, geometry: Geometry, tool: Tool) -> Program:
    """Return the program of a part with lands, for a tool; `geometry` is over its heights.

    The feed of the station is the one nearest to that of the skirt which a table holds. Raises
    CamtoolsError: tracks do not meet, a groove is too narrow, or no table holds the program.
    """
    bands, by_band = part.bands, steps_of(part.bands)
    for band in bands:
        check_tracks(tool, band.passes[-1].feed_mm)
    steps = list(chain.from_iterable(by_band))
    runs = [max(step.run_mm for step in own) for own in by_band]
    tips = tuple(_tip(geometry, *own, tool) for own in zip(bands, runs, strict=True))
    _check_grooves(bands, tips, runs, tool.nose_radius_mm)
    ends = [(tip, z) for tip in tips for z in tip.breaks_mm()]
    inwards_mm = _MOST_AMPLITUDE * max(tip.deepest_mm(float(z)) for tip, z in ends)
    outer_mm = max(float(tip.radius_mm(z)) for tip, z in ends) + part.process.depth_mm
    first_nm = round(_ends_mm(steps)[0] * NM_PER_MM)
    for power in _FEEDS:
        feed_nm = round(part.process.feed_mm * NM_PER_MM * 1.1**power)
        if feed_nm < _LEAST_FEED_NM:
            continue
        pieces = _pieces(steps, tips, outer_mm + inwards_mm + CLEAR_MM, feed_nm / NM_PER_MM)
        for per_knot in (1, _EVERY_TURNS):
            program = Program(tips, pieces, feed_nm, per_knot, first_nm)
            if program.fits:
                return program
    problem = "no table holds the turns of all bands and passes"
    remedy = "give fewer passes, feeds that are more alike, or make tables of fewer bands"
    raise CamtoolsError([f"piston.land: {problem}; {remedy}"])


_MOST_AMPLITUDE = 1.25  # of the controller: amplitude_ppm


@dataclass(frozen=True, eq=False)
class _StationSurface(SkirtSurface):
    program: Program

    @property
    def log2_repeat(self) -> int:
        """See `SkirtSurface`."""
        return min(tip.surface.log2_repeat for tip in self.program.tips)

    def delta(self, phi_rad: FloatsLike, z_mm: FloatsLike) -> SectionValues:
        """See `SkirtSurface`; its section stays beyond a band, and blends in moves."""
        phi, station = np.asarray(phi_rad, dtype=np.float64), np.asarray(z_mm, dtype=np.float64)
        shape = np.broadcast_shapes(phi.shape, station.shape)
        turn = self.program.turn_of(np.broadcast_to(station, shape).ravel())
        angle = np.broadcast_to(phi, shape).ravel()
        z, which = self.program.z(turn)[:, 0], self.program.which(turn)
        found = np.zeros((4, turn.size))
        for i in np.unique(which):
            at, piece = which == i, self.program.pieces[i]
            if piece.to is None:
                found[:, at] = self._section(piece.step, angle[at], z[at])
                continue
            share = (turn[at] - piece.z.at) / piece.z.turns
            before = self._section(piece.step, angle[at], np.full(share.size, piece.step.high_mm))
            after = self._section(piece.to, angle[at], np.full(share.size, piece.to.low_mm))
            found[:, at] = (1 - share) * before + share * after
        return SectionValues(*(values.reshape(shape) for values in found))

    def _section(self, step: Step, angle: Floats, z_mm: Floats) -> Floats:
        within = np.clip(z_mm, step.low_mm, step.high_mm)
        return np.stack(self.program.tips[step.band].delta(angle, within))


@dataclass(frozen=True, eq=False)
class StationGeometry(Geometry):
    """Surface and X over the station: `z_mm` of all functions is the station."""

    program: Program = field(kw_only=True)

    def radius_mm(self, z_mm: FloatsLike | Sequence[float], derivative: int = 0) -> Floats:
        """Return X, or its derivatives by the station."""
        station = np.asarray(z_mm, dtype=np.float64)
        found = self.program.x(self.program.turn_of(station.ravel()))[:, derivative]
        return np.asarray(found.reshape(station.shape) * self._per_mm**derivative)

    def breaks_mm(self) -> Floats:
        """Return the stations where a piece of the shape ends, rising, both ends included."""
        return np.asarray(self.z_first_mm + self.program.breaks_turn() / self._per_mm)

    @property
    def _per_mm(self) -> float:
        return NM_PER_MM / self.program.feed_nm
