"""Picture of the surface between the tracks: measured on the simulator, and worked out.

>>> callable(draw_measured)
True
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camtools.plots.style import BLUE, GREY, ORANGE, angle_axis, drawing, new_figure, png_of
from camtools.study.path import PathStudy
from camtools.study.path_cut import PathCut, predicted_scallop_um
from camtools.study.path_plots import paint_map

_COLOURS = (BLUE, ORANGE, GREY)


def _draw_heights(axes: Axes, cuts: Sequence[PathCut]) -> None:
    """Draw peak to valley over the angle: lines measured, dashes worked out."""
    for one, colour in zip(cuts, _COLOURS, strict=True):
        deg = np.linspace(0, 360, one.scallop_um.size + 1)
        name = f"{one.row.name}, {one.row.path.feed_mm:g} mm"
        axes.plot(deg, np.append(one.scallop_um, one.scallop_um[0]), color=colour, label=name)
        predicted_um = predicted_scallop_um(one.row)
        axes.plot(deg, np.append(predicted_um, predicted_um[0]), color=colour, ls="--", lw=1)
    angle_axis(axes)
    axes.set_ylim(bottom=0)
    axes.set_ylabel("peak to valley, µm")
    axes.set_title("scallop height: cut (lines) and worked out (dashes)")
    axes.legend(frameon=False, loc="upper center", bbox_to_anchor=(0.5, 0.92))


def draw_measured(name: str, study: PathStudy, cuts: Sequence[PathCut]) -> bytes:
    """Return the maps of ring-helix and helix of as many turns, and the height of all, as PNG."""
    with drawing():
        figure: Figure = new_figure(9, 8.5)
        rpm = cuts[0].row.rpm
        figure.suptitle(
            f"{name}: metal left between the tracks, nose radius {study.nose_mm:g} mm, "
            f"{rpm:g} r/min"
        )
        layout = figure.add_gridspec(3, 2)
        highest = max(float(one.row.scallop_um.max()) for one in cuts[:2])
        maps = []
        for column, one in enumerate(cuts[:2]):
            for line, (what, map_um) in enumerate(
                (("cut on the simulator", one.proud_um), ("worked out", one.row.scallop_um))
            ):
                axes = figure.add_subplot(layout[line, column])
                shown = paint_map(axes, study, map_um, highest)
                axes.set_title(f"{one.row.name}, {one.row.path.feed_mm:g} mm: {what}")
                axes.set_ylabel("skirt height, mm" if column == 0 else "")
                maps.append(axes)
        figure.colorbar(shown, ax=maps, label="above the design, µm")
        _draw_heights(figure.add_subplot(layout[2, :]), cuts)
        return png_of(figure)
