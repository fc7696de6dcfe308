"""Panels, arrows and surfaces of the papers' pictures.

>>> figure, axes = panels(2, "over the angle", 4.0)
>>> len(axes), figure.get_suptitle()
(2, 'over the angle')
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.axes3d import Axes3D  # type: ignore[import-untyped]

from camtools.base.quantities import Floats
from camtools.papers.rows import Maker
from camtools.plots.style import BLUE, drawing, new_figure, png_of

UM_PER_MM = 1000.0


def png(draw: Callable[[], Figure]) -> Maker:
    """Return what makes a picture as PNG."""

    def make() -> bytes:
        with drawing():
            return png_of(draw())

    return make


def panels(n: int, title: str, height_in: float) -> tuple[Figure, list[Axes]]:
    """Return panels below each other that share x."""
    figure = new_figure(8, height_in)
    figure.suptitle(title)
    found = figure.subplots(n, 1, sharex=True, squeeze=False)[:, 0]
    for axes in found:
        axes.grid(alpha=0.3)
    return figure, list(found)


def side_by_side(n: int, title: str, size_in: tuple[float, float]) -> tuple[Figure, list[Axes]]:
    """Return panels beside each other."""
    figure = new_figure(*size_in)
    figure.suptitle(title)
    found = figure.subplots(1, n, squeeze=False)[0]
    for axes in found:
        axes.grid(alpha=0.3)
    return figure, list(found)


def points(axes: Axes, x: Floats, y: Floats, label: str, colour: str = BLUE) -> None:
    """Draw points joined by lines, with the name of y."""
    axes.plot(x, y, color=colour, marker="o", ms=3, lw=1.2)
    axes.set_ylabel(label)


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
