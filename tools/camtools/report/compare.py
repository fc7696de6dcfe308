"""What each part of the controller is worth: the same cut with parts of it switched off.

>>> worth_text((CutVariant("a", 0.1, 0.03), CutVariant("b", 3.0, 1.0)))
['', '30 times worse']
"""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from camtools.base.quantities import length_text
from camtools.plots.style import BLUE, GREEN, RED, new_figure
from camtools.sim.results import CutVariant

_WHITE = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}


def worth_text(variants: Sequence[CutVariant]) -> list[str]:
    """Return how much worse each variant is than the first."""
    best_um = variants[0].max_um if variants else 0.0
    texts = [""]
    for variant in variants[1:]:
        ratio = variant.max_um / best_um if best_um > 0 else 0.0
        texts.append(f"{ratio:.3g} times worse" if ratio > 1 else "no worse")
    return texts[: len(variants)]


def draw_variants(variants: Sequence[CutVariant], tolerance_um: float) -> Figure:
    """Return bars of the largest control error on a logarithmic scale, beside the tolerance."""
    figure = new_figure(10, 0.9 + 0.5 * len(variants))
    axes = figure.add_subplot()
    for i, (variant, worth) in enumerate(zip(variants, worth_text(variants), strict=True)):
        axes.barh(i, variant.max_um, color=BLUE if i == 0 else RED, height=0.6)
        text = f"  {length_text(variant.max_um)}" + (f", {worth}" if worth else "")
        axes.text(variant.max_um, i, text, va="center", bbox=_WHITE, zorder=3)
    axes.axvline(tolerance_um, color=GREEN, lw=1.6, ls="--")
    axes.set_title(f"dashed line: tolerance {length_text(tolerance_um)}")
    axes.set_yticks(range(len(variants)), [variant.name for variant in variants])
    axes.invert_yaxis()
    axes.set_xscale("log")
    values = [tolerance_um, *(variant.max_um for variant in variants)]
    above_zero = [value for value in values if value > 0] or [1.0]
    axes.set_xlim(min(above_zero) / 5, max(above_zero) * 15)
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set_xlabel("largest error of the controller, µm")
    return figure
