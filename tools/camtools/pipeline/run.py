"""The whole pipeline: table, cut on the host simulator, gauge, report, for every kind of part.

All cuts of a part work in the folder of the table, which is the working folder.

>>> from camtools.pipeline.job import Correcting
>>> job = RunJob(Correcting(), feed=0.5)
>>> made = make(load(job.part), job.part)
>>> turns_of(job, made)
124.0
"""

import json
import shutil
import sys
import time
from collections.abc import Sequence
from contextlib import chdir, suppress
from pathlib import Path
from typing import Annotated, NamedTuple

from camtools.base.arguments import Words
from camtools.base.errors import CamtoolsError
from camtools.base.files import cannot_write, staged
from camtools.base.project import Origin, origin_of
from camtools.base.quantities import length_text
from camtools.base.text import Json, duration_text, size_text
from camtools.pipeline.job import RUNS, RunJob, say, shown, without_faults, write_files
from camtools.pipeline.kind import Rig, made_cut
from camtools.pipeline.load import Made, load, make
from camtools.report.kind_report import make_report, rows_of
from camtools.report.sheet_page import SHEETS, out_of_tolerance
from camtools.report.text import ReportRow, certified_facts, page_text, remedies, verdict_of
from camtools.sim.drawn_parts import DrawnParts
from camtools.sim.drive_mismatch import SHARE, Mismatch, mismatch
from camtools.sim.results import (
    OVERVIEW,
    SECTIONS,
    SUMMARY,
    SURFACE,
    TRACE,
    AnyCut,
    Cut,
    CutVariant,
    read_trace,
    sections_of,
    surface_of,
)
from camtools.sim.simulate import Result, begun

_OVERVIEW_TICKS = 50_000
MAX_TRACED_TICKS = 500_000  # about 13 MB of trace
_WINDOW_TURNS = 200  # at most of a longer cut, for trace and comparison
_TICK_HZ = 20_000  # of the default machine; good enough for an estimate
# Learning makes up for what is missing, so each part is judged without it.
_VARIANTS = {
    "complete controller": [],
    "without learning": ["--no-learning"],
    "without learning and lead": ["--no-learning", "--no-lead"],
    "without learning and feed-forward": ["--no-learning", "--no-feed-forward"],
}
_LONG_TICKS = 3_000_000  # a few seconds of computing
_TRIAL_TICKS = 400_000
_SHOWN_EVERY_S, _LINE_EVERY_S = 0.2, 20.0  # progress on a terminal, and elsewhere


def traced_turns(turns: float, speed_rpm: float) -> float | None:
    """Return how many turns of a cut too long to trace are traced, nothing when all of it is."""
    ticks_per_turn = 60 / speed_rpm * _TICK_HZ
    if turns * ticks_per_turn <= MAX_TRACED_TICKS:
        return None
    return min(_WINDOW_TURNS, MAX_TRACED_TICKS / 2 / ticks_per_turn)


class CutPlan(NamedTuple):
    """What a cut will take.

    >>> CutPlan(650.0, 17.5, 20_000.0).text()
    '650 turns, 18 s of machine time'
    >>> CutPlan(6_200_030.0, 148_802.0, 20_000.0, 2_976.0).text()
    '6200030 turns, 1 d 17 h of machine time, about 49 min 36 s of computing'
    """

    turns: float  # of all passes
    machine_s: float
    tick_hz: float
    computing_s: float | None = None  # of a cut that is long

    @property
    def is_long(self) -> bool:
        """Return whether people want to know how far it is."""
        return self.machine_s * self.tick_hz > _LONG_TICKS

    def text(self) -> str:
        """Return it in a few words."""
        computing = self.computing_s
        about = "" if computing is None else f", about {duration_text(computing)} of computing"
        return f"{self.turns:.0f} turns, {duration_text(self.machine_s)} of machine time{about}"


def plan_of(table: str, words: Sequence[str]) -> CutPlan:
    """Return what a cut will take, or what the simulator refuses."""
    with begun([table, *words]) as session:
        plan = CutPlan(*session.plan())
        if not plan.is_long:
            return plan
        begin_s = time.monotonic()
        session.run(_TRIAL_TICKS)
        tick_s = (time.monotonic() - begin_s) / _TRIAL_TICKS
    return plan._replace(computing_s=plan.machine_s * plan.tick_hz * tick_s)


class _Progress:
    """Reports how much of a cut is done, in place on a terminal, else in a line now and then."""

    def __init__(self, machine_s: float) -> None:
        self._machine_s = machine_s
        self._begin_s = self._shown_s = time.monotonic()
        self._is_terminal = sys.stderr.isatty()

    def __call__(self, share: float) -> None:
        now_s = time.monotonic()
        every_s = _SHOWN_EVERY_S if self._is_terminal else _LINE_EVERY_S
        if share < 1 and now_s < self._shown_s + every_s:
            return
        self._shown_s = now_s
        left_s = (now_s - self._begin_s) * (1 / share - 1) if share else 0.0
        begin = "\r" if self._is_terminal else ""
        end = "   " if self._is_terminal and share < 1 else "\n"
        done = f"{100 * share:5.1f} %, {share * self._machine_s:.1f} s of machine time"
        sys.stderr.write(f"{begin}camsim: {done}, about {left_s:.0f} s left{end}")
        sys.stderr.flush()


def cut_part(
    table: str,
    words: Sequence[str],
    plan: CutPlan,
    window_turns: float | None,
    every: int = 1,
    *,
    sections_mm: Sequence[float] = (),
    keeps_text: bool = False,
) -> Result:
    """Cut a part; write surface, sections and trace; return the result with surface and sections.

    With `window_turns` the trace is that of a second run, which ends after so many turns, and an
    overview of the cut itself holds one tick of `every`. Heights of sections are rising; without
    any camsim chooses. `keeps_text` writes the traces as CSV, too.
    """
    more = ["--sections-mm", ",".join(map(repr, sections_mm))] if len(sections_mm) else []
    more += [] if window_turns is None else ["--trace-every", str(every)]

    def trace(file: str) -> dict[str, str]:
        names = [file, Path(file).with_suffix(".csv").name] if keeps_text else [file]
        return dict.fromkeys(names, "trace")

    files = {SURFACE: "surface", SECTIONS: "sections"}
    result = made_cut(
        *(table, [*words, *more]),
        tables=("surface", "sections"),
        files=files | trace(TRACE if window_turns is None else OVERVIEW),
        progress=_Progress(plan.machine_s) if plan.is_long else None,
    )
    if result.message:
        sys.stderr.write(f"camsim: {result.message}\n")
    if window_turns is not None:
        made_cut(table, [*words, "--turns-limit", repr(window_turns)], files=trace(TRACE))
    return result


def variant_of(name: str, summary: Json) -> CutVariant | None:
    """Return the controller's own error in a comparison cut, None when nothing was cut."""
    form = summary["control_error_um" if "control_error_um" in summary else "form_error_um"]
    if form["max"] is None:
        return None
    ended = "" if summary["end"] in ("done", "stopped") else f" (ended early: {summary['end']})"
    return CutVariant(name + ended, form["max"], form["rms"])


def compare(table: str, words: Sequence[str], window_turns: float | None) -> tuple[CutVariant, ...]:
    """Return the same cut with parts of the controller switched off, the complete one first."""
    limit = [] if window_turns is None else ["--turns-limit", repr(window_turns)]
    found = []
    for name, switches in _VARIANTS.items():
        with suppress(CamtoolsError):
            found.append(variant_of(name, made_cut(table, [*words, *limit, *switches]).summary))
    return tuple(variant for variant in found if variant is not None)


_MARK = "run_wall_time_s"  # only the summary of a run of the whole pipeline has it
_MOST_NAMED = 6


class Kept(NamedTuple):
    """The results of a run."""

    name: str
    made_s: float
    n_bytes: int


def _is_run(folder: Path) -> bool:
    try:
        return _MARK in json.loads((folder / SUMMARY).read_bytes())
    except (OSError, ValueError, TypeError):
        return False


def runs(place: Path) -> list[Kept]:
    """Return the runs in a folder, the newest first."""
    found = []
    for folder in place.iterdir() if place.is_dir() else ():
        if folder.is_dir() and not folder.is_symlink() and _is_run(folder):
            n_bytes = sum(f.lstat().st_size for f in folder.rglob("*") if f.is_file())
            found.append(Kept(folder.name, (folder / SUMMARY).stat().st_mtime, n_bytes))
    return sorted(found, key=lambda run: (-run.made_s, run.name))


def drop_all_but(place: Path, n: int) -> list[Kept]:
    """Remove the oldest runs until so many are left; return those that were removed."""
    dropped = runs(place)[n:]
    for run in dropped:
        shutil.rmtree(place / run.name, ignore_errors=True)
    return dropped


def kept_text(place: Path) -> str:
    """Return what lies there in one line."""
    found = runs(place)
    if not found:
        return "no runs"
    names = [run.name for run in found]
    more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
    total = size_text(sum(run.n_bytes for run in found))
    count = f"{len(found)} run" + ("s" if len(found) != 1 else "")
    return f"{count}, {total}: {', '.join(names[:_MOST_NAMED])}{more}"


def turns_of(job: RunJob, made: Made) -> float:
    """Return how many turns the cut takes, about."""
    return made.kind.turns(made.table, job.feed or made.table.part.process.feed_mm)


def _simulate(
    job: RunJob, made: Made, folder: Path, origin: Origin, drawn: DrawnParts | None
) -> AnyCut:
    kind, part, name = made.kind, made.table.part, made.table.part.part.name
    machine, turns = f"{name}_machine.toml", turns_of(job, made)
    rpm = kind.mean_rpm(made.table, job.rpm)
    window = traced_turns(turns, rpm)
    files = made.files(with_plots=False)
    text = kind.machine(part).encode("ascii") if job.machine is None else job.machine
    write_files(folder, files | {machine: text})
    table = f"{name}.camtab"
    words = [
        *("--machine", machine, *kind.speed_words(job.rpm), *job.feed_words(), *job.extra),
        *job.tolerance(part.process.form_error_um, kind.taken_um(made.table)),
    ]
    plain, every = without_faults(words), int(turns * 60 / rpm * _TICK_HZ / _OVERVIEW_TICKS) + 1
    sections_mm = kind.sections_mm(made.table, job.feed or part.process.feed_mm)
    try:
        with chdir(folder):  # camsim names files as its words do
            plan = plan_of(table, words)
            say(f"cutting {plan.text()} on the host simulator")
            result = cut_part(
                *(table, words, plan, window, every), sections_mm=sections_mm, keeps_text=job.csv
            )
            seen: AnyCut = Cut(
                made.table,
                result.summary,
                surface_of(result.surface),
                read_trace(Path(TRACE)),
                window is None,
                compare(table, plain, window),
                read_trace(Path(OVERVIEW)) if window is not None else None,
                origin,
                sections_of(result.sections),
                job.upr,
                drawn,
            )
            outcome: AnyCut = kind.outcome(seen, Rig(result, table, plain, turns))
    except OSError as error:
        raise cannot_write(folder.parent, error) from error
    return outcome


def _mismatch(job: RunJob, made: Made, folder: Path) -> Mismatch | None:
    """Return what a drive costs that is 5 % off; where that cannot be told, say why."""
    part, name = made.table.part, made.table.part.part.name
    text = made.kind.machine(part) if job.machine is None else job.machine.decode("utf-8")
    words = [*made.kind.speed_words(job.rpm), *job.feed_words(), *without_faults(job.extra)]
    table = folder / f"{name}.camtab"
    try:
        return mismatch(table, text, words, made.kind.mean_rpm(made.table, job.rpm))
    except CamtoolsError as error:
        say(f"the effect of a U drive {100 * SHARE:.0f} % slower is not known: {error}")
        return None


def complete_summary(made: Made, outcome: AnyCut, off: Mismatch | None, total_s: float) -> Json:
    """Return camsim's summary with what else is known."""
    ticks = int(outcome.trace.t_s.size)
    return {
        **outcome.summary,
        **made.kind.facts(made.table),
        "trace": {"file": TRACE, "ticks": ticks, "is_complete": outcome.is_trace_complete},
        "comparison": [variant._asdict() for variant in outcome.variants],
        "smoothing_takes_um": made.kind.taken_um(made.table),
        "drive_off": None if off is None else off.facts(),
        "run_wall_time_s": total_s,
    }


def run(
    job: RunJob,
    typed: Annotated[tuple[str, ...], Words()] = (),
    extra: Annotated[tuple[str, ...], Words(is_after_dashes=True)] = (),
) -> int:
    """Make the table of a part, cut the part on the host simulator, write a report."""
    begin_s = time.monotonic()
    job = job.with_words(extra)
    origin = origin_of("tools/run", list(typed))
    loaded = load(job.part)
    job.check_feed(loaded.part)
    if job.feed is not None:
        loaded.kind.check_feed(loaded.part, job.feed)
    correction = job.correcting.correction(loaded, None if job.output is None else Path(job.output))
    say(f"making the table of {job.part.name}")
    made = make(
        *(loaded, job.part), rpm=job.rpm, tolerance_nm=job.tolerance_nm, correction=correction
    )
    drawn = job.drawn(made)
    folder = job.folder(loaded.part.part.name, len(correction.rounds) if correction else 0)
    with staged(folder) as stage:
        outcome = _simulate(job, made, stage.folder, origin, drawn)
        off = _mismatch(job, made, stage.folder)
        say("drawing the report")
        report = made.kind.report()
        files = make_report(report, outcome)
        out = out_of_tolerance(files.get(SHEETS))
        undecided = out_of_tolerance(files.get(SHEETS), "not_decided")
        verdict = verdict_of(outcome, out, undecided)
        is_good = verdict.kind == "good"
        write_files(stage.folder, files)
        summary = complete_summary(made, outcome, off, time.monotonic() - begin_s)
        summary |= {"is_good": is_good, "sheets_out_of_tolerance": out}
        summary |= {"verdict": verdict.title, "sheets_not_decided": undecided}
        summary |= {"certified": certified_facts(outcome)}
        text = json.dumps(summary, indent=1, allow_nan=False) + "\n"
        write_files(stage.folder, {SUMMARY: text.encode("ascii")})
        stage.publish()
    rows, total_s = rows_of(report, outcome), time.monotonic() - begin_s
    if "better_rpm" in outcome.summary:
        text = "encoder counts do not average at this speed (whole ones per tick)"
        rows.append(ReportRow("better speed", f"{outcome.summary['better_rpm']:g} r/min: {text}"))
    if "is_loop_assumed" in outcome.summary:
        text = "not measured; run tools/tune --machine FILE -o DIR --apply"
        rows.append(ReportRow("loop of U", text))
    form = outcome.summary["form_error_um"]
    if form.get("turned_urad") is not None:
        largest, rms = (length_text(form[f"{kind}_not_turned"]) for kind in ("max", "rms"))
        text = f"{form['turned_urad']:+.1f} µrad; without it max {largest}, rms {rms}"
        rows.append(ReportRow("whole part turned", text))
    if off is not None:
        rows.append(ReportRow(f"if U were {100 * SHARE:.0f} % slower", off.text()))
        rows += remedies(off.faults)
    sys.stdout.write(page_text(outcome, rows, shown(folder), total_s, out, undecided))
    if job.output is None:
        for old in drop_all_but(RUNS, job.keep) if job.keep is not None else ():
            say(f"removed {shown(RUNS / old.name)}, {size_text(old.n_bytes)}")
        hint = "" if job.keep is not None else "; --keep N deletes all but the N newest"
        say(f"{shown(RUNS)} holds {kept_text(RUNS)}{hint}")
    return 0 if is_good else 1
