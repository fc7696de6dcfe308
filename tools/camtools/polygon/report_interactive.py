"""What of the report of a polygon is alive: the board of its surface, U over one turn.

>>> ANGLE
'spindle angle from the corner'
"""

from __future__ import annotations

import numpy as np

from camtools.base.quantities import NM_PER_MM, Floats, omega_rad_s
from camtools.polygon.report_text import PolygonCut
from camtools.polygon.summary import angles_of
from camtools.report.board import board_of
from camtools.report.charts import ChartPanel, TurnOfU, motion_sentence
from camtools.report.page_scripts import Live, charts_of
from camtools.sim.results import CUTTING, CutTrace

ANGLE = "spindle angle from the corner"
_MM_PER_M = 1000.0
_MARKS = 180


def _measured(turn: CutTrace) -> tuple[Floats, Floats, Floats]:
    """Return angle [degrees], place of U [mm] and its velocity [mm/s] at some ticks of a turn."""
    u_mm, step = turn.u_act_nm / NM_PER_MM, max(1, turn.t_s.size // _MARKS)
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
            ChartPanel("acceleration, m/s²", u.d2 * omega**2 / _MM_PER_M),
        ),
        "table",
        degrees,
        "angle of the drawing",
    )


def live_of(outcome: PolygonCut) -> Live:
    """Return what of a report is alive."""
    geometry, summary = outcome.generated.geometry, outcome.summary
    board = board_of(
        outcome.surface,
        (geometry.z_first_mm, geometry.z_last_mm),
        summary["cut"]["feed_mm"],
        summary["form_error_um"]["tolerance"],
    )
    motion = motion_of(outcome)
    charts = charts_of(outcome.trace, motion)
    return Live(board, ANGLE, charts, {"motion": motion_sentence(motion)})
