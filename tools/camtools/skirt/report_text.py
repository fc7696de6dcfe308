"""What the cut of a skirt came to, in words and numbers."""

from __future__ import annotations

from camtools.base.quantities import length_text
from camtools.report.text import ReportRow, error_pair
from camtools.skirt.outcome import SkirtOutcome
from camtools.skirt.refit import judge


def what_was_cut(outcome: SkirtOutcome) -> str:
    """Return part, speed, feed and turns in one phrase."""
    cut, geometry = outcome.summary["cut"], outcome.generated.geometry
    span_mm = geometry.z_last_mm - geometry.z_first_mm
    magnify = outcome.generated.part.magnify
    enlarged = f", {magnify.words}" if magnify else ""
    mean = "mean " if outcome.generated.speed is not None else ""
    return (
        f"skirt of {span_mm:g} mm at {mean}{cut['spindle_rpm']:g} r/min, "
        f"feed {cut['feed_mm']:g} mm, "
        f"{cut['turns']:.0f} of {cut['planned_turns']:.0f} turns{enlarged}"
    )


def _corner_rows(outcome: SkirtOutcome) -> list[ReportRow]:
    """Return what the refit of a corner costs, nothing for other sections."""
    corner = outcome.generated.geometry.corner
    if corner is None or corner.recipe is None:
        return []
    joint, recipe = corner.joint(corner.worst_mm), corner.recipe
    found = judge(joint, recipe, outcome.summary["cut"]["spindle_rpm"])
    deleted = f"({recipe.s1}, {recipe.s2})"
    return [
        ReportRow(
            "refit of the corner",
            f"{recipe.spline}, {deleted} left out: at most {length_text(found.deviation_um)} off "
            "the drawing; form error is against the refit",
        )
    ]


def _removal_rows(outcome: SkirtOutcome) -> list[ReportRow]:
    """Return what equal-volume turning brought, nothing for uniform turning."""
    if outcome.even is None:
        return []
    ours, theirs = outcome.even.summary["removal"], outcome.even.uniform_summary["removal"]
    if "rate_ripple" not in ours or "rate_ripple" not in theirs:
        return [
            ReportRow("ripple of the removal rate", "none: no whole turn at full feed was measured")
        ]
    rate, plain = ours["rate_ripple"], theirs["rate_ripple"]
    chip, plain_chip = ours["chip_force_ripple"], theirs["chip_force_ripple"]
    return [
        ReportRow(
            "ripple of the removal rate",
            f"mean {100 * rate['mean']:.1f} %, max {100 * rate['max']:.1f} % of its mean in a turn "
            f"(uniform turning {100 * plain['mean']:.0f} %, {100 * plain['max']:.0f} %)",
        ),
        ReportRow(
            "ripple of the chip's force",
            f"mean {100 * chip['mean']:.0f} % (uniform turning {100 * plain_chip['mean']:.0f} %): "
            "no speed law changes it",
        ),
        ReportRow(
            "form error at uniform speed",
            error_pair(outcome.even.uniform_summary["form_error_um"]),
        ),
    ]


def rows_of(outcome: SkirtOutcome) -> list[ReportRow]:
    """Return the summary, machine limits apart."""
    summary, generated = outcome.summary, outcome.generated
    form = summary["form_error_um"]
    worst_nm = max(generated.accuracy_u.value_nm, generated.accuracy_x.value_nm)
    wall_s, machine_s = summary["wall_time_s"], summary["machine_time_s"]
    return [
        ReportRow("cut", what_was_cut(outcome)),
        ReportRow("form error", f"{error_pair(form)} (tolerance {length_text(form['tolerance'])})"),
        ReportRow("following error of U", error_pair(summary["following_error_um"])),
        *_corner_rows(outcome),
        *_removal_rows(outcome),
        ReportRow("table", f"{summary['table_bytes']} bytes, error at most {worst_nm:.2g} nm"),
        ReportRow("machine time", f"{machine_s:.1f} s"),
        ReportRow("computing time", f"{wall_s:.2f} s for the cut with its trace"),
    ]
