"""Plunge grinding: the wheel stands in a lobe, X feeds in turn by turn and sparks out.

Every lobe takes as many turns: X comes in, falls by the infeed per turn, eases out over a turn,
stays for the spark-out, and goes off; then Z moves to the next.

>>> plan = Plan(10, 3, 4, 8, 300_000, 4, 9.5, 0.01)
>>> plan.stay_turns, plan.turns(3)
(22, 82)
>>> sampled(_pieces(plan), np.array([4.0, 5.0, 14.5, 15.0, 18.0]))[:, 0].round(6).tolist()
[0.105, 0.095, 0.000938, 0.0, 0.0]
"""

from itertools import pairwise
from math import ceil, cos, sin, sqrt
from typing import NamedTuple

import numpy as np

from camtools.base.errors import CamtoolsError, GeometryError
from camtools.base.quantities import NM_PER_MM, Floats
from camtools.cut.stretch import AHEAD_MM, Stretch, is_gentle, over_turns, sampled
from camtools.lobe.motion import ShaftLobe
from camtools.lobe.part import LobePart
from camtools.table.channel import KIND_WAY, KIND_X, MAX_SLICES, MIN_SPACING_NM, Channel
from camtools.table.header import TooLargeError

CLEAR_MM = 1.0  # between the wheel and all that stands out, while Z moves
_FEED_MM = 9.9
_LEAST_TURNS, _MOST_TURNS = 4, 400
_KNOTS = 8  # at most, of a turn


class Plan(NamedTuple):
    """The turns of a plunge cut, alike for every lobe."""

    infeed_turns: int  # with the whole infeed
    spark_turns: int
    off_turns: int  # in which X comes in, and in which it goes off
    move_turns: int  # in which Z moves to the next lobe
    feed_nm: int  # of the station per turn
    knots: int  # of a turn
    clear_mm: float  # by which X is off its last place while Z moves
    infeed_mm: float  # per turn

    @property
    def stay_turns(self) -> int:
        """Return the turns of a lobe."""
        return 2 * self.off_turns + self.infeed_turns + 1 + self.spark_turns

    def turns(self, n_lobes: int) -> int:
        """Return the turns of the whole shaft."""
        return n_lobes * self.stay_turns + (n_lobes - 1) * self.move_turns

    @property
    def first_mm(self) -> float:
        """Return the height of X above its last place where the even infeed begins."""
        return (self.infeed_turns + 0.5) * self.infeed_mm


def _pieces(plan: Plan) -> list[Stretch]:
    """Return X above its last place over the turns of a lobe [mm]."""
    ends = ((plan.clear_mm, 0.0), (plan.first_mm, -plan.infeed_mm))
    eased = (plan.infeed_mm / 2, -plan.infeed_mm)
    parts = (
        (plan.off_turns, *ends),
        (plan.infeed_turns, ends[1], eased),
        (1, eased, (0.0, 0.0)),
        (plan.spark_turns, (0.0, 0.0), (0.0, 0.0)),
        (plan.off_turns, (0.0, 0.0), ends[0]),
    )
    found, at = [], 0
    for turns, low, high in parts:
        if turns:
            found.append(Stretch(at, turns, low, high))
            at += turns
    return found


def middles_nm(lobes: list[ShaftLobe]) -> list[int]:
    """Return where Z stands in each lobe."""
    return [round((lobe.z_mm[0] + lobe.z_mm[1]) / 2 * NM_PER_MM) for lobe in lobes]


def check_width(part: LobePart) -> None:
    """Refuse a wheel that does not cover a lobe, or touches the next one."""
    width = part.cam.wheel_width_mm
    assert width is not None
    places, field = [lobe.z_mm for lobe in part.cam.lobe], f"cam.wheel_width_mm = {width:g}"
    widest = max(range(len(places)), key=lambda i: places[i][1] - places[i][0])
    needed = places[widest][1] - places[widest][0]
    if width < needed - 1e-9:
        problem = f"lobe {widest} is {needed:.6g} mm wide"
        raise GeometryError(field, problem, f"give at least {needed:.6g} mm")
    for i, (low, high) in enumerate(pairwise(places)):
        rooms = (high[0] - sum(low) / 2, sum(high) / 2 - low[1])
        k = int(np.argmin(rooms))
        if width / 2 > rooms[k] + 1e-9:
            stands, touched = (i, i + 1) if k == 0 else (i + 1, i)
            problem = (
                f"in the middle of lobe {stands} the wheel reaches {width / 2:.6g} mm to each "
                f"side, lobe {touched} begins {rooms[k]:.6g} mm away"
            )
            remedy = f"give at most {2 * rooms[k]:.6g} mm, at least {needed:.6g}"
            raise GeometryError(field, problem, remedy)


def plan_of(part: LobePart, lobes: list[ShaftLobe]) -> Plan:
    """Return the plan of a part; refuse a bad wheel, too many turns, lobes too far apart."""
    check_width(part)
    process, n = part.process, len(lobes)
    assert process.infeed_um is not None and process.stock_um is not None
    infeed = process.infeed_um / 1000
    # half an infeed is left for the turn that eases out
    turns = max(1, ceil(process.stock_um / process.infeed_um - 0.5 - 1e-9))
    phi = np.linspace(0, 2 * np.pi, 721)
    lift = max(float(lobe.at(phi).lift.max()) for lobe in lobes)
    clear = lift + (turns + 0.5) * infeed + CLEAR_MM
    z_nm = middles_nm(lobes)
    pitch = max((high - low for low, high in pairwise(z_nm)), default=0) / NM_PER_MM
    travel = (z_nm[-1] - z_nm[0]) / NM_PER_MM + AHEAD_MM
    off, move = _LEAST_TURNS, _LEAST_TURNS
    while max(off, move) <= _MOST_TURNS:
        plan = Plan(turns, process.spark_out_turns, off, move, 0, 1, clear, infeed)
        feed = min(_FEED_MM, travel / plan.turns(n))
        room = min((MAX_SLICES - 1) // plan.turns(n), int(feed * NM_PER_MM) // MIN_SPACING_NM)
        if room < 1:
            problem = f"the cut takes {plan.turns(n)} turns, more than a table holds"
            remedy = "give a larger infeed, less stock, or fewer lobes"
            raise CamtoolsError([f"process.infeed_um = {process.infeed_um:g}: {problem}; {remedy}"])
        knots = min(_KNOTS, room)
        spacing = feed / knots
        is_off = is_gentle(clear, off, feed, spacing)
        is_moved = is_gentle(pitch, move, feed, spacing)
        if is_off and is_moved:
            feed_nm = int(feed * NM_PER_MM) // knots * knots
            return plan._replace(feed_nm=feed_nm, knots=knots)
        off, move = off + (not is_off), move + (not is_moved)
    problem = f"lobes are up to {pitch:.6g} mm apart, too far for so few turns"
    raise CamtoolsError([f"cam.lobe: {problem}; give a smaller infeed, or fewer lobes"])


def stations_of(plan: Plan, lobes: list[ShaftLobe]) -> list[tuple[int, int]]:
    """Return where on the station each lobe begins and ends [nm]."""
    first, every = middles_nm(lobes)[0], (plan.stay_turns + plan.move_turns) * plan.feed_nm
    stay = plan.stay_turns * plan.feed_nm
    return [(first + i * every, first + i * every + stay) for i in range(len(lobes))]


def _channel(kind: int, plan: Plan, exact: Floats, range_nm: tuple[int, int]) -> Channel:
    """Return a channel over the station of triples per turn [nm]."""
    try:
        return over_turns(kind, exact, plan.knots, range_nm)
    except TooLargeError as error:
        problem = "lobes are too unevenly spaced, or the lift is too large"
        raise CamtoolsError([f"cam.lobe: {problem}; make tables of fewer lobes"]) from error


def _over_shaft(plan: Plan, stays: list[list[Stretch]], places: list[float]) -> Floats:
    """Return pieces of all lobes and of the moves between them, at all knots."""
    every, pieces = plan.stay_turns + plan.move_turns, []
    for i, stay in enumerate(stays):
        pieces += [piece._replace(at=piece.at + i * every) for piece in stay]
        if i + 1 < len(stays):
            ends = (places[i], 0.0), (places[i + 1], 0.0)
            pieces.append(Stretch(i * every + plan.stay_turns, plan.move_turns, *ends))
    n = plan.turns(len(stays)) * plan.knots
    return sampled(pieces, np.arange(n + 1) / plan.knots)


def x_channel(plan: Plan, part: LobePart, lobes: list[ShaftLobe]) -> Channel:
    """Return X over the station: infeed and spark-out of each lobe, with the wear of the wheel."""
    wear = part.process.wheel_wear_um_per_lobe / 1000
    bases = [lobes[0].base_mm + lobes[0].follower_mm - wear * i for i in range(len(lobes))]

    def raised(piece: Stretch, by: float) -> Stretch:
        low, high = piece.low, piece.high
        return piece._replace(low=(low[0] + by, low[1]), high=(high[0] + by, high[1]))

    stays = [[raised(piece, base) for piece in _pieces(plan)] for base in bases]
    exact = _over_shaft(plan, stays, [base + plan.clear_mm for base in bases]) * NM_PER_MM
    return _channel(KIND_X, plan, exact, _range(plan, lobes))


def way_channel(plan: Plan, lobes: list[ShaftLobe]) -> Channel:
    """Return how far Z is ahead of the station: it stands in the lobes and moves between them."""
    z_nm = [float(z) for z in middles_nm(lobes)]
    stays = [[Stretch(0, plan.stay_turns, (z, 0.0), (z, 0.0))] for z in z_nm]
    exact = _over_shaft(plan, stays, z_nm)
    exact[:, 0] -= z_nm[0] + np.arange(len(exact)) * (plan.feed_nm // plan.knots)
    exact[:, 1] -= plan.feed_nm
    return _channel(KIND_WAY, plan, exact, _range(plan, lobes))


def _range(plan: Plan, lobes: list[ShaftLobe]) -> tuple[int, int]:
    stations = stations_of(plan, lobes)
    return stations[0][0], stations[-1][1]


def left_by_wear_um(part: LobePart, lobes: list[ShaftLobe]) -> float:
    """Return a bound of what the worn wheel leaves on the last lobe, MATHS.md (120).

    X follows the radius along the line of centres, the wheel shrinks along the normal.
    """
    wear = part.process.wheel_wear_um_per_lobe / 1000 * (len(lobes) - 1)
    phi, wheel = np.linspace(0, 2 * np.pi, 7201), lobes[0].follower_mm
    widest = max(float(np.abs(lobe.at(phi).angle).max()) for lobe in lobes)
    across, along = wear * sin(widest), wear * cos(widest)
    return 1000 * (wheel - along - sqrt((wheel - wear) ** 2 - across**2))
