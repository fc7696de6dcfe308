"""What of the report of a camshaft is alive: the board of its surface, U over one turn.

>>> ANGLE
'polar angle on the shaft'
"""

from __future__ import annotations

import numpy as np

from camtools.base.quantities import NM_PER_MM, Floats, Ints
from camtools.lobe.report_text import LobeOutcome
from camtools.report.board import board_of
from camtools.report.charts import ChartPanel, TurnOfU, motion_sentence
from camtools.report.page_scripts import Live, charts_of
from camtools.sim.results import CUTTING, CutTrace

ANGLE = "polar angle on the shaft"
_TICKS = 8  # over which a slope is taken: set-points are whole nanometres
_MARKS = 180
_MM_PER_M = 1000.0


def _slope(values: Floats, t_s: Floats) -> Floats:
    """Return the slope of values over some ticks to both sides; NaN at the ends."""
    slope = np.full(values.size, np.nan)
    if values.size > 2 * _TICKS:
        ends = slice(2 * _TICKS, None), slice(None, -2 * _TICKS)
        rise, run = (one[ends[0]] - one[ends[1]] for one in (values, t_s))
        slope[_TICKS:-_TICKS] = rise / run
    return slope


def whole_turn(trace: CutTrace) -> Ints:
    """Return the ticks of the turn in the middle of the cut; none where there is no whole one."""
    cutting = np.flatnonzero(trace.state == CUTTING)
    turns = np.floor(trace.turn[cutting]).astype(np.int64)
    inner = np.unique(turns)[1:-1]
    if not inner.size:
        return cutting[:0]
    return np.asarray(cutting[turns == inner[inner.size // 2]], dtype=np.int64)


def motion_of(outcome: LobeOutcome) -> TurnOfU | None:
    """Return U over a turn in the middle of the cut; nothing where no whole turn was cut."""
    rows = whole_turn(outcome.trace)
    if rows.size <= 4 * _TICKS:
        return None
    turn = outcome.trace.pick(rows)
    degrees: Floats = 360 * (turn.turn % 1)
    due_mm, is_mm = turn.u_due_nm / NM_PER_MM, turn.u_act_nm / NM_PER_MM
    velocity = _slope(due_mm, turn.t_s)
    curves = (
        ("U towards the axis, mm", due_mm, is_mm),
        ("velocity, mm/s", velocity, _slope(is_mm, turn.t_s)),
        ("acceleration, m/s²", _slope(velocity, turn.t_s) / _MM_PER_M, None),
    )
    fine, coarse = (slice(None, None, max(1, rows.size // n)) for n in (1440, _MARKS))
    return TurnOfU(
        f"height {turn.z_mm.mean():.1f} mm",
        degrees[fine],
        [
            ChartPanel(name, wanted[fine], None if found is None else found[coarse])
            for name, wanted, found in curves
        ],
        "table",
        degrees[coarse],
        "spindle angle",
    )


def live_of(outcome: LobeOutcome, motion: TurnOfU | None) -> Live:
    """Return what of a report is alive."""
    lobes = outcome.generated.lobes
    z_mm = min(lobe.z_mm[0] for lobe in lobes), max(lobe.z_mm[1] for lobe in lobes)
    form, feed_mm = outcome.summary["form_error_um"], outcome.summary["cut"]["feed_mm"]
    board = board_of(outcome.surface, z_mm, feed_mm, form["tolerance"])
    words = {} if motion is None else {"stroke": motion_sentence(motion)}
    return Live(board, ANGLE, charts_of(outcome.trace, motion, "stroke"), words)
