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
DIR/store holds every cut that is done: the same command goes on where it was interrupted, and one
with more --runs adds to it. tools/docs/FORECAST.md is the manual.
Exit status: 0 done, whatever the forecast says; 2 wrong usage or bad input; 128 + n on signal n."""


def _arguments(argv: Sequence[str] | None) -> argparse.Namespace:
    parser = Parser(
        prog="tools/forecast",
        description="Draw machines from what is not known of one, cut a part on each of them on "
        "the host simulator, and tell how the form error is distributed and what matters most.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("part", type=Path, metavar="PART.toml")
    add("--machine", metavar="M", help="name or file; default: a machine with the part's limits")
    add("--vary", type=Path, metavar="V.toml", help="what is not known; default: the usual")
    add("--runs", type=int, default=_RUNS, metavar="N", help=f"machines, default {_RUNS}")
    add("--seed", type=int, default=1, metavar="S", help="of the draw, default 1")
    add("--rpm", type=float, metavar="N", help="spindle speed, r/min; default: the part's")
    add("--feed", type=float, metavar="MM", help="feed per turn, mm; default: the part's")
    add("--turns", type=float, metavar="N", help="only the first turns; default: the whole part")
    add("--tolerance-um", type=float, metavar="T", help="default: the part's")
    add("--set", action="append", default=[], metavar="P=V", help="a parameter of the controller")
    add("--workers", type=int, metavar="N", help="processes here; default: one for each core")
    add("--scheduler", metavar="tcp://HOST:PORT", help="Dask cluster to cut on; default: here")
    add("-o", "--output", type=Path, metavar="DIR", help="folder; default build/forecast/NAME")
    return parser.parse_args(argv)


def _positive(option: str, value: float | None) -> list[str]:
    """Return an option of camsim, nothing when it is not given."""
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
    kept = "what is done is kept: the same command goes on"
    return run_command("forecast", lambda: _run(given), kept=kept)


if __name__ == "__main__":
    sys.exit(main())
