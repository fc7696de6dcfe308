"""Pictures of the comparison of paths: unrolled, and the metal left between the tracks.

>>> from camtools.papers.paths import make_study
>>> from camtools.part.common import MachineLimits
>>> sorted(drawers("a", make_study(0.0, 62.0, 0.2, 1000.0, 0.8, MachineLimits())))
['path_scallop', 'path_unrolled']
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camtools.cut.path import ToolPath
from camtools.papers.paths import PathCut, PathStudy
from camtools.plots.style import BLUE, GREY, ORANGE, Drawers, angle_axis, legend_below, new_figure

_DEG = np.linspace(0, 360, 361)
_COLOURS = (BLUE, ORANGE, GREY)


def _track(axes: Axes, path: ToolPath, low_mm: float, high_mm: float) -> None:
    """Draw every turn that touches the heights: rings blue, helix turns orange."""
    names = [("closed ring", BLUE), ("turn of a helix", ORANGE)]
    for turn in range(int(np.ceil(path.turns))):
        z = path.height_mm(turn + _DEG / 360)
        if z[-1] >= low_mm and z[0] <= high_mm:
            name, colour = names[not (path.kind == "ring-helix" and turn % 2 == 0)]
            label = "_" if name in axes.get_legend_handles_labels()[1] else name
            axes.plot(_DEG, z, color=colour, lw=1.8, label=label)
    angle_axis(axes)


def draw_unrolled(name: str, study: PathStudy) -> Figure:
    """Return the paths on the unrolled skirt, over the heights of the maps."""
    figure = new_figure(10, 5.2)
    figure.suptitle(f"{name}: two paths of as many turns, unrolled")
    panels = figure.subplots(1, 2, sharey=True)
    low, high = float(study.z_mm[0]), float(study.z_mm[-1])
    path = study.rows[0].path
    room = 0.1 * path.feed_mm
    for axes, row in zip(panels, study.rows, strict=False):
        _track(axes, row.path, low, high)
        axes.set(title=f"{row.name}, {row.path.feed_mm:g} mm", ylim=(low - room, high + room))
        axes.grid(alpha=0.3)
    straight = ToolPath(path.kind, path.z_first_mm, path.z_last_mm, path.feed_mm)
    first = 2 * round((low - straight.z_first_mm) / straight.feed_mm) + 1
    printed = straight.height_mm(first + _DEG / 360)
    panels[0].plot(_DEG, printed, color=GREY, ls="--", lw=1, label="as printed, without ramps")
    panels[0].set_ylabel("skirt height, mm")
    legend_below(figure, panels[0], 3)
    return figure


def draw_scallop(name: str, study: PathStudy, cuts: Sequence[PathCut] = ()) -> Figure:
    """Return maps of the metal left between the tracks; of cuts also the height of the scallops."""
    shown = [(f"{row.name}, {row.path.feed_mm:g} mm", row.scallop_um) for row in study.rows]
    maps = [(f"{title}: worked out", map_um) for title, map_um in shown[:2]]
    if cuts:
        first = zip(shown[:2], cuts, strict=False)
        maps = [
            (f"{title}: cut on the simulator", one.proud_um) for (title, _), one in first
        ] + maps
    n_rows = len(maps) // 2
    figure = new_figure(10, 5.2 if not cuts else 9)
    nose = f"nose radius {study.nose_mm:g} mm, {study.rows[0].rpm:g} r/min"
    figure.suptitle(f"{name}: metal left between the tracks, {nose}")
    grid = figure.add_gridspec(n_rows + bool(cuts), 2)
    highest = max(float(map_um.max()) for _, map_um in shown[:2])
    extent = (0.0, 360.0, float(study.z_mm[0]), float(study.z_mm[-1]))
    style: dict[str, Any] = {"origin": "lower", "aspect": "auto", "cmap": "viridis"}
    style |= {"vmin": 0, "vmax": highest}
    panels = [figure.add_subplot(grid[i // 2, i % 2]) for i in range(len(maps))]
    for axes, (title, map_um) in zip(panels, maps, strict=True):
        image = axes.imshow(np.r_[map_um, map_um[:1]].T, extent=extent, **style)
        angle_axis(axes)
        axes.set(title=title, ylabel="skirt height, mm" if axes in panels[::2] else "")
    figure.colorbar(image, ax=panels, label="above the design, µm")
    if cuts:
        axes = figure.add_subplot(grid[n_rows, :])
        for (title, _), one, colour in zip(shown, cuts, _COLOURS, strict=True):
            for values, dash in ((one.scallop_um, "-"), (one.predicted_um, "--")):
                closed, label = np.r_[values, values[0]], title if dash == "-" else "_"
                axes.plot(np.linspace(0, 360, closed.size), closed, dash, color=colour, label=label)
        axes.set_title("scallop height: cut (lines) and worked out (dashes)")
        axes.set(ylabel="peak to valley, µm", ylim=(0, None))
        axes.legend(frameon=False, loc="upper center")
        angle_axis(axes)
    return figure


def drawers(name: str, study: PathStudy) -> Drawers:
    """Return the makers of the pictures of the theory by topic."""
    return {
        "path_unrolled": partial(draw_unrolled, name, study),
        "path_scallop": partial(draw_scallop, name, study),
    }
