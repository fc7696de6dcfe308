"""The speed-ratio channel of a part that is turned with an even removal rate.

>>> from camtools.skirt.part.part_file import example_part
>>> from camtools.skirt.geometry.skirt_geometry import make_geometry
>>> load = load_at(make_geometry(example_part()), 46.1, 20.0)
>>> f"{load.area_mm2[0]:.6f} {load.area_mm2[N_GRID // 2]:.6f}"
'4.605000 9.200000'
"""

from math import ceil
from typing import NamedTuple

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import NM_PER_MM, Floats, omega_rad_s
from camtools.cut.feasibility import tenth_below
from camtools.cut.speed_law import (
    N_GRID,
    InfeasibleError,
    Law,
    Load,
    SpeedLimits,
    full_mean_rad_s,
    largest_partial,
    optimise,
    uniform,
)
from camtools.cut.spindle_loop import SpindleLoop, played_ripple
from camtools.part.common import MachineLimits
from camtools.skirt.geometry.skirt_geometry import Geometry, blank_radius_mm
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.table.accuracy import height_range_nm
from camtools.skirt.tool.turning import turning_at
from camtools.table.channel import KIND_SPEED, MAX_SPACING_NM, RATIO_ONE, Channel
from camtools.table.evaluate import MotionPeaks, evaluate_at, knot_interval, peaks_together
from camtools.table.header import quantise, slice_heights_mm, with_bounds

_LOG2_KNOTS = 7  # per pattern: the table is within 1e-6 of laws of 32 control points
_SLICES = 17


class SpeedTable(NamedTuple):
    """A speed channel and what it is worth."""

    channel: Channel
    z_mm: Floats  # heights of the slices
    laws: tuple[Law, ...]  # of each slice
    played: Floats  # ripple of each as the spindle plays it
    partial: tuple[Law, ...]  # MATHS.md (26), for comparison
    full_mean_rpm: float  # up to here the rate can be kept constant
    uniform_rpm: float  # highest speed at which the part can be turned uniformly
    peaks: MotionPeaks


def load_at(geometry: Geometry, blank_mm: float, z_mm: float) -> Load:
    """Return the section at a height as a load of the spindle."""
    pattern_rad = 2 * np.pi / (1 << geometry.surface.log2_repeat)
    u = geometry.delta(pattern_rad * np.arange(N_GRID) / N_GRID, z_mm)
    rho = float(geometry.radius_mm(z_mm)) - u.delta
    return Load((blank_mm - rho) * (blank_mm + rho) / 2, u.d1, u.d2, pattern_rad)


def limits_of(limits: MachineLimits) -> SpeedLimits:
    """Return a part's limits as the speed law takes them."""
    return SpeedLimits(
        limits.alpha_rad_s2,
        omega_rad_s(limits.spindle_rpm),
        limits.u_speed_mm_s,
        limits.u_acceleration_mm_s2,
        limits.spindle_bandwidth_rad_s,
    )


def loop_of(limits: MachineLimits) -> SpindleLoop:
    """Return a part's spindle as it plays a law."""
    return SpindleLoop(
        limits.spindle_bandwidth_rad_s,
        limits.alpha_rad_s2,
        omega_rad_s(limits.spindle_rpm),
        limits.spindle_ripple,
        1 / limits.tick_hz,
    )


def _channel(laws: list[Law], range_nm: tuple[int, int], repeat: int) -> Channel:
    h = 2 * np.pi / (1 << (_LOG2_KNOTS + repeat))
    phi = h * np.arange(1 << _LOG2_KNOTS, dtype=np.float64)
    triple = [
        np.stack([law.ratio(phi, n) * h**n / max(1, n) for n in range(3)], axis=-1) for law in laws
    ]
    return with_bounds(quantise(KIND_SPEED, np.stack(triple) * RATIO_ONE, repeat, range_nm))


def make_speed(part: SkirtPart, geometry: Geometry, u: Channel, uniform_rpm: float) -> SpeedTable:
    """Return the speed channel of least ripple for a part, at its own mean speed.

    The highest speed of uniform turning is for comparison. Raises CamtoolsError: uniform speed is
    beyond a limit already, or the rate ripples by more than is accepted.
    """
    range_nm = height_range_nm(geometry)
    n = max(_SLICES, ceil((range_nm[1] - range_nm[0]) / MAX_SPACING_NM) + 1)
    z_mm = np.clip(slice_heights_mm(range_nm, n), *geometry.skirt_mm)  # held while it runs in
    limits, mean = limits_of(part.machine.limits), omega_rad_s(part.process.spindle_rpm)
    loop = loop_of(part.machine.limits)
    blank_mm = blank_radius_mm(geometry, part.process.depth_mm)
    loads = [load_at(geometry, blank_mm, float(z)) for z in z_mm]
    laws = [optimise(load, limits, mean) for load in loads]
    channel = _channel(laws, range_nm, geometry.surface.log2_repeat)
    made = SpeedTable(
        channel,
        z_mm,
        tuple(laws),
        played_ripple(laws, mean, loop),
        tuple(largest_partial(load, limits, mean) for load in loads),
        min(full_mean_rad_s(load, limits) for load in loads) * 60 / (2 * np.pi),
        uniform_rpm,
        peaks_together(u, channel),
    )
    check_ripple(made, part)
    return made


def check_ripple(speed: SpeedTable, part: SkirtPart) -> None:
    """Refuse a part whose removal rate will ripple by more than its file accepts."""
    most, worst = part.process.ripple_percent, float(speed.played.max())
    if most is None or 100 * worst <= most:
        return
    load = speed.laws[worst_of(speed)].load
    rpm = highest_rpm_for(load, part.machine.limits, most / 100)
    problem = f"at mean {part.process.spindle_rpm:g} r/min this spindle makes {100 * worst:.2f} %"
    remedy = f"process.spindle_rpm may be at most {tenth_below(rpm)} r/min"
    if rpm == 0:
        remedy = "at no speed it makes less: the ripple of the spindle itself is too large"
    raise CamtoolsError([f"process.ripple_percent = {most:g}: {problem}; {remedy}"])


def highest_rpm_for(load: Load, limits: MachineLimits, ripple: float) -> float:
    """Return the highest mean speed at which the rate, as played, ripples by at most a share.

    It is searched by halving to a thousandth, 0 where there is none [r/min].
    """
    low, high = 0.0, limits.spindle_rpm
    while high - low > 1e-3 * high and high > 1e-3:
        middle = (low + high) / 2
        try:
            law = optimise(load, limits_of(limits), omega_rad_s(middle))
            is_kept = played_ripple([law], omega_rad_s(middle), loop_of(limits))[0] <= ripple
        except InfeasibleError:
            is_kept = False
        low, high = (middle, high) if is_kept else (low, middle)
    return low


def motion_played(
    geometry: Geometry, mean_rpm: float, z_mm: float, turns: Floats, speed: Channel | None
) -> tuple[Floats, Floats, Floats]:
    """Return U [mm], its velocity and acceleration at turns of the drawing's angle at a height.

    Without a speed channel the spindle turns uniformly.
    """
    wanted = turning_at(geometry, mean_rpm, z_mm, turns)
    velocity, acceleration = wanted.velocity_mm_s, wanted.acceleration_mm_s2
    if speed is not None:
        law = evaluate_at(speed, turns, np.full(turns.size, z_mm * NM_PER_MM))
        ratio, slope = law.value / RATIO_ONE, law.d1 / RATIO_ONE
        alpha = ratio * slope * omega_rad_s(mean_rpm)
        acceleration = acceleration * ratio**2 + velocity * alpha  # MATHS.md (25)
        velocity = velocity * ratio
    return wanted.u_mm, velocity, acceleration


def worst_of(speed: SpeedTable) -> int:
    """Return the index of the height with the largest ripple."""
    return int(np.argmax(speed.played))


def summary_of(speed: SpeedTable, part: SkirtPart) -> dict[str, object]:
    """Return what modulation brings, as JSON values."""
    worst = worst_of(speed)
    turns = part.height_mm / part.process.feed_mm
    rpm = part.process.spindle_rpm
    return {
        "mean_spindle_rpm": float(rpm),
        "ripple_uniform": uniform(speed.laws[worst].load).ripple,
        "ripple_partial": speed.partial[worst].ripple,
        "partial_share": speed.partial[worst].share,
        "ripple": float(speed.played[worst]),
        "ripple_of_the_law": speed.laws[worst].ripple,
        "height_mm": float(speed.z_mm[worst]),
        "full_modulation_up_to_rpm": speed.full_mean_rpm,
        "ratio_max": speed.peaks.ratio,
        "spindle_acceleration_rad_s2": speed.peaks.spindle_rad2 * omega_rad_s(rpm) ** 2,
        "time_per_part_s": turns * 60 / rpm,
        "uniform_highest_rpm": speed.uniform_rpm,
        "time_uniform_at_highest_speed_s": turns * 60 / speed.uniform_rpm,
        "bytes": speed.channel.size,
        "knot_interval_deg": float(np.degrees(knot_interval(speed.channel))),
    }
