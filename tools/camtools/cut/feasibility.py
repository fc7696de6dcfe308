"""Whether a machine can move its axes as a table demands, and how fast.

The firmware judges by the same sums at the same places (firmware/feasible/cam_feasible_inner.h).

Along the feed U and the swing change with the slices of the table, at a speed that jumps where one
slice ends: a set-point takes the jump, and what that needs comes on top, MATHS.md (61), (63).

>>> peaks = Peaks(u_stroke_mm=0.15, u1_mm=0.15, u2_mm=0.3)
>>> from camtools.part.common import MachineLimits
>>> best = highest_speed(peaks, MachineLimits())
>>> f"{best.rpm:.0f} r/min, decided by {best.decides}"
'3000 r/min, decided by spindle_rpm'
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camtools.base.controller_limits import LIMITS
from camtools.base.errors import CamtoolsError
from camtools.base.quantities import NM_PER_MM, Floats, omega_rad_s
from camtools.base.text import Json
from camtools.part.common import MachineLimits, SwingLimits
from camtools.table.channel import Bounds, Channel
from camtools.table.evaluate import PLACES, evaluate_grid

_PLACES = np.arange(21) / 20
_STEP = _PLACES**3 * (10 - 15 * _PLACES + 6 * _PLACES**2)
_STEP1 = 30 * _PLACES**2 * (1 - _PLACES) ** 2
_STEP2 = np.abs(60 * _PLACES * (1 - _PLACES) * (1 - 2 * _PLACES))
_BETWEEN = 1.01  # what lies between two places


class Motion(NamedTuple):
    """Largest magnitudes of an axis over the angle, at the speed ratio of the table."""

    most: float  # unit
    first: float  # unit/rad: speed over the mean speed
    second: float  # unit/rad^2: acceleration over its square


FIELDS = {  # of machine.limits in a part file, by the controller's name of the limit
    "u_stroke": "u_stroke_mm",
    "spindle_speed": "spindle_rpm",
    "spindle_acceleration": "spindle_acceleration_rad_s2",
    "u_speed": "u_speed_mm_s",
    "u_acceleration": "u_acceleration_mm_s2",
    "z_speed": "z_speed_mm_s",
    "swing_range": "swing_deg",
    "swing_speed": "swing_speed_deg_s",
    "swing_acceleration": "swing_acceleration_deg_s2",
}
UNITS = {field: LIMITS[name].unit for name, field in FIELDS.items()}
_DRIFT_MARGIN = 1.015  # the firmware's bounds of it are larger by up to that
PLAN_PERIOD_S = 400e-6  # from set-point to set-point of the swing: cam_plan_period_us


class Drift(NamedTuple):
    """What an axis does because the slices of its channel change along the feed, at its peak."""

    step: float = 0.0  # per radian: speed
    twist: float = 0.0  # per radian^2: of a step that differs over the angle
    kink: float = 0.0  # per radian: the speed jumps by it where slices change

    def at(self, ratio: float) -> Drift:
        """Return it over the mean speed, of a spindle that turns faster than that by a ratio."""
        return Drift(self.step * ratio, self.twist * ratio**2, self.kink * ratio)


class Peaks(NamedTuple):
    """Guaranteed peaks of U over the table, per radian of the spindle."""

    u_stroke_mm: float  # travel, centred on u = 0 as the firmware centres it
    u1_mm: float  # mm/rad, of u' r where the spindle is modulated
    u2_mm: float  # mm/rad^2, of u'' r^2 + u' r r'
    ratio: float = 1.0  # largest speed over mean speed
    spindle_rad2: float = 0.0  # |r r'|
    swing_deg: float = 0.0  # of a tool that swings
    swing1_deg: float = 0.0  # degrees/rad
    swing2_deg: float = 0.0  # degrees/rad^2
    u_drift: Drift = Drift()  # mm
    feed_mm: float = 0.0  # per turn, of Z
    change_mm: float = 0.0  # height of the shortest change between two lobes; 0 without any


def _in_gap(motion: Motion, peaks: Peaks, n_set_points: int) -> Motion:
    """Return what an axis needs on the lobes and in the shortest change between two of them.

    Its lift falls from all to none there. One of the set-points from plan to plan takes the bend of
    all; the spindle's own acceleration is taken at its highest speed, a little more than there is.
    """
    x = peaks.ratio / (2 * np.pi * (peaks.change_mm / peaks.feed_mm))
    more1 = motion.most * x * _STEP1
    swept = 2 * motion.first * x + n_set_points * motion.most * x * peaks.spindle_rad2
    more2 = swept * _STEP1 + n_set_points * motion.most * x**2 * _STEP2
    return Motion(motion.most, _largest(motion.first, more1), _largest(motion.second, more2))


def _largest(own: float, more: Floats) -> float:
    """Return the largest sum: the share of its own at the upper end of each interval."""
    return float((own * _STEP[1:] + _BETWEEN * np.maximum(more[1:], more[:-1])).max())


class HighestSpeed(NamedTuple):
    """Highest spindle speed within all limits, and the limit that decides."""

    rpm: float
    decides: str


def peaks_of(bounds: Bounds, ratio: float = 1.0) -> Peaks:
    """Return the peaks that an image's header guarantees, in mm, with its largest speed ratio."""
    return Peaks(
        2 * max(bounds.u_max_nm, -bounds.u_min_nm) * 1e-6,
        bounds.u1_peak_nm_per_rad * 1e-6,
        bounds.u2_peak_nm_per_rad2 * 1e-6,
        ratio,
        bounds.spindle_peak_ppm_per_rad * 1e-6,
    )


def drift_of(channel: Channel, unit: float, feed_mm: float) -> Drift:
    """Return what the feed per turn adds to the motion of an axis, at uniform speed.

    `unit` is one of the channel's units in those of the result.
    """
    spacing_nm = (channel.z_last_nm - channel.z_first_nm) / (channel.n_slices - 1)
    z_nm = np.linspace(channel.z_first_nm, channel.z_last_nm, channel.n_slices)
    slices = evaluate_grid(channel, z_nm, PLACES)
    steps, slopes = np.diff(slices.value, axis=0), np.diff(slices.d1, axis=0)
    kinks = np.diff(steps, axis=0)
    per_rad = _DRIFT_MARGIN * unit * feed_mm * NM_PER_MM / (2 * np.pi * spacing_nm)
    return Drift(
        float(np.abs(steps).max()) * per_rad,
        2 * float(np.abs(slopes).max()) * per_rad,
        float(np.abs(kinks).max(initial=0.0)) * per_rad,
    )


class AxisDemand(NamedTuple):
    """What one axis needs at a mean speed omega: first * omega, second * omega^2 + kink * omega."""

    first: float
    second: float
    kink: float  # per s: taken within one set-point

    def speed(self, omega: float) -> float:
        """Return the highest speed."""
        return self.first * omega

    def acceleration(self, omega: float) -> float:
        """Return the highest acceleration."""
        return (self.second * omega + self.kink) * omega

    def omega_of_speed(self, limit: float) -> float:
        """Return at which omega the speed meets a limit."""
        return limit / self.first if self.first > 0 else float("inf")

    def omega_of_acceleration(self, limit: float) -> float:
        """Return at which omega the acceleration does."""
        root = self.kink + float(np.sqrt(self.kink**2 + 4 * self.second * limit))
        return 2 * limit / root if root > 0 else float("inf")


def _motion(
    peaks: Peaks, axis: Motion, drift: Drift, set_point_hz: float, n_set_points: int
) -> AxisDemand:
    if peaks.change_mm > 0 and peaks.feed_mm > 0:
        axis = _in_gap(axis, peaks, n_set_points)
    return AxisDemand(axis.first + drift.step, axis.second + drift.twist, drift.kink * set_point_hz)


def _plan_ticks(limits: MachineLimits) -> int:
    return max(1, round(PLAN_PERIOD_S * limits.tick_hz))


def u_motion(peaks: Peaks, limits: MachineLimits) -> AxisDemand:
    """Return what U needs, in mm."""
    axis = Motion(peaks.u_stroke_mm / 2, peaks.u1_mm, peaks.u2_mm)
    return _motion(peaks, axis, peaks.u_drift, limits.tick_hz, _plan_ticks(limits))


def swing_motion(peaks: Peaks, limits: MachineLimits) -> AxisDemand:
    """Return what the swing needs, in degrees."""
    rate_hz = limits.tick_hz / _plan_ticks(limits)
    axis = Motion(peaks.swing_deg, peaks.swing1_deg, peaks.swing2_deg)
    return _motion(peaks, axis, Drift(), rate_hz, 1)


def highest_speed(peaks: Peaks, limits: MachineLimits) -> HighestSpeed:
    """Return the highest spindle speed [r/min] at which U stays within its limits."""
    per_omega, u = 60 / (2 * np.pi), u_motion(peaks, limits)
    speeds = {
        "spindle_rpm": limits.spindle_rpm / peaks.ratio,
        "u_speed_mm_s": per_omega * u.omega_of_speed(limits.u_speed_mm_s),
        "u_acceleration_mm_s2": per_omega * u.omega_of_acceleration(limits.u_acceleration_mm_s2),
    }
    if peaks.feed_mm > 0:
        speeds["z_speed_mm_s"] = 60 * limits.z_speed_mm_s / (peaks.feed_mm * peaks.ratio)
    if peaks.spindle_rad2 > 0:
        root = np.sqrt(limits.alpha_rad_s2 / peaks.spindle_rad2)
        speeds["spindle_acceleration_rad_s2"] = float(per_omega * root)
    if isinstance(limits, SwingLimits) and peaks.swing1_deg > 0:
        swing, most = swing_motion(peaks, limits), limits.swing_acceleration_deg_s2
        speeds["swing_speed_deg_s"] = per_omega * swing.omega_of_speed(limits.swing_speed_deg_s)
        speeds["swing_acceleration_deg_s2"] = per_omega * swing.omega_of_acceleration(most)
    decides = min(speeds, key=lambda name: speeds[name])
    return HighestSpeed(speeds[decides], decides)


def needed_of(peaks: Peaks, limits: MachineLimits, omega: float) -> dict[str, float]:
    """Return what the part needs at a mean speed [rad/s], by the name of its limit."""
    u, swing = u_motion(peaks, limits), swing_motion(peaks, limits)
    return {
        "u_stroke_mm": peaks.u_stroke_mm,
        "u_speed_mm_s": u.speed(omega),
        "u_acceleration_mm_s2": u.acceleration(omega),
        "spindle_rpm": omega * 60 / (2 * np.pi) * peaks.ratio,
        "spindle_acceleration_rad_s2": peaks.spindle_rad2 * omega**2,
        "z_speed_mm_s": peaks.feed_mm * omega / (2 * np.pi) * peaks.ratio,
        "swing_deg": peaks.swing_deg,
        "swing_speed_deg_s": swing.speed(omega),
        "swing_acceleration_deg_s2": swing.acceleration(omega),
    }


def given_of(limits: MachineLimits) -> dict[str, float]:
    """Return the limits by their names; of a lathe without a swing none for it."""
    given = limits.model_dump() | {"spindle_acceleration_rad_s2": limits.alpha_rad_s2}
    return {name: float(given[name]) for name in UNITS if name in given}


def feasibility_of(peaks: Peaks, limits: MachineLimits, rpm: float, best: HighestSpeed) -> Json:
    """Return limits, what a table needs of them at a mean speed, and its highest speed."""
    given, needed = given_of(limits), needed_of(peaks, limits, omega_rad_s(rpm))
    return {
        "limits": given,
        "needed": {name: needed[name] for name in given},
        "highest_spindle_rpm": best.rpm,
        "decided_by": best.decides,
    }


def tenth_below(rpm: float) -> str:
    """Return a highest speed as text, never more than it is."""
    return f"{np.floor(rpm * 10 + 1e-6) / 10:.1f}"


def remedy_text(best: HighestSpeed, asked_rpm: float, feed_mm: float | None) -> str:
    """Return what would do: a lower speed, or where there is one a smaller feed."""
    speed = "turn more slowly"
    if best.rpm < asked_rpm:
        speed = (
            f"with these limits process.spindle_rpm = {asked_rpm:g} may be at most "
            f"{tenth_below(best.rpm)} r/min (limited by {best.decides})"
        )
    if feed_mm is None:
        return speed
    return f"{speed}, or process.feed_mm at most {np.floor(feed_mm * 1e4) / 1e4:.4f}"


def check_feasible(peaks: Peaks, limits: MachineLimits, spindle_rpm: float) -> None:
    """Refuse what a machine cannot follow without a table: the axes of an NC program.

    A table is judged by the controller's own rule, `camtools.cut.verdict`. CamtoolsError has one
    line for each limit exceeded: needed, limit, highest speed that would do.
    """
    remedy = remedy_text(highest_speed(peaks, limits), spindle_rpm, None)
    shape = "lift" if isinstance(limits, SwingLimits) else "ovality"
    at_any_speed = {
        "u_stroke_mm": f"no speed helps: give less {shape}, or a longer stroke",
        "swing_deg": "no speed helps: give a less steep lift",
    }
    needed = needed_of(peaks, limits, omega_rad_s(spindle_rpm))
    lines = [
        f"machine.limits.{name} = {limit:.9g} {UNITS[name]}: the part needs "
        f"{needed[name]:.9g} {UNITS[name]}; {at_any_speed.get(name, remedy)}"
        for name, limit in given_of(limits).items()
        if needed[name] > limit
    ]
    if lines:
        raise CamtoolsError(lines)
