"""Command line of the whole way: table, cut on the host simulator, gauge, report.

>>> from camtools.skirt.part import example_part
>>> _turns(Job(["--feed", "0.5"]), generate(example_part()))
124.0
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from camtools.base.command import BAD_INPUT, run_command
from camtools.base.errors import CamtoolsError
from camtools.base.stage import Stage
from camtools.cli.job import Job, say, shown, without_faults, write_files
from camtools.cli.mktables import products
from camtools.cut.path import Path as ToolPath
from camtools.lobe.part import CamPart
from camtools.lobe.run_cam import run_cam
from camtools.part.file import load_any
from camtools.sim.camsim import (
    SUMMARY,
    SURFACE,
    TRACE,
    Simulator,
    camsim_path,
    compare,
    cut,
    machine_text,
    traced_turns,
)
from camtools.sim.results import (
    Even,
    Json,
    Outcome,
    Variant,
    read_summary,
    read_surface,
    read_trace,
)
from camtools.skirt.generate import Generated, generate
from camtools.skirt.part import Part
from camtools.skirt.report_text import terminal_text
from camtools.skirt.run_even import compare_removal


def _turns(job: Job, generated: Generated) -> float:
    """Return how many turns the cut takes, about."""
    geometry = generated.geometry
    process = generated.part.process
    ends = geometry.z_first_mm, geometry.z_last_mm
    return ToolPath(process.path, *ends, job.feed_mm or process.feed_mm).turns


def _window_turns(job: Job, generated: Generated) -> float | None:
    """Return how many turns to trace, nothing when the whole cut can be traced."""
    return traced_turns(_turns(job, generated), job.rpm or generated.part.process.spindle_rpm)


def _at_speed(part: Part, rpm: float | None) -> Part:
    """Return the part for another mean speed: the law of its modulation depends on it."""
    if rpm is None or part.process.mode == "uniform":
        return part
    process = part.process.model_copy(update={"spindle_rpm": rpm})
    return part.model_copy(update={"process": process})


def _make_table(path: Path, part: Part, rpm: float | None) -> Generated:
    """Return the table of a part; of a modulated part for the speed asked for.

    Raises
    ------
    CamtoolsError
        With the file's name in every line.
    """
    try:
        return generate(_at_speed(part, rpm))
    except CamtoolsError as error:
        raise CamtoolsError([f"{path}: {line}" for line in error.lines]) from error


def _read(
    generated: Generated,
    folder: Path,
    variants: tuple[Variant, ...],
    window: float | None,
    even: Even | None,
) -> Outcome:
    return Outcome(
        generated,
        read_summary(folder / SUMMARY),
        read_surface(folder / SURFACE),
        read_trace(folder / TRACE),
        window is None,
        variants,
        even,
    )


def _complete_summary(outcome: Outcome, total_s: float) -> Json:
    """Return camsim's summary with what else is known."""
    generated = outcome.generated
    return outcome.summary | {
        "table_error_nm": {
            "u": generated.accuracy_u.value_nm,
            "x": generated.accuracy_x.value_nm,
            "tolerance": generated.tolerance_nm,
        },
        "trace": {
            "file": TRACE,
            "ticks": int(outcome.trace.t_s.size),
            "is_complete": outcome.is_trace_complete,
        },
        "comparison": [variant._asdict() for variant in outcome.variants],
        "run_wall_time_s": total_s,
    }


def _cut_and_report(job: Job, generated: Generated, stage: Stage, begin_s: float) -> Outcome | None:
    """Fill the stage; return nothing when camsim refused and said why."""
    from camtools.skirt.report import make_report  # after the cut: matplotlib is slow to load

    name, window = generated.part.part.name, _window_turns(job, generated)
    machine = f"{name}_machine.toml"
    files = products(generated, with_plots=False)
    files[machine] = machine_text(generated.part.machine.limits).encode("ascii")
    write_files(stage.folder, files)
    simulator = Simulator(camsim_path(), stage.folder, f"{name}.camtab")
    words = [
        "--machine",
        machine,
        *job.tolerance(generated.part.process.form_error_um),
        *job.options(),
        *job.extra,
    ]
    if cut(simulator, words, window) == BAD_INPUT:
        return None
    plain = without_faults(words)
    variants = compare(simulator, plain, window)
    even = compare_removal(simulator, generated, plain, _turns(job, generated))
    say("drawing the report")
    outcome = _read(generated, stage.folder, variants, window, even)
    write_files(stage.folder, make_report(outcome))
    summary = _complete_summary(outcome, time.monotonic() - begin_s)
    text = json.dumps(summary, indent=1, allow_nan=False) + "\n"
    write_files(stage.folder, {SUMMARY: text.encode("ascii")})
    return outcome


def _run(argv: Sequence[str]) -> int:
    begin_s = time.monotonic()
    job = Job(argv)
    part = load_any(job.part_path)
    job.check_feed(part)
    say(f"making the table of {job.part_path.name}")
    if isinstance(part, CamPart):
        return run_cam(job, part, begin_s)
    generated = _make_table(job.part_path, part, job.rpm)
    folder = job.folder(generated.part.part.name)
    with Stage(folder) as stage:
        say(f"cutting {_turns(job, generated):.0f} turns on the host simulator")
        outcome = _cut_and_report(job, generated, stage, begin_s)
        if outcome is None:
            return BAD_INPUT
        stage.publish()
    sys.stdout.write(terminal_text(outcome, shown(folder), time.monotonic() - begin_s))
    return 0 if outcome.is_good else 1


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return its exit status.

    Returns
    -------
    int
        0 done, 1 fault or out of tolerance, 2 wrong usage or bad input, 128 + n on signal n.
    """
    return run_command("run", lambda: _run(sys.argv[1:] if argv is None else argv))


if __name__ == "__main__":
    sys.exit(main())
