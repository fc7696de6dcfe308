"""From lobes to channels of integers, each as small as its tolerance allows.

>>> from camtools.lobe.motion import example_lobe, make_lobes
>>> made = choose_lift(make_lobes(example_lobe()), 10.0)
>>> made.channel.log2_knots, made.error <= 10.0
(8, True)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import make_interp_spline

from camtools.base.errors import CamtoolsError, GeometryError
from camtools.base.quantities import NM_PER_MM, Floats, Ints
from camtools.lobe.motion import ShaftLobe
from camtools.lobe.speed import N_GRID
from camtools.table.evaluate import GRID_MARGIN, PLACES, ROUNDING_LSB, evaluate_grid
from camtools.table.image import (
    ANGLE_TURN,
    KIND_CONTACT,
    KIND_SPEED,
    KIND_SWING,
    KIND_U,
    KIND_X,
    MAX_CHANNEL_BYTES,
    MAX_LOG2_KNOTS,
    MAX_RATIO,
    MAX_SLICES,
    MAX_SPACING_NM,
    MIN_RATIO,
    MIN_SPACING_NM,
    RATIO_ONE,
    Channel,
)
from camtools.table.quantise import TooLargeError, quantise, with_bounds
from camtools.table.records import KNOT_SIZE

ANGLE_TOLERANCE_DEG = 1e-4
_RATIO_TOLERANCE = 1e-5
_FEWEST_LOG2 = 6
_KEPT_OFF_NM = 20_000  # a tenth of the narrowest gap
_LONGEST_NM = 2_000_000_000  # heights are -1000 .. 1000 mm
_GAPS_MM = np.unique(np.ceil(np.geomspace(0.2, 1000, 120) * 10) / 10)  # that a refusal tries
_NAMES = {KIND_U: "u", KIND_SPEED: "speed", KIND_SWING: "swing", KIND_CONTACT: "contact"}
_UNIT_PER_DEG = ANGLE_TURN / 360

Function = Callable[[ShaftLobe, Floats], tuple[Floats, Floats, Floats]]


class MadeChannel(NamedTuple):
    """A channel and its largest error against the exact function, the firmware's included."""

    channel: Channel
    error: float  # nm, degrees, or 1 for speeds


def range_of(lobes: list[ShaftLobe]) -> tuple[int, int]:
    """Return the heights of the shaft from the first to the last lobe [nm]."""
    return round(lobes[0].z_mm[0] * NM_PER_MM), round(lobes[-1].z_mm[1] * NM_PER_MM)


def _edges(lobes: list[ShaftLobe]) -> Ints:
    """Return where lobes begin and end above the first one [nm], shape (lobes, 2)."""
    rounded = [[round(z * NM_PER_MM) for z in lobe.z_mm] for lobe in lobes]
    edges = np.array(rounded, dtype=np.int64)
    return np.asarray(edges - edges[0, 0])


def _counts(edges: Ints, most: int) -> Ints:
    """Return the numbers of slices whose spacing the format allows, up to the most."""
    span = int(edges[-1, 1])
    fewest = max(2, -(-span // MAX_SPACING_NM) + 1)
    return np.arange(fewest, min(span // MIN_SPACING_NM + 1, most) + 1)


def _slice_edges(edges: Ints, counts: Ints) -> tuple[Ints, Ints]:
    """Return first and last slice that each lobe needs, shape (counts, lobes)."""
    span = edges[-1, 1]
    kept = np.clip(edges + np.array([-_KEPT_OFF_NM, _KEPT_OFF_NM]), 0, span)
    steps = (counts - 1)[:, None]
    return kept[:, 0] * steps // span, -(-kept[:, 1] * steps // span)


def _in_gaps(edges: Ints, counts: Ints) -> npt.NDArray[np.bool_]:
    """Return whether slices change over inside each gap, shape (counts, gaps)."""
    low, high = _slice_edges(edges, counts)
    return low[:, 1:] > high[:, :-1]


def slices_of(lobes: list[ShaftLobe]) -> Ints:
    """Return the lobe of each slice: the fewest slices whose changes all lie in the gaps.

    They keep off the lobes by 20 um: where lobes change, an error of Z is one of U, many times.

    Raises
    ------
    GeometryError
        The format has not as many: narrow gaps on a long shaft.
    """
    edges = _edges(lobes)
    counts = _counts(edges, MAX_SLICES)
    enough = counts[_in_gaps(edges, counts).all(axis=1)]
    if not enough.size:
        problem = f"there is none of {counts[0]} .. {counts[-1]} slices that fits"
        raise _refusal(lobes, MAX_SLICES, problem, [])
    first, _ = _slice_edges(edges, enough[:1])
    return np.searchsorted(first[0], np.arange(enough[0]), side="right") - 1


def _apart(edges: Ints, gap_nm: int) -> Ints:
    """Return lobes moved upwards until every gap is as wide as this."""
    missing = np.maximum(gap_nm - (edges[1:, 0] - edges[:-1, 1]), 0)
    return np.asarray(edges + np.append(0, np.cumsum(missing))[:, None])


def _wide_gap_mm(edges: Ints, most: int) -> float | None:
    """Return a width of every gap with which so many slices would do, where there is one."""
    for gap_mm in _GAPS_MM:
        wider = _apart(edges, round(gap_mm * NM_PER_MM))
        if wider[-1, 1] > _LONGEST_NM:
            break
        if _in_gaps(wider, _counts(wider, most)).all(axis=1).any():
            return float(gap_mm)
    return None


def _most_for_angle(lobes: list[ShaftLobe]) -> int:
    """Return how many slices the channel of the angle may have: it needs the most knots."""
    for log2_knots in range(_FEWEST_LOG2, MAX_LOG2_KNOTS):
        made = _measured(KIND_CONTACT, _angle, lobes, log2_knots)
        if made is not None and made.error <= ANGLE_TOLERANCE_DEG * _UNIT_PER_DEG:
            return MAX_CHANNEL_BYTES // (KNOT_SIZE << log2_knots)
    return MAX_CHANNEL_BYTES // (KNOT_SIZE << MAX_LOG2_KNOTS)


def _refusal(lobes: list[ShaftLobe], most: int, problem: str, remedies: list[str]) -> GeometryError:
    """Return the refusal of a shaft that needs more slices than there may be."""
    edges, most = _edges(lobes), min(most, _most_for_angle(lobes))
    counts = _counts(edges, most)
    if len(lobes) == 1 or not counts.size:
        longest_mm = (most - 1) * MAX_SPACING_NM // 1000 / 1000
        remedy = " or ".join([f"make tables of pieces of at most {longest_mm:g} mm", *remedies])
        problem = f"reaches over {int(edges[-1, 1]) / NM_PER_MM:.7g} mm, {problem}"
        return GeometryError("cam.lobe", problem, remedy)
    i = int(_in_gaps(edges, counts).mean(axis=0).argmin())
    gap_mm, wide_mm = (edges[i + 1, 0] - edges[i, 1]) / NM_PER_MM, _wide_gap_mm(edges, most)
    wider = [] if wide_mm is None else [f"make every gap at least {wide_mm:g} mm wide"]
    remedy = " or ".join([*wider, "make tables of fewer lobes each", *remedies])
    problem = f"with a gap of {gap_mm:.7g} mm above cam.lobe.{i} {problem}"
    return GeometryError(f"cam.lobe.{i + 1}.z_mm", problem, remedy)


def _knots(function: Function, lobes: list[ShaftLobe], log2_knots: int) -> Floats:
    h = 2 * np.pi / (1 << log2_knots)
    phi = h * np.arange(1 << log2_knots, dtype=np.float64)
    triples = [function(lobe, phi) for lobe in lobes]
    return np.stack([np.stack([y, h * y1, h**2 / 2 * y2], axis=-1) for y, y1, y2 in triples])


def _off(function: Function, lobe: ShaftLobe, alone: Channel) -> float:
    """Return the largest difference in units of a channel of one lobe, on a dense grid."""
    n = alone.knots.shape[1]
    phi = ((np.arange(n)[:, None] + PLACES).ravel() / n) * 2 * np.pi
    got = evaluate_grid(alone, np.array([float(alone.z_first_nm)]), PLACES).value[0]
    return float(np.abs(got - function(lobe, phi)[0]).max())


def _error(function: Function, lobes: list[ShaftLobe], channel: Channel) -> float:
    """Return the largest error in units of the channel, which has one slice for each lobe."""
    alone = (replace(channel, knots=channel.knots[[i, i]]) for i in range(len(lobes)))
    largest = max(_off(function, *one) for one in zip(lobes, alone, strict=True))
    return GRID_MARGIN * largest + ROUNDING_LSB * channel.lsb


def _measured(
    kind: int, function: Function, lobes: list[ShaftLobe], log2_knots: int
) -> MadeChannel | None:
    """Return a channel of one slice for each lobe, where the format holds it."""
    try:
        channel = quantise(kind, _knots(function, lobes, log2_knots), 0, range_of(lobes))
    except TooLargeError:
        return None
    return MadeChannel(channel, _error(function, lobes, channel))


def _too_large(
    kind: int, lobes: list[ShaftLobe], log2_knots: int, best: MadeChannel | None
) -> GeometryError:
    """Return the refusal of a channel of more bytes than there may be."""
    n, size = slices_of(lobes).size, KNOT_SIZE << log2_knots
    remedies = ['set process.speed = "uniform"'] if kind == KIND_SPEED else []
    if kind == KIND_U and best is not None and n <= _most_for_angle(lobes):
        remedies = [f"ask for a tolerance_nm of at least {best.error * 1.05:.2g}"]
    problem = (
        f"the {_NAMES[kind]} channel needs {n} slices of {1 << log2_knots} knots, "
        f"{n * size} bytes, and may have {MAX_CHANNEL_BYTES}"
    )
    return _refusal(lobes, MAX_CHANNEL_BYTES // size, problem, remedies)


def _chosen(
    kind: int, function: Function, lobes: list[ShaftLobe], tolerance: float
) -> MadeChannel | None:
    """Return the channel of the lobes that `_smallest` takes; none where the format has none."""
    n_slices, best = slices_of(lobes).size, None
    for log2_knots in range(_FEWEST_LOG2, MAX_LOG2_KNOTS + 1):
        made = _measured(kind, function, lobes, log2_knots)
        if made is None:
            continue
        fits = n_slices * KNOT_SIZE << log2_knots <= MAX_CHANNEL_BYTES
        is_last = best is None and log2_knots == MAX_LOG2_KNOTS
        if not fits and (is_last or made.error <= tolerance):
            raise _too_large(kind, lobes, log2_knots, best)
        if fits and (best is None or made.error < best.error):
            best = made
        if made.error <= tolerance:
            break
    return best


def _smallest(
    kind: int, function: Function, lobes: list[ShaftLobe], tolerance: float
) -> MadeChannel:
    """Return the smallest channel within a tolerance, or the best one there is."""
    best = _chosen(kind, function, lobes, tolerance)
    if best is None:
        raise CamtoolsError([f"cam.lobe: channel {kind} does not fit the format; give less lift"])
    channel = with_bounds(best.channel)
    return MadeChannel(replace(channel, knots=channel.knots[slices_of(lobes)]), best.error)


def _lift(lobe: ShaftLobe, phi_rad: Floats) -> tuple[Floats, Floats, Floats]:
    """Return u [nm]: minus the lift (TABLE_FORMAT.md, Lobes)."""
    path = lobe.at(phi_rad)
    return -path.lift * NM_PER_MM, -path.d1 * NM_PER_MM, -path.d2 * NM_PER_MM


def _angle(lobe: ShaftLobe, phi_rad: Floats) -> tuple[Floats, Floats, Floats]:
    path, unit = lobe.at(phi_rad), ANGLE_TURN / (2 * np.pi)
    return path.angle * unit, path.angle1 * unit, path.angle2 * unit


def choose_lift(lobes: list[ShaftLobe], tolerance_nm: float) -> MadeChannel:
    """Return the smallest u channel within a tolerance; error in nm.

    Raises
    ------
    CamtoolsError
        Out of reach; the message has the best that is possible.
    """
    made = _smallest(KIND_U, _lift, lobes, tolerance_nm)
    if made.error > tolerance_nm:
        best = f"unreachable for u, best achievable is {made.error:.3g} nm"
        remedy = f"ask for at least {made.error * 1.05:.2g} nm"
        raise CamtoolsError([f"tolerance_nm = {tolerance_nm:g}: {best}; {remedy}"])
    return made


def choose_angle(lobes: list[ShaftLobe], *, is_swung: bool) -> MadeChannel:
    """Return the smallest channel of swing or contact within 1e-4 degrees; error in degrees.

    Raises
    ------
    CamtoolsError
        Out of reach; the message has the best that is possible.
    """
    kind = KIND_SWING if is_swung else KIND_CONTACT
    made = _smallest(kind, _angle, lobes, ANGLE_TOLERANCE_DEG * _UNIT_PER_DEG)
    error_deg = made.error / _UNIT_PER_DEG
    if error_deg > ANGLE_TOLERANCE_DEG:
        problem = f"the angle of the contact changes too fast, {error_deg:.2g} degrees are left"
        raise CamtoolsError([f"cam.lobe: {problem}; give a lift with less jerk"])
    return MadeChannel(made.channel, error_deg)


def centre_channel(lobes: list[ShaftLobe]) -> Channel:
    """Return the x channel: distance of the follower's centre on the base circle."""
    knots = np.zeros((slices_of(lobes).size, 1, 3))
    knots[..., 0] = (lobes[0].base_mm + lobes[0].follower_mm) * NM_PER_MM
    return with_bounds(quantise(KIND_X, knots, 0, range_of(lobes)))


def speed_channel(lobes: list[ShaftLobe], laws: list[Floats], mean_rad_s: float) -> MadeChannel:
    """Return the channel of speed ratios; error of the ratio.

    Parameters
    ----------
    laws : list of ndarray, shape (N_GRID,)
        Speed of the spindle over the spindle's angle, for each lobe [rad/s].
    mean_rad_s : float
        What the ratios refer to.

    Raises
    ------
    GeometryError
        Ratios beyond what a table holds.
    """
    low, high = (float(f(np.stack(laws))) / mean_rad_s for f in (np.min, np.max))
    if low < MIN_RATIO / RATIO_ONE or high > MAX_RATIO / RATIO_ONE:
        problem = f"needs {low:.4g} .. {high:.4g} times the mean speed, a table holds 1/16 .. 4"
        raise GeometryError("process.speed", problem, 'use "uniform", or a smaller wheel')
    x = 2 * np.pi * np.arange(N_GRID + 1) / N_GRID
    splines = {
        id(lobe): make_interp_spline(x, np.append(law, law[0]), k=5, bc_type="periodic")
        for lobe, law in zip(lobes, laws, strict=True)
    }

    def ratio(lobe: ShaftLobe, phi_rad: Floats) -> tuple[Floats, Floats, Floats]:
        unit, spline = RATIO_ONE / mean_rad_s, splines[id(lobe)]
        y, y1, y2 = (np.asarray(spline(phi_rad, nu=n)) * unit for n in range(3))
        return y, y1, y2

    made = _smallest(KIND_SPEED, ratio, lobes, _RATIO_TOLERANCE * RATIO_ONE)
    return MadeChannel(made.channel, made.error / RATIO_ONE)
