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


class Peaks(NamedTuple):
    """Guaranteed peaks of U over the table, per radian of the spindle."""

    u_stroke_mm: float  # travel, centred on u = 0 as the firmware centres it
    u1_mm: float  # mm/rad, of u' r where the spindle is modulated
    u2_mm: float  # mm/rad^2, of u'' r^2 + u' r r'
    ratio: float = 1.0  # largest speed over mean speed
    spindle_rad2: float = 0.0  # |r r'|


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
    decides = min(speeds, key=lambda name: speeds[name])
    return HighestSpeed(speeds[decides], decides)


def _excess(name: str, needed: float, limit: float, unit: str, remedy: str) -> list[str]:
    if needed <= limit:
        return []
    place = f"machine.limits.{name} = {limit:.9g} {unit}"
    return [f"{place}: the part needs {needed:.9g} {unit}; {remedy}"]


def check_feasible(peaks: Peaks, limits: Limits, spindle_rpm: float) -> HighestSpeed:
    """Return the highest speed, or refuse a part that the machine cannot cut.

    Raises
    ------
    CamtoolsError
        One line for each limit exceeded: needed, limit, highest speed that would do.
    """
    omega, best = omega_rad_s(spindle_rpm), highest_speed(peaks, limits)
    remedy = (
        f"with these limits process.spindle_rpm = {spindle_rpm:g} may be at most "
        f"{np.floor(best.rpm * 10) / 10:.1f} r/min ({best.decides} decides)"
    )
    at_any_speed = "no speed would do: less ovality, or a longer stroke"
    acceleration, most_acceleration = peaks.u2_mm * omega**2, limits.u_acceleration_mm_s2
    lines = [
        *_excess("u_stroke_mm", peaks.u_stroke_mm, limits.u_stroke_mm, "mm", at_any_speed),
        *_excess("spindle_rpm", spindle_rpm * peaks.ratio, limits.spindle_rpm, "r/min", remedy),
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
    if lines:
        raise CamtoolsError(lines)
    return best
