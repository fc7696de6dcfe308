"""A forecast in a few lines for people.

>>> _um(float("inf")), _um(0.1234)
('no result', '123 nm')
>>> _interval(0.1, float("inf"))
'from 100 nm up'
"""

from __future__ import annotations

import numpy as np

from camtools.base.quantities import length_text
from camtools.forecast.job import ForecastPlan
from camtools.forecast.result import Forecast
from camtools.forecast.statistics import LEAST_FOR_RANKING, Effect
from camtools.part.smoothing_text import share_text
from camtools.report.text import plain

_SHOWN = 5


def _um(value: float) -> str:
    return length_text(value) if np.isfinite(value) else "no result"


def _interval(low_um: float, high_um: float) -> str:
    if not np.isfinite(high_um):
        return f"from {_um(low_um)} up"
    return f"{_um(low_um)} .. {_um(high_um)}"


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
        rows.append((name, f"{_um(one.value)} ({_interval(one.low, one.high)})"))
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
