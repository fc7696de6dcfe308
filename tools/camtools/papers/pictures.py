"""Declared pictures: panels of the columns of a table, or of several.

>>> label_of("spindle_acceleration_rad_s2"), label_of("depth_mm"), label_of("s1")
(('spindle acceleration', 'rad/s²'), ('depth', 'mm'), ('s1', ''))
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase

from camtools.base.text import Columns
from camtools.papers.declared import declarations
from camtools.plots.style import GREY, legend_below, new_figure, stroke_of

_UNITS = {
    "mm_s3": "mm/s³",
    "mm_s2": "mm/s²",
    "rad_s2": "rad/s²",
    "deg_s2": "degrees/s²",
    "mm3_s": "mm³/s",
    "mm_s": "mm/s",
    "deg_s": "degrees/s",
    "mm_rad": "mm/rad",
    "mm2": "mm²",
    "mm": "mm",
    "um": "µm",
    "deg": "degrees",
    "rpm": "r/min",
    "ms": "ms",
    "n": "N",
    "w": "W",
}


def label_of(name: str) -> tuple[str, str]:
    """Return the words and the unit of a column's name."""
    for end, unit in _UNITS.items():
        if name.endswith(f"_{end}"):
            return name.removesuffix(f"_{end}").replace("_", " "), unit
    return name.replace("_", " "), ""


def _plot(
    axes: Axes, columns: Columns, picture: Mapping[str, Any], names: list[str], of: str
) -> None:
    """Draw columns in a panel; `of` names the table where there are several."""
    x = np.asarray(columns[picture["x"]][0])
    if x.dtype.kind == "U":
        axes.set_xticks(range(x.size), x)
        x = np.arange(x.size)
    for i, name in enumerate(names):
        values = np.array(columns[name][0], dtype=np.float64)
        values[np.abs(values) > picture.get("most", np.inf)] = np.nan
        stroke, label = stroke_of(len(axes.lines) + len(axes.containers)), of or label_of(name)[0]
        if np.isnan(values).all():
            continue
        if picture.get("kind") == "bars":
            width = 0.8 / len(names)
            shown = x + width * (i - (len(names) - 1) / 2)
            axes.bar(shown, np.abs(values), width, color=stroke["color"], label=label)
        else:
            marker = "o" if picture.get("kind") == "dots" else ""
            axes.plot(x, values, lw=1.3, label=label, marker=marker, ms=3, **stroke)


def fill_panels(figure: FigureBase, topic: str, tables: Mapping[str, Columns]) -> None:
    """Draw a declared picture of tables, by name where there are several, on a figure."""
    picture = declarations()["pictures"][topic]
    panels = figure.subplots(len(picture["panels"]), 1, sharex=True, squeeze=False)[:, 0]
    for axes, names in zip(panels, picture["panels"], strict=True):
        for of, columns in tables.items():
            _plot(axes, columns, picture, names, of)
        words, unit = label_of(names[0])
        axes.set_ylabel(f"{words},\n{unit}" if unit else words)
        axes.grid(alpha=0.3)
        if len(names) > 1:
            axes.legend(frameon=False, fontsize=8)
        axes.set(**picture.get("settings", {}).get(names[0], {}))
        for at in picture.get("limits", {}).get(names[0], ()):
            axes.axhline(at, color=GREY, ls="--", lw=1)
    panels[-1].set(
        xlabel=", ".join(filter(None, label_of(picture["x"]))), **picture.get("axis", {})
    )
    figure.align_ylabels(list(panels))


def draw_table(topic: str, title: str, tables: Mapping[str, Columns]) -> Figure:
    """Return a declared picture of a table, or of several in the same panels."""
    figure = new_figure(9, 1.2 + 1.9 * len(declarations()["pictures"][topic]["panels"]))
    figure.suptitle(title)
    fill_panels(figure, topic, tables)
    if len(tables) > 1:
        legend_below(figure, figure.axes[0], 3)
    return figure
