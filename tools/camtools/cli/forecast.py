"""Command line of the forecast: how good a part will be on a machine not known exactly.

>>> main(["no.toml", "--runs", "0"])
2
"""

import math
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from camtools.base.arguments import Option, PartFile, command
from camtools.base.errors import CamtoolsError
from camtools.base.files import write_all
from camtools.base.project import RESULTS
from camtools.base.text import emit_json
from camtools.forecast.cuts import CutOutcome, Store, cut_all
from camtools.forecast.job import ForecastPlan, plan_of
from camtools.forecast.result import (
    evaluate,
    forecast_summary,
    forecast_text,
    runs_parquet,
)

_RUNS = 256
_MOST_RUNS = 1_000_000
_MOST_SEED = 2**31 - 1
_EPILOG = """\
DIR/store keeps every finished cut: the same command continues after an interruption, and one with
more --runs adds to it. Manual: tools/docs/FORECAST.md.
Exit status: 0 done, whatever the result; 2 wrong usage or bad input; 128 + n on signal n."""


@dataclass(frozen=True)
class Options:
    """What is forecast."""

    part: PartFile
    machine: Annotated[
        str | None, Option("machine name or file (default: a machine with the part's limits)", "M")
    ] = None
    vary: Annotated[
        Path | None,
        Option("file of the uncertain properties (default: camtools/sim/vary.toml)", "V.toml"),
    ] = None
    runs: Annotated[int, Option(f"number of machines (default: {_RUNS})", "N")] = _RUNS
    seed: Annotated[int, Option("seed of the random machines (default: 1)", "S")] = 1
    rpm: Annotated[float | None, Option("spindle speed in r/min (default: the part's)", "N")] = None
    feed: Annotated[float | None, Option("feed in mm per turn (default: the part's)", "MM")] = None
    turns: Annotated[
        float | None, Option("cut only the first N turns (default: the whole part)", "N")
    ] = None
    tolerance_um: Annotated[
        float | None, Option("accepted form error in um (default: the part's)", "T")
    ] = None
    set: Annotated[
        tuple[str, ...], Option("value of a controller parameter; repeatable", "P=V")
    ] = ()
    sections: Annotated[
        bool, Option("also bound each feature of the sheets: what 95 %% of all parts keep")
    ] = False
    workers: Annotated[
        int | None, Option("parallel processes on this computer (default: one per core)", "N")
    ] = None
    scheduler: Annotated[
        str | None,
        Option("Dask cluster that runs the cuts (default: this computer)", "tcp://HOST:PORT"),
    ] = None
    output: Annotated[
        Path | None, Option("folder for the results (default: build/forecast/NAME)", "DIR", "-o")
    ] = None

    def plan(self) -> ForecastPlan:
        """Return what is to be cut."""
        words = [*_positive("--rpm", self.rpm), *_positive("--feed", self.feed)]
        words += _positive("--turns", self.turns)
        for setting in self.set:
            words += ["--set", setting]
        _positive("--tolerance-um", self.tolerance_um)
        _check("--runs", self.runs, 1, _MOST_RUNS)
        _check("--seed", self.seed, 0, _MOST_SEED)
        _check("--workers", 1 if self.workers is None else self.workers, 1, 1024)
        return plan_of(
            *(self.part, self.runs, self.seed),
            machine_name=self.machine,
            vary=self.vary,
            rpm=self.rpm,
            words=words,
            tolerance_um=self.tolerance_um,
            feed_mm=self.feed,
            has_sections=self.sections,
        )


def _check(option: str, value: int, low: int, high: int) -> None:
    if not low <= value <= high:
        raise CamtoolsError([f"{option} {value}: out of range; give {low} .. {high}"])


def _positive(option: str, value: float | None) -> list[str]:
    """Return an option of camsim above 0, nothing when it is not given."""
    if value is None:
        return []
    if not (math.isfinite(value) and value > 0):
        raise CamtoolsError([f"{option} {value}: must be a finite number above 0; give one"])
    return [option.replace("--turns", "--turns-limit"), repr(value)]


_LINES = 10  # where there is no terminal


class Progress:
    """Counts cuts on stderr; `n_done` of them were there before."""

    def __init__(self, n_all: int, n_done: int) -> None:
        self._n_all, self._n_before, self._n_done = n_all, n_done, n_done
        self._n_failed = 0
        self._begin_s = time.monotonic()
        self._is_open = False
        self._reported = n_done * _LINES // max(n_all, 1)
        if n_done:
            sys.stderr.write(f"forecast: {n_done} of {n_all} cuts are already done\n")

    def add(self, n_cuts: int, n_failed: int) -> None:
        """Count cuts that have been made."""
        self._n_done += n_cuts
        self._n_failed += n_failed
        if sys.stderr.isatty():
            sys.stderr.write(f"\r{self._text()}\033[K")
            self._is_open = True
        elif self._n_done * _LINES // self._n_all > self._reported:
            self._reported = self._n_done * _LINES // self._n_all
            sys.stderr.write(f"{self._text()}\n")
        sys.stderr.flush()

    def _text(self) -> str:
        words = [f"forecast: {self._n_done} of {self._n_all} cuts"]
        if self._n_failed:
            words.append(f"{self._n_failed} without a result")
        since_s, n_here = time.monotonic() - self._begin_s, self._n_done - self._n_before
        left_s = since_s / n_here * (self._n_all - self._n_done)
        if left_s >= 1:
            words.append(f"{left_s:.0f} s left")
        return ", ".join(words)

    def end(self) -> None:
        """Begin a new line on a terminal."""
        if self._is_open:
            sys.stderr.write("\n")
            sys.stderr.flush()


def forecast(options: Options) -> int:
    """Predict the form error of a part on a machine whose properties are uncertain.

    They are varied at random, the part is cut on each simulated machine, and the report has the
    distribution of the form error and the properties that matter most.
    """
    plan = options.plan()
    folder = options.output or RESULTS / "forecast" / plan.made.table.part.part.name
    store = Store(folder / "store")
    texts = dict(zip(plan.keys, plan.texts, strict=True))
    missing = [text for key, text in texts.items() if key not in store.found]
    progress = Progress(len(texts), len(texts) - len(missing))

    def take(outcomes: list[CutOutcome]) -> None:
        store.add(outcomes)
        progress.add(len(outcomes), sum(not outcome.is_gauged for outcome in outcomes))

    try:
        cut_all(plan.task, missing, take, scheduler=options.scheduler, n_workers=options.workers)
    finally:
        progress.end()
    store.compact()
    outcomes = store.pick(plan.keys)
    found = evaluate(plan, outcomes)
    from camtools.forecast.plots import draw_forecast  # matplotlib is slow to load

    about = forecast_summary(plan, found)
    files = {
        "forecast.json": emit_json(about).encode("utf-8"),
        "forecast.png": draw_forecast(plan, found),
        "runs.parquet": runs_parquet(plan, outcomes, about),
    }
    write_all(folder, files)
    sys.stdout.write(forecast_text(plan, found, str(folder)))
    return 0


main = command(
    *("tools/forecast", forecast),
    kept="finished cuts are kept; repeat the command to continue",
    epilog=_EPILOG,
)

if __name__ == "__main__":
    sys.exit(main())
