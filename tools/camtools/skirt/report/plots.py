"""Pictures of a skirt as drawn: sections, motion of U, profile.

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
from matplotlib.figure import Figure
from matplotlib.projections.polar import PolarAxes

from camtools.base.quantities import MM_PER_M, UM_PER_MM, Floats
from camtools.plots.style import (
    GREY,
    RED,
    angle_axis,
    legend_below,
    pictures,
    stacked,
    stroke_of,
    titled_figure,
)
from camtools.skirt.geometry.growth import thrust_rad
from camtools.skirt.geometry.profile import smoothed_curves, smoothing_facts
from camtools.skirt.geometry.skirt_geometry import Geometry, dense_heights_mm
from camtools.skirt.report.fit import on_metal_um, states_at
from camtools.skirt.table.generate import GeneratedSkirt
from camtools.skirt.table.speed import motion_played
from camtools.skirt.tool.program import program_of

_N_ANGLES = 1441
_N_SECTIONS = 4
_N_FIT_HEIGHTS = 201


def _title(result: GeneratedSkirt, what: str) -> str:
    magnify = result.part.magnify
    enlarged = f", {magnify.words}" if magnify else ""
    return f"{result.part.part.name}: {what}{enlarged}"


def _heights_mm(geometry: Geometry) -> Floats:
    return np.linspace(*geometry.ends_mm, _N_SECTIONS)


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
    for low, high in piston.grooves_mm:
        z_mm[(z_mm > low) & (z_mm < high)] = np.nan
    heights_mm = geometry.ovality.x if piston.ovality is None else piston.ovality.height_mm
    of_profile, of_ovality = (np.asarray(z, float) for z in (piston.profile.height_mm, heights_mm))
    long_mm: Callable[[Floats], Floats] = geometry.radius_mm
    if piston.has_fit:
        left.set_title("as turned: cold and bare")
        right.set_title("as drawn")
        long_mm = partial(geometry.drawn_mm, 0.0)
    _against_height(left, z_mm, lambda z: 2 * long_mm(z), of_profile, "diameter")
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
    for axes, (name, facts) in zip(panels, found.items(), strict=True):
        axes.plot(facts["off_um"], facts["height_mm"], "o-", lw=0.6, ms=3, color=_colour(1))
        for edge_um in (-facts["smooth_um"], facts["smooth_um"]):
            axes.axvline(edge_um, lw=0.8, ls="--", color=_colour(2))
        axes.set_xlabel(f"{name}: smoothed less listed, µm")
        axes.grid(alpha=0.3)
    panels[0].set_ylabel("skirt height, mm")
    return figure


def draw_clearance(result: GeneratedSkirt) -> Figure:
    """Return cold, coated and hot profiles over height, and the last one's clearance all round."""
    piston, geometry = result.part.piston, result.geometry
    z_mm, deg = np.linspace(*geometry.skirt_mm, _N_FIT_HEIGHTS), np.arange(0.0, 361.0)
    states = states_at(piston, geometry, np.radians(deg), z_mm)
    *_, (last, state) = states.items()
    figure = titled_figure(11, 5.5, _title(result, ", ".join(states)))
    left, right = figure.subplots(1, 2, sharey=True, width_ratios=[2, 3])
    datum_mm = piston.bore.diameter_mm / 2 if piston.bore else float(state.radius_mm.max())
    thrust_deg = round(float(np.degrees(thrust_rad(piston))))
    for i, (name, each) in enumerate(states.items()):
        below_um = (datum_mm - each.radius_mm) * UM_PER_MM
        for along, turned_deg, stroke in (("thrust", 0, "-"), ("pin", 90, "--")):
            drop_um, colour = below_um[:, thrust_deg + turned_deg], stroke_of(i)["color"]
            left.plot(drop_um, z_mm, color=colour, ls=stroke, label=f"{name}, along the {along}")
    if state.bore_mm is not None:
        bore_um = (datum_mm - state.bore_mm) * UM_PER_MM
        left.axvline(bore_um, color=GREY, ls=":", label=f"bore, {last}")
    left.invert_xaxis()
    left.grid(alpha=0.3)
    left.set_ylabel("skirt height, mm")
    left.set_xlabel("radius below the cold bore, µm" if piston.bore else "drop of the radius, µm")
    legend_below(figure, left, 4)
    room = (datum_mm - state.radius_mm) * UM_PER_MM
    if piston.bore is not None:
        room = on_metal_um(piston, state, np.radians(deg), z_mm)
    extent = (0.0, 360.0, *geometry.skirt_mm)
    picture = right.imshow(room, extent=extent, origin="lower", aspect="auto", cmap="viridis")
    if np.nanmin(room) < 0 < np.nanmax(room):
        right.contour(deg, z_mm, room, levels=[0.0], colors=[RED])
    what = "radial clearance" if piston.bore else "drop of the radius"
    figure.colorbar(picture, ax=right).set_label(f"{what}, {last}, µm")
    angle_axis(right)
    return figure


def draw_program(result: GeneratedSkirt) -> Figure:
    """Return Z and X over the turns of a part with lands, each band shaded."""
    part = result.part
    program = program_of(part, result.geometry, part.tool)
    turn = np.linspace(0, program.turns, 20 * program.turns + 1)
    z_mm, x_mm = program.z(turn)[:, 0], program.x(turn)[:, 0]
    figure = titled_figure(8.5, 6.0, _title(result, "Z and X over the turns"))
    upper, lower = figure.subplots(2, 1, sharex=True)
    upper.plot(turn, z_mm, color=_colour(1))
    lower.plot(turn, x_mm, color=_colour(2))
    for band in part.bands:
        upper.axhspan(band.low_mm, band.high_mm, color=GREY, alpha=0.2, lw=0)
    for axes, name in ((upper, "Z, mm (grey: bands)"), (lower, "X, radius at the long axis, mm")):
        axes.set_ylabel(name)
        axes.grid(alpha=0.3)
    lower.set_xlabel("turns of the spindle at full feed")
    return figure


def draw_all(result: GeneratedSkirt) -> dict[str, bytes]:
    """Return all pictures by topic."""
    drawers = {"smoothing": draw_smoothing} if smoothed_curves(result.part.piston) else {}
    drawers |= {"clearance": draw_clearance} if result.part.piston.has_fit else {}
    drawers |= {"program": draw_program} if result.part.piston.lands else {}
    drawers |= {"section": draw_section, "motion": draw_motion, "profile": draw_profile}
    return pictures({topic: partial(draw, result) for topic, draw in drawers.items()})
