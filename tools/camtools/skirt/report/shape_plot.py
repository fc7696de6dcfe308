"""The cut skirt in space, its deviations from a cylinder enlarged.

>>> enlargement_of(1.0), enlargement_of(30.0)
(30, 1)
"""

from __future__ import annotations

import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.axes3d import Axes3D  # type: ignore[import-untyped]

from camtools.base.quantities import Floats
from camtools.plots.style import new_figure
from camtools.sim.results import GaugedSurface
from camtools.skirt.geometry.skirt_geometry import Geometry

_ENLARGED = 30.0
_N_ROWS, _N_COLUMNS = 48, 180
_UM_PER_MM = 1000.0


def enlargement_of(factor: float) -> int:
    """Return by how much to enlarge a part whose drawing is enlarged by a factor already."""
    return max(1, round(_ENLARGED / factor))


def radius_grid(surface: GaugedSurface, geometry: Geometry) -> tuple[Floats, Floats, Floats]:
    """Return heights (n,), turns (m,) and the mean cut radius (n, m) [mm]; NaN where uncut."""
    low, high = geometry.z_first_mm, geometry.z_last_mm
    row = ((surface.z_mm - low) / (high - low) * _N_ROWS).astype(np.int64).clip(0, _N_ROWS - 1)
    column = (surface.turn * _N_COLUMNS).astype(np.int64).clip(0, _N_COLUMNS - 1)
    cell, n_cells = row * _N_COLUMNS + column, _N_ROWS * _N_COLUMNS
    count = np.bincount(cell, minlength=n_cells)
    total = np.bincount(cell, surface.radius_mm, minlength=n_cells)
    mean = np.where(count > 0, total / np.maximum(count, 1), np.nan)
    heights = low + (np.arange(_N_ROWS) + 0.5) * (high - low) / _N_ROWS
    return heights, (np.arange(_N_COLUMNS) + 0.5) / _N_COLUMNS, mean.reshape(_N_ROWS, _N_COLUMNS)


def draw_skirt(surface: GaugedSurface, geometry: Geometry, factor: float) -> Figure:
    """Return the cut skirt, deviations from its largest radius enlarged.

    Parameters
    ----------
    factor : float
        By which the drawing is enlarged already, 1 for a real part.
    """
    heights, turns, radius = radius_grid(surface, geometry)
    enlarged, largest = enlargement_of(factor), float(np.nanmax(radius))
    depth_mm = largest - radius
    shown = largest - enlarged * depth_mm
    closed = np.column_stack([shown, shown[:, 0]])
    colour_of = Normalize(0, float(np.nanmax(depth_mm)) * _UM_PER_MM)
    colours = colormaps["viridis_r"](colour_of(np.column_stack([depth_mm, depth_mm[:, 0]]) * 1e3))
    phi = 2 * np.pi * np.append(turns, turns[0] + 1)
    figure = new_figure(10, 7)
    axes = figure.add_subplot(projection="3d")
    assert isinstance(axes, Axes3D)
    axes.plot_surface(
        closed * np.cos(phi),
        closed * np.sin(phi),
        np.broadcast_to(heights[:, None], closed.shape),
        facecolors=colours,
        rstride=1,
        cstride=1,
        linewidth=0,
        antialiased=False,
        shade=False,
    )
    height_to_width = float(heights[-1] - heights[0]) / (2 * largest)
    axes.set_box_aspect((1, 1, max(0.4, height_to_width)))
    axes.view_init(elev=24, azim=-58)
    axes.set_xlabel("long axis, mm")
    axes.set_ylabel("short axis, mm")
    axes.set_zlabel("skirt height, mm")
    axes.set_title(f"deviations enlarged {enlarged} times" if enlarged > 1 else "as drawn")
    bar = figure.colorbar(ScalarMappable(colour_of, "viridis_r"), ax=axes, shrink=0.6, pad=0.1)
    bar.set_label("below the largest radius, µm")
    return figure
