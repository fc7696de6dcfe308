"""What the controller learned, in words, and how the error converged, as a picture.

>>> numbers_text([2, 3, 4, 7])
'2 .. 4, 7'
>>> learning_rows({})
[]
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter, NullLocator

from camtools.base.json_text import Json
from camtools.base.quantities import Floats, length_text
from camtools.plots.style import BLUE, GREEN, ORANGE, PALE, RED, nice_floor, nice_limit
from camtools.plots.style import new_figure as _new_figure
from camtools.report.text import ReportRow

CONVERGENCE_TEXT = (
    "Error of each turn",
    "Each point is a turn: in the rehearsal, where the tool is clear of the work, how far U's tip "
    "swings beside the drawing; in the cut the turn's largest form error. What is learned shows as "
    "a fall from left to right; a rise where the cut begins is what only the chip brings, its "
    "force above all. The scale grows tenfold from number to number of the same digit.",
)
_OFF = {
    "not_asked": "learn_harmonics is 0, which is the default unless U is measured and the machine "
    "is believed otherwise than it is",
    "not_measured": "the port does not measure U, so there is no error to learn from",
    "no_table": "no table is in use",
    "modulated": "the table modulates the speed of the spindle",
    "slow_turn": "a turn has more ticks than are gathered; turn faster",
    "fast_turn": "a turn has too few ticks for one harmonic; turn slower",
}
_LIMITED = {
    "lobes": "of a shaft with lobes only the drive's constants are learned",
    "diverged": "the drive's constants did not converge, and the best that was found is in force",
}
_NO_REHEARSAL = "on, but not one turn was steady enough; set rehearse_turns"
_MOST_MARKS = 150  # beyond, points of a line hide one another


def numbers_text(numbers: Sequence[int]) -> str:
    """Return numbers in rising order in words, neighbours as a range."""
    runs: list[list[int]] = []
    for number in numbers:
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    texts = [f"{run[0]} .. {run[-1]}" if len(run) > 2 else ", ".join(map(str, run)) for run in runs]
    return ", ".join(texts)


def _on_text(found: Json) -> str:
    """Return what was learned, sentence by sentence."""
    at_first, at_last = length_text(found["begin_error_um"]), length_text(found["error_um"])
    texts = [
        f"on, {found['turns']} turns used: error at the scale {at_first} rms at first, {at_last} "
        "at last",
        f"the drive's constants moved by {found['k1_ns']:+d} ns and {found['k2_us2']:+d} µs²",
        f"a correction of {length_text(found['correction_um'])} in all is added to U",
    ]
    if found["ripple_turns"]:
        ripple_urad = 2e-3 * np.pi * found["ripple_nturn"]
        texts.append(
            f"the spindle's ripple of {ripple_urad:.0f} µrad was learned of "
            f"{found['ripple_turns']} turns"
        )
    masked = [k for k in found["masked"] if k > 0]
    texts.append(f"harmonics masked: {numbers_text(masked)}" if masked else "no harmonic is masked")
    if 0 in found["masked"]:
        texts.append("the mean of U is left as it is")
    if found["reason"] in _LIMITED:
        texts.append(_LIMITED[found["reason"]])
    return "; ".join(texts)


def learning_rows(summary: Json) -> list[ReportRow]:
    """Return whether and what was learned, nothing where camsim does not say."""
    found = summary.get("learning")
    if found is None:
        return []
    if found["is_on"]:
        return [ReportRow("learning", _on_text(found))]
    why = _OFF.get(found["reason"])
    return [ReportRow("learning", f"off: {why}" if why else _NO_REHEARSAL)]


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
    axes.set_yscale("log")
    axes.set_ylim(low * (0.5 if low == high else 0.8), high * 1.25)
    subs = (1.0, 2.0, 5.0) if high / low < 1e4 else (1.0,)
    axes.yaxis.set_major_locator(LogLocator(base=10, subs=subs, numticks=40))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_minor_formatter(NullFormatter())


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
        axes.text((low + high) / 2, 1.02, name, transform=axes.get_xaxis_transform(), ha="center")
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
