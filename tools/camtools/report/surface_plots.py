"""Pictures of any gauged surface: error map, section as a roundness instrument draws it, height.

>>> Extent((0.0, 62.0), 0.5, "spindle angle", "height").n_rows
64
"""

from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camtools.base.quantities import UM_PER_MM, Floats, length_text, length_unit
from camtools.plots import style
from camtools.report.surface import bands_by_height, cells_of, closed, map_rows
from camtools.sim.results import GaugedSurface

_ROOM = 0.3  # share of the radius in which errors are drawn
TURN = np.linspace(0, 1, 721)


class Extent(NamedTuple):
    """Where a surface was gauged, and the names of its axes."""

    heights_mm: tuple[float, float]
    feed_mm: float
    angle: str  # "spindle angle from the long axis"
    height: str  # "skirt height"

    @property
    def n_rows(self) -> int:
        """Return the rows of the error map."""
        return map_rows(self.heights_mm[1] - self.heights_mm[0], self.feed_mm)

    @property
    def half_band_mm(self) -> float:
        """Return how far points may be from the height of a section [mm]."""
        return 1.5 * (self.heights_mm[1] - self.heights_mm[0]) / self.n_rows


def draw_map(surface: GaugedSurface, extent: Extent, against: str = "drawing") -> Figure:
    """Return the unrolled part coloured by its error; limits symmetric about zero."""
    figure = style.new_figure(10, 5.2)
    paint_map(figure.add_subplot(), surface, extent, against)
    return figure


def paint_map(axes: Axes, surface: GaugedSurface, extent: Extent, against: str = "drawing") -> None:
    """Draw the error map with its scale into a panel."""
    limit_um = style.nice_limit(float(np.abs(surface.error_um).max(initial=0.0)))
    factor, unit = length_unit(limit_um)
    axes.set_facecolor(style.PALE)
    picture = axes.imshow(
        cells_of(surface, extent.heights_mm, extent.n_rows).error_um * factor,
        extent=(0, 360, *extent.heights_mm),
        origin="lower",
        aspect="auto",
        interpolation="nearest",
        cmap=style.ERROR_COLOURS,
        vmin=-limit_um * factor,
        vmax=limit_um * factor,
    )
    bar = axes.figure.colorbar(picture, ax=axes, pad=0.02)
    bar.set_label(f"error against the {against}, {unit}  (above 0: metal left)")
    style.angle_axis(axes, extent.angle)
    axes.set_ylabel(f"{extent.height}, mm")


def draw_height(surface: GaugedSurface, extent: Extent) -> Figure:
    """Return the error of the surface over height: range and rms."""
    figure = style.new_figure(10, 3.6)
    axes = figure.add_subplot()
    z_mm, least, most, rms = bands_by_height(surface, extent.heights_mm)
    factor, unit = length_unit(float(np.abs(surface.error_um).max(initial=0.0)))
    curves = least * factor, most * factor, rms * factor
    style.paint_band(axes, z_mm, curves, ("largest and smallest at this height", "rms"))
    axes.set(xlim=extent.heights_mm, xlabel=f"{extent.height}, mm")
    axes.set_ylabel(f"error against\nthe drawing, {unit}")
    return figure


def draw_ring(axes: Axes, turn: Floats, radius: Floats | float, **look: object) -> None:
    """Draw a closed curve by its radii over the turn."""
    phi, radii = 2 * np.pi * turn, np.broadcast_to(radius, turn.shape)
    axes.plot(radii * np.cos(phi), radii * np.sin(phi), **look)  # type: ignore[arg-type]


def draw_clock(axes: Axes, title: str, middle: str, names_at: float) -> None:
    """Dress a round picture: angles and a text in the middle instead of a frame."""
    axes.set(aspect="equal", xlim=(-1.72, 1.72), ylim=(-1.55, 1.55))
    axes.axis("off")
    axes.set_title(title, fontsize=9.5)
    for quarter, name in enumerate(("0°", "90°", "180°", "270°")):
        x, y = np.cos(quarter * np.pi / 2), np.sin(quarter * np.pi / 2)
        where = (names_at * float(x), (names_at + 0.05) * float(y))
        side = ("left", "center", "right", "center")[quarter]
        axes.text(*where, name, ha=side, va="center", color=style.GREY, fontsize=9)
    axes.text(0, 0, middle, ha="center", va="center", color=style.GREY)


def draw_roundness(axes: Axes, near: GaugedSurface, a_mm: float, limit_um: float) -> None:
    """Draw one section's error like a roundness instrument: zero is the middle circle."""
    factor = int(float(f"{_ROOM * a_mm * UM_PER_MM / limit_um:.2g}"))
    for ring, look in ((1 - _ROOM, ":"), (1.0, "-"), (1 + _ROOM, ":")):
        draw_ring(axes, TURN, ring, color=style.BLUE if ring == 1 else style.GREY, lw=0.9, ls=look)
    line = closed(near)
    draw_ring(axes, line.turn, 1 + _ROOM * line.error_um / limit_um, color=style.RED, lw=1.2)
    title = "nothing cut here"
    if near.turn.size:
        spread = length_text(float(np.ptp(near.error_um)))
        title = f"off the drawing: {spread} peak to peak"
    enlarged = f"{factor:,}".replace(",", "\u2009")
    middle = f"error enlarged\n{enlarged}-fold\ndotted: ±{length_text(limit_um)}"
    draw_clock(axes, title, middle, 1.36)
