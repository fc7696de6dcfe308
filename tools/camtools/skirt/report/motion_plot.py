"""U over one turn of a skirt: drawing beside measurement.

>>> steady = np.arange(12.0)
>>> _slope(2 * steady, steady)[5]
np.float64(2.0)
"""

from __future__ import annotations

import numpy as np

from camtools.base.quantities import NM_PER_MM, Floats, Ints
from camtools.report.charts import ChartPanel, TurnOfU
from camtools.sim.results import CUTTING, CutTrace
from camtools.skirt.geometry.skirt_geometry import Geometry
from camtools.skirt.table.speed import motion_played
from camtools.table.channel import Channel

_UM_PER_MM, _MM_PER_M = 1000.0, 1000.0
_N_ANGLES = 721
_BETWEEN_PASSES = 1000  # ticks: engaging and disengaging take more
_DERIVATIVE_TICKS = 4  # the measured position is quantised, so the slope is taken over 2 x 4 ticks


def hardest_turn(trace: CutTrace, geometry: Geometry) -> Ints:
    """Return the ticks of the whole turn of the last pass on the skirt in which U moves most."""
    low, high = geometry.skirt_mm
    on_skirt = (trace.z_mm >= low) & (trace.z_mm <= high)
    cutting = np.flatnonzero((trace.state == CUTTING) & on_skirt)
    if not cutting.size:
        return cutting
    cutting = cutting[np.append(0, np.flatnonzero(np.diff(cutting) > _BETWEEN_PASSES) + 1)[-1] :]
    turned = trace.sense * trace.turn[cutting]
    whole = np.floor(turned).astype(np.int64)
    turns = np.arange(whole[0] + 1, whole[-1])
    if not turns.size:
        return cutting[:0]
    first = np.searchsorted(turned, turns)
    moves_mm = geometry.ovality_mm(trace.z_mm[cutting[first]])
    best = turns[int(np.argmax(moves_mm))]
    return np.asarray(cutting[whole == best], dtype=np.int64)


def _slope(values: Floats, t_s: Floats) -> Floats:
    """Return the slope of values over a few ticks to both sides; NaN at the ends."""
    k = _DERIVATIVE_TICKS
    slope = np.full(values.size, np.nan)
    slope[k:-k] = (values[2 * k :] - values[: -2 * k]) / (t_s[2 * k :] - t_s[: -2 * k])
    return slope


def motion_at(
    trace: CutTrace,
    geometry: Geometry,
    speed_rpm: float,
    middle_mm: float = 0.0,
    speed: Channel | None = None,
) -> TurnOfU:
    """Return U, its velocity and acceleration over the turn in which U moves most.

    Parameters
    ----------
    middle_mm : float
        Reduction of the radius at U 0 [mm].
    speed : Channel, optional
        Ratio of the spindle's speed over the drawing's angle, where it is modulated.
    """
    rows = hardest_turn(trace, geometry)
    z_mm = float(trace.z_mm[rows].mean()) if rows.size else geometry.z_last_mm
    turns = np.linspace(0, 1, _N_ANGLES)
    u_mm, velocity, acceleration = motion_played(geometry, speed_rpm, z_mm, turns, speed)
    degrees, moved_um, slope = _measured(trace.pick(rows)) if rows.size else (None,) * 3
    mean = "mean " if speed is not None else ""
    return TurnOfU(
        f"height {z_mm:.1f} mm, {mean}{speed_rpm:g} r/min",
        360 * turns,
        (
            ChartPanel("U towards the axis, µm", (u_mm - middle_mm) * _UM_PER_MM, moved_um),
            ChartPanel("velocity, mm/s", trace.sense * velocity, slope),
            ChartPanel("acceleration, m/s²", acceleration / _MM_PER_M),
        ),
        geometry.played_name,
        degrees,
    )


def _measured(turn: CutTrace) -> tuple[Floats, Floats, Floats]:
    """Return angle [degrees], place of U [um] and its velocity [mm/s] at some ticks of a turn."""
    u_mm = turn.u_act_nm / NM_PER_MM
    step = max(1, u_mm.size // 60)
    columns = 360 * (turn.turn % 1), u_mm * _UM_PER_MM, _slope(u_mm, turn.t_s)
    degrees, moved_um, slope = (column[::step] for column in columns)
    return degrees, moved_um, slope
