"""Pictures of paths: unrolled, and the scallops they leave.

>>> from camtools.part.common import MachineLimits
>>> from camtools.study.path import make_study
>>> sorted(draw_all("example", make_study(0.0, 62.0, 0.2, 1000.0, 0.8, MachineLimits())))
['path_scallop', 'path_unrolled']
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage

from camtools.base.quantities import Floats
from camtools.cut.path import ToolPath
from camtools.plots.panels import legend_below, pictures
from camtools.plots.style import BLUE, GREY, ORANGE, angle_axis, new_figure
from camtools.study.path import PathStudy

_POINTS = 361
_DEG = np.linspace(0, 360, _POINTS)


def _tracks(axes: Axes, path: ToolPath, low_mm: float, high_mm: float) -> None:
    """Draw every turn that touches the heights: rings blue, helix turns orange."""
    named: set[str] = set()
    for turn in range(int(np.ceil(path.turns))):
        z = path.height_mm(turn + _DEG / 360)
        if z[-1] < low_mm or z[0] > high_mm:
            continue
        is_ring = path.kind == "ring-helix" and turn % 2 == 0
        name = "closed ring" if is_ring else "turn of a helix"
        label = None if name in named else name
        named.add(name)
        axes.plot(_DEG, z, color=BLUE if is_ring else ORANGE, lw=1.8, label=label)
    angle_axis(axes)


def draw_unrolled(name: str, study: PathStudy) -> Figure:
    """Return the paths on the unrolled skirt, over the heights of the maps."""
    figure = new_figure(10, 5.2)
    ring, plain = study.rows[:2]
    figure.suptitle(f"{name}: two paths of as many turns, unrolled")
    panels = figure.subplots(1, 2, sharey=True)
    low, high = float(study.z_mm[0]), float(study.z_mm[-1])
    for axes, row in zip(panels, (ring, plain), strict=True):
        _tracks(axes, row.path, low, high)
        axes.set_title(f"{row.name}, {row.path.feed_mm:g} mm")
        axes.set_ylim(low - 0.1 * ring.path.feed_mm, high + 0.1 * ring.path.feed_mm)
        axes.grid(alpha=0.3)
    straight = ToolPath(
        ring.path.kind, ring.path.z_first_mm, ring.path.z_last_mm, ring.path.feed_mm
    )
    first = 2 * round((low - straight.z_first_mm) / straight.feed_mm) + 1
    as_printed = straight.height_mm(first + _DEG / 360)
    panels[0].plot(_DEG, as_printed, color=GREY, ls="--", lw=1, label="as printed, without ramps")
    panels[0].set_ylabel("skirt height, mm")
    legend_below(figure, panels[0], 3)
    return figure


def paint_map(axes: Axes, study: PathStudy, map_um: Floats, highest_um: float) -> AxesImage:
    """Draw metal above the design over angle and height, in colours from 0 to `highest_um`."""
    around = np.append(map_um, map_um[:1], axis=0).T
    extent = (0.0, 360.0, float(study.z_mm[0]), float(study.z_mm[-1]))
    shown = axes.imshow(
        around,
        origin="lower",
        aspect="auto",
        extent=extent,
        cmap="viridis",
        vmin=0,
        vmax=highest_um,
    )
    angle_axis(axes)
    return shown


def draw_scallop(name: str, study: PathStudy) -> Figure:
    """Return maps of the metal left between the tracks, on one scale of colours."""
    figure = new_figure(10, 5.2)
    figure.suptitle(f"{name}: metal left between the tracks, nose radius {study.nose_mm:g} mm")
    panels = figure.subplots(1, 2, sharey=True)
    highest = max(float(row.scallop_um.max()) for row in study.rows[:2])
    for axes, row in zip(panels, study.rows[:2], strict=True):
        shown = paint_map(axes, study, row.scallop_um, highest)
        most, mean = row.scallop_um.max(), row.scallop_um.mean()
        axes.set_title(f"{row.name}: largest {most:.3g} µm, mean {mean:.3g} µm")
    panels[0].set_ylabel("skirt height, mm")
    figure.colorbar(shown, ax=list(panels), label="above the design, µm")
    return figure


def draw_all(name: str, study: PathStudy) -> dict[str, bytes]:
    """Return all pictures by topic."""
    return pictures(
        {
            "path_unrolled": lambda: draw_unrolled(name, study),
            "path_scallop": lambda: draw_scallop(name, study),
        }
    )
