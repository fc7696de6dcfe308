"""What the cut of a skirt came to, in words and numbers."""

from __future__ import annotations

from camtools.base.json_text import Json
from camtools.base.quantities import length_text
from camtools.report.learning_text import learning_rows
from camtools.report.text import ReportRow, error_pair, form_text
from camtools.skirt.geometry.profile import notable_overshoots
from camtools.skirt.geometry.smooth_points import (
    noise_facts,
    smoothing_facts,
    smoothing_takes_um,
    smoothing_texts,
)
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.report.outcome import SkirtOutcome
from camtools.skirt.report.tool_text import tool_row, track_row


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


def pass_rows(summary: Json) -> list[ReportRow]:
    """Return what each of several passes came to, nothing for one."""
    passes = summary.get("passes", [])
    return [
        ReportRow(
            f"pass {one['pass']} of {len(passes)}",
            f"{one['spindle_rpm']:g} r/min, feed {one['feed_mm']:g} mm, depth "
            f"{one['depth_min_mm']:.3f} .. {one['depth_max_mm']:.3f} mm, leaves "
            f"{length_text(one['allowance_um'])}: {error_pair(one['form_error_um'])}"
            f"{_force_text(one['chip_force_n'])}",
        )
        for one in passes
    ]


def _force_text(force: Json) -> str:
    """Return the force of a pass in words, nothing where it is not measured (rings)."""
    if not force["max"]:
        return ""
    return f", chip force {force['mean']:.0f} N, at most {force['max']:.0f} N"


def _corner_rows(outcome: SkirtOutcome) -> list[ReportRow]:
    """Return what the refit of a corner costs, nothing for other sections."""
    corner = outcome.generated.geometry.corner
    if corner is None or corner.recipe is None:
        return []
    recipe, off = corner.recipe, corner.off
    assert off is not None
    return [
        ReportRow(
            "refit of the corner",
            f"{recipe.spline}, ({recipe.s1}, {recipe.s2}) points left out: deviates from the "
            f"drawing by at most {length_text(off.um)}, {length_text(corner.off_limit_um)} allowed",
        )
    ]


def _filter_rows(outcome: SkirtOutcome) -> list[ReportRow]:
    """Return what the filter of measured points changes, nothing for other sections."""
    geometry, section = outcome.generated.geometry, outcome.generated.part.piston.section
    if geometry.off_points_um is None or section.harmonics is None:
        return []
    waves = f"waves up to {section.harmonics} per turn are kept"
    off = f"at most {length_text(geometry.off_points_um)} from the points"
    return [ReportRow("filter of the points", f"{waves}; {off}")]


def _correction_rows(outcome: SkirtOutcome) -> list[ReportRow]:
    """Return what was expected of a part whose table gauged parts have corrected."""
    correction = outcome.generated.geometry.correction
    if correction is None:
        return []
    about = correction.rounds[-1]
    left = about["expected_um"]
    text = (
        f"round {len(correction.rounds)}: measured at most "
        f"{length_text(about['gauged_um']['max'])}; expected {length_text(left['max'])}, "
        f"rms {length_text(left['rms'])}"
    )
    return [ReportRow("correction by measured parts", text)]


def _control_rows(outcome: SkirtOutcome) -> list[ReportRow]:
    """Return the controller's own error where the table does not play the drawing itself."""
    control = outcome.summary.get("control_error_um")
    if control is None or outcome.generated.geometry.drawn is None:
        return []
    played = outcome.generated.geometry.played_name
    return [ReportRow("controller's own error", f"{error_pair(control)} against the {played}")]


def _smoothing_rows(part: SkirtPart) -> list[ReportRow]:
    """Return what smoothing of points did, or would do; nothing for smooth points."""
    found, noise = smoothing_facts(part.piston), noise_facts(part.piston)
    texts = smoothing_texts(found, noise, part.process.form_error_um)
    return [ReportRow("smoothing", text) for text in texts]


def _removal_rows(outcome: SkirtOutcome) -> list[ReportRow]:
    """Return what equal-volume turning brought, nothing for uniform turning."""
    if outcome.even is None:
        return []
    ours, theirs = outcome.even.summary["removal"], outcome.even.uniform_summary["removal"]
    if "rate_ripple" not in ours or "rate_ripple" not in theirs:
        return [
            ReportRow("ripple of the removal rate", "unknown: no whole turn at full feed was cut")
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
            "ripple of the chip force",
            f"mean {100 * chip['mean']:.0f} % (uniform turning {100 * plain_chip['mean']:.0f} %); "
            "no speed law changes it",
        ),
        ReportRow(
            "form error at uniform speed", error_pair(outcome.even.uniform_summary["form_error_um"])
        ),
    ]


def rows_of(outcome: SkirtOutcome) -> list[ReportRow]:
    """Return the summary, machine limits apart."""
    summary, generated = outcome.summary, outcome.generated
    form, piston = summary["form_error_um"], generated.part.piston
    worst_nm = max(generated.accuracy_u.value_nm, generated.accuracy_x.value_nm)
    wall_s, machine_s = summary["wall_time_s"], summary["machine_time_s"]
    law = generated.part.process.feed_law
    feed_peak = max(law.feed_mm) / generated.part.process.feed_mm if law is not None else 1.0
    return [
        ReportRow("cut", what_was_cut(outcome)),
        ReportRow("form error", form_text(form, smoothing_takes_um(generated.part))),
        *_correction_rows(outcome),
        *_control_rows(outcome),
        *pass_rows(summary),
        ReportRow("following error of U", error_pair(summary["following_error_um"])),
        *learning_rows(summary),
        *_corner_rows(outcome),
        *_filter_rows(outcome),
        *(ReportRow("overshoot", text) for text in notable_overshoots(piston)),
        *_smoothing_rows(generated.part),
        *_removal_rows(outcome),
        tool_row(summary, generated.part.tool, generated.heel),
        track_row(summary, generated.part.tool, feed_peak),
        ReportRow("table", f"{summary['table_bytes']} bytes, accurate to {worst_nm:.2g} nm"),
        ReportRow("machine time", f"{machine_s:.1f} s"),
        ReportRow("computing time", f"{wall_s:.2f} s for the cut with its trace"),
    ]
