"""What a cut of any kind came to, in words and numbers, for the terminal and the report.

>>> plain("0.1 µm, 3 m/s²")
'0.1 um, 3 m/s2'
"""

import re
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from camtools.base.errors import InputError
from camtools.base.project import ROOT
from camtools.base.quantities import length_text
from camtools.base.text import Json
from camtools.cut.feasibility import UNITS
from camtools.part.smoothing import share_text
from camtools.sim.drawn_parts import FAIL, NOT_DECIDED, PASS, WHOLE, decision
from camtools.sim.results import FAULT, AnyCut, is_beyond

_FAULTS = ROOT / "firmware" / "FAULTS.md"
_FAULT_ROW = re.compile(r"^\| `(\w+)` \|(.*)\|$", re.MULTILINE)
_MOST_NAMES = 3
_LOST = {"drive", "u_travel", "u_runaway"}  # faults after which nothing retracts
_CLEAR_MM = 0.2  # the tool counts as out of the work: twice the usual depth of cut
_MARGINS = {
    "spindle_rpm": "spindle speed",
    "u_speed_mm_s": "U speed",
    "u_acceleration_mm_s2": "U acceleration",
    "u_stroke_mm": "U stroke",
    "spindle_acceleration_rad_s2": "spindle acceleration",
}
_SHOWN = {"mm/s2": ("m/s²", 1e-3), "rad/s2": ("rad/s²", 1.0)}  # units for people, and the scale


class ReportRow(NamedTuple):
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


def plain(text: str) -> str:
    """Return text with the few characters that not every terminal shows replaced."""
    for wide, ascii_text in (("µ", "u"), ("²", "2"), ("°", " deg"), ("±", "+-")):
        text = text.replace(wide, ascii_text)
    return text


def _named(names: Sequence[str]) -> str:
    """Return the first few names, and how many more there are."""
    more = len(names) - _MOST_NAMES
    return "; ".join(names[:_MOST_NAMES]) + (f"; and {more} more" if more > 0 else "")


def verdict_of(outcome: AnyCut, out: Sequence[str] = (), undecided: Sequence[str] = ()) -> Verdict:
    """Return whether the part is good, and why not; `out` and `undecided`: found by the sheets."""
    summary = outcome.summary
    form = summary["form_error_um"]
    if outcome.has_fault:
        first = ", ".join(summary["first_faults"])
        return Verdict("fault", f"fault: {first}", "The controller stopped the cut.")
    if form["max"] is None:
        title = f"nothing cut ({summary['end']})"
        return Verdict("poor", title, "No surface was cut to full depth.")
    found = f"largest form error {length_text(form['max'])}"
    allowed = f"tolerance of {length_text(form['tolerance'])}"
    within = f"The {found} is within the {allowed}"
    zones = summary.get("zones", [])
    within = f"The {found} is within what each zone accepts" if zones else within
    is_out = is_beyond(summary)
    if is_out and outcome.drawn is None:
        where = [f"in zone {zone['name']}" for zone in zones if not zone.get("is_good", True)]
        where += [] if form.get("is_good_beside_zones", True) else ["beside the zones"]
        above = f"The surface is out of tolerance {_named(where)}." if where else ""
        why = above or f"The {found} is above the {allowed}."
        return Verdict("poor", "out of tolerance", why)
    if summary["end"] != "done":
        cut = summary["cut"]
        turns = f"{cut['turns']:.0f} of {cut['planned_turns']:.0f} turns were cut"
        so_far = "is above the tolerance" if is_out else "is good"
        sentence = f"{turns}. So far the {found} {so_far}."
        return Verdict("poor", f"incomplete: {summary['end']}", sentence)
    if not outcome.is_good and not is_out:  # a lobe of a camshaft, or a zone
        sentence = f"{found.capitalize()}, but not every lobe or zone was gauged."
        return Verdict("poor", "not gauged", sentence)
    if outcome.drawn is not None:
        return _decided(form, outcome.drawn.expanded(WHOLE, form["max"]), out, undecided)
    if out:
        shown = f"but the measurement sheets show out of tolerance: {_named(out)}"
        return Verdict("poor", "out of tolerance", f"{within}, {shown}.")
    return Verdict("good", "within tolerance", f"{within}.")


def certified_facts(outcome: AnyCut) -> Json | None:
    """Return the form error's expanded uncertainty and where it is from; none without forecast."""
    drawn, form_um = outcome.drawn, outcome.summary["form_error_um"]["max"]
    if drawn is None:
        return None
    expanded = None if form_um is None else drawn.expanded(WHOLE, form_um)
    return {"forecast": drawn.folder, "parts": drawn.n_parts, "form_error_u_um": expanded}


def _decided(
    form: Json, expanded: float | None, out: Sequence[str], undecided: Sequence[str]
) -> Verdict:
    """Return the verdict of a whole cut by ISO 14253-1, by the uncertainty of its form error."""
    verdicts = {decision(form["max"], expanded, form["tolerance"])}
    verdicts |= ({FAIL} if out else set()) | ({NOT_DECIDED} if undecided else set())
    title = next(verdict for verdict in (FAIL, NOT_DECIDED, PASS) if verdict in verdicts)
    known = "an unknown U" if expanded is None else f"U = {length_text(expanded)} (k = 2)"
    names = {FAIL: out, NOT_DECIDED: undecided}.get(title)
    sentence = (
        f"The largest form error is {length_text(form['max'])} with {known}, the tolerance "
        + length_text(form["tolerance"])
        + (f"; {title} on the measurement sheets: {_named(names)}." if names else ".")
    )
    return Verdict("good" if title == PASS else "poor", title, sentence)


def error_pair(error: Json) -> str:
    """Return largest and rms of an error [um] in words."""
    if error["max"] is None:
        return "none: nothing was cut to full depth"
    return f"max {length_text(error['max'])}, rms {length_text(error['rms'])}"


def form_text(form: Json, taken_um: float = 0.0) -> str:
    """Return the form error, its reference and its tolerance, of which smoothing takes a share."""
    left = length_text(form["tolerance"]) + (" beside zones" if "excess" in form else "")
    if taken_um == 0:
        return f"{error_pair(form)} against the drawing (tolerance {left})"
    share = share_text(taken_um, form["tolerance"] + taken_um)
    return f"{error_pair(form)} against the smoothed drawing ({left} left: {share})"


RowsOf = Callable[[Any], Sequence[ReportRow]]
"""What a report states of a cut: a row, none or several."""


def quantity(name: str, text: Callable[[Any], str]) -> RowsOf:
    """Return what states a quantity of a cut in a row; no row for an empty text."""

    def rows(cut: AnyCut) -> list[ReportRow]:
        value = text(cut)
        return [ReportRow(name, value)] if value else []

    return rows


FOLLOWING_ERROR = quantity(
    "following error of U", lambda cut: error_pair(cut.summary["following_error_um"])
)
MACHINE_TIME = quantity("machine time", lambda cut: f"{cut.summary['machine_time_s']:.1f} s")
COMPUTING_TIME = quantity(
    "computing time", lambda cut: f"{cut.summary['wall_time_s']:.2f} s for the cut with its trace"
)


def table_quantity(error_nm: Callable[[Any], float]) -> RowsOf:
    """Return what states the size of a table and its largest error [nm]."""
    return quantity(
        "table",
        lambda cut: f"{cut.summary['table_bytes']} bytes, accurate to {error_nm(cut):.2g} nm",
    )


def turns_text(cut: AnyCut) -> str:
    """Return speed, feed and turns of a cut in words."""
    made, mean = cut.summary["cut"], "mean " if cut.is_modulated else ""
    return (
        f"at {mean}{made['spindle_rpm']:g} r/min, feed {made['feed_mm']:g} mm, "
        f"{made['turns']:.0f} of {made['planned_turns']:.0f} turns"
    )


def margins_of(outcome: AnyCut) -> list[Margin]:
    """Return needed and limit of spindle and U; of its acceleration when the speed changes."""
    found = []
    for key, name in _MARGINS.items():
        if key == "spindle_acceleration_rad_s2" and not outcome.is_modulated:
            continue
        unit, scale = _SHOWN.get(UNITS[key], (UNITS[key], 1.0))
        demand = outcome.summary["feasibility"][key]
        needed, limit = demand["needed"] * scale, demand["limit"] * scale
        percent = 100 * needed / limit
        found.append(Margin(name, f"{needed:.4g} {unit}", f"{limit:.4g} {unit}", percent))
    return found


def page_text(
    outcome: AnyCut,
    about: list[ReportRow],
    place: str,
    total_s: float,
    out: Sequence[str] = (),
    undecided: Sequence[str] = (),
) -> str:
    """Return the summary for the terminal: folder as typed, computing time, what is out or open."""
    verdict = verdict_of(outcome, out, undecided)
    rows = [row for row in about if row.name != "computing time"]
    for margin in margins_of(outcome):
        value = f"{margin.needed}, {margin.percent:.0f} % of the limit of {margin.limit}"
        rows.append(ReportRow(f"required {margin.name}", value))
    cut_s = outcome.summary["wall_time_s"]
    rows.append(ReportRow("computing time", f"{total_s:.1f} s in all, {cut_s:.2f} s for the cut"))
    rows.append(ReportRow("results", f"{place}/report.html and the other files there"))
    if out:
        rows.insert(0, ReportRow("out of tolerance", _named(out)))
    if outcome.drawn is not None:
        rows.insert(0, ReportRow("verdict", verdict.sentence))
    width = max(len(row.name) for row in rows)
    lines = [f"{outcome.name}: {verdict.title}"]
    lines += [f"  {row.name:<{width}}  {plain(row.value)}" for row in rows]
    return "\n".join(lines) + "\n"


def origin_rows(outcome: AnyCut) -> list[ReportRow]:
    """Return what a person needs to repeat the cut."""
    summary, origin = outcome.summary, outcome.origin
    machine = ReportRow("machine", f"{summary['machine']}, seed {summary['seed']}")
    if origin is None:
        return [machine]
    made = ReportRow("made", f"{origin.date}, version {origin.version}")
    return [made, ReportRow("command", origin.command), machine]


def fault_facts() -> dict[str, FaultFacts]:
    """Return the table of faults of the firmware's manual, or refuse a missing one."""
    try:
        text = _FAULTS.read_text(encoding="utf-8")
    except OSError as error:
        problem = f"cannot be read: {error.strerror}"
        raise InputError(
            _FAULTS.name, "", None, problem, "restore it from the repository"
        ) from error
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


def clear_after_s(outcome: AnyCut) -> float | None:
    """Return how long after the fault the tool was out of the work [s], none if it never was."""
    trace = outcome.trace
    after = np.flatnonzero(trace.state == FAULT)
    clear = after[trace.error_nm[after] > _CLEAR_MM * 1e6]
    if not clear.size:
        return None
    return float(trace.t_s[clear[0]] - trace.t_s[after[0]])


def fault_story(outcome: AnyCut) -> list[ReportRow]:
    """Return what happened, when, and what the controller did, in the order of time."""
    fault, facts = outcome.summary["fault"], fault_facts()
    rows = [
        ReportRow(name, f"{facts[name].cause}; detected within {facts[name].seen_within}")
        for name in outcome.summary["first_faults"]
        if name in facts
    ]
    since = fault.get("time_of_cutting_s")
    cutting = "" if since is None else f" ({since:.3f} s into the cut)"
    place = f"height {fault['z_mm']:.3f} mm, angle {360 * fault['turn']:.1f}°"
    when = f"{fault['time_s']:.4f} s after the start{cutting}, {fault['state']}, {place}"
    rows += [ReportRow("when", when), ReportRow("reaction", _reaction(outcome))]
    first = outcome.summary["first_faults"]
    if later := [name for name in outcome.summary["faults"] if name not in first]:
        rows.append(ReportRow("later faults", ", ".join(later)))
    return rows + remedies(outcome.summary["first_faults"])


def remedies(faults: Iterable[str]) -> list[ReportRow]:
    """Return a row for each fault that the manual knows."""
    facts = fault_facts()
    return [ReportRow("remedy", facts[name].remedy) for name in faults if name in facts]


def _reaction(outcome: AnyCut) -> str:
    if not _LOST.isdisjoint(outcome.summary["first_faults"]):
        return (
            "A U whose drive is not ready, or whose position loop does not work, cannot retract; "
            "the drives were disabled in the same tick."
        )
    clear, clear_s = "", clear_after_s(outcome)
    if clear_s is not None:
        clear = " The tool was already out of the work."
        if clear_s > 0:
            clear = f" The tool was {_CLEAR_MM} mm clear after {clear_s * 1e3:.1f} ms."
    rest_ms = outcome.summary["fault"]["retract_s"] * 1e3
    return (
        "In the same tick the controller commanded U to retract, X to move away, Z to brake and "
        f"the spindle to stop.{clear} The drives were disabled after {rest_ms:.1f} ms."
    )
