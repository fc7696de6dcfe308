"""The picture of a forecast: how large the error is, what it depends on, and how.

>>> _edges([0.1, 0.4])
(0.05, 1.0)
"""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from camtools.base.quantities import Floats, length_text
from camtools.forecast.job import ForecastPlan
from camtools.forecast.result import Forecast
from camtools.plots import style

_SCATTERS = 3
_BARS = 8


def _edges(values: Sequence[float] | Floats) -> tuple[float, float]:
    """Return round numbers around values above 0, with room to both sides."""
    low, high = float(np.min(values)), float(np.max(values))
    return style.nice_floor(0.9 * low), style.nice_limit(1.5 * high)


def _distribution(axes: Axes, plan: ForecastPlan, forecast: Forecast) -> None:
    n = forecast.errors_um.size
    errors_um = np.sort(forecast.errors_um[np.isfinite(forecast.errors_um)])
    axes.step(errors_um, 100 * np.arange(1, errors_um.size + 1) / n, where="post", color=style.BLUE)
    low, high = _edges([*errors_um, plan.tolerance_um])
    style.log_axis(axes, "x", low, high)
    axes.set_ylim(0, 104)
    axes.axvline(plan.tolerance_um, color=style.RED, lw=1)
    text = f"tolerance {length_text(plan.tolerance_um)}"
    # Where the curve is not, left of the tolerance.
    height, side = (2, "bottom") if forecast.within.share > 0.5 else (102, "top")
    axes.text(plan.tolerance_um, height, text, rotation=90, color=style.RED, ha="right", va=side)
    for quantile in forecast.quantiles:
        if np.isfinite(quantile.value):
            ends = [quantile.low, quantile.high if np.isfinite(quantile.high) else high]
            axes.plot(ends, [quantile.percent] * 2, color=style.ORANGE, lw=3, alpha=0.7)
            axes.plot(quantile.value, quantile.percent, "o", color=style.BLUE, ms=4)
    axes.set(xlabel="largest form error, µm", ylabel="share of machines below, %")
    axes.grid(color=style.PALE, lw=0.5)
    failed = n - errors_um.size
    count = f"{n} machines, {failed} without a result" if failed else f"{n} machines"
    axes.set_title(f"{count}: {100 * forecast.within.share:.1f} % within tolerance")


def _bars(axes: Axes, forecast: Forecast) -> None:
    shown = forecast.effects[:_BARS][::-1]
    if not shown:
        axes.text(0.5, 0.5, "too few cuts", ha="center", transform=axes.transAxes, color=style.GREY)
        axes.set_axis_off()
        return
    places = np.arange(len(shown))
    colours = [style.PALE if effect.is_noise else style.BLUE for effect in shown]
    axes.barh(places, [effect.pawn for effect in shown], color=colours, height=0.6)
    first = [min(max(effect.first_order, 0.0), 1.0) for effect in shown]
    spread = [effect.first_order_conf for effect in shown]
    axes.errorbar(first, places, xerr=spread, fmt="o", color=style.GREEN, ms=4, lw=1)
    axes.set_yticks(places, [effect.key for effect in shown])
    axes.set(xlim=(0, 1), xlabel="bar: PAWN index, dot: share of the variance alone")
    axes.set_title("what matters (grey: no more than noise)")


def _scatter(axes: Axes, plan: ForecastPlan, forecast: Forecast, key: str) -> None:
    place = plan.names.index(key)
    is_there = np.isfinite(forecast.errors_um)
    values, errors_um = plan.inputs[:, place], forecast.errors_um[is_there]
    axes.plot(values[is_there], errors_um, ".", color=style.BLUE, ms=3, alpha=0.6)
    low, high = _edges(errors_um)
    for value in values[~is_there]:
        axes.axvline(value, color=style.RED, lw=0.4, alpha=0.5)
    axes.axvline(plan.unknowns[place].nominal, color=style.GREY, lw=1, ls="--")
    style.log_axis(axes, "y", low, high)
    axes.set_xlabel(f"true {key}, believed {plan.unknowns[place].nominal:g}")
    axes.set_ylabel("form error, µm")


def draw_forecast(plan: ForecastPlan, forecast: Forecast) -> bytes:
    """Return the picture as PNG."""
    name = plan.made.table.part.part.name
    shown = [effect.key for effect in forecast.effects[:_SCATTERS]]
    with style.drawing():
        figure = style.titled_figure(11, 7.5 if shown else 4, f"{name} on {plan.machine.name}")
        parts = figure.subfigures(2 if shown else 1, 1, squeeze=False)[:, 0]
        left, right = parts[0].subplots(1, 2)
        _distribution(left, plan, forecast)
        _bars(right, forecast)
        for number, key in enumerate(shown, start=1):
            _scatter(parts[1].add_subplot(1, len(shown), number), plan, forecast, key)
        return style.png_of(figure)
