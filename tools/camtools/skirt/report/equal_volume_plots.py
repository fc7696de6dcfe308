"""Pictures of equal-volume turning: speed law, removal rate and forces, beside uniform turning.

>>> nothing, turn, rate = np.zeros(4), np.array([0.1, 0.4, 1.2, 1.6]), np.array([1.0, 2, 5, 5])
>>> slices = Removal(nothing, turn, nothing, rate, nothing, nothing, nothing)
>>> ripple_by_turn(slices)[1].round(3).tolist()
[0.667, 0.0]
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camtools.base.quantities import Floats
from camtools.plots.panels import stacked
from camtools.plots.style import BLUE, GREY, ORANGE, RED, angle_axis, new_figure
from camtools.sim.results import Removal
from camtools.skirt.report.outcome import Even
from camtools.skirt.table.speed import SpeedTable, worst_of

_PERCENT = 100.0
_RISING = 4  # turns at either end in which the feed rises or falls, or the chips of such a turn


def ripple_by_turn(removal: Removal) -> tuple[Floats, Floats]:
    """Return mean height [mm] and (largest - least) / mean of the rate of every turn."""
    whole = np.floor(removal.turn).astype(np.int64)
    starts = np.flatnonzero(np.diff(whole, prepend=whole[0] - 1))
    count = np.diff(np.append(starts, whole.size))
    least = np.minimum.reduceat(removal.rate_mm3_s, starts)
    most = np.maximum.reduceat(removal.rate_mm3_s, starts)
    mean = np.add.reduceat(removal.rate_mm3_s, starts) / count
    z_mm = np.add.reduceat(removal.z_mm, starts) / count
    return z_mm, (most - least) / mean


def turn_near(removal: Removal, z_mm: float) -> Removal:
    """Return the slices of the whole turn nearest to a height."""
    whole = np.floor(removal.turn)
    turns = np.unique(whole)[1:-1]
    if not turns.size:
        return removal
    middle = np.array([removal.z_mm[whole == turn].mean() for turn in turns])
    best = turns[int(np.argmin(np.abs(middle - z_mm)))]
    return Removal(*(column[whole == best] for column in removal))


def draw_even(even: Even, speed: SpeedTable, spindle_rpm: float) -> Figure:
    """Return speed, rate, power and both forces over one turn where the ripple is largest."""
    worst = worst_of(speed)
    z_mm, law = float(speed.z_mm[worst]), speed.laws[worst]
    forces = ("force, papers'\nmodel, N", "force of the\nchip, N")
    figure = new_figure(10, 10)
    panels = stacked(figure, ("spindle, r/min", "removal rate,\nmm³/s", "power, W", *forces))
    ours, theirs = turn_near(even.removal, z_mm), turn_near(even.uniform_removal, z_mm)
    deg = np.linspace(0, 360, 721)
    panels[0].plot(deg, spindle_rpm * law.ratio(np.radians(deg)), color=BLUE, label="equal volume")
    # between the middles of the slices; with M4 the drawing's angle falls
    measured_rpm = 60 * np.abs(np.gradient(ours.turn, ours.t_s))
    style: dict[str, Any] = {"color": RED, "ls": "", "marker": "o", "ms": 3.2, "mfc": "none"}
    panels[0].plot(360 * (ours.turn % 1), measured_rpm, label="spindle, measured", **style)
    panels[0].axhline(spindle_rpm, color=GREY, ls="--", label="uniform turning")
    _pair(panels[1], theirs, ours, "rate_mm3_s")
    _pair(panels[2], theirs, ours, "power_w")
    _pair(panels[3], theirs, ours, "rate_force_n")
    _pair(panels[4], theirs, ours, "chip_force_n")
    for axes in panels[1:]:
        axes.set_ylim(bottom=0)
    panels[0].set_title(f"height {z_mm:.1f} mm, mean {spindle_rpm:g} r/min", loc="left")
    panels[0].legend(frameon=False, loc="lower right", bbox_to_anchor=(1, 0.97), ncols=3)
    angle_axis(panels[-1])
    return figure


def _pair(axes: Axes, uniform: Removal, even: Removal, name: str) -> None:
    for removal, colour, style in ((uniform, GREY, "--"), (even, BLUE, "-")):
        order = np.argsort(removal.turn % 1, kind="stable")
        place = 360 * (removal.turn % 1)[order]
        axes.plot(place, getattr(removal, name)[order], color=colour, ls=style)


def draw_ripple(even: Even, speed: SpeedTable) -> Figure:
    """Return the ripple of the removal rate over height: measured, planned, uniform."""
    figure = new_figure(10, 4)
    axes = figure.add_subplot()
    for removal, colour, name in (
        (even.uniform_removal, GREY, "uniform turning, measured"),
        (even.removal, RED, "equal volume, measured"),
    ):
        z_mm, ripple = ripple_by_turn(removal)
        full = slice(_RISING, -_RISING)
        axes.plot(z_mm[full], _PERCENT * ripple[full], color=colour, lw=1.4, label=name)
    laws = _PERCENT * speed.played
    blended = [_PERCENT * law.ripple for law in speed.partial]
    axes.plot(speed.z_mm, laws, color=BLUE, ls="", marker="o", ms=4, label="promised by the table")
    axes.plot(
        speed.z_mm, blended, color=ORANGE, ls="", marker="x", ms=5, label="partial modulation"
    )
    axes.set_ylim(bottom=0)
    axes.set_xlabel("skirt height, mm")
    axes.set_ylabel("ripple of the removal rate,\n% of its mean in the turn")
    axes.grid(alpha=0.3)
    axes.legend(frameon=False, ncols=2)
    return figure
