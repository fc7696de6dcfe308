"""The report of a polygon.

>>> REPORT.views[0].key, REPORT.views[-1].key
('fault', 'compare')
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from camtools.base.quantities import MM_PER_M, NM_PER_MM, Floats, omega_rad_s
from camtools.part.common import Tolerances
from camtools.plots.style import RED, new_figure, stacked
from camtools.polygon.plots import BLEND_NAMES, hardest_blend, paint_blend
from camtools.polygon.summary import ROWS, PolygonCut, angles_of
from camtools.report.charts import ChartPanel, TurnOfU
from camtools.report.kind_report import KindReport
from camtools.report.sheet import Subject
from camtools.report.views import (
    COMPARE,
    LEARNING,
    SEQUENCE,
    View,
    fault_view,
    following_view,
    has_surface,
    motion_view,
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
    View(
        "blend",
        "The hardest joint",
        "Where two curves of the outline meet, U would need an acceleration that jumps or is "
        "infinite. The blend keeps it finite at the cost of the deviation at the top; the cut "
        "points must lie on the blend and within the tolerance.",
        draw_cut_blend,
        lambda cut: has_surface(cut) and bool(cut.generated.blended.blends),
    ),
    motion_view(
        "The measured points must lie on the curve of the table in position and velocity; the "
        "peaks are the required values in the table of machine limits above.",
        motion_of,
    ),
    LEARNING,
    following_view(
        "Difference between the actual and the demanded position of U; the band covers every turn "
        "of the cut."
    ),
    SEQUENCE,
    COMPARE,
)

REPORT = KindReport(
    what="shaft",
    angle=ANGLE,
    heights_mm=lambda cut: (
        cut.generated.geometry.z_first_mm,
        cut.generated.geometry.z_last_mm,
    ),
    rows=ROWS,
    views=_VIEWS,
    subject=_subject,
    hint="Stripes at the joints are the blends, which count as error; anything else comes from the "
    "machine.",
)
