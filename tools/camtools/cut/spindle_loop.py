"""What a spindle makes of its set-points: the ripple of the removal rate as it comes.

The controller plans every 400 us; its set-point is held meanwhile and limited to what the drive
takes; the loop is of first order, its torque limited, MATHS.md (82). The ripple of a law that is
played is that of its own, of the hold, of what the limits take away, and of the spindle itself.

>>> from camtools.cut.speed_law import N_GRID, Load, SpeedLimits, full, grid_rad
>>> load = Load(1 + np.cos(2 * np.pi * np.arange(N_GRID) / N_GRID) / 3, *np.zeros((2, N_GRID)), 3.1)
>>> loop = SpindleLoop(bandwidth_rad_s=40.0, alpha_rad_s2=500.0, highest_rad_s=300.0, ripple=0.0)
>>> bool(played_ripple([full(load)], 20.0, loop)[0] < 0.01)
True
"""

from collections.abc import Sequence
from math import ceil
from typing import NamedTuple

import numpy as np

from camtools.base.quantities import Floats
from camtools.cut.speed_law import Law

PLAN_S = 400e-6  # cam_plan_period_us
_TURNS, _JUDGED_TURNS = 3, 1
_MOST_PLANS = 1500  # of a turn: slower spindles are looked at with longer plans
_GRID = 4096


class SpindleLoop(NamedTuple):
    """A spindle and its controller."""

    bandwidth_rad_s: float
    alpha_rad_s2: float
    highest_rad_s: float  # highest set-point
    ripple: float  # amplitude of the spindle's own, share of the speed
    tick_s: float = 50e-6


class _LawTables:
    """Ratio and load of some laws on a common grid of their patterns."""

    def __init__(self, laws: Sequence[Law]) -> None:
        self.pattern = np.array([law.load.pattern_rad for law in laws])
        share = np.arange(_GRID + 1) / _GRID
        self.ratio = np.array([law.ratio(law.load.pattern_rad * share) for law in laws])
        closed = [np.append(law.load.area_mm2, law.load.area_mm2[0]) for law in laws]
        self.area = np.array([np.interp(share, np.linspace(0, 1, a.size), a) for a in closed])
        self.rows = np.arange(len(laws))

    def at(self, table: Floats, phi_rad: Floats) -> Floats:
        """Return a row of a table for each angle."""
        place = np.mod(phi_rad / self.pattern, 1.0) * _GRID
        i = np.minimum(place.astype(np.int64), _GRID - 1)
        w = place - i
        return np.asarray((1 - w) * table[self.rows, i] + w * table[self.rows, i + 1])


class _PlayedSpindle:
    """Spindles of all laws, stepped together."""

    def __init__(self, n: int, mean_rad_s: float, loop: SpindleLoop) -> None:
        self.omega = np.full(n, mean_rad_s)
        self.phi = np.zeros(n)
        self.loop = loop

    def step(self, set_points: Floats, time_s: float) -> None:
        """Let time pass with set-points in force, solved exactly while the torque is enough."""
        b, alpha = self.loop.bandwidth_rad_s, self.loop.alpha_rad_s2
        gap = set_points - self.omega
        sign, size = np.sign(gap), np.abs(gap)
        pushed_s = np.clip((size - alpha / b) / alpha, 0.0, time_s)  # with all of the torque
        free_s = time_s - pushed_s
        left = size - alpha * pushed_s
        decay = -np.expm1(-b * free_s)
        travel = (size - alpha * pushed_s / 2) * pushed_s + left * decay / b
        self.phi = self.phi + set_points * time_s - sign * travel
        self.omega = set_points - sign * left * (1 - decay)


def played_ripple(laws: Sequence[Law], mean_rad_s: float, loop: SpindleLoop) -> Floats:
    """Return (largest - least) / mean of the removal rate of each law, as a spindle plays it.

    The spindle's own ripple may have any phase, so all of it is added.
    """
    tables, spindle = _LawTables(laws), _PlayedSpindle(len(laws), mean_rad_s, loop)
    longest_s = max(PLAN_S, 2 * np.pi / mean_rad_s / _MOST_PLANS)
    ticks = max(1, round(longest_s / loop.tick_s))
    plan_s, lag_plans = ticks * loop.tick_s, 1 / (loop.bandwidth_rad_s * ticks * loop.tick_s)
    set_points = np.full(len(laws), mean_rad_s)
    ahead_s, before = (ticks + 1) * loop.tick_s, np.ones(len(laws))
    least, most = np.full(len(laws), np.inf), np.zeros(len(laws))
    n = ceil(2 * np.pi * _TURNS / (mean_rad_s * plan_s))
    for i in range(n):
        after = tables.at(tables.ratio, spindle.phi + spindle.omega * ahead_s)
        spindle.step(set_points, loop.tick_s)
        wanted = mean_rad_s * ((before + after) / 2 + (after - before) * lag_plans)
        set_points, before = np.clip(wanted, 0.0, loop.highest_rad_s), after
        for share_s in (plan_s - loop.tick_s) / 2, (plan_s - loop.tick_s) / 2:
            spindle.step(set_points, share_s)
            if i >= n * (_TURNS - _JUDGED_TURNS) // _TURNS:
                rate = tables.at(tables.area, spindle.phi) * spindle.omega
                least, most = np.minimum(least, rate), np.maximum(most, rate)
    mean = np.array([law.load.area_mm2.mean() for law in laws]) * mean_rad_s
    return np.asarray((most - least) / mean + 2 * loop.ripple, dtype=np.float64)
