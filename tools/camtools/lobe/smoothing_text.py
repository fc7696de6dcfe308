# SPDX-License-Identifier: Apache-2.0
"""What smoothing did to a list of lift, or would do, for programs and for people.

>>> from camtools.lobe.lift import Poly345
>>> smoothing_of(Poly345(8.0, 1.2))
{}
"""

from __future__ import annotations

from camtools.base.json_text import Json
from camtools.lobe.lift import LiftLaw, Listed
from camtools.lobe.smooth_list import Smoothing, peaks_of


def _facts(smoothing: Smoothing) -> Json:
    before, after = peaks_of(smoothing.before), peaks_of(smoothing.after)
    return {
        "smooth_um": smoothing.band_um,
        "largest_um": smoothing.largest_um,
        "largest_at_deg": smoothing.largest_at_deg,
        "rms_um": smoothing.rms_um,
        "acceleration_mm_per_rad2": {"before": before.acceleration, "after": after.acceleration},
        "jerk_mm_per_rad3": {"before": before.jerk, "after": after.jerk},
    }


def smoothing_of(law: LiftLaw) -> Json:
    """Return the residuals and peaks of a smoothed list, or of one that should be smoothed."""
    found: Json = {}
    if isinstance(law, Listed) and law.smoothing is not None:
        found["smoothing"] = _facts(law.smoothing)
    if isinstance(law, Listed) and law.needed is not None:
        found["noise"] = _facts(law.needed)
    return found


def noise_hint(laws: list[LiftLaw]) -> str:
    """Return what noise of lists may have to do with a refusal; nothing without any."""
    for i, law in enumerate(laws):
        if isinstance(law, Listed) and law.needed is not None:
            return (
                f"; the list is noisy: cam.lobe.{i}.smooth_um = {law.needed.band_um:g} smooths it"
            )
    return ""


def smoothing_texts(found: Json) -> list[str]:
    """Return what `smoothing_of` found as lines for people, none where it found nothing."""
    lines = []
    if "smoothing" in found:
        one = found["smoothing"]
        lines.append(
            f"list smoothed within {one['smooth_um']:g} um: largest residual "
            f"{one['largest_um']:.3g} um at {one['largest_at_deg']:g} degrees, rms "
            f"{one['rms_um']:.3g} um; {_peaks_text(one)}"
        )
    if "noise" in found:
        one = found["noise"]
        lines.append(
            f"warning: the list is noisy or rounded coarsely: smooth_um = {one['smooth_um']:g} "
            f"would change {_peaks_text(one)}"
        )
    return lines


def _peaks_text(one: Json) -> str:
    acceleration, jerk = one["acceleration_mm_per_rad2"], one["jerk_mm_per_rad3"]
    return (
        f"largest acceleration from {acceleration['before']:.4g} to {acceleration['after']:.4g} "
        f"mm/rad2, largest jerk from {jerk['before']:.4g} to {jerk['after']:.4g} mm/rad3"
    )
