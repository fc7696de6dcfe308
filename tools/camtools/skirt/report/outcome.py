"""All that is known about the cut of a skirt, and in words and numbers."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from camtools.base.quantities import length_text
from camtools.base.text import Json
from camtools.part.common import Tool
from camtools.pipeline.kind import Rig, made_cut
from camtools.report.learning_text import learned
from camtools.report.text import (
    COMPUTING_TIME,
    FOLLOWING_ERROR,
    MACHINE_TIME,
    ReportRow,
    error_pair,
    form_text,
    quantity,
    table_quantity,
    turns_text,
)
from camtools.sim.machine_file import machine_text
from camtools.sim.results import AnyCut, Cut, GaugedSurface, Removal, removal_of
from camtools.skirt.geometry.profile import (
    noise_facts,
    notable_overshoots,
    smoothing_facts,
    smoothing_takes_um,
    smoothing_texts,
)
from camtools.skirt.report.summary import clearance_text, make_summary
from camtools.skirt.table.generate import GeneratedSkirt, generate
from camtools.skirt.tool.texture import scallop_um
from camtools.skirt.tool.turning import Heel
from camtools.table.summary import table_files

REMOVAL, REMOVAL_UNIFORM = "removal.csv", "removal_uniform.csv"
_TWIN = "uniform"
_MAX_TURNS = 2000  # 120 rows each


class Even(NamedTuple):
    """Equal-volume turning beside uniform turning of the same part at the same mean speed."""

    summary: Json
    uniform_summary: Json
    removal: Removal
    uniform_removal: Removal


@dataclass(frozen=True, eq=False)
class SkirtOutcome(Cut[GeneratedSkirt]):
    """All that is known about the cut of a skirt."""

    even: Even | None = None  # removal rate and forces of a part turned with equal volumes
    control: GaugedSurface | None = None  # own errors, where a refit or a filter is played


def limited_turns(turns: float) -> list[str]:
    """Return camsim's words that keep the table of slices small."""
    return [] if turns <= _MAX_TURNS else ["--turns-limit", str(_MAX_TURNS)]


def uniform_twin(generated: GeneratedSkirt) -> GeneratedSkirt:
    """Return the table of the same part at a constant spindle speed."""
    part = generated.part
    process = part.process.model_copy(update={"mode": "uniform"})
    return generate(part.model_copy(update={"process": process}))


def compare_removal(rig: Rig, generated: GeneratedSkirt) -> Even | None:
    """Return removal rate and forces beside those of uniform turning; none of uniform parts.

    Leaves removal.csv and removal_uniform.csv in the working folder.
    """
    if generated.speed is None:
        return None
    twin = Path(_TWIN)
    twin.mkdir()
    twin_table = uniform_twin(generated)
    for name, data in table_files(twin_table.table, make_summary(twin_table)).items():
        (twin / name).write_bytes(data)
    words = [*rig.words, *limited_turns(rig.turns)]
    cuts = [
        made_cut(table, words, tables=["removal"], files={file: "removal"})
        for table, file in ((rig.table, REMOVAL), (str(twin / rig.table), REMOVAL_UNIFORM))
    ]
    even, uniform = (removal_of(cut.removal) for cut in cuts)
    return Even(cuts[0].summary, cuts[1].summary, even, uniform)


def _nose_text(nose_mm: float) -> str:
    return f"nose radius {nose_mm:g} mm" if nose_mm else "pointed, without nose radius"


def tool_row(summary: Json, tool: Tool, heel: Heel) -> ReportRow:
    """Return the row of the tool that the simulator had, by default that of the table."""
    used = summary.get("tool", {})
    nose_mm = used.get("nose_mm", tool.nose_radius_mm)
    words = _nose_text(nose_mm)
    if nose_mm != tool.nose_radius_mm:
        words += f", but the table is made for: {_nose_text(tool.nose_radius_mm)}"
    if used.get("wear_um", 0):
        words += f", worn by {used['wear_um']:g} um"
    return ReportRow("tool", f"{words}; {clearance_text(tool.clearance_deg, heel)}")


def track_row(summary: Json, tool: Tool, peak: float = 1.0) -> ReportRow:
    """Return the row of what stays between the tracks of the tool.

    The form error is that of the tool's path: ridges do not count in it. The largest feed over the
    height is `peak` times the mean.

    >>> track_row({"cut": {"feed_mm": 0.1}}, Tool(nose_radius_mm=0.8)).value
    '1.56 µm in theory (nose radius 0.8 mm, feed 0.1 mm); not part of the form error'
    """
    nose_mm = summary.get("tool", {}).get("nose_mm", tool.nose_radius_mm)
    feed_mm = summary["cut"]["feed_mm"] * peak
    why = f"(nose radius {nose_mm:g} mm, feed {feed_mm:.4g} mm)"
    if not nose_mm:
        text = "not judged: the tool has no nose radius; give tool.nose_radius_mm"
    elif feed_mm >= 2 * nose_mm:
        text = f"the tracks do not meet, so metal remains {why}; reduce the feed"
    else:
        height = length_text(scallop_um(feed_mm, nose_mm))
        text = f"{height} in theory {why}; not part of the form error"
    return ReportRow("ridges between tracks", text)


def what_was_cut(outcome: SkirtOutcome) -> str:
    """Return part, speed, feed and turns in one phrase."""
    geometry, magnify = outcome.generated.geometry, outcome.generated.part.magnify
    span_mm = geometry.z_last_mm - geometry.z_first_mm
    enlarged = f", {magnify.words}" if magnify else ""
    lands = len(outcome.generated.part.piston.lands)
    belt = f" with {lands} land{'s' * (lands > 1)}" if lands else ""
    return f"skirt{belt} of {span_mm:g} mm {turns_text(outcome)}{enlarged}"


def pass_rows(outcome: AnyCut) -> list[ReportRow]:
    """Return what each of several passes came to, nothing for one."""
    passes = outcome.summary.get("passes", [])
    return [
        ReportRow(
            f"pass {record['pass']} of {len(passes)}",
            f"{record['spindle_rpm']:g} r/min, feed {record['feed_mm']:g} mm, depth "
            f"{record['depth_min_mm']:.3f} .. {record['depth_max_mm']:.3f} mm, leaves "
            f"{length_text(record['allowance_um'])}: {error_pair(record['form_error_um'])}"
            f"{_force_text(record['chip_force_n'])}",
        )
        for record in passes
    ]


def _force_text(force: Json) -> str:
    """Return the force of a pass in words, nothing where it is not measured (rings)."""
    if not force["max"]:
        return ""
    return f", chip force {force['mean']:.0f} N, at most {force['max']:.0f} N"


def _corner_text(outcome: SkirtOutcome) -> str:
    corner = outcome.generated.geometry.corner
    if corner is None or corner.recipe is None:
        return ""
    recipe, off = corner.recipe, corner.off
    assert off is not None
    return (
        f"{recipe.spline}, ({recipe.s1}, {recipe.s2}) points left out: deviates from the "
        f"drawing by at most {length_text(off.um)}, {length_text(corner.off_limit_um)} allowed"
    )


def _filter_text(outcome: SkirtOutcome) -> str:
    geometry, section = outcome.generated.geometry, outcome.generated.part.piston.section
    if geometry.off_points_um is None or section.harmonics is None:
        return ""
    waves = f"waves up to {section.harmonics} per turn are kept"
    return f"{waves}; at most {length_text(geometry.off_points_um)} from the points"


def _correction_text(outcome: SkirtOutcome) -> str:
    """Return what was expected of a part whose table gauged parts have corrected."""
    correction = outcome.generated.geometry.correction
    if correction is None:
        return ""
    about = correction.rounds[-1]
    left = about["expected_um"]
    return (
        f"round {len(correction.rounds)}: measured at most "
        f"{length_text(about['gauged_um']['max'])}; expected {length_text(left['max'])}, "
        f"rms {length_text(left['rms'])}"
    )


def _control_text(outcome: SkirtOutcome) -> str:
    geometry, control = outcome.generated.geometry, outcome.summary.get("control_error_um")
    if control is None or geometry.drawn is None:
        return ""
    return f"{error_pair(control)} against the {geometry.played_name}"


def _zone_text(found: Json) -> str:
    if not found["samples"]:
        return "not cut"
    verdict = "good" if found["is_good"] else "out of tolerance"
    beyond_um = found["excess_um"]
    of_band = beyond_um > max(0.0, found["max_um"] - found["tolerance_um"])
    beyond = f", {length_text(beyond_um)} beyond its band" if of_band else ""
    text = error_pair({"max": found["max_um"], "rms": found["rms_um"]})
    at = f"{360 * found['max_at_turn']:.1f} degrees, height {found['max_at_z_mm']:.3f} mm"
    return f"{verdict}: {text} at {at}; {length_text(found['tolerance_um'])} accepted{beyond}"


def _zone_rows(outcome: SkirtOutcome) -> list[ReportRow]:
    """Return the verdict of each zone of tolerance."""
    zones = outcome.summary.get("zones", [])
    return [ReportRow(f"zone {found['name']}", _zone_text(found)) for found in zones]


def _window_text(outcome: SkirtOutcome) -> str:
    windows = outcome.generated.part.piston.windows
    if not windows:
        return ""
    names = ", ".join(dict.fromkeys(window.name for window in windows))
    margins = sorted({window.margin_mm for window in windows})
    apart = " .. ".join(f"{margin:g}" for margin in dict.fromkeys((margins[0], margins[-1])))
    return f"{names}: no verdict in them, nor within {apart} mm of an edge"


def _smoothing_rows(outcome: SkirtOutcome) -> list[ReportRow]:
    part = outcome.generated.part
    found, noise = smoothing_facts(part.piston), noise_facts(part.piston)
    texts = smoothing_texts(found, noise, part.process.form_error_um)
    return [ReportRow("smoothing", text) for text in texts]


def _removal_rows(outcome: SkirtOutcome) -> list[ReportRow]:
    if outcome.even is None:
        return []
    ours, theirs = outcome.even.summary["removal"], outcome.even.uniform_summary["removal"]
    if "rate_ripple" not in ours or "rate_ripple" not in theirs:
        text = "unknown: no whole turn at full feed was cut"
        return [ReportRow("ripple of the removal rate", text)]
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


def tool_rows(outcome: AnyCut) -> list[ReportRow]:
    """Return the rows of the tool and of what stays between its tracks."""
    made, summary = outcome.generated, outcome.summary
    law = getattr(made.part.process, "feed_law", None)
    peak = max(law.feed_mm) / made.part.process.feed_mm if law is not None else 1.0
    tool = made.part.tool
    return [tool_row(summary, tool, made.heel), track_row(summary, tool, peak)]


def table_error_nm(outcome: AnyCut) -> float:
    """Return the largest error of a table of U and X [nm]."""
    made = outcome.generated
    return float(max(made.accuracy_u.value_nm, made.accuracy_x.value_nm))


def table_errors(made: Any) -> Json:  # noqa: ANN401 (a skirt or a polygon)
    """Return the errors of a table of U and X for the summary of a cut."""
    error = {"u": made.accuracy_u.value_nm, "x": made.accuracy_x.value_nm}
    return {"table_error_nm": error | {"tolerance": made.tolerance_nm}}


def section_machine(part: Any) -> str:  # noqa: ANN401 (a skirt or a polygon)
    """Return camsim's machine file for a part that is turned by sections."""
    return machine_text(part.machine.limits, part.tool.wear_um)


ROWS = (
    quantity("cut", what_was_cut),
    quantity(
        "form error",
        lambda cut: form_text(cut.summary["form_error_um"], smoothing_takes_um(cut.generated.part)),
    ),
    _zone_rows,
    quantity("windows", _window_text),
    quantity("correction by measured parts", _correction_text),
    quantity("controller's own error", _control_text),
    pass_rows,
    FOLLOWING_ERROR,
    learned,
    quantity("refit of the corner", _corner_text),
    quantity("filter of the points", _filter_text),
    lambda cut: [
        ReportRow("overshoot", text) for text in notable_overshoots(cut.generated.part.piston)
    ],
    _smoothing_rows,
    _removal_rows,
    tool_rows,
    table_quantity(table_error_nm),
    MACHINE_TIME,
    COMPUTING_TIME,
)
