"""A view of a report, as a kind of part declares it, and the views that all kinds share.

>>> worth_text((CutVariant("a", 0.1, 0.03), CutVariant("b", 3.0, 1.0)))
['', '30 times worse']
"""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Generic, NamedTuple, TypeVar

import numpy as np
from matplotlib.figure import Figure

from camtools.base.quantities import Floats, length_text
from camtools.base.text import Json
from camtools.plots import style
from camtools.report.charts import (
    TurnOfU,
    following_chart,
    following_sentence,
    motion_chart,
    motion_sentence,
)
from camtools.report.motion import draw_fault, draw_sequence, following_by_angle
from camtools.report.text import fault_story
from camtools.sim.results import CUTTING, FAULT, AnyCut, CutVariant

_MOST_MARKS = 150  # beyond, points of a line hide one another
_WHITE = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
CutT = TypeVar("CutT", bound=AnyCut)
ShownT = TypeVar("ShownT", bound=AnyCut, contravariant=True)  # a view of every cut shows a skirt's


def has_surface(cut: AnyCut) -> bool:
    """Return whether points of the surface were gauged."""
    return bool(cut.surface.turn.size)


def has_turns(cut: AnyCut) -> bool:
    """Return whether the trace has ticks of cutting."""
    return bool((cut.trace.state == CUTTING).any())


class View(NamedTuple, Generic[ShownT]):
    """A picture or chart of a report, with what to look for."""

    key: str  # names the file of a picture: cut_KEY.png
    title: str
    text: str
    draw: Callable[[ShownT], Figure] | None  # nothing for a chart
    when: Callable[[ShownT], bool] = lambda _: True
    chart: Callable[[ShownT], Json] | None = None  # of plotly.js
    sentence: Callable[[ShownT], str] | None = None  # what it shows, for readers who cannot see it

    def words(self, cut: ShownT) -> str:
        """Return what the view shows."""
        return (self.sentence(cut) if self.sentence else "") or self.title

    def png(self, cut: ShownT) -> bytes:
        """Return the picture."""
        assert self.draw is not None
        return style.png_of(self.draw(cut))


def fault_view(text: str) -> View[AnyCut]:
    """Return the axes around the first fault."""

    def draw(cut: AnyCut) -> Figure:
        return draw_fault(cut.trace, cut.summary.get("fault", {}).get("retract_s", 0.0))

    def sentence(cut: AnyCut) -> str:
        story = fault_story(cut)[:3] if cut.has_fault else []
        return " ".join(f"{row.name}: {row.value}." for row in story)

    def is_seen(cut: AnyCut) -> bool:
        return bool((cut.trace.state == FAULT).any())

    return View("fault", "The fault", text, draw, is_seen, sentence=sentence)


def motion_view(
    text: str, motion: Callable[[CutT], TurnOfU | None], key: str = "motion"
) -> View[CutT]:
    """Return U over one turn, of a cut that has one."""

    def found(cut: CutT) -> TurnOfU:
        turn = motion(cut)
        assert turn is not None
        return turn

    return View(
        *(key, "Motion of U over one turn", text),
        None,
        lambda cut: motion(cut) is not None,
        lambda cut: motion_chart(found(cut)),
        sentence=lambda cut: motion_sentence(found(cut)),
    )


def following_view(text: str) -> View[AnyCut]:
    """Return the following error of U over the spindle angle."""
    return View(
        *("following", "Following error of U", text),
        None,
        has_turns,
        lambda cut: following_chart(following_by_angle(cut.trace)),
        sentence=lambda cut: following_sentence(following_by_angle(cut.trace)),
    )


def _sequence_sentence(cut: AnyCut) -> str:
    whole = cut.trace if cut.overview is None else cut.overview
    cutting = whole.t_s[whole.state == CUTTING]
    from_to = f", cutting from {cutting[0]:.2f} to {cutting[-1]:.2f} s" if cutting.size else ""
    return f"State, Z, X and U over {whole.t_s[-1]:.2f} s{from_to}."


SEQUENCE: View[AnyCut] = View(
    "sequence",
    "Sequence of the cut",
    "Homing finds the index with U out of the work; engaging brings X to depth and increases the "
    "stroke of U smoothly from zero; disengaging is the reverse. No line may jump; only the green "
    "stretch counts for the verdict.",
    lambda cut: draw_sequence(cut.trace, cut.overview),
    lambda cut: cut.trace.t_s.size > 1,
    sentence=_sequence_sentence,
)


def _spans(turn: Floats, is_cut: np.ndarray) -> list[tuple[str, float, float]]:
    """Return name, begin and end [turn] of rehearsal, engaging and cut, in their order."""
    edges = (np.flatnonzero(np.diff(is_cut.astype(np.int8))) + 1).tolist()
    spans: list[tuple[str, float, float]] = []
    for begin, end in pairwise([0, *edges, turn.size]):
        name = "cut" if is_cut[begin] else "rehearsal"
        low, high = float(turn[begin]), float(turn[end - 1]) + 1
        if spans:
            spans.append(("engage" if name == "cut" else "", spans[-1][2], low))
        spans.append((name, low, high))
    return spans


def draw_convergence(summary: Json) -> Figure:
    """Return the error of each turn of rehearsal and cut on a logarithmic scale."""
    um = np.asarray(summary["error_per_turn_um"], dtype=np.float64)
    turn = np.asarray(summary["error_per_turn"]["turn"], dtype=np.float64)
    is_cut = np.asarray([state == "cutting" for state in summary["error_per_turn"]["state"]])
    tolerance_um = float(summary["form_error_um"]["tolerance"])
    figure = style.new_figure(10, 4.2)
    axes = figure.add_subplot()
    above = np.append(um[um > 0], tolerance_um)
    shown = np.maximum(um, above.min())  # nothing of a logarithmic scale is 0
    for name, low, high in _spans(turn, is_cut):
        shade = {"rehearsal": style.PALE, "engage": style.ORANGE}.get(name)
        if shade:
            axes.axvspan(low, high, color=shade, alpha=0.35, lw=0)
        row = 1.07 if name == "engage" else 1.02  # it is narrow, and its neighbours may be
        axes.text((low + high) / 2, row, name, transform=axes.get_xaxis_transform(), ha="center")
    look = {"marker": "o", "ms": 3} if um.size <= _MOST_MARKS else {}
    for part, colour in ((~is_cut, style.BLUE), (is_cut, style.RED)):
        gaps = np.flatnonzero(np.diff(np.flatnonzero(part)) > 1) + 1
        for rows in np.split(np.flatnonzero(part), gaps):
            axes.plot(turn[rows] + 0.5, shown[rows], color=colour, lw=1.2, **look)  # type: ignore[arg-type]
    axes.axhline(tolerance_um, color=style.GREEN, lw=1.6, ls="--")
    text = f" tolerance {length_text(tolerance_um)}"
    place = axes.get_yaxis_transform()
    axes.text(1, tolerance_um, text, transform=place, va="center", color=style.GREEN)
    low = style.nice_floor(min(shown.min(), tolerance_um))
    high = style.nice_limit(max(shown.max(), tolerance_um))
    style.log_axis(axes, "y", low * (0.5 if low == high else 0.8), high * 1.25)
    axes.set(xlim=(float(turn[0]), float(turn[-1]) + 1), xlabel="turns of the spindle")
    axes.set(ylabel="error of the turn, µm")
    axes.grid(alpha=0.3)
    return figure


def _learning_sentence(cut: AnyCut) -> str:
    um = cut.summary["error_per_turn_um"]
    first, last, least = (length_text(value) for value in (um[0], um[-1], min(um)))
    return f"Error of each of {len(um)} turns: first {first}, last {last}, smallest {least}."


LEARNING: View[AnyCut] = View(
    "learning",
    "Error of each turn",
    "Each point is a turn. In the rehearsal, with the tool clear of the work, it shows the "
    "deviation of U's tip from the drawing; in the cut, the largest form error of the turn. "
    "Learning shows as a fall from left to right; a rise at the start of the cut comes from the "
    "chip, mainly from its force. The scale is logarithmic.",
    lambda cut: draw_convergence(cut.summary),
    lambda cut: len(cut.summary.get("error_per_turn_um", [])) > 1,
    sentence=_learning_sentence,
)


def worth_text(variants: Sequence[CutVariant]) -> list[str]:
    """Return how much worse each variant is than the first."""
    best_um = variants[0].max_um if variants else 0.0
    texts = [""]
    for variant in variants[1:]:
        ratio = variant.max_um / best_um if best_um > 0 else 0.0
        times = f"{float(f'{ratio:.3g}'):g}"  # without a power of ten
        texts.append(f"{times} times worse" if ratio > 1 else "no worse")
    return texts[: len(variants)]


def draw_variants(variants: Sequence[CutVariant], tolerance_um: float) -> Figure:
    """Return the largest control errors on a logarithmic scale, beside the tolerance."""
    figure = style.new_figure(10, 1.1 + 0.5 * len(variants))
    axes = figure.add_subplot()
    values = [tolerance_um, *(variant.max_um for variant in variants)]
    above_zero = [value for value in values if value > 0] or [1.0]
    low, high = min(above_zero) / 2, max(above_zero) * 40  # with room for words
    axes.axvspan(low, tolerance_um, color=style.GREEN, alpha=0.12, lw=0)
    axes.axvline(tolerance_um, color=style.GREEN, lw=1.6, ls="--", zorder=1)
    for i, (variant, worth) in enumerate(zip(variants, worth_text(variants), strict=True)):
        at_um = max(variant.max_um, low)  # 0 has no place on a logarithmic scale
        marker, colour = ("o", style.BLUE) if i == 0 else ("D", style.RED)
        axes.plot([at_um], [i], ms=9, ls="", marker=marker, color=colour)
        text = f"{length_text(variant.max_um)}" + (f", {worth}" if worth else "")
        offset = {"xytext": (10, 0), "textcoords": "offset points", "va": "center"}
        axes.annotate(text, (at_um, i), bbox=_WHITE, zorder=1.5, **offset)  # type: ignore[arg-type]
    axes.set_title(f"shaded: within the tolerance of {length_text(tolerance_um)}", loc="left")
    axes.set_yticks(range(len(variants)), [variant.name for variant in variants])
    axes.set_ylim(len(variants) - 0.5, -0.5)
    style.log_axis(axes, "x", low, high)
    axes.grid(axis="x", alpha=0.3)
    axes.set_xlabel("largest error of the controller, µm")
    return figure


def _variants_sentence(cut: AnyCut) -> str:
    found = "; ".join(f"{variant.name} {length_text(variant.max_um)}" for variant in cut.variants)
    return f"Largest error of the controller: {found}."


COMPARE: View[AnyCut] = View(
    "compare",
    "What each part of the controller contributes",
    "The same cut with parts of the controller switched off; the scale is logarithmic. Dead-time "
    "lead plays the table ahead by the reaction time of the drive; feed-forward adds the velocity "
    "and acceleration of the table so that U does not lag.",
    lambda cut: draw_variants(cut.variants, cut.summary["form_error_um"]["tolerance"]),
    lambda cut: len(cut.variants) > 1,
    sentence=_variants_sentence,
)
