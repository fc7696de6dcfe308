"""Pictures of the gauged surface: error map, magnified sections, error over height.

>>> enlargement(46.0, 0.1)
100
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from camtools.base.quantities import Floats, length_text, length_unit
from camtools.plots.style import (
    BLUE,
    ERROR_COLOURS,
    GREY,
    ORANGE,
    PALE,
    RED,
    angle_axis,
    new_figure,
    nice_floor,
    nice_limit,
)
from camtools.report.map_cells import cells_of, map_rows, worst_of
from camtools.sim.results import GaugedSurface
from camtools.skirt.geometry.skirt_geometry import Geometry

N_BINS = 180  # of a section
N_SECTIONS = 3
_ROOM, _ROOM_FOR_OVAL = 0.3, 0.35  # shares of the radius in which deviations are drawn
_UM_PER_MM = 1000.0
_TURN = np.linspace(0, 1, 721)


def enlargement(radius_mm: float, deviation_mm: float) -> int:
    """Return the largest round factor by which a deviation fills a third of a radius at most."""
    if deviation_mm <= 0:
        return 1
    return max(1, round(nice_floor(_ROOM_FOR_OVAL * radius_mm / deviation_mm)))


def error_grid(surface: GaugedSurface, z_range_mm: tuple[float, float], n_rows: int) -> Floats:
    """Return the worst error of every cell.

    Returns
    -------
    ndarray, shape (n_rows, N_COLUMNS)
        Error [um], rows by rising height, columns by angle; NaN where nothing was gauged.
    """
    return cells_of(surface, z_range_mm, n_rows).error_um


def heights_range_mm(geometry: Geometry) -> tuple[float, float]:
    """Return the height range of the part [mm]."""
    return geometry.z_first_mm, geometry.z_last_mm


def draw_map(
    surface: GaugedSurface, geometry: Geometry, feed_mm: float, against: str = "drawing"
) -> Figure:
    """Return the unrolled skirt coloured by its error; limits symmetric about zero."""
    figure = new_figure(10, 5.2)
    _paint_map(figure, figure.add_subplot(), surface, geometry, feed_mm, against)
    return figure


def _paint_map(
    figure: Figure,
    axes: Axes,
    surface: GaugedSurface,
    geometry: Geometry,
    feed_mm: float,
    against: str = "drawing",
) -> None:
    limit_um = nice_limit(float(np.abs(surface.error_um).max(initial=0.0)))
    factor, unit = length_unit(limit_um)
    low, high = heights_range_mm(geometry)
    grid = error_grid(surface, (low, high), map_rows(high - low, feed_mm))
    axes.set_facecolor(PALE)
    picture = axes.imshow(
        grid * factor,
        extent=(0, 360, low, high),
        origin="lower",
        aspect="auto",
        interpolation="nearest",
        cmap=ERROR_COLOURS,
        vmin=-limit_um * factor,
        vmax=limit_um * factor,
    )
    bar = figure.colorbar(picture, ax=axes, pad=0.02)
    bar.set_label(f"error against the {against}, {unit}  (above 0: metal left)")
    angle_axis(axes)
    axes.set_ylabel("skirt height, mm")


def section_at(surface: GaugedSurface, z_mm: float, half_band_mm: float) -> GaugedSurface:
    """Return the worst point of every `N_BINS`-th of a turn near a height, by rising angle."""
    near = np.flatnonzero(np.abs(surface.z_mm - z_mm) <= half_band_mm)
    index = (surface.turn[near] * N_BINS).astype(np.int64).clip(0, N_BINS - 1)
    worst = worst_of(index, surface.error_um[near], N_BINS)
    rows = near[worst[worst >= 0]]
    return GaugedSurface(*(column[rows] for column in surface))


def closed(near: GaugedSurface) -> GaugedSurface:
    """Return a section with its first point again at the end when it goes all around."""
    if near.turn.size < N_BINS:
        return near
    again = near.turn[:1] + 1
    return GaugedSurface(
        np.append(near.turn, again), *(np.append(column, column[:1]) for column in near[1:])
    )


def _ring(axes: Axes, turn: Floats, radius: Floats | float, **style: object) -> None:
    phi, radii = 2 * np.pi * turn, np.broadcast_to(radius, turn.shape)
    axes.plot(radii * np.cos(phi), radii * np.sin(phi), **style)  # type: ignore[arg-type]


def _clock(axes: Axes, title: str, middle: str, names_at: float) -> None:
    """Dress a round picture: angles and a text in the middle instead of a frame."""
    axes.set_aspect("equal")
    axes.set_xlim(-1.72, 1.72)
    axes.set_ylim(-1.55, 1.55)
    axes.axis("off")
    axes.set_title(title, fontsize=9.5)
    for quarter, name in enumerate(("0°", "90°", "180°", "270°")):
        x, y = np.cos(quarter * np.pi / 2), np.sin(quarter * np.pi / 2)
        where = (names_at * float(x), (names_at + 0.05) * float(y))
        side = ("left", "center", "right", "center")[quarter]
        axes.text(*where, name, ha=side, va="center", color=GREY, fontsize=9)
    axes.text(0, 0, middle, ha="center", va="center", color=GREY)


def draw_shape(
    axes: Axes, near: GaugedSurface, geometry: Geometry, z_mm: float, factor: int
) -> None:
    """Draw one section, its deviation from the long-axis circle enlarged by a factor."""
    a_mm = float(geometry.radius_mm(z_mm))
    drawn_mm = geometry.drawing.delta(2 * np.pi * _TURN, z_mm).delta
    _ring(axes, _TURN, 1.0, color=GREY, lw=0.8, ls=":")
    _ring(axes, _TURN, 1 - factor * drawn_mm / a_mm, color=BLUE, lw=1.6)
    if geometry.drawn is not None:
        delta_mm = geometry.delta(2 * np.pi * _TURN, z_mm).delta
        _ring(axes, _TURN, 1 - factor * delta_mm / a_mm, color=ORANGE, lw=1.2, ls="--")
    # each point against the long half axis of its own height: the taper is not ovality
    own_mm = geometry.radius_mm(near.z_mm)
    cut = 1 - factor * (own_mm - near.radius_mm) / a_mm
    step = max(1, cut.size // 60)
    _ring(axes, near.turn[::step], cut[::step], color=RED, ls="", marker="o", ms=3.2, mfc="none")
    words = geometry.oval_words(z_mm).replace(", with", ",\nwith")
    _clock(axes, f"height {z_mm:.1f} mm: {words}", f"oval enlarged\n{factor}-fold", 1.08)


def draw_roundness(axes: Axes, near: GaugedSurface, a_mm: float, limit_um: float) -> None:
    """Draw one section's error like a roundness instrument: zero is the middle circle."""
    factor = round_to_two_digits(_ROOM * a_mm * _UM_PER_MM / limit_um)
    for ring, style in ((1 - _ROOM, ":"), (1.0, "-"), (1 + _ROOM, ":")):
        _ring(axes, _TURN, ring, color=BLUE if ring == 1 else GREY, lw=0.9, ls=style)
    line = closed(near)
    _ring(axes, line.turn, 1 + _ROOM * line.error_um / limit_um, color=RED, lw=1.2)
    spread_um = float(np.ptp(near.error_um)) if near.turn.size else 0.0
    title = (
        f"off the drawing: {length_text(spread_um)} peak to peak"
        if near.turn.size
        else "nothing cut here"
    )
    enlarged = f"{factor:,}".replace(",", "\u2009")
    middle = f"error enlarged\n{enlarged}-fold\ndotted: ±{length_text(limit_um)}"
    _clock(axes, title, middle, 1.36)


def round_to_two_digits(value: float) -> int:
    """Return a number above 10 with its first two digits.

    >>> round_to_two_digits(137936.0)
    140000
    """
    return int(float(f"{value:.2g}"))


def section_heights_mm(geometry: Geometry) -> Floats:
    """Return the heights of the sections shown: near the bottom, the middle, near the top."""
    low, high = heights_range_mm(geometry)
    return np.asarray(low + (high - low) * np.linspace(0.05, 0.95, N_SECTIONS), dtype=np.float64)


def draw_sections(surface: GaugedSurface, geometry: Geometry, feed_mm: float) -> Figure:
    """Return sections: above with the oval enlarged, below the error alone, enlarged far more."""
    low, high = heights_range_mm(geometry)
    heights = section_heights_mm(geometry)
    half_band_mm = 1.5 * (high - low) / map_rows(high - low, feed_mm)
    bands = [section_at(surface, float(z), half_band_mm) for z in heights]
    worst_um = max((float(np.abs(near.error_um).max(initial=0.0)) for near in bands), default=0.0)
    radii = geometry.radius_mm(heights)
    deepest_mm = max(geometry.deepest_mm(float(z_mm)) for z_mm in heights)
    factor = enlargement(float(radii.min()), deepest_mm)
    figure = new_figure(10, 7.4)
    panels = figure.subplots(2, N_SECTIONS)
    for i, (z_mm, near) in enumerate(zip(heights, bands, strict=True)):
        draw_shape(panels[0, i], near, geometry, float(z_mm), factor)
        draw_roundness(panels[1, i], near, float(radii[i]), nice_limit(worst_um))
    figure.legend(
        handles=_section_handles(geometry), loc="outside upper center", ncols=4, frameon=False
    )
    return figure


def _section_handles(geometry: Geometry) -> list[Line2D]:
    """Return what explains the lines of a section."""
    played = Line2D([], [], color=ORANGE, lw=1.2, ls="--", label=geometry.played_name)
    return [
        Line2D([], [], color=BLUE, lw=1.6, label="drawing"),
        *([] if geometry.drawn is None else [played]),
        Line2D([], [], color=RED, ls="", marker="o", mfc="none", label="cut"),
        Line2D([], [], color=GREY, ls=":", label="circle through the long axis"),
    ]


def bands_by_height(surface: GaugedSurface, z_range_mm: tuple[float, float]) -> Floats:
    """Return the error in bands of height.

    Returns
    -------
    ndarray, shape (4, n)
        Height [mm], smallest, largest and rms error [um] of every band that has points.
    """
    low, high = z_range_mm
    n = 124
    band = ((surface.z_mm - low) / (high - low) * n).astype(np.int64).clip(0, n - 1)
    count = np.bincount(band, minlength=n)
    square = np.bincount(band, surface.error_um**2, minlength=n)
    least, most = np.full(n, np.inf), np.full(n, -np.inf)
    np.minimum.at(least, band, surface.error_um)
    np.maximum.at(most, band, surface.error_um)
    some = count > 0
    centre_mm = low + (np.arange(n) + 0.5) * (high - low) / n
    rms = np.sqrt(square[some] / count[some])
    return np.stack([centre_mm[some], least[some], most[some], rms])


def draw_height(surface: GaugedSurface, geometry: Geometry) -> Figure:
    """Return the error of the surface over height: range and rms."""
    figure = new_figure(10, 3.6)
    axes = figure.add_subplot()
    z_mm, least, most, rms = bands_by_height(surface, heights_range_mm(geometry))
    factor, unit = length_unit(float(np.abs(surface.error_um).max(initial=0.0)))
    axes.fill_between(z_mm, least * factor, most * factor, color=ORANGE, alpha=0.35, lw=0)
    axes.plot(z_mm, most * factor, color=ORANGE, lw=1, label="largest and smallest at this height")
    axes.plot(z_mm, least * factor, color=ORANGE, lw=1)
    axes.plot(z_mm, rms * factor, color=BLUE, lw=1.6, ls="--", label="rms")
    axes.axhline(0, color=GREY, lw=0.8)
    axes.set_xlim(*heights_range_mm(geometry))
    axes.set_xlabel("skirt height, mm")
    axes.set_ylabel(f"error against\nthe drawing, {unit}")
    axes.legend(frameon=False, loc="upper left", bbox_to_anchor=(0, 1.16), ncols=2)
    return figure


def draw_overview(surface: GaugedSurface, geometry: Geometry, feed_mm: float, title: str) -> Figure:
    """Return error map and one section side by side: the result at a glance."""
    figure = new_figure(11, 4.4)
    figure.suptitle(title)
    left, right = figure.subplots(1, 2, width_ratios=[2.1, 1])
    _paint_map(figure, left, surface, geometry, feed_mm)
    low, high = heights_range_mm(geometry)
    z_mm = float(section_heights_mm(geometry)[-1])
    near = section_at(surface, z_mm, 1.5 * (high - low) / map_rows(high - low, feed_mm))
    factor = enlargement(float(geometry.radius_mm(z_mm)), geometry.deepest_mm(z_mm))
    draw_shape(right, near, geometry, z_mm, factor)
    below = {"loc": "upper center", "bbox_to_anchor": (0.5, 0.06), "frameon": False}
    right.legend(handles=_section_handles(geometry), **below)
    return figure
