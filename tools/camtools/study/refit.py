"""Study of the corner's refit: cubic, quintic, quintic with points left out, beside the paper.

The paper's own numbers stand beside ours only for the section it is about; notes say what agrees,
what does not, and why: MATHS.md (14) .. (17).

>>> PAPER_JERK_MM_S3[0], len(PAPER_JERK_MM_S3)
(1140000000.0, 16)
"""

from __future__ import annotations

from textwrap import fill
from typing import NamedTuple

import numpy as np

from camtools.base.csv_text import csv_text
from camtools.skirt.geometry.composite import Joint
from camtools.skirt.geometry.corner import Corner
from camtools.skirt.geometry.refit import Recipe, RefitCandidate, judge, judge_all

# The paper's Table 1, largest jerk, rows s2 = 0 .. 3, columns s1 = 0 .. 3.
PAPER_JERK_MM_S3 = (
    *(1.14e9, 8.43e7, 9.03e7, 6.82e7),
    *(5.13e8, 1.31e7, 2.57e7, 2.74e7),
    *(1.25e9, 2.08e8, 5.14e6, 1.08e7),
    *(7.63e8, 2.17e8, 1.78e7, 3.48e6),
)
PAPER_PEAK_MM_S2 = {"cubic": 8e5, "quintic": 5e5}  # read off its plots
_PAPER = {"ovality_mm": 0.38, "trim_mm": 0.4, "joint_deg": 48.0, "spindle_rpm": 800.0}
_PAPER_DIAMETER_MM = 90.929096914
_NEAR_MM, _NEAR = 0.2, 1e-9


class RefitVariant(NamedTuple):
    """A refit of the corner."""

    name: str
    recipe: Recipe
    found: RefitCandidate
    paper_mm_s2: float | None  # peak acceleration


class Study(NamedTuple):
    """What was found at one height and speed."""

    joint: Joint
    height_mm: float
    spindle_rpm: float
    is_papers: bool
    variants: tuple[RefitVariant, ...]
    as_paper: tuple[RefitCandidate, ...]
    mirror: tuple[RefitCandidate, ...]


def is_papers_section(joint: Joint, spindle_rpm: float) -> bool:
    """Return whether a section at a speed is the one the paper computes with."""
    ours = {
        "ovality_mm": float(joint.ovality_mm),
        "trim_mm": float(joint.trim_mm),
        "joint_deg": float(np.degrees(joint.joint_rad)),
        "spindle_rpm": spindle_rpm,
    }
    is_near = abs(2 * float(joint.a_mm) - _PAPER_DIAMETER_MM) < _NEAR_MM
    return is_near and all(abs(ours[key] - value) < _NEAR for key, value in _PAPER.items())


def study(corner: Corner, height_mm: float, spindle_rpm: float) -> Study:
    """Return the study of a part's section at a height [mm] and speed [r/min]."""
    joint = corner.joint(height_mm)
    is_papers = is_papers_section(joint, spindle_rpm)
    as_paper = judge_all(joint, "quintic", "as-paper", spindle_rpm)
    mirror = judge_all(joint, "quintic", "mirror", spindle_rpm)
    recipes = (
        ("cubic", Recipe("cubic", 0, 0, "as-paper"), PAPER_PEAK_MM_S2["cubic"]),
        ("quintic", Recipe("quintic", 0, 0, "as-paper"), PAPER_PEAK_MM_S2["quintic"]),
        ("quintic, (3, 3) deleted", Recipe("quintic", 3, 3, "as-paper"), None),
        ("quintic, (3, 3) deleted, mirror ends", Recipe("quintic", 3, 3, "mirror"), None),
    )
    variants = tuple(
        RefitVariant(name, recipe, judge(joint, recipe, spindle_rpm), peak if is_papers else None)
        for name, recipe, peak in recipes
    )
    found = tuple(as_paper), tuple(mirror)
    return Study(joint, height_mm, spindle_rpm, is_papers, variants, *found)


def comparison_csv(found: Study) -> str:
    """Return the three splines of the paper and the production variant as CSV."""
    printed = [one.paper_mm_s2 for one in found.variants]
    ours = [one.found for one in found.variants]
    ratios = [a.acceleration_mm_s2 / b if b else None for a, b in zip(ours, printed, strict=True)]
    return csv_text(
        {
            "variant": ([f'"{one.name}"' for one in found.variants], ""),
            "peak_acceleration_mm_s2": ([one.acceleration_mm_s2 for one in ours], ".1f"),
            "peak_deg": ([one.peak_deg for one in ours], ".2f"),
            "undershoot_mm_s2": ([one.undershoot_mm_s2 for one in ours], ".1f"),
            "largest_jerk_mm_s3": ([one.jerk_mm_s3 for one in ours], ".4e"),
            "deviation_um": ([one.deviation_um for one in ours], ".2f"),
            "paper_peak_acceleration_mm_s2": (printed, ".3g"),
            "ratio_to_paper": (ratios, ".3f"),
        }
    )


def candidates_csv(found: Study) -> str:
    """Return all 16 deletions, both constructions, beside the paper's Table 1."""
    ours, mirrored = found.as_paper, found.mirror
    printed = [one if found.is_papers else None for one in PAPER_JERK_MM_S3]
    ratios = [a.tail_jerk_mm_s3 / b if b else None for a, b in zip(ours, printed, strict=True)]
    return csv_text(
        {
            "s1": ([one.s1 for one in ours], "d"),
            "s2": ([one.s2 for one in ours], "d"),
            "paper_construction_peak_mm_s2": ([one.acceleration_mm_s2 for one in ours], ".0f"),
            "peak_deg": ([one.peak_deg for one in ours], ".2f"),
            "jerk_behind_corner_mm_s3": ([one.tail_jerk_mm_s3 for one in ours], ".3e"),
            "deviation_um": ([one.deviation_um for one in ours], ".2f"),
            "paper_jerk_mm_s3": (printed, ".3g"),
            "ratio_to_paper": (ratios, ".2f"),
            "mirror_peak_mm_s2": ([one.acceleration_mm_s2 for one in mirrored], ".0f"),
            "mirror_deviation_um": ([one.deviation_um for one in mirrored], ".2f"),
        }
    )


def notes(found: Study) -> str:
    """Return what the study shows, in words and numbers (Markdown)."""
    cubic, quintic, deleted, mirrored = (one.found for one in found.variants)
    ratio = quintic.acceleration_mm_s2 / cubic.acceleration_mm_s2
    text = (
        f"# Refit of the corner at height {found.height_mm:g} mm, {found.spindle_rpm:g} r/min\n\n"
        f"The slope jumps by {float(found.joint.corner_mm_rad()):.4f} mm/rad at the joint.\n\n"
        f"- Cubic spline through a point per degree: {cubic.acceleration_mm_s2:.0f} mm/s2.\n"
        f"- Quintic: {quintic.acceleration_mm_s2:.0f} mm/s2, {ratio:.3f} of the cubic's; the ratio "
        "is fixed by spline theory.\n"
        f"- Quintic, three points left out on each side: {deleted.acceleration_mm_s2:.0f} mm/s2 "
        f"for {deleted.deviation_um:.2f} um of contour.\n"
        f"- The same with mirrored ends, the production variant: "
        f"{mirrored.acceleration_mm_s2:.0f} mm/s2 for {mirrored.deviation_um:.2f} um.\n"
    )
    return text + (_papers_notes(found) if found.is_papers else "")


def _papers_notes(found: Study) -> str:
    ours = np.array([one.tail_jerk_mm_s3 for one in found.as_paper])
    ratios = ours / PAPER_JERK_MM_S3
    correlation = float(np.corrcoef(np.log10(ours), np.log10(PAPER_JERK_MM_S3))[0, 1])
    within = [(one.s1, one.s2) for one in found.as_paper if one.tail_jerk_mm_s3 <= 1e7]
    peaks = {(one.s1, one.s2): f"{one.acceleration_mm_s2:.0f}" for one in found.as_paper}
    cubic, quintic, deleted, _ = (one.found for one in found.variants)
    ratio = quintic.acceleration_mm_s2 / cubic.acceleration_mm_s2
    items = (
        f"Its cubic peak, 8e5 mm/s2 read off a plot, agrees with {cubic.acceleration_mm_s2:.0f}.",
        f"Its quintic peak, 5e5, does not: we find {quintic.acceleration_mm_s2:.0f}, and no choice "
        f"of diameter, ovality or ends brings the ratio to the cubic from {ratio:.3f} to its "
        f"0.625. With one neighbour left out, (0, 1), the peak is {peaks[0, 1]}.",
        f"Its Table 1 of jerks is met within a factor of {ratios.min():.2f} .. {ratios.max():.2f} "
        "by one construction: the joint counts as the first of the s1 points, averaged knots, the "
        "largest signed jerk from 50 degrees on; correlation of the logarithms "
        f"{correlation:.3f}. Rule and window were fitted to the table, so this is evidence, not "
        "proof. The paper's own window, from 56 degrees on, does not give its numbers.",
        "Its optimum (3, 3) under the jerk limit 1e7 mm/s3 is reproduced, "
        f"{deleted.tail_jerk_mm_s3:.3g} against 3.48e6; the deletions that keep the limit are "
        f"{within}, in the paper (2, 2) and (3, 3).",
        f"Without the limit (3, 2) would be chosen: {peaks[3, 2]} against {peaks[3, 3]} mm/s2.",
        f"The contour at (3, 3) is off by {deleted.deviation_um:.2f} um at the joint; the paper "
        "measured 3 um, on a piston with less ovality (0.35 mm) and a milder corner.",
        "A cubic spline's acceleration is continuous; what it lacks is a continuous jerk. The peak "
        "comes from the corner in the data, not from the spline's order.",
    )
    lines = [fill(item, 100, initial_indent="- ", subsequent_indent="  ") for item in items]
    return "\n".join(["", "## Beside the paper", "", *lines, ""])
