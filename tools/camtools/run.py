"""Command line of the whole way: table, cut on the host simulator, gauge, report.

>>> Job(["--rpm", "600"]).options()
['--rpm', '600.0']
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Sequence
from math import isfinite
from pathlib import Path

from camtools.command import BAD_INPUT, Parser, run_command
from camtools.errors import CamtoolsError
from camtools.generate import Generated, generate
from camtools.mktables import products
from camtools.part import Part, load_part
from camtools.path import Path as ToolPath
from camtools.report_data import (
    Even,
    Json,
    Outcome,
    Variant,
    read_summary,
    read_surface,
    read_trace,
)
from camtools.report_text import terminal_text
from camtools.run_cut import (
    ROOT,
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
from camtools.run_even import compare_removal
from camtools.run_stage import Stage, cannot_write

_DEFAULT_PART = ROOT / "tools" / "parts" / "perkins240.toml"
_OURS = ("--rpm", "--feed", "--trace", "--surface", "--summary", "--design", "--progress", "--help")
_EPILOG = """\
What follows -- goes to `camsim run`, for example to see how a fault is met:
  tools/run -o build/run/estop -- --inject estop@5
Exit status: 0 done, 1 the cut ended in a fault or out of tolerance, 2 wrong usage or bad input."""


def _parser() -> argparse.ArgumentParser:
    parser = Parser(
        prog="tools/run",
        usage="tools/run [PART.toml] [--rpm N] [--feed MM] [-o DIR] [-- CAMSIM-OPTIONS]",
        description="Make the table of a part, cut it on the host simulator, write a report.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.add_argument(
        "part", type=Path, nargs="?", metavar="PART.toml", help="default: the Perkins 240 skirt"
    )
    parser.add_argument("--rpm", metavar="N", help="spindle speed, r/min; default: the part's")
    parser.add_argument("--feed", metavar="MM", help="feed per turn, mm; default: the part's")
    parser.add_argument(
        "-o", "--output", metavar="DIR", help="folder of the results; default build/run/NAME"
    )
    return parser


def _positive(option: str, text: str | None, unit: str) -> float | None:
    """Return the number of an option, None when it is not given.

    Raises
    ------
    CamtoolsError
        Not a finite number above 0.
    """
    if text is None:
        return None
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not (isfinite(value) and value > 0):
        problem = f"{option} {text}: must be a finite number above 0"
        raise CamtoolsError([f"{problem}; give {unit}, or leave it out for the part's own"])
    return value


def _for_camsim(words: Sequence[str]) -> list[str]:
    """Return the user's words for camsim, which works in another folder.

    Raises
    ------
    CamtoolsError
        An option that this command sets itself.
    """
    for word in words:
        if word.split("=")[0] in _OURS:
            raise CamtoolsError([f"-- {word}: is set by tools/run itself; leave it out"])
    return [str(Path(word).resolve()) if Path(word).is_file() else word for word in words]


class Job:
    """What was asked for, checked as far as this is possible without the part.

    Parameters
    ----------
    argv : list of str
        Command line without the program's name.
    """

    def __init__(self, argv: Sequence[str]) -> None:
        words = list(argv)
        split = words.index("--") if "--" in words else len(words)
        arguments = _parser().parse_args(words[:split])
        self.part_path: Path = arguments.part or _DEFAULT_PART
        self.rpm = _positive("--rpm", arguments.rpm, "r/min")
        self.feed_mm = _positive("--feed", arguments.feed, "mm per turn")
        self.extra = _for_camsim(words[split + 1 :])
        if arguments.output == "":
            raise CamtoolsError(["-o: an empty path; give a folder"])
        self.output: Path | None = Path(arguments.output) if arguments.output else None

    def folder(self, name: str) -> Path:
        """Return the output folder for a part's name."""
        return self.output or ROOT / "build" / "run" / name

    def tolerance(self, generated: Generated) -> list[str]:
        """Return the part's own form error for camsim, unless another is given."""
        if any(word.split("=")[0] == "--tolerance-um" for word in self.extra):
            return []
        return ["--tolerance-um", repr(generated.part.process.form_error_um)]

    def options(self) -> list[str]:
        """Return speed and feed for camsim, when they are given."""
        words = [] if self.rpm is None else ["--rpm", repr(self.rpm)]
        return words + ([] if self.feed_mm is None else ["--feed", repr(self.feed_mm)])

    def turns(self, generated: Generated) -> float:
        """Return how many turns the cut takes, about."""
        geometry = generated.geometry
        process = generated.part.process
        ends = geometry.z_first_mm, geometry.z_last_mm
        return ToolPath(process.path, *ends, self.feed_mm or process.feed_mm).turns

    def window_turns(self, generated: Generated) -> float | None:
        """Return how many turns to trace, nothing when the whole cut can be traced."""
        speed_rpm = self.rpm or generated.part.process.spindle_rpm
        return traced_turns(self.turns(generated), speed_rpm)


def _say(text: str) -> None:
    sys.stderr.write(f"run: {text}\n")
    sys.stderr.flush()


def _at_speed(part: Part, rpm: float | None) -> Part:
    """Return the part for another mean speed: the law of its modulation depends on it."""
    if rpm is None or part.process.mode == "uniform":
        return part
    process = part.process.model_copy(update={"spindle_rpm": rpm})
    return part.model_copy(update={"process": process})


def _make_table(path: Path, rpm: float | None) -> Generated:
    """Return the table of a part file; of a modulated part for the speed asked for.

    Raises
    ------
    CamtoolsError
        With the file's name in every line.
    """
    part = _at_speed(load_part(path), rpm)
    try:
        return generate(part)
    except CamtoolsError as error:
        raise CamtoolsError([f"{path}: {line}" for line in error.lines]) from error


def _write(folder: Path, files: dict[str, bytes]) -> None:
    try:
        for name, data in files.items():
            (folder / name).write_bytes(data)
    except OSError as error:
        raise cannot_write(folder.parent, error) from error


def _without_faults(words: Sequence[str]) -> list[str]:
    """Return camsim's words without --inject and its value."""
    kept, skips = [], False
    for word in words:
        if not skips and not word.startswith("--inject"):
            kept.append(word)
        skips = not skips and word == "--inject"
    return kept


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
    from camtools.report import make_report  # after the cut: matplotlib is slow to load

    name, window = generated.part.part.name, job.window_turns(generated)
    machine = f"{name}_machine.toml"
    files = products(generated, with_plots=False)
    files[machine] = machine_text(generated.part.machine.limits).encode("ascii")
    _write(stage.folder, files)
    simulator = Simulator(camsim_path(), stage.folder, f"{name}.camtab")
    words = ["--machine", machine, *job.tolerance(generated), *job.options(), *job.extra]
    if cut(simulator, words, window) == BAD_INPUT:
        return None
    plain = _without_faults(words)
    variants = compare(simulator, plain, window)
    even = compare_removal(simulator, generated, plain, job.turns(generated))
    _say("drawing the report")
    outcome = _read(generated, stage.folder, variants, window, even)
    _write(stage.folder, make_report(outcome))
    summary = _complete_summary(outcome, time.monotonic() - begin_s)
    text = json.dumps(summary, indent=1, allow_nan=False) + "\n"
    _write(stage.folder, {SUMMARY: text.encode("ascii")})
    return outcome


def _shown(folder: Path) -> str:
    """Return a folder as the user may type it, relative when it lies below."""
    try:
        return str(folder.resolve().relative_to(Path.cwd()))
    except ValueError:
        return str(folder)


def _run(argv: Sequence[str]) -> int:
    begin_s = time.monotonic()
    job = Job(argv)
    _say(f"making the table of {job.part_path.name}")
    generated = _make_table(job.part_path, job.rpm)
    folder = job.folder(generated.part.part.name)
    with Stage(folder) as stage:
        _say(f"cutting {job.turns(generated):.0f} turns on the host simulator")
        outcome = _cut_and_report(job, generated, stage, begin_s)
        if outcome is None:
            return BAD_INPUT
        stage.publish()
    sys.stdout.write(terminal_text(outcome, _shown(folder), time.monotonic() - begin_s))
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
