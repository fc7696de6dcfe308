# SPDX-License-Identifier: Apache-2.0
"""The windows of the position switches over a turn, and where they acted, as a picture.

>>> switches({})
{}
"""

from __future__ import annotations

from collections.abc import Callable

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camtools.base.json_text import Json
from camtools.plots.style import BLUE, RED, SKY
from camtools.plots.style import new_figure as _new_figure

SWITCHES_TEXT = (
    "Position switches",
    "Each bar is a window over the angle of the drawing. The marks show the mean true spindle "
    "angle at which the switched device acted, including its dead time; they must lie at the "
    "ends of the bars, within the half tick by which an output can be early or late.",
)
TURN_DEG = 360.0


def _bars(one: Json) -> list[tuple[float, float]]:
    """Return begin and width [degrees] of the windows in one turn, split where they pass 0.

    >>> _bars({"windows_per_turn": 1, "on_deg": 350, "off_deg": 10})
    [(350.0, 10.0), (0.0, 10.0)]
    """
    period = TURN_DEG / one["windows_per_turn"]
    wide = (one["off_deg"] - one["on_deg"]) % TURN_DEG
    if wide == 0 and one["off_deg"] != one["on_deg"]:
        wide = TURN_DEG
    bars = []
    for i in range(int(one["windows_per_turn"])):
        begin = (one["on_deg"] + i * period) % TURN_DEG
        width = min(wide, period)
        bars.append((begin, min(width, TURN_DEG - begin)))
        if begin + width > TURN_DEG:
            bars.append((0.0, begin + width - TURN_DEG))
    return bars


def _mark(axes: Axes, one: Json, row: int, end: str, colour: str) -> None:
    """Draw the mean place of the changes of one kind at each window."""
    error = one[f"{end}_error_deg"]
    if error is None:
        return
    n = int(one["windows_per_turn"])
    at = [(one[f"{end}_deg"] + error["mean"] + i * TURN_DEG / n) % TURN_DEG for i in range(n)]
    marker = ">" if end == "on" else "<"
    axes.plot(
        at,
        [row] * n,
        marker,
        color=colour,
        ms=7,
        clip_on=False,
        label=f"acted: {end}" if row == 0 else "",
    )


def draw_switches(summary: Json) -> Figure:
    """Return the windows of every switch in use, with where it acted."""
    found = summary["switches"]
    figure = _new_figure(10, 1.4 + 0.45 * len(found))
    axes = figure.add_subplot()
    for row, one in enumerate(found):
        axes.broken_barh(_bars(one), (row - 0.3, 0.6), color=SKY, lw=0)
        for end, colour in (("on", BLUE), ("off", RED)):
            _mark(axes, one, row, end, colour)
    axes.set_yticks(range(len(found)), [f"switch {one['output']:.0f}" for one in found])
    axes.set_ylim(len(found) - 0.4, -0.6)
    axes.set_xlim(0, TURN_DEG)
    axes.set_xticks(range(0, 361, 45))
    axes.grid(axis="x", alpha=0.3)
    axes.set_xlabel("drawing's angle before the tool, degrees")
    handles, _ = axes.get_legend_handles_labels()
    if handles:
        axes.legend(loc="lower right", bbox_to_anchor=(1, 1), ncols=2, frameon=False)
    return figure


def switches(summary: Json) -> dict[str, Callable[[], Figure]]:
    """Return the picture by its key, nothing when no switch is in use."""
    if not summary.get("switches"):
        return {}
    return {"switches": lambda: draw_switches(summary)}
