"""Panels of pictures: below each other, beside each other, in the plane, in space.

>>> panels = stacked(new_figure(4, 4), ["depth, mm", "area, mm²"])
>>> [axes.get_ylabel() for axes in panels]
['depth, mm', 'area, mm²']
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.axes3d import Axes3D  # type: ignore[import-untyped]

from camtools.base.quantities import Floats
from camtools.plots.style import BLUE, GREY, ORANGE, drawing, new_figure, png_of

Drawers = Mapping[str, Callable[[], Figure]]
"""What draws each picture, by its name."""


def pictures(drawers: Drawers) -> dict[str, bytes]:
    """Return pictures as PNG by their names."""
    with drawing():
        return {name: png_of(draw()) for name, draw in drawers.items()}


def stacked(figure: Figure, names: Sequence[str]) -> list[Axes]:
    """Return panels below each other that share x, each with the name of its y and a grid."""
    panels: list[Axes] = list(figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0])
    for axes, name in zip(panels, names, strict=True):
        axes.set_ylabel(name)
        axes.grid(alpha=0.3)
    figure.align_ylabels(panels)
    return panels


def side_by_side(n: int, title: str, size_in: tuple[float, float]) -> tuple[Figure, list[Axes]]:
    """Return a figure with a title and panels beside each other."""
    figure = new_figure(*size_in)
    figure.suptitle(title)
    panels: list[Axes] = list(figure.subplots(1, n, squeeze=False)[0])
    for axes in panels:
        axes.grid(alpha=0.3)
    return figure, panels


def legend_below(figure: Figure, axes: Axes, n_columns: int) -> None:
    """Explain the lines of a panel once for all, below the panels."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=n_columns, frameon=False)


def points(axes: Axes, x: Floats, y: Floats, colour: str = BLUE) -> None:
    """Draw points joined by lines."""
    axes.plot(x, y, color=colour, marker="o", ms=3, lw=1.2)


def plane(axes: Axes) -> None:
    """Make a panel a plane of equal scales without a frame."""
    axes.set_aspect("equal")
    axes.axis("off")


def space(figure: Figure, place: int, aspect: float) -> Axes3D:
    """Return a panel in space; `place` as of `add_subplot`, aspect: height to width."""
    axes = figure.add_subplot(place, projection="3d")
    assert isinstance(axes, Axes3D)
    axes.set_box_aspect((1, 1, aspect), zoom=0.85)
    axes.view_init(elev=22, azim=-58)
    axes.set_xlabel("x, mm")
    axes.set_ylabel("y, mm")
    axes.set_zlabel("height, mm")
    return axes


def around(radius: Floats, phi_rad: Floats) -> tuple[Floats, Floats]:
    """Return the plane coordinates of polar ones."""
    return radius * np.cos(phi_rad), radius * np.sin(phi_rad)


def paint_band(
    axes: Axes, x: Floats, curves: tuple[Floats, Floats, Floats], names: tuple[str, str]
) -> None:
    """Draw the range of a curve around its dashed middle, both named above the panel.

    Parameters
    ----------
    curves : tuple of ndarray
        Smallest and largest value, and the middle.
    names : tuple of str
        Of the range and of the middle.
    """
    least, most, middle = curves
    axes.fill_between(x, least, most, color=ORANGE, alpha=0.35, lw=0)
    axes.plot(x, most, color=ORANGE, lw=1, label=names[0])
    axes.plot(x, least, color=ORANGE, lw=1)
    axes.plot(x, middle, color=BLUE, lw=1.6, ls="--", label=names[1])
    axes.axhline(0, color=GREY, lw=0.8)
    axes.legend(frameon=False, loc="upper left", bbox_to_anchor=(0, 1.16), ncols=2)
