"""What the analysis of a section comes to, as JSON values and in words.

>>> from camtools.study.section import AnalysisWishes, make_analysis
>>> from camtools.skirt.part.part_file import example_part
>>> parts = figures(make_analysis(example_part(), AnalysisWishes()))["parts"]
>>> parts["largest_depth_change_in_part"]
9
"""

from __future__ import annotations

from textwrap import fill
from typing import Any

import numpy as np

from camtools.cut.removal import mean_rpm_for
from camtools.study.section import Analysis

_PAPERS = (46.0, 46.1, 10.846348637)  # half axis, blank [mm], area of a quarter [mm2]


def figures(study: Analysis) -> dict[str, Any]:
    """Return the figures of an analysis; names carry their units."""
    cut, peaks, rates, parts = study.cut, study.peaks, study.rates, study.parts
    omega = 2 * np.pi * study.rpm / 60
    return {
        "part": study.name,
        "section": {
            "height_mm": study.height_mm,
            "long_half_axis_mm": cut.a_mm,
            "blank_radius_mm": cut.blank_mm,
            "pattern_deg": float(np.degrees(cut.pattern_rad)),
            "area_mm2": cut.total_mm2,
        },
        "parts": {
            "n": int(parts.phi_rad.size),
            "area_mm2": cut.total_mm2 / parts.phi_rad.size,
            "least": study.range.least,
            "most": study.range.most,
            "largest_depth_change_in_part": int(np.argmax(parts.change_mm)) + 1,
        },
        "speed": {
            "mean_rpm": study.rpm,
            "largest_rpm": study.rpm * peaks.ratio_max,
            "least_rpm": study.rpm * peaks.ratio_min,
            "spindle_acceleration_rad_s2": peaks.alpha * omega**2,
            "spindle_acceleration_at_deg": float(np.degrees(peaks.alpha_rad)),
            "highest_mean_rpm": mean_rpm_for(peaks, study.alpha_rad_s2),
            "spindle_limit_rad_s2": study.alpha_rad_s2,
            "u_speed_mm_s": peaks.u1_mm * omega,
            "u_acceleration_max_mm_s2": peaks.u2_max_mm * omega**2,
            "u_acceleration_min_mm_s2": peaks.u2_min_mm * omega**2,
        },
        "removal": {
            "feed_mm": study.feed_mm,
            "kc_n_mm2": study.kc_n_mm2,
            "kc_exponent": study.force.exponent,
            "rate_mm3_s": rates.rate_mm3_s,
            "power_w": rates.power_w,
            "uniform_largest_to_least": rates.largest_to_least,
            "uniform_ripple": rates.ripple,
            "uniform_steps_largest_to_least": rates.steps_largest_to_least,
            "uniform_steps_ripple": rates.steps_ripple,
        },
        "u_waves_mm": {f"{n}": float(study.waves_mm[n]) for n in range(2, study.waves_mm.size, 2)},
    }


def summary(study: Analysis) -> str:
    """Return the essentials as a few lines for people."""
    cut, rates, speed = study.cut, study.rates, figures(study)["speed"]
    chip = study.chip_n(cut.depth_mm(np.linspace(0, cut.pattern_rad, 2001)))
    return (
        f"{study.name}: section at height {study.height_mm:g} mm, blank radius {cut.blank_mm:.4f} "
        f"mm, {np.degrees(cut.pattern_rad):g} degrees cut {cut.total_mm2:.6f} mm2\n"
        f"  uniform turning: removal rate goes 1 : {rates.largest_to_least:.3f}, ripple "
        f"{100 * rates.ripple:.2f} % of its mean\n"
        f"  {_parts_line(study)}\n"
        f"  equal volume at mean {study.rpm:g} r/min: {speed['least_rpm']:.1f} .. "
        f"{speed['largest_rpm']:.1f} r/min, {speed['spindle_acceleration_rad_s2']:.0f} rad/s2; the "
        f"machine's {study.alpha_rad_s2:g} rad/s2 allow {speed['highest_mean_rpm']:.1f} r/min\n"
        f"  constant then: {rates.rate_mm3_s:.3f} mm3/s and {rates.power_w:.3f} W; not constant: "
        f"the force of the chip, {chip.min():.2f} .. {chip.max():.2f} N at any speed law\n"
    )


def _parts_line(study: Analysis) -> str:
    """Return how many equal parts are possible; judged where the part is turned in such parts."""
    n, allowed = study.parts.phi_rad.size, study.range
    bounds = f"{allowed.least} (volume of a part) .. {allowed.most} (controller's cycle)"
    if not study.is_even:
        return f"the part is turned uniformly; equal volume would take {bounds} parts"
    if allowed.least > allowed.most:
        remedy = "turn more slowly, feed less, or allow --slice-volume-mm3"
        return f"{n} equal parts: no number is possible, {bounds}; {remedy}"
    if allowed.least <= n <= allowed.most:
        return f"{n} equal parts are possible, as {bounds} are"
    return f"{n} equal parts are not possible: {bounds} are; give --parts or process.parts"


def is_papers_section(study: Analysis) -> bool:
    """Return whether a section is the one that the papers on equal removal calculate with."""
    ours = study.cut.a_mm, study.cut.blank_mm, study.cut.total_mm2
    return all(abs(one - theirs) < 1e-6 for one, theirs in zip(ours, _PAPERS, strict=True))


def notes(study: Analysis) -> str:
    """Return what a reader of the papers must know about the section (Markdown)."""
    chip = study.cut.depth_mm(np.linspace(0, study.cut.pattern_rad, 2001))
    items = [
        "The number of parts has an upper bound, too, which the papers leave out: a part must not "
        f"be shorter than the controller's cycle. Here {study.range.least} .. {study.range.most}.",
        "The papers say that the cutting force becomes constant. Force is kc x section of the "
        "chip = kc x depth x feed, and neither depends on the spindle's speed: it goes 1 : "
        f"{float(chip.max() / chip.min()):.3f} here in both ways of turning. Constant become the "
        "removal rate and the power.",
        "U needs more bandwidth: in time it is no longer one pair of waves per turn "
        "(harmonics.csv).",
    ]
    if is_papers_section(study):
        items += _papers_notes(study)
    lines = [fill(item, 100, initial_indent="- ", subsequent_indent="  ") for item in items]
    title = f"# Beside the papers: {study.name}, height {study.height_mm:g} mm"
    return "\n".join([title, "", *lines, ""])


def _papers_notes(study: Analysis) -> list[str]:
    """Return what differs from the papers' own numbers, and why."""
    parts = study.parts
    at_part = int(np.argmax(parts.change_mm)) + 1
    deg = np.degrees(parts.phi_rad)
    begin = float(deg[at_part - 2]) if at_part > 1 else 0.0
    return [
        "Area: S_ell = (a b / 2) atan2(a sin, b cos), not (a b / 2) angle; with the latter all "
        "steps of angle would have equal areas, against the papers' own text.",
        "The largest change of depth per equal part is in part "
        f"{at_part} ({begin:.2f} .. {float(deg[at_part - 1]):.2f} degrees). The papers say "
        '"near 8 degrees": that is the number of the slice, counted from 0, not an angle.',
        "The papers' maximum speed of 2500 r/min means 1667.27 r/min on average and a spindle "
        "acceleration of 32 205 rad/s2 for their section, sixty times that of a common lathe "
        "spindle. The spindle decides how fast equal-volume turning can be; mktables finds the "
        "speed law of least ripple within its limits.",
        "S1 says that the stroke of U depends on the rate of change of the ovality: it depends on "
        "the ovality itself.",
    ]
