"""Whether a machine can move U as a table asks, and how fast.

>>> peaks = Peaks(u_stroke_mm=0.15, u1_mm=0.15, u2_mm=0.3)
>>> from camtools.part import Limits
>>> best = highest_speed(peaks, Limits())
>>> f"{best.rpm:.0f} r/min, decided by {best.decides}"
'3000 r/min, decided by spindle_rpm'
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camtools.errors import CamtoolsError
from camtools.geometry import omega_rad_s
from camtools.image import Bounds
from camtools.part import Limits
from camtools.part_cam import CamLimits


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
        bounds.spindle_peak_ppm * 1e-6,
    )


def highest_speed(peaks: Peaks, limits: Limits) -> HighestSpeed:
    """Return the highest spindle speed [r/min] at which U stays within its limits."""
    per_omega = 60 / (2 * np.pi)
    speeds = {"spindle_rpm": limits.spindle_rpm / peaks.ratio}
    if peaks.spindle_rad2 > 0:
        root = np.sqrt(limits.alpha_rad_s2 / peaks.spindle_rad2)
        speeds["spindle_acceleration_rad_s2"] = float(per_omega * root)
    if peaks.u1_mm > 0:
        speeds["u_speed_mm_s"] = per_omega * limits.u_speed_mm_s / peaks.u1_mm
    if peaks.u2_mm > 0:
        root = np.sqrt(limits.u_acceleration_mm_s2 / peaks.u2_mm)
        speeds["u_acceleration_mm_s2"] = float(per_omega * root)
    if isinstance(limits, CamLimits) and peaks.swing1_deg > 0:
        speeds["swing_speed_deg_s"] = per_omega * limits.swing_speed_deg_s / peaks.swing1_deg
        root = np.sqrt(limits.swing_acceleration_deg_s2 / peaks.swing2_deg)
        speeds["swing_acceleration_deg_s2"] = float(per_omega * root)
    decides = min(speeds, key=lambda name: speeds[name])
    return HighestSpeed(speeds[decides], decides)


def _excess(name: str, needed: float, limit: float, unit: str, remedy: str) -> list[str]:
    if needed <= limit:
        return []
    place = f"machine.limits.{name} = {limit:.9g} {unit}"
    return [f"{place}: the part needs {needed:.9g} {unit}; {remedy}"]


def _swing_excess(peaks: Peaks, limits: CamLimits, omega: float, remedy: str) -> list[str]:
    speed, acceleration = peaks.swing1_deg * omega, peaks.swing2_deg * omega**2
    most, at_any_speed = limits.swing_acceleration_deg_s2, "no speed would do: less steep a lift"
    return [
        *_excess("swing_deg", peaks.swing_deg, limits.swing_deg, "degrees", at_any_speed),
        *_excess("swing_speed_deg_s", speed, limits.swing_speed_deg_s, "degrees/s", remedy),
        *_excess("swing_acceleration_deg_s2", acceleration, most, "degrees/s2", remedy),
    ]


def check_feasible(
    peaks: Peaks,
    limits: Limits,
    spindle_rpm: float,
    best: HighestSpeed | None = None,
    asked_rpm: float | None = None,
) -> HighestSpeed:
    """Return the highest speed, or refuse a part that the machine cannot cut.

    Parameters
    ----------
    spindle_rpm : float
        Mean speed.
    best : HighestSpeed, optional
        Highest speed asked for that would do, where it is not the highest mean speed.
    asked_rpm : float, optional
        Speed of the part file, where it is not the mean speed.

    Raises
    ------
    CamtoolsError
        One line for each limit exceeded: needed, limit, highest speed that would do.
    """
    omega, best = omega_rad_s(spindle_rpm), best or highest_speed(peaks, limits)
    asked_rpm = spindle_rpm if asked_rpm is None else asked_rpm
    remedy = (
        f"with these limits process.spindle_rpm = {asked_rpm:g} may be at most "
        f"{np.floor(best.rpm * 10) / 10:.1f} r/min ({best.decides} decides)"
    )
    is_cam = isinstance(limits, CamLimits)
    at_any_speed = f"no speed would do: less {'lift' if is_cam else 'ovality'}, or a longer stroke"
    fastest_rpm = max(asked_rpm, spindle_rpm * peaks.ratio)
    acceleration, most_acceleration = peaks.u2_mm * omega**2, limits.u_acceleration_mm_s2
    lines = [
        *_excess("u_stroke_mm", peaks.u_stroke_mm, limits.u_stroke_mm, "mm", at_any_speed),
        *_excess("spindle_rpm", fastest_rpm, limits.spindle_rpm, "r/min", remedy),
        *_excess(
            "spindle_acceleration_rad_s2",
            peaks.spindle_rad2 * omega**2,
            limits.alpha_rad_s2,
            "rad/s2",
            remedy,
        ),
        *_excess("u_speed_mm_s", peaks.u1_mm * omega, limits.u_speed_mm_s, "mm/s", remedy),
        *_excess("u_acceleration_mm_s2", acceleration, most_acceleration, "mm/s2", remedy),
    ]
    if isinstance(limits, CamLimits):
        lines += _swing_excess(peaks, limits, omega, remedy)
    if lines:
        raise CamtoolsError(lines)
    return best
