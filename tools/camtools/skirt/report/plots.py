"""Pictures of a skirt as drawn and as gauged: sections, motion of U, profile, in space.

>>> from camtools.skirt.table.generate import generate
>>> from camtools.skirt.part.part_file import example_part
>>> sorted(draw_all(generate(example_part())))
['motion', 'profile', 'section']
"""

from collections.abc import Callable
from functools import partial

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.projections.polar import PolarAxes
from mpl_toolkits.mplot3d.axes3d import Axes3D  # type: ignore[import-untyped]

from camtools.base.quantities import MM_PER_M, UM_PER_MM, Floats
from camtools.plots.style import (
    BLUE,
    GREY,
    ORANGE,
    RED,
    angle_axis,
    legend_below,
    new_figure,
    nice_floor,
    nice_limit,
    pictures,
    stacked,
    titled_figure,
)
from camtools.report.surface import section_at
from camtools.report.surface_plots import (
    TURN,
    Extent,
    draw_clock,
    draw_ring,
    draw_roundness,
    paint_map,
)
from camtools.sim.results import GaugedSurface
from camtools.skirt.geometry.profile import smoothed_curves, smoothing_facts
from camtools.skirt.geometry.skirt_geometry import Geometry, dense_heights_mm
from camtools.skirt.table.generate import GeneratedSkirt
from camtools.skirt.table.speed import motion_played

_N_ANGLES = 1441
_N_SECTIONS = 4


def _title(result: GeneratedSkirt, what: str) -> str:
    magnify = result.part.magnify
    enlarged = f", {magnify.words}" if magnify else ""
    return f"{result.part.part.name}: {what}{enlarged}"


def _heights_mm(geometry: Geometry) -> Floats:
    return np.linspace(geometry.z_first_mm, geometry.z_last_mm, _N_SECTIONS)


def _colour(i: int) -> tuple[float, float, float, float]:
    red, green, blue, alpha = colormaps["viridis"](0.9 * i / (_N_SECTIONS - 1))
    return float(red), float(green), float(blue), float(alpha)


def draw_section(result: GeneratedSkirt) -> Figure:
    """Return a polar picture of sections: radius reduction, hugely magnified."""
    geometry = result.geometry
    of = "" if geometry.drawn is None else f" of the {geometry.played_name}"
    figure = titled_figure(7.5, 7.5, _title(result, f"radius reduction{of} in µm"))
    axes = figure.add_subplot(projection="polar")
    assert isinstance(axes, PolarAxes)
    phi = 2 * np.pi * np.linspace(0, 1, _N_ANGLES)
    deepest_um = 0.0
    for i, z_mm in enumerate(_heights_mm(geometry)):
        u_um = geometry.delta(phi, float(z_mm)).delta * UM_PER_MM
        deepest_um = max(deepest_um, float(u_um.max()))
        label = f"height {z_mm:.1f} mm, {geometry.oval_words(float(z_mm))}"
        axes.plot(phi, -u_um, color=_colour(i), label=label, clip_on=False)
    _polar_scale(axes, max(deepest_um, 1.0))
    figure.legend(loc="outside lower center", ncols=2, frameon=False)
    return figure


def _polar_scale(axes: PolarAxes, deepest_um: float) -> None:
    """Put 0 on the outer circle; the centre three times as deep as U goes."""
    axes.set_rlim(-3 * deepest_um, 0)
    ticks = [deepest_um / 2, deepest_um]
    axes.set_rgrids([-tick for tick in ticks], [f"{tick:.4g}" for tick in ticks], angle=184)
    angles = list(range(0, 360, 30))
    names = {0: "0°\nlong axis", 90: "90° short axis"}
    axes.set_thetagrids(angles, [names.get(angle, f"{angle}°") for angle in angles])
    axes.tick_params(axis="x", pad=14)


def draw_motion(result: GeneratedSkirt) -> Figure:
    """Return U, its velocity and acceleration over one turn at the part's speed."""
    speed_rpm = result.part.process.spindle_rpm
    figure = titled_figure(8.5, 8.5, _title(result, f"motion of U at {speed_rpm:g} r/min"))
    panels = stacked(figure, ("U towards the axis, µm", "velocity, mm/s", "acceleration, m/s²"))
    turns = np.linspace(0, 1, _N_ANGLES)
    law = result.speed.channel if result.speed is not None else None
    for i, z_mm in enumerate(_heights_mm(result.geometry)):
        u_mm, velocity, bend = motion_played(result.geometry, speed_rpm, float(z_mm), turns, law)
        curves = (u_mm * UM_PER_MM, velocity, bend / MM_PER_M)
        for axes, values in zip(panels, curves, strict=True):
            axes.plot(360 * turns, values, color=_colour(i), label=f"height {z_mm:.1f} mm")
    angle_axis(panels[-1])
    legend_below(figure, panels[0], _N_SECTIONS)
    return figure


def _against_height(
    axes: Axes, z_mm: Floats, value: Callable[[Floats], Floats], points_mm: Floats, name: str
) -> None:
    """Draw a curve over height, and the points of the drawing, as enlarged as the part is."""
    axes.plot(value(z_mm), z_mm, color=_colour(1), label=name)
    at = points_mm[(points_mm >= z_mm[0]) & (points_mm <= z_mm[-1])]
    axes.plot(value(at), at, "o", color=_colour(1), label="points of the drawing")
    axes.grid(alpha=0.3)
    axes.tick_params(axis="x", rotation=30)


def draw_profile(result: GeneratedSkirt) -> Figure:
    """Return long-axis diameter and ovality over height, with the points of the drawing."""
    geometry, piston = result.geometry, result.part.piston
    figure = titled_figure(8.5, 6.0, _title(result, "profile and ovality"))
    left, right = figure.subplots(1, 2, sharey=True)
    z_mm = dense_heights_mm(geometry, 32)
    heights_mm = geometry.ovality.x if piston.ovality is None else piston.ovality.height_mm
    of_profile, of_ovality = (np.asarray(z, float) for z in (piston.profile.height_mm, heights_mm))
    _against_height(left, z_mm, lambda z: 2 * geometry.radius_mm(z), of_profile, "diameter")
    name = "ovality" if geometry.corner is None else "ovality without trim"
    _against_height(right, z_mm, geometry.ovality_mm, of_ovality, name)
    if geometry.corner is not None:
        trimmed_mm = geometry.ovality_mm(z_mm) + 2 * geometry.corner.trim(z_mm)
        right.plot(trimmed_mm, z_mm, color=_colour(2), ls="--", label="ovality with trim")
    right.legend(frameon=False)
    left.legend(frameon=False)
    left.set_ylabel("skirt height, mm")
    left.set_xlabel("long-axis diameter, mm")
    right.set_xlabel("ovality (long minus short axis), mm")
    return figure


def draw_smoothing(result: GeneratedSkirt) -> Figure:
    """Return the residuals of smoothed points over the height, side by side."""
    found = smoothing_facts(result.part.piston)
    figure = titled_figure(8.5, 5.0, _title(result, "residuals of smoothed points"))
    panels = figure.subplots(1, len(found), sharey=True, squeeze=False)[0]
    for axes, (name, one) in zip(panels, found.items(), strict=True):
        axes.plot(one["off_um"], one["height_mm"], "o-", lw=0.6, ms=3, color=_colour(1))
        for edge_um in (-one["smooth_um"], one["smooth_um"]):
            axes.axvline(edge_um, lw=0.8, ls="--", color=_colour(2))
        axes.set_xlabel(f"{name}: smoothed less listed, µm")
        axes.grid(alpha=0.3)
    panels[0].set_ylabel("skirt height, mm")
    return figure


def draw_all(result: GeneratedSkirt) -> dict[str, bytes]:
    """Return all pictures by topic."""
    drawers = {"smoothing": draw_smoothing} if smoothed_curves(result.part.piston) else {}
    drawers |= {"section": draw_section, "motion": draw_motion, "profile": draw_profile}
    return pictures({topic: partial(draw, result) for topic, draw in drawers.items()})


ANGLE = "spindle angle from the long axis"
N_SECTIONS = 3
_ROOM_FOR_OVAL = 0.35  # share of the radius in which deviations are drawn
_ENLARGED = 30.0
_N_ROWS, _N_COLUMNS = 48, 180


def enlargement(radius_mm: float, deviation_mm: float) -> int:
    """Return the largest round factor by which a deviation fills a third of a radius at most."""
    if deviation_mm <= 0:
        return 1
    return max(1, round(nice_floor(_ROOM_FOR_OVAL * radius_mm / deviation_mm)))


def extent_of(geometry: Geometry, feed_mm: float) -> Extent:
    """Return the extent of a skirt's surface."""
    return Extent((geometry.z_first_mm, geometry.z_last_mm), feed_mm, ANGLE, "skirt height")


def draw_shape(
    axes: Axes, near: GaugedSurface, geometry: Geometry, z_mm: float, factor: int
) -> None:
    """Draw one section, its deviation from the long-axis circle enlarged by a factor."""
    a_mm = float(geometry.radius_mm(z_mm))
    drawn_mm = geometry.drawing.delta(2 * np.pi * TURN, z_mm).delta
    draw_ring(axes, TURN, 1.0, color=GREY, lw=0.8, ls=":")
    draw_ring(axes, TURN, 1 - factor * drawn_mm / a_mm, color=BLUE, lw=1.6)
    if geometry.drawn is not None:
        delta_mm = geometry.delta(2 * np.pi * TURN, z_mm).delta
        draw_ring(axes, TURN, 1 - factor * delta_mm / a_mm, color=ORANGE, lw=1.2, ls="--")
    # each point against the long half axis of its own height: the taper is not ovality
    own_mm = geometry.radius_mm(near.z_mm)
    cut = 1 - factor * (own_mm - near.radius_mm) / a_mm
    step = max(1, cut.size // 60)
    draw_ring(
        axes, near.turn[::step], cut[::step], color=RED, ls="", marker="o", ms=3.2, mfc="none"
    )
    words = geometry.oval_words(z_mm).replace(", with", ",\nwith")
    draw_clock(axes, f"height {z_mm:.1f} mm: {words}", f"oval enlarged\n{factor}-fold", 1.08)


def section_heights_mm(geometry: Geometry) -> Floats:
    """Return the heights of the sections shown: near the bottom, the middle, near the top."""
    low, high = geometry.z_first_mm, geometry.z_last_mm
    return np.asarray(low + (high - low) * np.linspace(0.05, 0.95, N_SECTIONS), dtype=np.float64)


def draw_sections(surface: GaugedSurface, geometry: Geometry, feed_mm: float) -> Figure:
    """Return sections: above with the oval enlarged, below the error alone, enlarged far more."""
    heights, half_band_mm = section_heights_mm(geometry), extent_of(geometry, feed_mm).half_band_mm
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
    played = Line2D([], [], color=ORANGE, lw=1.2, ls="--", label=geometry.played_name)
    return [
        Line2D([], [], color=BLUE, lw=1.6, label="drawing"),
        *([] if geometry.drawn is None else [played]),
        Line2D([], [], color=RED, ls="", marker="o", mfc="none", label="cut"),
        Line2D([], [], color=GREY, ls=":", label="circle through the long axis"),
    ]


def draw_overview(surface: GaugedSurface, geometry: Geometry, feed_mm: float, title: str) -> Figure:
    """Return error map and one section side by side: the result at a glance."""
    figure = new_figure(11, 4.4)
    figure.suptitle(title)
    left, right = figure.subplots(1, 2, width_ratios=[2.1, 1])
    extent = extent_of(geometry, feed_mm)
    paint_map(left, surface, extent)
    z_mm = float(section_heights_mm(geometry)[-1])
    near = section_at(surface, z_mm, extent.half_band_mm)
    factor = enlargement(float(geometry.radius_mm(z_mm)), geometry.deepest_mm(z_mm))
    draw_shape(right, near, geometry, z_mm, factor)
    below = {"loc": "upper center", "bbox_to_anchor": (0.5, 0.06), "frameon": False}
    right.legend(handles=_section_handles(geometry), **below)
    return figure


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
    """Return the cut skirt, deviations enlarged; by `factor` the drawing is enlarged already."""
    heights, turns, radius = radius_grid(surface, geometry)
    enlarged, largest = enlargement_of(factor), float(np.nanmax(radius))
    depth_mm = largest - radius
    shown = largest - enlarged * depth_mm
    closed = np.column_stack([shown, shown[:, 0]])
    colour_of = Normalize(0, float(np.nanmax(depth_mm)) * UM_PER_MM)
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
