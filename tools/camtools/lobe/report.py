"""The report of a camshaft: error over the angle, surface speed, and the pictures of its table.

>>> from camtools.lobe.motion import example_lobe, make_lobes
>>> [lobe] = make_lobes(example_lobe())
>>> speed_of_contact(lobe, np.zeros(1), np.ones(1)).tolist()
[28.0]
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from camtools.base.beside import beside
from camtools.base.quantities import Floats, length_unit
from camtools.lobe.list_report import smoothing_takes_um
from camtools.lobe.motion import ShaftLobe
from camtools.lobe.plots import draw_lobes
from camtools.lobe.report_interactive import live_of, motion_of
from camtools.lobe.report_text import LobeOutcome, lobe_rows
from camtools.part.smoothing_text import sheet_note
from camtools.plots.panels import stacked
from camtools.plots.style import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    RED,
    angle_axis,
    drawing,
    new_figure,
    png_of,
    stroke_of,
)
from camtools.report.charts import TurnOfU
from camtools.report.common_pictures import COMPARE_TEXT, common_drawers
from camtools.report.learning import CONVERGENCE_TEXT
from camtools.report.motion import draw_motion
from camtools.report.page import Caption, Page, render_page
from camtools.report.sheet import Subject
from camtools.report.sheet_page import sheet_pages
from camtools.sim.results import CUTTING, CutTrace

_N_BINS = 720
_SPEED_TICKS = 10
_TEXTS = {
    "fault": (
        "The fault",
        "U must leave the work first, beyond the nose of the cam, and no axis may move towards the "
        "axis after the dashed line. X follows more slowly; the spindle runs down by itself.",
    ),
    "profile": (
        "Error of the profile",
        "Error of the profile along its normal: above 0 metal left, below 0 cut too deep; the band "
        "covers all turns. An error that follows the slope of the lift comes from the angle or "
        "dead time, one that follows its curvature from U's feed-forward.",
    ),
    "cam": (
        "Cam and tool",
        "The profile with the tool or the wheel at some angles. The red lines are the normals at "
        "the contacts; the number at a tool is its swing, which equals the pressure angle.",
    ),
    "motion": (
        "Lift, pressure angle, curvature and speeds",
        "One turn of the spindle as the table demands it. Where the flank is flat, the contact "
        "moves far within a degree; there a constant surface speed needs a slow spindle.",
    ),
    "smoothing": (
        "Smoothing of a list",
        "Top: by how much smoothing moved each listed point; the dashed lines are the band of "
        "smooth_um. Residuals that follow one another on the same side mean a curve that the band "
        "bent, not noise. Below: acceleration and jerk of the lift, as listed (thin) and smoothed.",
    ),
    "stroke": (
        "Motion of U over one turn",
        "U as the table demands it and as measured, in position and velocity; the peaks of "
        "velocity and acceleration are the required values in the table of machine limits above.",
    ),
    "speed": (
        "Surface speed",
        "Speed of the contact along the profile, from the measured spindle speed. With a constant "
        "surface speed it stays near that of the base circle (dashed) and is lower where the "
        "spindle cannot accelerate or decelerate fast enough.",
    ),
    "rake": (
        "Effective rake",
        "The angle between the tool and the normal of the profile, by which the ground rake "
        "changes. With the swing it stays at 0; without, it would be the pressure angle. Bottom: "
        "the remaining error of the swing drive and its set-points, enlarged.",
    ),
    "learning": CONVERGENCE_TEXT,
    "following": (
        "Following error of U",
        "Difference between the actual and the demanded position of U; the band covers every turn. "
        "The shape of the lift's slope points to a wrong dead time or k1, that of its curvature "
        "to a wrong k2.",
    ),
    "sequence": (
        "Sequence of the cut",
        "X approaches from clear of the lobes while the lift grows from zero, so that the nose is "
        "never cut; disengaging is the reverse. Only the green stretch counts for the verdict.",
    ),
    "compare": COMPARE_TEXT,
}


def band(turn: Floats, values: Floats) -> tuple[Floats, Floats, Floats]:
    """Return angle [degrees], smallest and largest value of every bin of a turn that has any."""
    place = (np.mod(turn, 1) * _N_BINS).astype(np.int64).clip(0, _N_BINS - 1)
    least, most = np.full(_N_BINS, np.inf), np.full(_N_BINS, -np.inf)
    np.minimum.at(least, place, values)
    np.maximum.at(most, place, values)
    some = least <= most
    degrees: Floats = (np.arange(_N_BINS, dtype=np.float64) + 0.5) * (360 / _N_BINS)
    return degrees[some], least[some], most[some]


def _heights(lobe: ShaftLobe, z_mm: Floats) -> Floats:
    return np.asarray((z_mm >= lobe.z_mm[0]) & (z_mm <= lobe.z_mm[1]))


def draw_profile(outcome: LobeOutcome) -> Figure:
    """Return the error of every lobe's profile against the polar angle."""
    lobes, surface = outcome.generated.lobes, outcome.surface
    figure = new_figure(10, 1.2 + 2.4 * len(lobes))
    panels = figure.subplots(len(lobes), 1, sharex=True, squeeze=False)[:, 0]
    for i, (axes, lobe) in enumerate(zip(panels, lobes, strict=True)):
        rows = _heights(lobe, surface.z_mm)
        degrees, least, most = band(surface.turn[rows], surface.error_um[rows])
        largest_um = float(np.abs(np.concatenate([least, most])).max(initial=0.0))
        factor, unit = length_unit(largest_um)
        axes.fill_between(degrees, least * factor, most * factor, color=ORANGE, alpha=0.4, lw=0)
        axes.plot(degrees, most * factor, color=ORANGE, lw=1, label="largest of all turns")
        axes.plot(degrees, least * factor, color=BLUE, lw=1, label="smallest of all turns")
        axes.axhline(0, color=GREY, lw=0.8)
        axes.axvline(np.degrees(lobe.phase_rad) % 360, color=GREEN, lw=1, ls="--")
        name = f"lobe {i}, {lobe.z_mm[0]:g} .. {lobe.z_mm[1]:g} mm; dashed: zero of its law"
        axes.set_title(name, loc="left")
        axes.set_ylabel(f"error, {unit}\n(above 0: metal left)")
        axes.grid(alpha=0.3)
    panels[0].legend(frameon=False, loc="lower right", bbox_to_anchor=(1, 0.97), ncols=2)
    angle_axis(panels[-1])
    panels[-1].set_xlabel("polar angle on the shaft, degrees")
    return figure


def speed_of_contact(lobe: ShaftLobe, phi_rad: Floats, omega_rad_s: Floats) -> Floats:
    """Return the speed of the contact along the profile [mm/s] at spindle angles."""
    return np.asarray(lobe.at(phi_rad).ds_dphi * omega_rad_s)


def _speed_of(trace: CutTrace) -> Floats:
    """Return the spindle's speed from its angle over some ticks to both sides [rad/s]."""
    k, speed = _SPEED_TICKS, np.full(trace.t_s.size, np.nan)
    if trace.t_s.size > 2 * k:
        turned = trace.turn[2 * k :] - trace.turn[: -2 * k]
        speed[k:-k] = 2 * np.pi * np.abs(turned) / (trace.t_s[2 * k :] - trace.t_s[: -2 * k])
    return speed


def _over_the_angle(lowest: Axes, named: Axes, height: float) -> None:
    """Make x the spindle's angle, and put the names of the curves above the panels."""
    named.legend(frameon=False, loc="upper left", bbox_to_anchor=(0, height), ncols=4)
    angle_axis(lowest)
    lowest.set_xlabel("spindle angle, degrees")


def draw_speed(outcome: LobeOutcome) -> Figure:
    """Return the speed of the contact against the spindle's angle, all turns of cutting."""
    figure = new_figure(10, 3.8)
    axes, trace = figure.add_subplot(), outcome.trace
    omega = _speed_of(trace)
    for i, lobe in enumerate(outcome.generated.lobes):
        rows = (trace.state == CUTTING) & _heights(lobe, trace.z_mm) & np.isfinite(omega)
        if not rows.any():
            continue
        phi = 2 * np.pi * np.mod(trace.turn[rows], 1)
        degrees, least, most = band(phi / (2 * np.pi), speed_of_contact(lobe, phi, omega[rows]))
        axes.fill_between(degrees, least, most, color=stroke_of(i)["color"], alpha=0.4, lw=0)
        axes.plot(degrees, most, **stroke_of(i), lw=1.2, label=f"lobe {i}")
    speed = outcome.summary["cam"].get("surface_speed_mm_s")
    if speed is not None:
        axes.axhline(speed["base_circle"], color=RED, lw=1.2, ls="--", label="base circle")
    axes.set_ylim(bottom=0)
    axes.set_ylabel("surface speed, mm/s")
    axes.grid(alpha=0.3)
    _over_the_angle(axes, axes, 1.16)
    return figure


def draw_rake(outcome: LobeOutcome, swing_deg: Floats) -> Figure:
    """Return the tool's line from the normal over the angle, with and without the swing."""
    figure, trace = new_figure(10, 5.4), outcome.trace
    names = "off the ground rake,\ndegrees", "the same with the\nswing, degrees"
    above, below = stacked(figure, names)
    rows = trace.state == CUTTING
    lobe = outcome.generated.lobes[0]  # one is enough to see it
    rows &= _heights(lobe, trace.z_mm)
    pressure_deg = np.degrees(lobe.at(2 * np.pi * np.mod(trace.turn[rows], 1)).angle)
    turn, off_deg = trace.turn[rows], swing_deg[rows] - pressure_deg
    degrees, least, most = band(turn, -pressure_deg)
    above.plot(degrees, (least + most) / 2, color=ORANGE, lw=1.4, label="without the swing")
    degrees, least, most = band(turn, -off_deg)
    above.plot(degrees, (least + most) / 2, color=BLUE, lw=1.6, label="with the swing")
    below.fill_between(degrees, least, most, color=BLUE, alpha=0.5, lw=0.8)
    for axes in (above, below):
        axes.axhline(0, color=GREY, lw=0.8)
    _over_the_angle(below, above, 1.22)
    return figure


def _drawers(outcome: LobeOutcome, motion: TurnOfU | None) -> dict[str, Callable[[], Figure]]:
    """Return what the cut lets be drawn, but for the pictures of its table."""
    swing_deg = outcome.swing_deg
    drawers = common_drawers(outcome, "spindle angle")
    if outcome.surface.turn.size:
        drawers["profile"] = lambda: draw_profile(outcome)
    if (outcome.trace.state == CUTTING).any():
        drawers["speed"] = lambda: draw_speed(outcome)
        if swing_deg is not None:
            drawers["rake"] = lambda: draw_rake(outcome, swing_deg)
    if motion is not None:
        drawers["stroke"] = lambda: draw_motion(motion)
    return drawers


def _subject(outcome: LobeOutcome) -> Subject:
    """Return what of a sheet applies: the middle of each lobe, along its normals."""
    return Subject(
        is_oval=False,
        has_radius=False,
        left_out="long and short axis, ovality, phase, roundness of the section as it is: a lobe "
        "is no oval, so each is described by the deviation along the normals of its profile, over "
        "the direction of the roller; profiles along the axis: a lobe is gauged as one section",
        names=tuple(
            f"lobe {i}, {lobe['z_first_mm']:g} .. {lobe['z_last_mm']:g} mm"
            for i, lobe in enumerate(outcome.summary["cam"]["lobes"])
        ),
        note=sheet_note(
            outcome.summary["form_error_um"], smoothing_takes_um(outcome.generated.laws)
        ),
    )


def make_lobe_report(outcome: LobeOutcome) -> dict[str, bytes]:
    """Return the page and its pictures, by file name."""
    pngs, motion = draw_lobes(outcome.generated), motion_of(outcome)
    with drawing(), beside(lambda: sheet_pages(outcome, _subject(outcome))) as drawn_sheets:
        pngs |= {key: png_of(draw()) for key, draw in _drawers(outcome, motion).items()}
        sheets = drawn_sheets()
    tool = "a circle" if outcome.is_turned else "a whole cylinder"
    shown = [(Caption(key, *text), pngs[key]) for key, text in _TEXTS.items() if key in pngs]
    page = Page(
        outcome.generated.part.part.source,
        lobe_rows(outcome),
        shown,
        f"{'The tip of the tool' if outcome.is_turned else 'The wheel'} is {tool} that takes off "
        "what it sweeps; forces, wear and bending are not modelled.",
        "what it leaves, along the normals of the profile,",
        "cam",
        live_of(outcome, motion),
        sheets,
    )
    html = render_page(outcome, page).encode("utf-8")
    files = {f"cut_{key}.png": png for key, png in pngs.items()} | {"report.html": html}
    return files | (sheets.files if sheets is not None else {})
