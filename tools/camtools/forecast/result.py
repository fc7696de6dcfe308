"""What a forecast found, as data and for people: quantiles of the form error, what it depends on.

>>> share_within(98, 100).share
0.98
"""

from collections import Counter
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import scipy

from camtools.base.errors import CamtoolsError
from camtools.base.parquet import parquet_bytes
from camtools.base.quantities import Floats, length_text
from camtools.base.text import Json, emit_json
from camtools.forecast.cuts import SCHEMA, CutOutcome
from camtools.forecast.job import ForecastPlan
from camtools.part.smoothing import share_text
from camtools.report.text import plain
from camtools.sim.drawn_parts import ABOUT, WHOLE, bound_of, cut_facts, drawn_parts

_CONFIDENCE = 0.95
LEAST_FOR_RANKING = 64  # of a RBD-FAST or PAWN with any meaning
_SLICES = 10  # of PAWN
_RESAMPLES = 100
_NOTHINGS = 100  # random columns, which show what an index is of what has no effect


class Share(NamedTuple):
    """A share of a sample with its interval of 95 % confidence."""

    share: float
    low: float
    high: float


class Quantile(NamedTuple):
    """A quantile with its interval; infinite where it lies among cuts without a result."""

    percent: float
    value: float
    low: float
    high: float


class Effect(NamedTuple):
    """How much an unknown matters for the form error."""

    key: str  # of the unknown
    pawn: float  # how far its knowledge moves the distribution of the error, 0 .. 1
    first_order: float  # share of the variance of the error's logarithm that it explains alone
    first_order_conf: float  # half the width of its interval of 95 %
    is_noise: bool  # of numbers that have no effect, 5 % seem to move the distribution as far


def share_within(n_within: int, n: int) -> Share:
    """Return a share with Wilson's interval, MATHS.md (164)."""
    found = scipy.stats.binomtest(n_within, n).proportion_ci(_CONFIDENCE, "wilson")
    return Share(n_within / n, float(found.low), float(found.high))


def quantile(errors: Floats, percent: float) -> Quantile:
    """Return a quantile of errors (infinite: no result) with its interval, MATHS.md (163)."""
    share = percent / 100
    found = scipy.stats.quantile_test(errors, p=share).confidence_interval(_CONFIDENCE)
    value = float(np.quantile(errors, share, method="inverted_cdf"))
    low, high = np.where(np.isnan(found), (0.0, np.inf), found)
    return Quantile(percent, value, float(low), float(high))


def _problem(inputs: Floats) -> dict[str, Any]:
    """Return what SALib wants to know of columns of numbers."""
    ranges = [[float(column.min()), float(column.max())] for column in inputs.T]
    names = [str(place) for place in range(len(ranges))]
    return {"num_vars": len(names), "names": names, "bounds": ranges}


def effects(keys: list[str], inputs: Floats, errors: Floats, *, seed: int) -> list[Effect]:
    """Return how much unknowns matter, strongest first; finite errors, MATHS.md (165)."""
    from SALib.analyze import pawn, rbd_fast  # slow to load

    logs = np.log(np.maximum(errors, 1e-9))
    if errors.size < LEAST_FOR_RANKING or np.ptp(logs) == 0.0:
        return []
    nothing = np.random.default_rng(seed).random((errors.size, _NOTHINGS))
    drawn = np.column_stack([inputs, nothing])
    moved = pawn.analyze(_problem(drawn), drawn, logs, S=_SLICES, seed=seed)["median"]
    floor = float(np.quantile(moved[len(keys) :], _CONFIDENCE))
    first = rbd_fast.analyze(_problem(inputs), inputs, logs, num_resamples=_RESAMPLES, seed=seed)
    columns = (map(float, column) for column in (moved, first["S1"], first["S1_conf"]))
    rows = zip(keys, *columns, strict=False)  # moved has the random columns, too
    found = [Effect(key, far, alone, half, far <= floor) for key, far, alone, half in rows]
    return sorted(found, key=lambda effect: -effect.pawn)


PERCENTS = (50.0, 90.0, 95.0, 99.0)
_NOTHING_UM = float("inf")  # a cut without a result is worse than any error


class Forecast(NamedTuple):
    """What is known after all cuts."""

    errors_um: Floats  # shape (runs,); largest form error of each cut, infinite where there is none
    within: Share  # of the cuts that came to their end within tolerance
    quantiles: list[Quantile]
    ends: dict[str, int]  # count of cuts by how they ended, and by their first faults
    effects: list[Effect]  # of the unknowns, the strongest first; empty when there are too few cuts
    bounds: list[tuple[str, float]]  # what most parts keep, by feature; empty: without sections


def evaluate(plan: ForecastPlan, outcomes: Sequence[CutOutcome]) -> Forecast:
    """Return what the cuts of a plan say; refuse a plan of which none was gauged."""
    is_gauged = np.array([outcome.is_gauged for outcome in outcomes])
    if not is_gauged.any():
        first = outcomes[0].message or outcomes[0].end
        raise CamtoolsError([f"none of {len(outcomes)} cuts was gauged; the first: {first}"])
    found = np.array([outcome.form_max_um for outcome in outcomes])
    errors_um = np.where(is_gauged, found, _NOTHING_UM)
    ends = Counter(
        " ".join(["gauged" if outcome.is_gauged else outcome.end, outcome.faults]).strip()
        for outcome in outcomes
    )
    features = [outcome.features for outcome in outcomes]
    return Forecast(
        errors_um,
        share_within(int((errors_um <= plan.tolerance_um).sum()), len(outcomes)),
        [quantile(errors_um, percent) for percent in PERCENTS],
        dict(ends.most_common()),
        effects(plan.names, plan.inputs[is_gauged], found[is_gauged], seed=plan.seed),
        [
            (name, bound_of(np.abs(values)))
            for name, values in drawn_parts(errors_um, features).values.items()
            if any(features)
        ],
    )


def forecast_summary(plan: ForecastPlan, forecast: Forecast) -> Json:
    """Return all numbers of a forecast; a number that is infinite is null."""
    names = ("percent", "value_um", "low_um", "high_um")
    quantiles = [
        {name: v if np.isfinite(v) else None for name, v in zip(names, figures, strict=True)}
        for figures in forecast.quantiles
    ]
    return {
        "part": plan.made.table.part.part.name,
        "machine": plan.machine.name,
        "simulator": plan.task.build,
        "camsim_options": list(plan.words),
        "runs": len(plan.keys),
        "seed": plan.seed,
        "tolerance_um": plan.tolerance_um,
        "within_tolerance": forecast.within._asdict(),
        "form_error_um": quantiles,
        "ends": forecast.ends,
        "unknowns": [
            {"key": unknown.key, "nominal": unknown.nominal, "distribution": unknown.words}
            for unknown in plan.unknowns
        ],
        "left_out": plan.left_out,
        "effects": [effect._asdict() for effect in forecast.effects],
        "cut": cut_facts(plan.task.table, plan.made.table.part, plan.machine.text, plan.words),
        "bounds": [
            {"feature": name, "bound": bound if np.isfinite(bound) else None}
            for name, bound in forecast.bounds
        ],
    }


def runs_parquet(plan: ForecastPlan, outcomes: Sequence[CutOutcome], about: Json) -> bytes:
    """Return a row for every cut: the machine's true numbers, and what came of it."""
    fields: list[Any] = [("run", pa.int32()), *((key, pa.float64()) for key in plan.names)]
    names = [name for name in SCHEMA.names if name != "wall_s"]
    schema = pa.schema([*fields, *(SCHEMA.field(name) for name in names)])
    columns: dict[str, Any] = {"run": list(range(len(outcomes)))}
    columns |= {key: plan.inputs[:, place] for place, key in enumerate(plan.names)}
    columns |= {name: [getattr(outcome, name) for outcome in outcomes] for name in names}
    return parquet_bytes(columns, schema, {ABOUT: emit_json(about)})


_SHOWN = 5


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
    for found in forecast.quantiles:
        name = "median" if found.percent == 50 else f"{found.percent:.0f} % below"
        value, low, high = (length_text(um) if np.isfinite(um) else "no result" for um in found[1:])
        within = f"{low} .. {high}" if np.isfinite(found.high) else f"from {low} up"
        rows.append((name, f"{value} ({within})"))
    for end, count in forecast.ends.items():
        if end != "gauged":
            rows.append((f"ended: {end}", f"{count} cuts, counted as out of tolerance"))
    shown = forecast.effects[:_SHOWN]
    rows += [("matters most" if effect is shown[0] else "", _effect(effect)) for effect in shown]
    if not shown:
        rows.append(("matters most", f"unknown with fewer than {LEAST_FOR_RANKING} different cuts"))
    for name, bound in forecast.bounds:
        size = f"{bound:.3g}" if np.isfinite(bound) else "no bound"
        rows.append(("95 % of parts keep" if name == WHOLE else "", f"{size}  {name}"))
    if plan.left_out:
        rows.append(("not varied", f"{', '.join(plan.left_out)}: 0 on this machine"))
    rows.append(("results", f"{place}/forecast.json, forecast.png, runs.parquet"))
    width = max(len(name) for name, _ in rows)
    title = f"{plan.made.table.part.part.name} on {plan.machine.name}: form error"
    return "\n".join([title, *(f"  {name:<{width}}  {plain(text)}" for name, text in rows)]) + "\n"
