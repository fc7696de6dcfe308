"""What a cut came to, in words and numbers, for the terminal and for the report.

>>> share(30.0, 120.0)
'25 %'
>>> plain("0.1 µm, 3 m/s²")
'0.1 um, 3 m/s2'
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

import numpy as np

from camtools.base.errors import InputError
from camtools.plots.style import length_text
from camtools.sim.results import FAULT, Cut, Json, Outcome
from camtools.skirt.refit import judge

_FAULTS = Path(__file__).resolve().parents[3] / "firmware" / "FAULTS.md"
_FAULT_ROW = re.compile(r"^\| `(\w+)` \|(.*)\|$", re.MULTILINE)
_CLEAR_MM = 0.2  # the tool counts as out of the work: twice the usual depth of cut
_MARGINS = {
    "spindle_rpm": ("spindle speed", "r/min", 1.0),
    "u_speed_mm_s": ("U speed", "mm/s", 1.0),
    "u_acceleration_mm_s2": ("U acceleration", "m/s²", 1e-3),
    "u_stroke_mm": ("U stroke", "mm", 1.0),
    "spindle_acceleration_rad_s2": ("spindle acceleration", "rad/s²", 1.0),
}


class Row(NamedTuple):
    """One line of a summary."""

    name: str
    value: str


class Verdict(NamedTuple):
    """The result in one word for the eye and one sentence."""

    kind: str  # good, poor or fault
    title: str
    sentence: str


class Margin(NamedTuple):
    """How much of a limit of the machine a cut needs."""

    name: str
    needed: str
    limit: str
    percent: float


class FaultFacts(NamedTuple):
    """A line of firmware/FAULTS.md."""

    cause: str
    seen_within: str
    armed_in: str
    remedy: str


def share(needed: float, limit: float) -> str:
    """Return needed as a percentage of limit."""
    return f"{100 * needed / limit:.0f} %"


def plain(text: str) -> str:
    """Return text with the few characters that not every terminal shows replaced."""
    for wide, ascii_text in (("µ", "u"), ("²", "2"), ("°", " deg"), ("±", "+-")):
        text = text.replace(wide, ascii_text)
    return text


def verdict_of(outcome: Cut) -> Verdict:
    """Return whether the part is good, and why not."""
    summary = outcome.summary
    form = summary["form_error_um"]
    if outcome.has_fault:
        first = ", ".join(summary["first_faults"])
        return Verdict("fault", f"fault: {first}", "The controller ended the cut by itself.")
    if form["max"] is None:
        return Verdict(
            "poor", f"nothing cut ({summary['end']})", "No surface was cut to full depth."
        )
    found = f"largest form error {length_text(form['max'])}"
    allowed = f"tolerance of {length_text(form['tolerance'])}"
    if form["max"] > form["tolerance"]:
        return Verdict("poor", "out of tolerance", f"The {found} is above the {allowed}.")
    if summary["end"] != "done":
        return Verdict("poor", f"incomplete: {summary['end']}", "The cut did not reach the end.")
    if not outcome.is_good:  # a lobe of a cam
        return Verdict("poor", "not gauged", f"The {found}, but the gauge has not seen all of it.")
    return Verdict("good", "within tolerance", f"The {found} is within the {allowed}.")


def what_was_cut(outcome: Outcome) -> str:
    """Return part, speed, feed and turns in one phrase."""
    cut, geometry = outcome.summary["cut"], outcome.generated.geometry
    span_mm = geometry.z_last_mm - geometry.z_first_mm
    magnify = outcome.generated.part.magnify
    enlarged = f", deviations enlarged {magnify.factor:g} times" if magnify else ""
    mean = "mean " if outcome.generated.speed is not None else ""
    return (
        f"skirt of {span_mm:g} mm at {mean}{cut['spindle_rpm']:g} r/min, "
        f"feed {cut['feed_mm']:g} mm, "
        f"{cut['turns']:.0f} of {cut['planned_turns']:.0f} turns{enlarged}"
    )


def error_pair(error: Json) -> str:
    """Return largest and rms of an error [um] in words."""
    if error["max"] is None:
        return "none: nothing was cut to full depth"
    return f"max {length_text(error['max'])}, rms {length_text(error['rms'])}"


def margins_of(outcome: Outcome) -> list[Margin]:
    """Return needed and limit of spindle and U, as the controller judged them."""
    return margins_in(outcome.summary, is_modulated=outcome.generated.speed is not None)


def margins_in(summary: Json, *, is_modulated: bool) -> list[Margin]:
    """Return the margins of a summary; of the spindle's acceleration when its speed changes."""
    found = []
    for key, (name, unit, scale) in _MARGINS.items():
        if key == "spindle_acceleration_rad_s2" and not is_modulated:
            continue
        one = summary["feasibility"][key]
        needed, limit = one["needed"] * scale, one["limit"] * scale
        percent = 100 * needed / limit
        found.append(Margin(name, f"{needed:.4g} {unit}", f"{limit:.4g} {unit}", percent))
    return found


def _corner_rows(outcome: Outcome) -> list[Row]:
    """Return what the refit of a corner costs, nothing for other sections."""
    corner = outcome.generated.geometry.corner
    if corner is None or corner.recipe is None:
        return []
    joint, recipe = corner.joint(corner.worst_mm), corner.recipe
    found = judge(joint, recipe, outcome.summary["cut"]["spindle_rpm"])
    deleted = f"({recipe.s1}, {recipe.s2})"
    return [
        Row(
            "refit of the corner",
            f"{recipe.spline}, {deleted} left out: at most {length_text(found.deviation_um)} off "
            "the drawing; form error is against the refit",
        )
    ]


def _removal_rows(outcome: Outcome) -> list[Row]:
    """Return what equal-volume turning brought, nothing for uniform turning."""
    if outcome.even is None:
        return []
    ours, theirs = outcome.even.summary["removal"], outcome.even.uniform_summary["removal"]
    if "rate_ripple" not in ours or "rate_ripple" not in theirs:
        return [Row("ripple of the removal rate", "none: no whole turn at full feed was measured")]
    rate, plain = ours["rate_ripple"], theirs["rate_ripple"]
    chip, plain_chip = ours["chip_force_ripple"], theirs["chip_force_ripple"]
    return [
        Row(
            "ripple of the removal rate",
            f"mean {100 * rate['mean']:.1f} %, max {100 * rate['max']:.1f} % of its mean in a turn "
            f"(uniform turning {100 * plain['mean']:.0f} %, {100 * plain['max']:.0f} %)",
        ),
        Row(
            "ripple of the chip's force",
            f"mean {100 * chip['mean']:.0f} % (uniform turning {100 * plain_chip['mean']:.0f} %): "
            "no speed law changes it",
        ),
        Row(
            "form error at uniform speed",
            error_pair(outcome.even.uniform_summary["form_error_um"]),
        ),
    ]


def rows_of(outcome: Outcome) -> list[Row]:
    """Return the summary, machine limits apart."""
    summary, generated = outcome.summary, outcome.generated
    form = summary["form_error_um"]
    worst_nm = max(generated.accuracy_u.value_nm, generated.accuracy_x.value_nm)
    wall_s, machine_s = summary["wall_time_s"], summary["machine_time_s"]
    return [
        Row("cut", what_was_cut(outcome)),
        Row("form error", f"{error_pair(form)} (tolerance {length_text(form['tolerance'])})"),
        Row("following error of U", error_pair(summary["following_error_um"])),
        *_corner_rows(outcome),
        *_removal_rows(outcome),
        Row("table", f"{summary['table_bytes']} bytes, error at most {worst_nm:.2g} nm"),
        Row("machine time", f"{machine_s:.1f} s"),
        Row("computing time", f"{wall_s:.2f} s for the cut with its trace"),
    ]


def terminal_text(outcome: Outcome, place: str, total_s: float) -> str:
    """Return the summary table for the terminal.

    Parameters
    ----------
    place : str
        Folder of the results, as the user may type it.
    total_s : float
        Computing time of everything [s].
    """
    return page_text(outcome, rows_of(outcome), margins_of(outcome), place, total_s)


def page_text(
    outcome: Cut, about: list[Row], margins: list[Margin], place: str, total_s: float
) -> str:
    """Return rows and margins as `terminal_text` does."""
    rows = [row for row in about if row.name != "computing time"]
    for margin in margins:
        value = f"{margin.needed} of {margin.limit} ({margin.percent:.0f} %)"
        rows.append(Row(f"needs {margin.name}", value))
    cut_s = outcome.summary["wall_time_s"]
    rows.append(Row("computing time", f"{total_s:.1f} s in all, {cut_s:.2f} s for the cut"))
    rows.append(Row("results", f"{place}/report.html and the files beside it"))
    width = max(len(row.name) for row in rows)
    lines = [f"{outcome.name}: {verdict_of(outcome).title}"]
    lines += [f"  {row.name:<{width}}  {plain(row.value)}" for row in rows]
    return "\n".join(lines) + "\n"


def fault_facts(path: Path = _FAULTS) -> dict[str, FaultFacts]:
    """Return the table of faults of the firmware's manual.

    Raises
    ------
    InputError
        The manual cannot be read.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        problem = f"cannot be read: {error.strerror}"
        raise InputError(path.name, "", None, problem, "restore it from the repository") from error
    rows = {name: rest.split(" | ") for name, rest in _FAULT_ROW.findall(text)}
    return {
        name: FaultFacts(*(_spelled_out(cell) for cell in cells))
        for name, cells in rows.items()
        if len(cells) == len(FaultFacts._fields)
    }


def _spelled_out(cell: str) -> str:
    """Return a cell of the manual without its short symbols: T, T_o."""
    text = cell.strip().replace("`", "").replace("T_o", "the settling time of the speed reading")
    return re.sub(r"\bT\b", "tick", text)


def clear_after_s(outcome: Cut) -> float | None:
    """Return how long after the fault the tool was out of the work [s], if the trace tells."""
    trace = outcome.trace
    after = np.flatnonzero(trace.state == FAULT)
    clear = after[trace.error_nm[after] > _CLEAR_MM * 1e6]
    if not clear.size:
        return None
    return float(trace.t_s[clear[0]] - trace.t_s[after[0]])


def fault_story(outcome: Cut) -> list[Row]:
    """Return what happened, when, and what the controller did, in the order of time."""
    fault, facts = outcome.summary["fault"], fault_facts()
    rows = [
        Row(name, f"{facts[name].cause}; seen within {facts[name].seen_within}")
        for name in outcome.summary["first_faults"]
        if name in facts
    ]
    rows += [Row("when", _when(fault)), Row("reaction", _reaction(outcome))]
    later = [
        name for name in outcome.summary["faults"] if name not in outcome.summary["first_faults"]
    ]
    if later:
        rows.append(Row("came on top", ", ".join(later)))
    rows += [
        Row("before the next try", facts[name].remedy)
        for name in outcome.summary["first_faults"]
        if name in facts
    ]
    return rows


def _when(fault: Json) -> str:
    since = fault.get("time_of_cutting_s")
    cutting = "" if since is None else f" ({since:.3f} s into the cut)"
    place = f"height {fault['z_mm']:.3f} mm, angle {360 * fault['turn']:.1f}°"
    return f"{fault['time_s']:.4f} s after the start{cutting}, {fault['state']}, {place}"


def _reaction(outcome: Cut) -> str:
    if "drive" in outcome.summary["first_faults"]:
        return "A drive that is not ready cannot retract: its enable was dropped in the same tick."
    clear_s = clear_after_s(outcome)
    if clear_s is None:
        clear = ""
    elif clear_s > 0:
        clear = f" The tool was {_CLEAR_MM} mm clear after {clear_s * 1e3:.1f} ms."
    else:
        clear = " The tool was out of the work already."
    rest_ms = outcome.summary["fault"]["retract_s"] * 1e3
    return (
        "In the same tick the controller took the axes over: U was told to retract, X to move off, "
        f"Z to brake, the spindle to stop.{clear} Enable was dropped after {rest_ms:.1f} ms."
    )
