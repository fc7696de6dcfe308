"""From lobes to channels of integers, each as small as its tolerance allows.

The contact runs along the lobe by ds/dphi; N = n0 r / (ds/dphi) keeps its speed at that of the base
circle, MATHS.md (35). Where that needs more acceleration than the spindle has, the square of the
speed rises and falls along straight lines below it, MATHS.md (36): no slower than needed.

>>> ds_dphi = 20 + 10 * np.sin(np.arange(N_GRID) * 2 * np.pi / N_GRID)
>>> law = surface_speed(ds_dphi, 20.0, 6.0, SpindleLimits(1e6, 1e3))
>>> bool(np.abs(law * ds_dphi / 120 - 1).max() < 1e-4)
True
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.interpolate import make_interp_spline

from camtools.base.errors import CamtoolsError, GeometryError
from camtools.base.quantities import NM_PER_MM, Floats
from camtools.lobe.lift import Listed
from camtools.lobe.motion import ShaftLobe, profiles_of
from camtools.table.channel import (
    ANGLE_TURN,
    DEG_PER_UNIT,
    KIND_CONTACT,
    KIND_SPEED,
    KIND_SWING,
    KIND_U,
    KIND_X,
    KNOT_SIZE,
    MAX_CHANNEL_BYTES,
    MAX_LOG2_KNOTS,
    MAX_RATIO,
    MAX_SPACING_NM,
    MIN_RATIO,
    RATIO_ONE,
    Channel,
    LobePlace,
    angle_in_sense,
)
from camtools.table.evaluate import (
    GRID_MARGIN,
    PLACES,
    ROUNDING_LSB,
    evaluate_grid,
    knot_interval,
    raw_bounds,
)
from camtools.table.header import TooLargeError, quantise, with_bounds

N_GRID = 1 << 15  # places of a turn
_MARGIN = 0.94  # of the acceleration: the table overshoots where straight lines meet
_TOP_MARGIN = 0.985  # of the highest speed
_COMMANDED_MARGIN = 0.992  # of the same as set-point
_COORDINATES = 1 << 15
_SMOOTHED = 8  # places over which those corners are rounded, on either side


class SpindleLimits(NamedTuple):
    """What the spindle can do."""

    alpha_rad_s2: float
    highest_rad_s: float
    bandwidth_rad_s: float = np.inf  # of its speed loop


def surface_speed(
    ds_dphi: Floats, base_mm: float, base_rad_s: float, limits: SpindleLimits
) -> Floats:
    """Return the spindle's speed [rad/s] at N_GRID angles of a turn, within the limits everywhere.

    `ds_dphi` is the travel of the contact along the profile [mm/rad], above 0, at those angles.

    The spindle accelerates by its torque, and by what its speed loop makes of a set-point between 0
    and its highest speed, MATHS.md (80). The largest function below a given one with bounded slope
    is found in one pass in each direction, twice round. Averages over a few places keep the bound
    of slope; where the speed has a corner downwards they are up to 2 % above it.
    """
    wanted = np.minimum(base_rad_s * base_mm / ds_dphi, _TOP_MARGIN * limits.highest_rad_s)
    alpha, loop = _MARGIN * limits.alpha_rad_s2, _MARGIN * limits.bandwidth_rad_s
    commanded = _COMMANDED_MARGIN * limits.highest_rad_s

    def rising(omega: Floats) -> Floats:
        return np.minimum(alpha, np.maximum(loop * (commanded - omega), 1e-9))

    def falling(omega: Floats) -> Floats:
        return np.minimum(alpha, loop * np.maximum(omega, 1e-9))

    risen = _bounded(wanted, commanded, rising)
    square = _bounded(risen[::-1], commanded, falling)[::-1] ** 2
    kernel = np.ones(2 * _SMOOTHED + 1) / (2 * _SMOOTHED + 1)
    padded = np.concatenate([square[-_SMOOTHED:], square, square[:_SMOOTHED]])
    return np.asarray(np.sqrt(np.convolve(padded, kernel, "valid")), dtype=np.float64)


def _bounded(omega_rad_s: Floats, top_rad_s: float, alpha_of: Callable[[Floats], Floats]) -> Floats:
    """Return the largest speed below another that rises as its acceleration lets it.

    The angle over which the speed rises from 0 is a coordinate in which that is a bounded slope.
    """
    omega = top_rad_s * np.arange(_COORDINATES) / _COORDINATES
    per_rad = omega / alpha_of(omega)
    angle = np.append(0.0, np.cumsum((per_rad[1:] + per_rad[:-1]) / 2)) * omega[1]
    # The largest cyclic function below the wanted angles that rises by no more than the turn does.
    wanted = np.interp(omega_rad_s, omega, angle)
    ramp = (2 * np.pi / N_GRID) * np.arange(2 * wanted.size)
    risen = (np.minimum.accumulate(np.tile(wanted, 2) - ramp) + ramp)[wanted.size :]
    return np.asarray(np.interp(risen, angle, omega), dtype=np.float64)


def acceleration_of(omega_rad_s: Floats) -> Floats:
    """Return the acceleration of the spindle [rad/s2] at N_GRID angles of a turn."""
    square = omega_rad_s**2 / 2
    return (np.roll(square, -1) - np.roll(square, 1)) * (N_GRID / (4 * np.pi))


def mean_of(omega_rad_s: Floats) -> float:
    """Return the mean speed of a turn: one turn over its time."""
    return float(1 / np.mean(1 / omega_rad_s))


ANGLE_TOLERANCE_DEG = 1e-4
_REPORTED_DEG = 0.01
_RATIO_TOLERANCE = 1e-5
_FEWEST_LOG2 = 6
_NAMES = {KIND_U: "u", KIND_SPEED: "speed", KIND_SWING: "swing", KIND_CONTACT: "contact"}

Function = Callable[[ShaftLobe, Floats], tuple[Floats, Floats, Floats]]


class MadeChannel(NamedTuple):
    """A channel and its largest error against the exact function, the firmware's included."""

    channel: Channel
    error: float  # nm, degrees, or 1 for speeds


def range_of(lobes: list[ShaftLobe]) -> tuple[int, int]:
    """Return the heights of the shaft from the first to the last lobe [nm]."""
    return round(lobes[0].z_mm[0] * NM_PER_MM), round(lobes[-1].z_mm[1] * NM_PER_MM)


def _fewest_slices(lobes: list[ShaftLobe]) -> int:
    """Return how many slices over height the format demands of the shaft."""
    first, last = range_of(lobes)
    return max(2, -(-(last - first) // MAX_SPACING_NM) + 1)


def has_patterns(lobes: list[ShaftLobe]) -> bool:
    """Return whether slices are patterns: of one lobe only where two equal slices do not reach."""
    return len(lobes) > 1 or _fewest_slices(lobes) > 2


def patterns_of(lobes: list[ShaftLobe]) -> list[ShaftLobe]:
    """Return the lobe of each slice: a profile in its own frame, or the only lobe where it is."""
    return profiles_of(lobes) if has_patterns(lobes) else lobes


def places_of(lobes: list[ShaftLobe], direction: int = 1) -> tuple[LobePlace, ...]:
    """Return the directory of lobes of the table, empty where it needs none.

    Phases count in the sense of cutting, as the angles of a table do.
    """
    if not has_patterns(lobes):
        return ()
    return tuple(
        LobePlace(
            z_first_nm=round(lobe.z_mm[0] * NM_PER_MM),
            z_last_nm=round(lobe.z_mm[1] * NM_PER_MM),
            phase_q32=round(angle_in_sense(lobe.phase_rad, direction) / (2 * np.pi) * 2**32)
            % 2**32,
            pattern=lobe.profile,
        )
        for lobe in lobes
    )


def _measured(
    kind: int, function: Function, lobes: list[ShaftLobe], log2_knots: int
) -> MadeChannel | None:
    """Return a channel of one slice for each pattern, where the format holds it."""
    patterns = patterns_of(lobes)
    try:
        h = 2 * np.pi / (1 << log2_knots)
        phi = h * np.arange(1 << log2_knots, dtype=np.float64)
        triples = [function(lobe, phi) for lobe in patterns]
        knots = np.stack([np.stack([y, h * y1, h**2 / 2 * y2], axis=-1) for y, y1, y2 in triples])
        channel = quantise(kind, knots, 0, range_of(lobes))
    except TooLargeError:
        return None
    n = channel.knots.shape[1]
    dense = ((np.arange(n)[:, None] + PLACES).ravel() / n) * 2 * np.pi
    largest = 0.0
    for i, lobe in enumerate(patterns):
        alone = replace(channel, knots=channel.knots[[i, i]])
        got = evaluate_grid(alone, np.array([float(alone.z_first_nm)]), PLACES).value[0]
        largest = max(largest, float(np.abs(got - function(lobe, dense)[0]).max()))
    error = GRID_MARGIN * largest + ROUNDING_LSB * channel.lsb
    if has_patterns(lobes):  # what rounding the phase of a lobe to 2^-32 turn moves a value by
        slope = raw_bounds(channel).first * channel.lsb / knot_interval(channel)
        error += slope * 2 * np.pi / 2**33
    return MadeChannel(channel, error)


def _too_large(kind: int, n_patterns: int, log2_knots: int) -> GeometryError:
    size = KNOT_SIZE << log2_knots
    problem = (
        f"has {n_patterns} different profiles: the {_NAMES[kind]} channel needs {1 << log2_knots} "
        f"knots of each, {n_patterns * size} bytes, and may have {MAX_CHANNEL_BYTES}"
    )
    remedy = f"make tables of at most {MAX_CHANNEL_BYTES // size} profiles each"
    uniform = ', or set process.speed = "uniform"' if kind == KIND_SPEED else ""
    return GeometryError("cam.lobe", problem, remedy + uniform)


def _chosen(
    kind: int, function: Function, lobes: list[ShaftLobe], tolerance: float
) -> MadeChannel | None:
    """Return the channel of the lobes that `_smallest` takes; none where the format has none."""
    n_slices, best = max(2, len(patterns_of(lobes))), None
    for log2_knots in range(_FEWEST_LOG2, MAX_LOG2_KNOTS + 1):
        made = _measured(kind, function, lobes, log2_knots)
        if made is None:
            continue
        fits = n_slices * KNOT_SIZE << log2_knots <= MAX_CHANNEL_BYTES
        is_last = best is None and log2_knots == MAX_LOG2_KNOTS
        if not fits and (is_last or made.error <= tolerance):
            raise _too_large(kind, n_slices, log2_knots)
        if fits and (best is None or made.error < best.error):
            best = made
        if made.error <= tolerance:
            break
    return best


def _smallest(
    kind: int, function: Function, lobes: list[ShaftLobe], tolerance: float
) -> MadeChannel:
    """Return the smallest channel within a tolerance, or the best one there is.

    A single pattern stands in both slices that the format demands.
    """
    best = _chosen(kind, function, lobes, tolerance)
    if best is None:
        raise CamtoolsError([f"cam.lobe: channel {kind} does not fit the format; give less lift"])
    channel = with_bounds(best.channel)
    knots = channel.knots if channel.n_slices > 1 else channel.knots[[0, 0]]
    return MadeChannel(replace(channel, knots=knots, has_patterns=has_patterns(lobes)), best.error)


def _lift(lobe: ShaftLobe, phi_rad: Floats) -> tuple[Floats, Floats, Floats]:
    """Return u [nm]: minus the lift (TABLE_FORMAT.md, Lobes)."""
    path = lobe.at(phi_rad)
    return -path.lift * NM_PER_MM, -path.d1 * NM_PER_MM, -path.d2 * NM_PER_MM


def _angle(lobe: ShaftLobe, phi_rad: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the angle of the contact in units of a table."""
    path, unit = lobe.at(phi_rad), ANGLE_TURN / (2 * np.pi)
    return path.angle * unit, path.angle1 * unit, path.angle2 * unit


def choose_lift(lobes: list[ShaftLobe], tolerance_nm: float) -> MadeChannel:
    """Return the smallest u channel within a tolerance; error in nm.

    Raises CamtoolsError with the best that is possible, where it is out of reach.
    """
    made = _smallest(KIND_U, _lift, lobes, tolerance_nm)
    if made.error > tolerance_nm:
        best = f"unreachable for u, best achievable is {made.error:.3g} nm"
        remedy = f"ask for at least {made.error * 1.05:.2g} nm"
        raise CamtoolsError([f"tolerance_nm = {tolerance_nm:g}: {best}; {remedy}"])
    return made


def choose_angle(lobes: list[ShaftLobe], *, is_swung: bool) -> MadeChannel:
    """Return the smallest channel of swing or contact within 1e-4 degrees; error in degrees.

    The contact of a wheel is not played but reported: where the law's acceleration steps, the best
    channel is taken. Raises CamtoolsError with the best that is possible, where it is too bad.
    """
    kind = KIND_SWING if is_swung else KIND_CONTACT
    made = _smallest(kind, _angle, lobes, ANGLE_TOLERANCE_DEG / DEG_PER_UNIT)
    error_deg = made.error * DEG_PER_UNIT
    if error_deg > (ANGLE_TOLERANCE_DEG if is_swung else _REPORTED_DEG):
        problem = f"the angle of the contact changes too fast, {error_deg:.2g} degrees are left"
        is_listed = any(isinstance(lobe.law, Listed) for lobe in lobes)
        remedy = "give a lift with less jerk" + (", of a list by smooth_um" if is_listed else "")
        raise CamtoolsError([f"cam.lobe: {problem}; {remedy}"])
    return MadeChannel(made.channel, error_deg)


def centre_channel(lobes: list[ShaftLobe]) -> Channel:
    """Return the x channel: distance of the follower's centre on the base circle."""
    knots = np.zeros((_fewest_slices(lobes), 1, 3))
    knots[..., 0] = (lobes[0].base_mm + lobes[0].follower_mm) * NM_PER_MM
    return with_bounds(quantise(KIND_X, knots, 0, range_of(lobes)))


def speed_channel(lobes: list[ShaftLobe], laws: list[Floats], mean_rad_s: float) -> MadeChannel:
    """Return the channel of speed ratios to the mean; error of the ratio.

    `laws` are the speed of the spindle [rad/s] at N_GRID angles, one for each pattern. Raises
    GeometryError where ratios are beyond what a table holds.
    """
    low, high = (float(f(np.stack(laws))) / mean_rad_s for f in (np.min, np.max))
    if low < MIN_RATIO / RATIO_ONE or high > MAX_RATIO / RATIO_ONE:
        problem = f"needs {low:.4g} .. {high:.4g} times the mean speed, a table holds 1/16 .. 4"
        raise GeometryError("process.speed", problem, 'use "uniform", or a smaller wheel')
    x = 2 * np.pi * np.arange(N_GRID + 1) / N_GRID
    splines = [
        make_interp_spline(x, np.append(law, law[0]), k=5, bc_type="periodic") for law in laws
    ]

    def ratio(lobe: ShaftLobe, phi_rad: Floats) -> tuple[Floats, Floats, Floats]:
        unit, spline = RATIO_ONE / mean_rad_s, splines[lobe.profile]
        y, y1, y2 = (np.asarray(spline(phi_rad, nu=n)) * unit for n in range(3))
        return y, y1, y2

    made = _smallest(KIND_SPEED, ratio, lobes, _RATIO_TOLERANCE * RATIO_ONE)
    return MadeChannel(made.channel, made.error / RATIO_ONE)
