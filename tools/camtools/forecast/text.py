r"""A forecast in lines for people: how far it is, and what it found.

>>> import io
>>> stream = io.StringIO()
>>> progress = Progress(4, 0, stream, lambda: 0.0)
>>> progress.add(4, 1)
>>> stream.getvalue()
'forecast: 4 of 4 cuts, 1 without a result\n'
"""

from collections.abc import Callable
from typing import TextIO

import numpy as np

from camtools.base.quantities import length_text
from camtools.forecast.job import ForecastPlan
from camtools.forecast.result import LEAST_FOR_RANKING, Effect, Forecast
from camtools.part.smoothing import share_text
from camtools.report.text import plain

_LINES = 10  # where there is no terminal


class Progress:
    """Counts cuts; `n_done` of them were there before; the clock returns seconds."""

    def __init__(self, n_all: int, n_done: int, stream: TextIO, clock: Callable[[], float]) -> None:
        self._n_all, self._n_before, self._n_done = n_all, n_done, n_done
        self._n_failed = 0
        self._stream, self._clock = stream, clock
        self._begin_s = clock()
        self._is_open = False
        self._told = n_done * _LINES // max(n_all, 1)
        if n_done:
            stream.write(f"forecast: {n_done} of {n_all} cuts are already done\n")

    def add(self, n_cuts: int, n_failed: int) -> None:
        """Count cuts that have been made."""
        self._n_done += n_cuts
        self._n_failed += n_failed
        if self._stream.isatty():
            self._stream.write(f"\r{self._text()}\033[K")
            self._is_open = True
        elif self._n_done * _LINES // self._n_all > self._told:
            self._told = self._n_done * _LINES // self._n_all
            self._stream.write(f"{self._text()}\n")
        self._stream.flush()

    def _text(self) -> str:
        words = [f"forecast: {self._n_done} of {self._n_all} cuts"]
        if self._n_failed:
            words.append(f"{self._n_failed} without a result")
        since_s, n_here = self._clock() - self._begin_s, self._n_done - self._n_before
        left_s = since_s / n_here * (self._n_all - self._n_done)
        if left_s >= 1:
            words.append(f"{left_s:.0f} s left")
        return ", ".join(words)

    def end(self) -> None:
        """Begin a new line on a terminal."""
        if self._is_open:
            self._stream.write("\n")
            self._stream.flush()


_SHOWN = 5


def _um(value: float) -> str:
    return length_text(value) if np.isfinite(value) else "no result"


def _effect(effect: Effect) -> str:
    if effect.is_noise:
        return f"{effect.key}: no more than noise"
    alone = f"{100 * max(effect.first_order, 0):.0f} +- {100 * effect.first_order_conf:.0f} %"
    return f"{effect.key}: {effect.pawn:.2f}, alone {alone} of the variance"


def forecast_text(plan: ForecastPlan, forecast: Forecast, place: str) -> str:
    """Return the table for the terminal."""
    n, share = len(plan.keys), forecast.within
    percent = f"{100 * share.share:.1f} % ({100 * share.low:.1f} .. {100 * share.high:.1f} %)"
    rows = [(f"within {length_text(plan.tolerance_um)}", f"{percent} of {n} machines")]
    if taken_um := plan.made.kind.taken_um(plan.made.table):
        rows.append(("smoothing", share_text(taken_um, plan.tolerance_um + taken_um)))
    for one in forecast.quantiles:
        name = "median" if one.percent == 50 else f"{one.percent:.0f} % below"
        within = (
            f"{_um(one.low)} .. {_um(one.high)}"
            if np.isfinite(one.high)
            else f"from {_um(one.low)} up"
        )
        rows.append((name, f"{_um(one.value)} ({within})"))
    for end, count in forecast.ends.items():
        if end != "gauged":
            rows.append((f"ended: {end}", f"{count} cuts, counted as out of tolerance"))
    shown = forecast.effects[:_SHOWN]
    rows += [("matters most" if one is shown[0] else "", _effect(one)) for one in shown]
    if not shown:
        rows.append(("matters most", f"unknown with fewer than {LEAST_FOR_RANKING} different cuts"))
    if plan.left_out:
        rows.append(("not varied", f"{', '.join(plan.left_out)}: 0 on this machine"))
    rows.append(("results", f"{place}/forecast.json, forecast.png, runs.parquet"))
    width = max(len(name) for name, _ in rows)
    title = f"{plan.made.table.part.part.name} on {plan.machine.name}: form error"
    return "\n".join([title, *(f"  {name:<{width}}  {plain(text)}" for name, text in rows)]) + "\n"
