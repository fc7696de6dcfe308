"""From lobes to channels of integers, each as small as its tolerance allows.

>>> from camtools.cam_motion import example_cam, make_lobes
>>> made = choose_lift(make_lobes(example_cam()), 10.0)
>>> made.channel.log2_knots, made.error <= 10.0
(8, True)
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy.interpolate import make_interp_spline

from camtools.accuracy import GRID_MARGIN, PLACES, ROUNDING_LSB
from camtools.cam_motion import ShaftLobe
from camtools.cam_speed import N_GRID
from camtools.errors import CamtoolsError, GeometryError
from camtools.evaluate import evaluate_u_grid
from camtools.geometry import NM_PER_MM
from camtools.image import (
    ANGLE_TURN,
    KIND_CONTACT,
    KIND_SPEED,
    KIND_SWING,
    KIND_U,
    KIND_X,
    MAX_LOG2_KNOTS,
    MAX_RATIO,
    MAX_SPACING_NM,
    MIN_RATIO,
    MIN_SPACING_NM,
    RATIO_ONE,
    Channel,
    Ints,
)
from camtools.part_cam import MOST_SLICES
from camtools.quantise import TooLargeError, quantise, with_bounds
from camtools.sections import Floats

ANGLE_TOLERANCE_DEG = 1e-4
_RATIO_TOLERANCE = 1e-5
_FEWEST_LOG2 = 6
_KEPT_OFF_NM = 20_000  # a tenth of the narrowest gap
_UNIT_PER_DEG = ANGLE_TURN / 360

Function = Callable[[ShaftLobe, Floats], tuple[Floats, Floats, Floats]]


class Made(NamedTuple):
    """A channel and its largest error against the exact function, the firmware's included."""

    channel: Channel
    error: float  # nm, degrees, or 1 for speeds


def range_of(lobes: list[ShaftLobe]) -> tuple[int, int]:
    """Return the heights of the shaft from the first to the last lobe [nm]."""
    return round(lobes[0].z_mm[0] * NM_PER_MM), round(lobes[-1].z_mm[1] * NM_PER_MM)


def _kept_off(lobe: ShaftLobe, first_nm: int, span_nm: int) -> tuple[int, int]:
    """Return where a lobe begins and ends above the first one, with what belongs to it [nm]."""
    low, high = (round(z * NM_PER_MM) - first_nm for z in lobe.z_mm)
    return max(low - _KEPT_OFF_NM, 0), min(high + _KEPT_OFF_NM, span_nm)


def slices_of(lobes: list[ShaftLobe]) -> Ints:
    """Return the lobe of each slice: the fewest slices whose changes all lie in the gaps.

    They keep off the lobes by 20 um: where lobes change, an error of Z is one of U, many times.

    Raises
    ------
    GeometryError
        More slices would be needed than a table has: too long, or narrow gaps.
    """
    first, last = range_of(lobes)
    span = last - first
    places = [_kept_off(lobe, first, span) for lobe in lobes]
    fewest = max(2, -(-span // MAX_SPACING_NM) + 1)
    most = min(span // MIN_SPACING_NM + 1, MOST_SLICES)
    _check_extent(span, most)
    for n in range(fewest, most + 1):
        low = [z0 * (n - 1) // span for z0, _ in places]
        high = [-(-z1 * (n - 1) // span) for _, z1 in places]
        if all(behind > before for before, behind in zip(high[:-1], low[1:], strict=True)):
            return np.searchsorted(low, np.arange(n), side="right") - 1
    problem = f"none of {fewest} .. {most} slices of equal height change over inside every gap"
    raise GeometryError("cam.lobe", problem, "make gaps wider, or tables of fewer lobes each")


def _check_extent(span_nm: int, most: int) -> None:
    """Refuse shafts that no gaps would help."""
    longest_nm = (most - 1) * MAX_SPACING_NM
    if span_nm > longest_nm:
        length_mm, longest_mm = span_nm / NM_PER_MM, longest_nm // 1000 / 1000
        problem = f"reaches over {length_mm:.7g} mm, a table over at most {longest_mm:g} mm"
        raise GeometryError("cam.lobe", problem, "make tables of shorter pieces of the shaft")


def _knots(function: Function, lobes: list[ShaftLobe], log2_knots: int) -> Floats:
    h = 2 * np.pi / (1 << log2_knots)
    phi = h * np.arange(1 << log2_knots, dtype=np.float64)
    triples = [function(lobe, phi) for lobe in lobes]
    return np.stack([np.stack([y, h * y1, h**2 / 2 * y2], axis=-1) for y, y1, y2 in triples])


def _error(function: Function, lobes: list[ShaftLobe], slices: Ints, channel: Channel) -> float:
    """Return the largest error in units of the channel, on a dense grid off the knots."""
    n = channel.knots.shape[1]
    phi = ((np.arange(n)[:, None] + PLACES).ravel() / n) * 2 * np.pi
    step = (channel.z_last_nm - channel.z_first_nm) / (channel.n_slices - 1)
    first = np.searchsorted(slices, np.arange(len(lobes)))
    z_nm = np.asarray(channel.z_first_nm + step * first, dtype=np.float64)
    got = evaluate_u_grid(channel, z_nm, PLACES).value
    exact = np.stack([function(lobe, phi)[0] for lobe in lobes])
    return GRID_MARGIN * float(np.abs(got - exact).max()) + ROUNDING_LSB * channel.lsb_nm


def _smallest(kind: int, function: Function, lobes: list[ShaftLobe], tolerance: float) -> Made:
    """Return the smallest channel within a tolerance, or the best one there is."""
    slices, best = slices_of(lobes), None
    for log2_knots in range(_FEWEST_LOG2, MAX_LOG2_KNOTS + 1):
        try:
            knots = _knots(function, lobes, log2_knots)[slices]
            channel = quantise(kind, knots, 0, range_of(lobes))
        except TooLargeError:
            continue
        made = Made(with_bounds(channel), _error(function, lobes, slices, channel))
        best = made if best is None or made.error < best.error else best
        if made.error <= tolerance:
            return made
    if best is None:
        raise CamtoolsError([f"cam.lobe: channel {kind} does not fit the format; give less lift"])
    return best


def _lift(lobe: ShaftLobe, phi_rad: Floats) -> tuple[Floats, Floats, Floats]:
    """Return u [nm]: minus the lift (TABLE_FORMAT.md, Cams)."""
    path = lobe.at(phi_rad)
    return -path.lift * NM_PER_MM, -path.d1 * NM_PER_MM, -path.d2 * NM_PER_MM


def _angle(lobe: ShaftLobe, phi_rad: Floats) -> tuple[Floats, Floats, Floats]:
    path, unit = lobe.at(phi_rad), ANGLE_TURN / (2 * np.pi)
    return path.angle * unit, path.angle1 * unit, path.angle2 * unit


def choose_lift(lobes: list[ShaftLobe], tolerance_nm: float) -> Made:
    """Return the smallest u channel within a tolerance; error in nm.

    Raises
    ------
    CamtoolsError
        Out of reach; tells what can be had.
    """
    made = _smallest(KIND_U, _lift, lobes, tolerance_nm)
    if made.error > tolerance_nm:
        best = f"unreachable for u, best achievable is {made.error:.3g} nm"
        remedy = f"ask for at least {made.error * 1.05:.2g} nm"
        raise CamtoolsError([f"tolerance_nm = {tolerance_nm:g}: {best}; {remedy}"])
    return made


def choose_angle(lobes: list[ShaftLobe], *, is_swung: bool) -> Made:
    """Return the smallest channel of swing or contact within 1e-4 degrees; error in degrees.

    Raises
    ------
    CamtoolsError
        Out of reach; tells what can be had.
    """
    kind = KIND_SWING if is_swung else KIND_CONTACT
    made = _smallest(kind, _angle, lobes, ANGLE_TOLERANCE_DEG * _UNIT_PER_DEG)
    error_deg = made.error / _UNIT_PER_DEG
    if error_deg > ANGLE_TOLERANCE_DEG:
        problem = f"the angle of the contact changes too fast, {error_deg:.2g} degrees are left"
        raise CamtoolsError([f"cam.lobe: {problem}; give a lift with less jerk"])
    return Made(made.channel, error_deg)


def centre_channel(lobes: list[ShaftLobe]) -> Channel:
    """Return the x channel: distance of the follower's centre on the base circle."""
    knots = np.zeros((slices_of(lobes).size, 1, 3))
    knots[..., 0] = (lobes[0].base_mm + lobes[0].follower_mm) * NM_PER_MM
    return with_bounds(quantise(KIND_X, knots, 0, range_of(lobes)))


def speed_channel(lobes: list[ShaftLobe], laws: list[Floats], mean_rad_s: float) -> Made:
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
    return Made(made.channel, made.error / RATIO_ONE)
