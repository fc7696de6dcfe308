"""Command line of the forecast: how good a part will be on a machine not known exactly.

>>> main(["no.toml", "--runs", "0"])
2
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from camtools.base.command import Parser, run_command
from camtools.base.errors import CamtoolsError
from camtools.base.json_text import emit_json
from camtools.base.output import write_all
from camtools.base.project_paths import RESULTS
from camtools.forecast.job import Question, limits, plan_of
from camtools.forecast.one_cut import CutOutcome
from camtools.forecast.parallel_cuts import cut_all
from camtools.forecast.progress import Progress
from camtools.forecast.result import evaluate, forecast_summary, runs_parquet
from camtools.forecast.store import Store
from camtools.forecast.text import forecast_text

_RUNS = 256
_MOST_RUNS = 1_000_000
_MOST_SEED = 2**31 - 1
_EPILOG = """\
DIR/store keeps every finished cut: the same command continues after an interruption, and one with
more --runs adds to it. Manual: tools/docs/FORECAST.md.
Exit status: 0 done, whatever the result; 2 wrong usage or bad input; 128 + n on signal n."""


def _arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = Parser(
        prog="tools/forecast",
        description="Predict the form error of a part on a machine whose properties are\n"
        "uncertain: vary them at random, cut the part on each simulated machine, and report the\n"
        "distribution of the form error and the properties that matter most.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("part", type=Path, metavar="PART.toml", help="part file")
    add(
        "--machine",
        metavar="M",
        help="machine name or file (default: a machine with the part's limits)",
    )
    add(
        "--vary",
        type=Path,
        metavar="V.toml",
        help="file of the uncertain properties (default: camtools/forecast/vary.toml)",
    )
    add(
        "--runs",
        type=int,
        default=_RUNS,
        metavar="N",
        help=f"number of machines (default: {_RUNS})",
    )
    add("--seed", type=int, default=1, metavar="S", help="seed of the random machines (default: 1)")
    add("--rpm", type=float, metavar="N", help="spindle speed in r/min (default: the part's)")
    add("--feed", type=float, metavar="MM", help="feed in mm per turn (default: the part's)")
    add(
        "--turns",
        type=float,
        metavar="N",
        help="cut only the first N turns (default: the whole part)",
    )
    add(
        "--tolerance-um",
        type=float,
        metavar="T",
        help="accepted form error in um (default: the part's)",
    )
    add(
        "--set",
        action="append",
        default=[],
        metavar="P=V",
        help="value of a controller parameter; repeatable",
    )
    add(
        "--workers",
        type=int,
        metavar="N",
        help="parallel processes on this computer (default: one per core)",
    )
    add(
        "--scheduler",
        metavar="tcp://HOST:PORT",
        help="Dask cluster that runs the cuts (default: this computer)",
    )
    add(
        "-o",
        "--output",
        type=Path,
        metavar="DIR",
        help="folder for the results (default: build/forecast/NAME)",
    )
    return parser.parse_args(argv)


def _positive(option: str, value: float | None) -> list[str]:
    """Return an option of camsim, nothing when it is not given.

    Raises
    ------
    CamtoolsError
        Not a finite number above 0.
    """
    if value is None:
        return []
    if not (math.isfinite(value) and value > 0):
        raise CamtoolsError([f"{option} {value}: must be a finite number above 0; give one"])
    return [option.replace("--turns", "--turns-limit"), repr(value)]


def _question(given: argparse.Namespace) -> Question:
    words = [
        *_positive("--rpm", given.rpm),
        *_positive("--feed", given.feed),
        *_positive("--turns", given.turns),
    ]
    for setting in given.set:
        words += ["--set", setting]
    _positive("--tolerance-um", given.tolerance_um)
    return Question(
        given.part,
        given.machine,
        given.vary,
        limits("--runs", given.runs, 1, _MOST_RUNS),
        limits("--seed", given.seed, 0, _MOST_SEED),
        given.rpm,
        tuple(words),
        given.tolerance_um,
    )


def _run(given: argparse.Namespace) -> int:
    question = _question(given)
    workers = None if given.workers is None else limits("--workers", given.workers, 1, 1024)
    plan = plan_of(question)
    folder = given.output or RESULTS / "forecast" / plan.made.table.part.part.name
    store = Store(folder / "store")
    texts = dict(zip(plan.keys, plan.texts, strict=True))
    missing = [text for key, text in texts.items() if key not in store.found]
    progress = Progress(len(texts), len(texts) - len(missing), sys.stderr, time.monotonic)

    def take(outcomes: list[CutOutcome]) -> None:
        store.add(outcomes)
        progress.add(len(outcomes), sum(not one.is_gauged for one in outcomes))

    try:
        cut_all(plan.task, missing, take, scheduler=given.scheduler, n_workers=workers)
    finally:
        progress.end()
    store.compact()
    outcomes = store.pick(plan.keys)
    forecast = evaluate(plan, outcomes, question.seed)
    from camtools.forecast.plots import draw_forecast  # matplotlib is slow to load

    about = forecast_summary(question, plan, forecast)
    files = {
        "forecast.json": emit_json(about).encode("utf-8"),
        "forecast.png": draw_forecast(plan, forecast),
        "runs.parquet": runs_parquet(plan, outcomes, about),
    }
    write_all(folder, files)
    sys.stdout.write(forecast_text(plan, forecast, str(folder)))
    return 0


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; return its exit status: 0 done, 2 bad input, 128 + n on signal n."""
    given = _arguments(argv)
    kept = "finished cuts are kept; repeat the command to continue"
    return run_command("forecast", lambda: _run(given), kept=kept)


if __name__ == "__main__":
    sys.exit(main())
