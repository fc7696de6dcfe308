# SPDX-License-Identifier: Apache-2.0
"""What smoothing did to a list of lift, or would do, and how much of the tolerance it takes.

>>> from camtools.lobe.lift import Poly345
>>> smoothing_of(Poly345(8.0, 1.2)), taken_um(Poly345(8.0, 1.2))
({}, 0.0)
"""

from __future__ import annotations

from camtools.base.json_text import Json
from camtools.lobe.lift import LiftLaw, Listed
from camtools.lobe.smooth_list import Smoothing, peaks_of
from camtools.part.smoothing_text import (
    PeakChange,
    band_words,
    noise_text,
    residuals,
    smoothed_texts,
)


def _facts(smoothing: Smoothing) -> Json:
    before, after = peaks_of(smoothing.before), peaks_of(smoothing.after)
    at_deg, off_um = smoothing.angle_deg, smoothing.off_um
    return residuals(smoothing.band_um, off_um, at_deg, "largest_at_deg") | {
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


def taken_um(law: LiftLaw) -> float:
    """Return how far smoothing moves the lift at most."""
    if isinstance(law, Listed) and law.smoothing is not None:
        return law.smoothing.largest_um
    return 0.0


def smoothing_takes_um(laws: list[LiftLaw]) -> float:
    """Return how far smoothing moves the lift of any lobe at most."""
    return max(taken_um(law) for law in laws)


def noise_hint(laws: list[LiftLaw], form_error_um: float) -> str:
    """Return what noise of lists may have to do with a refusal; nothing without any."""
    for i, law in enumerate(laws):
        if isinstance(law, Listed) and law.needed is not None:
            words = band_words(law.needed.band_um, law.needed.largest_um, form_error_um)
            return f"; the list is noisy: cam.lobe.{i}.{words} smooths it"
    return ""


def smoothing_texts(found: Json, form_error_um: float) -> list[str]:
    """Return what `smoothing_of` found as lines for people, none where it found nothing."""
    lines = []
    if "smoothing" in found:
        one = found["smoothing"]
        place = f"{one['largest_at_deg']:g} degrees"
        lines += smoothed_texts("list", one, place, _changes(one))
    if "noise" in found:
        one = found["noise"]
        words = band_words(one["smooth_um"], one["largest_um"], form_error_um)
        lines.append(noise_text("list", words, _changes(one)))
    return lines


def _changes(one: Json) -> list[PeakChange]:
    acceleration, jerk = one["acceleration_mm_per_rad2"], one["jerk_mm_per_rad3"]
    return [
        PeakChange("acceleration", acceleration["before"], acceleration["after"], "mm/rad2"),
        PeakChange("jerk", jerk["before"], jerk["after"], "mm/rad3"),
    ]
