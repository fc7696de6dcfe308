"""The refit of a corner: cubic, quintic, points left out, beside the paper's own numbers.

The numbers of the paper stand beside ours only for the section it is about, MATHS.md (14) .. (17).

>>> from camtools.skirt.geometry.sections import Joint
>>> found = study(Joint(45.46, 0.38, 0.4, np.radians(48.0)), 40.0, 800.0)
>>> found.is_papers, quantities(found)["within"]
(True, '[(1, 1), (2, 2), (3, 3)]')
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import PPoly

from camtools.base.quantities import Floats, omega_rad_s
from camtools.base.text import Columns
from camtools.papers.declared import notes as declared_notes
from camtools.papers.declared import printed
from camtools.skirt.geometry.corner import (
    PAPER_JERK_LIMIT_MM_S3,
    Recipe,
    RefitCandidate,
    ellipse_steps,
    judge,
    judge_all,
    refit,
)
from camtools.skirt.geometry.sections import Joint

CUBIC, QUINTIC = Recipe("cubic", 0, 0, "as-paper"), Recipe("quintic", 0, 0, "as-paper")
DELETED, MIRRORED = Recipe("quintic", 3, 3, "as-paper"), Recipe("quintic", 3, 3, "mirror")
VARIANTS = {
    "cubic": CUBIC,
    "quintic": QUINTIC,
    "quintic, (3, 3) deleted": DELETED,
    "quintic, (3, 3) deleted, mirror ends": MIRRORED,
}
_PAPER = (0.38, 0.4, 48.0, 800.0)  # ovality, trim [mm], joint [degrees], speed [r/min]
_PAPER_DIAMETER_MM, _NEAR_MM = 90.929096914, 0.2


class Study(NamedTuple):
    """The refits of a section at a speed."""

    joint: Joint
    height_mm: float
    spindle_rpm: float
    is_papers: bool  # the paper calculates with this section
    variants: tuple[RefitCandidate, ...]  # as VARIANTS
    as_paper: tuple[RefitCandidate, ...]  # as CANDIDATES
    mirror: tuple[RefitCandidate, ...]

    @property
    def tail_jerk_mm_s3(self) -> Floats:
        """Return the largest jerk beyond the corner of the 16 deletions."""
        return np.array([fit.tail_jerk_mm_s3 for fit in self.as_paper])


def study(joint: Joint, height_mm: float, spindle_rpm: float) -> Study:
    """Return the study of a section at a speed [r/min]."""
    joint_deg = float(np.degrees(joint.joint_rad))
    ours = float(joint.ovality_mm), float(joint.trim_mm), joint_deg, spindle_rpm
    is_papers = abs(2 * float(joint.a_mm) - _PAPER_DIAMETER_MM) < _NEAR_MM and np.allclose(
        ours, _PAPER, rtol=0, atol=1e-9
    )
    variants = tuple(judge(joint, recipe, spindle_rpm) for recipe in VARIANTS.values())
    as_paper, mirror = (
        tuple(judge_all(joint, "quintic", ends, spindle_rpm)) for ends in ("as-paper", "mirror")
    )
    return Study(joint, height_mm, spindle_rpm, is_papers, variants, as_paper, mirror)


def tables(found: Study) -> dict[str, Columns]:
    """Return the splines of the paper with the production variant, and all 16 deletions."""
    ours, paper, mirrored = found.variants, found.as_paper, found.mirror
    peaks: list[float | None] = [None] * len(ours)
    jerks: list[float | None] = [None] * len(paper)
    if found.is_papers:
        peaks[:2] = printed("S2", "cubic_mm_s2"), printed("S2", "quintic_mm_s2")
        jerks = printed("S2", "table_1_mm_s3")
    tail = found.tail_jerk_mm_s3
    ratios = [a.acceleration_mm_s2 / b if b else None for a, b in zip(ours, peaks, strict=True)]
    of_jerks = [a / b if b else None for a, b in zip(tail, jerks, strict=True)]
    return {
        "refit_comparison": {
            "variant": ([f'"{name}"' for name in VARIANTS], ""),
            "peak_acceleration_mm_s2": ([fit.acceleration_mm_s2 for fit in ours], ".1f"),
            "peak_deg": ([fit.peak_deg for fit in ours], ".2f"),
            "undershoot_mm_s2": ([fit.undershoot_mm_s2 for fit in ours], ".1f"),
            "largest_jerk_mm_s3": ([fit.jerk_mm_s3 for fit in ours], ".4e"),
            "deviation_um": ([fit.deviation_um for fit in ours], ".2f"),
            "paper_peak_acceleration_mm_s2": (peaks, ".3g"),
            "ratio_to_paper": (ratios, ".3f"),
        },
        "refit_candidates": {
            "s1": ([fit.s1 for fit in paper], "d"),
            "s2": ([fit.s2 for fit in paper], "d"),
            "paper_construction_peak_mm_s2": ([fit.acceleration_mm_s2 for fit in paper], ".0f"),
            "peak_deg": ([fit.peak_deg for fit in paper], ".2f"),
            "jerk_behind_corner_mm_s3": (tail, ".3e"),
            "deviation_um": ([fit.deviation_um for fit in paper], ".2f"),
            "paper_jerk_mm_s3": (jerks, ".3g"),
            "ratio_to_paper": (of_jerks, ".2f"),
            "mirror_peak_mm_s2": ([fit.acceleration_mm_s2 for fit in mirrored], ".0f"),
            "mirror_deviation_um": ([fit.deviation_um for fit in mirrored], ".2f"),
        },
    }


def quantities(found: Study) -> dict[str, Any]:
    """Return the quantities of the notes and of the paper's rows."""
    cubic, quintic, deleted, mirrored = found.variants
    jerks, table = found.tail_jerk_mm_s3, printed("S2", "table_1_mm_s3")
    ratios = jerks / table
    peaks = {(fit.s1, fit.s2): fit.acceleration_mm_s2 for fit in found.as_paper}
    is_within = jerks <= PAPER_JERK_LIMIT_MM_S3
    return {
        "height_mm": found.height_mm,
        "rpm": found.spindle_rpm,
        "corner_mm_rad": float(found.joint.corner_mm_rad()),
        "cubic_mm_s2": cubic.acceleration_mm_s2,
        "cubic_deg": cubic.peak_deg,
        "quintic_mm_s2": quintic.acceleration_mm_s2,
        "quintic_deg": quintic.peak_deg,
        "ratio": quintic.acceleration_mm_s2 / cubic.acceleration_mm_s2,
        "deleted_mm_s2": deleted.acceleration_mm_s2,
        "deleted_um": deleted.deviation_um,
        "mirrored_mm_s2": mirrored.acceleration_mm_s2,
        "mirrored_um": mirrored.deviation_um,
        "peak_01": peaks[0, 1],
        "peak_32": peaks[3, 2],
        "table_1_mm_s3": jerks,
        "jerk_mm_s3": deleted.tail_jerk_mm_s3,
        "optimum": str(min(found.as_paper, key=lambda fit: fit.tail_jerk_mm_s3)[:2]),
        "factors": (ratios.min(), ratios.max()),
        "correlation": float(np.corrcoef(np.log10(jerks), np.log10(table))[0, 1]),
        "within": str([pair for pair, is_in in zip(peaks, is_within, strict=True) if is_in]),
    }


def notes(found: Study) -> str:
    """Return the results of the study in words and numbers (Markdown)."""
    return declared_notes("refit", quantities(found), is_papers=found.is_papers)


def curve_of(joint: Joint, recipe: Recipe) -> PPoly:
    """Return the refit of a section."""
    return refit(joint, recipe, ellipse_steps(float(joint.joint_rad)))


def motion(
    found: Study, recipes: Mapping[str, Recipe], low_deg: float, high_deg: float
) -> dict[str, Columns]:
    """Return the motion of U along refits, by their names, and their distance from the drawing."""
    deg, omega = np.linspace(low_deg, high_deg, 4001), omega_rad_s(found.spindle_rpm)
    phi = np.radians(deg)
    tables: dict[str, Columns] = {}
    for name, recipe in recipes.items():
        curve = curve_of(found.joint, recipe)
        off_mm = curve(phi) - found.joint.reduction(phi).delta
        tables[name] = {
            "angle_deg": (deg, 3),
            "deeper_than_drawn_um": (1000 * off_mm, 3),
            "u_mm": (curve(phi), 6),
            "u_speed_mm_s": (curve(phi, 1) * omega, 3),
            "u_acceleration_mm_s2": (curve(phi, 2) * omega**2, 1),
            "u_jerk_mm_s3": (curve(phi, 3) * omega**3, 1),
        }
    return tables
