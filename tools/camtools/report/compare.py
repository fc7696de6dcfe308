"""What each part of the controller is worth: the same cut with parts of it switched off.

>>> worth_text((CutVariant("a", 0.1, 0.03), CutVariant("b", 3.0, 1.0)))
['', '30 times worse']
"""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from camtools.base.quantities import length_text
from camtools.plots.style import BLUE, GREEN, RED, log_axis, new_figure
from camtools.sim.results import CutVariant

_WHITE = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}


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
    figure = new_figure(10, 1.1 + 0.5 * len(variants))
    axes = figure.add_subplot()
    values = [tolerance_um, *(variant.max_um for variant in variants)]
    above_zero = [value for value in values if value > 0] or [1.0]
    low, high = min(above_zero) / 2, max(above_zero) * 40  # with room for words
    axes.axvspan(low, tolerance_um, color=GREEN, alpha=0.12, lw=0)
    axes.axvline(tolerance_um, color=GREEN, lw=1.6, ls="--", zorder=1)
    for i, (variant, worth) in enumerate(zip(variants, worth_text(variants), strict=True)):
        at_um = max(variant.max_um, low)  # 0 has no place on a logarithmic scale
        style = {"marker": "o", "color": BLUE} if i == 0 else {"marker": "D", "color": RED}
        axes.plot([at_um], [i], ms=9, ls="", **style)  # type: ignore[arg-type]
        text = f"{length_text(variant.max_um)}" + (f", {worth}" if worth else "")
        offset = {"xytext": (10, 0), "textcoords": "offset points", "va": "center"}
        axes.annotate(text, (at_um, i), bbox=_WHITE, zorder=1.5, **offset)  # type: ignore[arg-type]
    axes.set_title(f"shaded: within the tolerance of {length_text(tolerance_um)}", loc="left")
    axes.set_yticks(range(len(variants)), [variant.name for variant in variants])
    axes.set_ylim(len(variants) - 0.5, -0.5)
    log_axis(axes, "x", low, high)
    axes.grid(axis="x", alpha=0.3)
    axes.set_xlabel("largest error of the controller, µm")
    return figure
