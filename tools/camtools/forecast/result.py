"""What a forecast found, as data: the distribution of the form error, and what matters most.

>>> forecast_summary.__name__
'forecast_summary'
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa

from camtools.base.errors import CamtoolsError
from camtools.base.json_text import Json, emit_json
from camtools.base.parquet import parquet_bytes
from camtools.base.quantities import Floats
from camtools.forecast.job import ForecastPlan, Question
from camtools.forecast.one_cut import CutOutcome
from camtools.forecast.statistics import Effect, Quantile, Share, effects, quantile, share_within
from camtools.forecast.store import SCHEMA

PERCENTS = (50.0, 90.0, 95.0, 99.0)
_NOTHING_UM = float("inf")  # a cut without a result is worse than any error


class Forecast(NamedTuple):
    """What is known after all cuts.

    Attributes
    ----------
    errors_um : ndarray, shape (runs,)
        Largest form error of each cut, infinite where there is none.
    within : Share
        Of the cuts that came to their end within tolerance.
    ends : dict
        Count of cuts by how they ended, and by their first faults.
    effects : list of Effect
        Of the unknowns, the strongest first; empty when there are too few cuts.
    """

    errors_um: Floats
    within: Share
    quantiles: list[Quantile]
    ends: dict[str, int]
    effects: list[Effect]


def evaluate(plan: ForecastPlan, outcomes: Sequence[CutOutcome], seed: int) -> Forecast:
    """Return what the cuts of a plan say.

    Raises
    ------
    CamtoolsError
        Not one of them was gauged; the line has the reason of the first.
    """
    is_gauged = np.array([one.is_gauged for one in outcomes])
    if not is_gauged.any():
        first = outcomes[0].message or outcomes[0].end
        raise CamtoolsError([f"none of {len(outcomes)} cuts was gauged; the first: {first}"])
    found = np.array([one.form_max_um for one in outcomes])
    errors_um = np.where(is_gauged, found, _NOTHING_UM)
    ends = Counter(
        " ".join(["gauged" if one.is_gauged else one.end, one.faults]).strip() for one in outcomes
    )
    return Forecast(
        errors_um,
        share_within(int((errors_um <= plan.tolerance_um).sum()), len(outcomes)),
        [quantile(errors_um, percent) for percent in PERCENTS],
        dict(ends.most_common()),
        effects(plan.names, plan.inputs[is_gauged], found[is_gauged], seed=seed),
    )


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def _quantile(one: Quantile) -> Json:
    values = {"value_um": one.value, "low_um": one.low, "high_um": one.high}
    return {"percent": one.percent} | {name: _finite(value) for name, value in values.items()}


def forecast_summary(question: Question, plan: ForecastPlan, forecast: Forecast) -> Json:
    """Return all numbers of a forecast; a number that is infinite is null."""
    share = forecast.within
    return {
        "part": plan.made.table.part.part.name,
        "machine": plan.machine.name,
        "simulator": plan.task.build,
        "camsim_options": list(question.words),
        "runs": len(plan.keys),
        "seed": question.seed,
        "tolerance_um": plan.tolerance_um,
        "within_tolerance": share._asdict(),
        "form_error_um": [_quantile(one) for one in forecast.quantiles],
        "ends": forecast.ends,
        "unknowns": [
            {"key": one.key, "nominal": one.nominal, "distribution": one.words}
            for one in plan.unknowns
        ],
        "left_out": plan.left_out,
        "effects": [effect._asdict() for effect in forecast.effects],
    }


def runs_parquet(plan: ForecastPlan, outcomes: Sequence[CutOutcome], about: Json) -> bytes:
    """Return a row for every cut: the machine's true numbers, and what came of it."""
    fields: list[Any] = [("run", pa.int32()), *((key, pa.float64()) for key in plan.names)]
    names = [name for name in SCHEMA.names if name != "wall_s"]
    schema = pa.schema([*fields, *(SCHEMA.field(name) for name in names)])
    columns: dict[str, Any] = {"run": range(len(outcomes))}
    columns |= {key: plan.inputs[:, place] for place, key in enumerate(plan.names)}
    columns |= {name: [getattr(one, name) for one in outcomes] for name in names}
    columns["run"] = list(columns["run"])
    return parquet_bytes(columns, schema, {"camturn.forecast": emit_json(about)})
