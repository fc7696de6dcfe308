"""The report of a polygon.

>>> REPORT.views[0].key, REPORT.views[-1].key
('fault', 'compare')
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from camtools.base.quantities import MM_PER_M, NM_PER_MM, Floats, omega_rad_s
from camtools.part.common import Tolerances
from camtools.plots.style import RED, new_figure, nice_limit, stacked
from camtools.polygon.plots import BLEND_NAMES, hardest_blend, paint_blend, paint_section
from camtools.polygon.summary import ROWS, PolygonCut, angles_of, name_of
from camtools.report.charts import ChartPanel, TurnOfU
from camtools.report.kind_report import KindReport
from camtools.report.sheet import Subject
from camtools.report.surface import section_at
from camtools.report.surface_plots import Extent, draw_roundness
from camtools.report.views import (
    COMPARE,
    LEARNING,
    SEQUENCE,
    View,
    fault_view,
    following_view,
    has_surface,
    height_view,
    map_view,
    motion_view,
    surface_view,
)
from camtools.sim.results import CUTTING, CutTrace

ANGLE = "spindle angle from the corner"
_MOST_TICKS = 180  # of the measured motion
_MARKS = {"color": RED, "ls": "", "marker": "o", "ms": 3.0, "mfc": "none"}
_MOST_MARKS = 240
_LEFT_OUT = (
    "long and short axis, ovality, phase and the roundness of the section itself, since a polygon "
    "is no oval; each section is described by its deviation from the drawing"
)


def _extent(cut: PolygonCut) -> Extent:
    geometry = cut.generated.geometry
    heights_mm = geometry.z_first_mm, geometry.z_last_mm
    return Extent(heights_mm, cut.summary["cut"]["feed_mm"], ANGLE, "height")


def draw_cut_section(outcome: PolygonCut) -> Figure:
    """Return the section with cut points, and their error enlarged."""
    made = outcome.generated
    extent = _extent(outcome)
    z_mm = sum(extent.heights_mm) / 2
    near = section_at(outcome.surface, z_mm, extent.half_band_mm)  # of the middle height
    figure = new_figure(11, 6.2)
    figure.set_layout_engine("constrained", h_pad=0.12)  # between the axis and what is named below
    left, right = figure.subplots(1, 2)
    paint_section(left, made)
    left.set_title(name_of(made.part.polygon), fontsize=9.5)
    factor = float(
        made.geometry.radius_mm(z_mm) / made.geometry.radius_mm(made.geometry.z_first_mm)
    )
    step, phi = max(1, near.turn.size // 90), 2 * np.pi * near.turn
    r = near.radius_mm / factor
    left.plot((r * np.cos(phi))[::step], (r * np.sin(phi))[::step], label="cut", **_MARKS)
    limit_um = nice_limit(float(np.abs(near.error_um).max(initial=0.0)))
    draw_roundness(right, near, float(made.geometry.radius_mm(z_mm)), limit_um)
    figure.legend(loc="outside lower center", ncols=3, frameon=False)
    return figure


def draw_cut_blend(outcome: PolygonCut) -> Figure:
    """Return the hardest joint with the points cut there."""
    made, surface = outcome.generated, outcome.surface
    blend = hardest_blend(made)
    figure = new_figure(10, 6.0)
    panels = stacked(figure, BLEND_NAMES)
    paint_blend(panels, made, blend)
    off = 2 * np.pi * surface.turn - blend.joint_rad
    off = np.mod(off + np.pi, 2 * np.pi) - np.pi
    near = np.flatnonzero(np.abs(off) < 2.2 * blend.half_rad)
    near = near[:: max(1, near.size // _MOST_MARKS)]
    degrees = np.degrees(blend.joint_rad + off[near])
    panels[0].plot(degrees, surface.error_um[near], label="cut", **_MARKS)  # type: ignore[arg-type]
    panels[0].legend(frameon=False)
    return figure


def _measured(turn: CutTrace) -> tuple[Floats, Floats, Floats]:
    """Return angle [degrees], place of U [mm] and its velocity [mm/s] at some ticks of a turn."""
    u_mm, step = turn.u_act_nm / NM_PER_MM, max(1, turn.t_s.size // _MOST_TICKS)
    columns = 360 * (turn.turn % 1), u_mm, np.gradient(u_mm, turn.t_s)
    degrees, moved_mm, slope = (column[::step] for column in columns)
    return degrees, moved_mm, slope


def motion_of(outcome: PolygonCut) -> TurnOfU:
    """Return U, its velocity and acceleration over a turn in the middle of the cut."""
    made, trace = outcome.generated, outcome.trace
    omega = omega_rad_s(outcome.summary["cut"]["spindle_rpm"])
    cutting = np.flatnonzero(trace.state == CUTTING)
    whole = np.floor(trace.turn[cutting])
    rows = cutting[whole == np.median(whole)] if cutting.size else cutting
    z_mm = float(trace.z_mm[rows].mean()) if rows.size else made.geometry.z_first_mm
    phi = angles_of(made)
    u = made.geometry.delta(phi, z_mm)
    degrees, moved_mm, slope = _measured(trace.pick(rows)) if rows.size > 2 else (None,) * 3
    return TurnOfU(
        f"height {z_mm:.1f} mm",
        np.degrees(phi),
        (
            ChartPanel("U towards the axis, mm", u.delta - made.middle_nm / NM_PER_MM, moved_mm),
            ChartPanel("velocity, mm/s", trace.sense * u.d1 * omega, slope),
            ChartPanel("acceleration, m/s²", u.d2 * omega**2 / MM_PER_M),
        ),
        "table",
        degrees,
        "angle of the drawing",
    )


def _subject(cut: PolygonCut) -> Subject:
    stated = Tolerances(**cut.generated.part.tolerances.model_dump())
    return Subject(False, True, _LEFT_OUT, tolerances=stated)


_VIEWS: tuple[View[PolygonCut], ...] = (
    fault_view(
        "U must leave the work first, within a few milliseconds, and the tool tip must not move "
        "towards the axis (below 0) after the dashed line."
    ),
    surface_view(
        "section",
        "The section",
        "Left: the drawing to scale between its two circles, with cut points of the middle height. "
        "Right: their error alone, enlarged as on a roundness instrument. Away from the joints the "
        "line should stay on the middle circle; at the joints it shows the blends.",
        draw_cut_section,
        "section",
    ),
    View(
        "blend",
        "The hardest joint",
        "Where two curves of the outline meet, U would need an acceleration that jumps or is "
        "infinite. The blend keeps it finite at the cost of the deviation at the top; the cut "
        "points must lie on the blend and within the tolerance.",
        draw_cut_blend,
        lambda cut: has_surface(cut) and bool(cut.generated.blended.blends),
    ),
    map_view(
        "Error map",
        "The shaft unrolled: red is metal left standing, blue is cut too deep. Stripes at the "
        "joints are the blends, which count as error; anything else comes from the machine.",
        _extent,
    ),
    height_view(
        "The band should be narrow and even from end to end: all sections are alike.", _extent
    ),
    motion_view(
        "The measured points must lie on the curve of the table in position and velocity; the "
        "peaks are the required values in the table of machine limits above.",
        motion_of,
    ),
    LEARNING,
    following_view(
        "Difference between the actual and the demanded position of U; the band covers every turn "
        "of the cut.",
        ANGLE,
    ),
    SEQUENCE,
    COMPARE,
)

REPORT = KindReport(
    what="shaft",
    angle=ANGLE,
    heights_mm=lambda cut: _extent(cut).heights_mm,
    rows=ROWS,
    views=_VIEWS,
    subject=_subject,
)
