"""How the error converged while the controller learned, as a picture.

>>> convergence({})
{}
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camtools.base.json_text import Json
from camtools.base.quantities import Floats, length_text
from camtools.plots.style import BLUE, GREEN, ORANGE, PALE, RED, log_axis, nice_floor, nice_limit
from camtools.plots.style import new_figure as _new_figure

CONVERGENCE_TEXT = (
    "Error of each turn",
    "Each point is a turn. In the rehearsal, with the tool clear of the work, it shows the "
    "deviation of U's tip from the drawing; in the cut, the largest form error of the turn. "
    "Learning shows as a fall from left to right; a rise at the start of the cut comes from the "
    "chip, mainly from its force. The scale is logarithmic.",
)
_MOST_MARKS = 150  # beyond, points of a line hide one another


def _spans(turn: Floats, is_cut: np.ndarray) -> list[tuple[str, float, float]]:
    """Return name, begin and end [turn] of rehearsal, engaging and cut, in their order."""
    edges = np.flatnonzero(np.diff(is_cut.astype(np.int8))) + 1
    begins = [0, *edges.tolist()]
    ends = [*edges.tolist(), turn.size]
    spans: list[tuple[str, float, float]] = []
    for begin, end in zip(begins, ends, strict=True):
        name = "cut" if is_cut[begin] else "rehearsal"
        low, high = float(turn[begin]), float(turn[end - 1]) + 1
        if spans:
            spans.append(("engage" if name == "cut" else "", spans[-1][2], low))
        spans.append((name, low, high))
    return spans


def _log_scale(axes: Axes, values: Floats) -> None:
    """Make y logarithmic between round numbers, with 1, 2 and 5 written out."""
    low, high = nice_floor(float(values.min())), nice_limit(float(values.max()))
    log_axis(axes, "y", low * (0.5 if low == high else 0.8), high * 1.25)


def draw_convergence(summary: Json) -> Figure:
    """Return the error of each turn of rehearsal and cut on a logarithmic scale."""
    um = np.asarray(summary["error_per_turn_um"], dtype=np.float64)
    turn = np.asarray(summary["error_per_turn"]["turn"], dtype=np.float64)
    is_cut = np.asarray([state == "cutting" for state in summary["error_per_turn"]["state"]])
    tolerance_um = float(summary["form_error_um"]["tolerance"])
    figure = _new_figure(10, 4.2)
    axes = figure.add_subplot()
    above = np.append(um[um > 0], tolerance_um)
    shown = np.maximum(um, above.min())  # nothing of a logarithmic scale is 0
    for name, low, high in _spans(turn, is_cut):
        shade = {"rehearsal": PALE, "engage": ORANGE}.get(name)
        if shade:
            axes.axvspan(low, high, color=shade, alpha=0.35, lw=0)
        row = 1.07 if name == "engage" else 1.02  # it is narrow, and its neighbours may be
        axes.text((low + high) / 2, row, name, transform=axes.get_xaxis_transform(), ha="center")
    style = {"marker": "o", "ms": 3} if um.size <= _MOST_MARKS else {}
    for part, colour in ((~is_cut, BLUE), (is_cut, RED)):
        gaps = np.flatnonzero(np.diff(np.flatnonzero(part)) > 1) + 1
        for rows in np.split(np.flatnonzero(part), gaps):
            axes.plot(turn[rows] + 0.5, shown[rows], color=colour, lw=1.2, **style)  # type: ignore[arg-type]
    axes.axhline(tolerance_um, color=GREEN, lw=1.6, ls="--")
    text = f" tolerance {length_text(tolerance_um)}"
    axes.text(1, tolerance_um, text, transform=axes.get_yaxis_transform(), va="center", color=GREEN)
    _log_scale(axes, np.append(shown, tolerance_um))
    axes.set_xlim(float(turn[0]), float(turn[-1]) + 1)
    axes.grid(alpha=0.3)
    axes.set_xlabel("turns of the spindle")
    axes.set_ylabel("error of the turn, µm")
    return figure


def convergence(summary: Json) -> dict[str, Callable[[], Figure]]:
    """Return the picture by its key, nothing with fewer than two turns."""
    if len(summary.get("error_per_turn_um", [])) < 2:
        return {}
    return {"learning": lambda: draw_convergence(summary)}
