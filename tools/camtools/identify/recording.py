# SPDX-License-Identifier: Apache-2.0
"""A record of an excited U, as a simulator or a controller gives it, and what is wrong with it.

>>> import numpy as np
>>> grid = Grid.of(20_000.0)
>>> record_of(grid, np.array([0, 1, 3]), np.zeros(3), np.zeros(3), 10.0)
Traceback (most recent call last):
    ...
camtools.base.errors.CamtoolsError: record: 1 gap, the first after tick 1; nothing is fitted, \
excite again
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats, Ints
from camtools.identify.multisine import N_DROPPED, Grid

MIN_PERIODS = 2
_COARSE_NM = 100.0
_AGAIN = "nothing is fitted, excite again"


@dataclass(frozen=True, eq=False)
class SettledRecord:
    """Set-points and measured positions of U in every tick of some periods.

    Attributes
    ----------
    u_nm : ndarray, shape (n_dropped + n_periods, n_ticks)
        written in a tick; the first periods are those in which U settles
    """

    grid: Grid
    u_nm: Floats
    y_nm: Floats  # measured in the same tick, before the set-point was written
    quantum_nm: float  # of the scale, 0 when it is not known
    n_dropped: int = N_DROPPED

    @property
    def is_coarse(self) -> bool:
        """A drive that rounds its commands as its scale does plays another wave."""
        return self.quantum_nm >= _COARSE_NM

    def rounded(self) -> SettledRecord:
        """Return the record with set-points rounded to the quantum of the scale."""
        return replace(self, u_nm=np.round(self.u_nm / self.quantum_nm) * self.quantum_nm)

    @property
    def period_nm(self) -> Floats:
        """Set-points of a settled period, about their mean; all of them are alike."""
        period = self.u_nm[self.n_dropped]
        return np.asarray(period - period.mean())

    @property
    def settled(self) -> tuple[Floats, Floats]:
        """Set-points and positions of the periods that count."""
        return self.u_nm[self.n_dropped :], self.y_nm[self.n_dropped :]


def record_of(
    grid: Grid,
    tick: Ints,
    u_nm: Floats,
    y_nm: Floats,
    quantum_nm: float,
    n_dropped: int = N_DROPPED,
) -> SettledRecord:
    """Return the whole periods at the end of a record.

    Parameters
    ----------
    tick : ndarray, shape (n,)
        number of each tick
    u_nm, y_nm : ndarray, shape (n,)
        while U plays the wave in full; the fading of its begin may be in periods that are dropped

    Raises
    ------
    CamtoolsError
        Ticks are missing, there are too few periods, U did not move, or its set-points do not
        repeat.
    """
    gaps = np.flatnonzero(np.diff(tick) != 1)
    if gaps.size:
        many = "gap" if gaps.size == 1 else "gaps"
        first = int(tick[gaps[0]])
        problem = f"{gaps.size} {many}, the first after tick {first}"
        raise CamtoolsError([f"record: {problem}; {_AGAIN}"])
    n_periods = tick.size // grid.n_ticks
    if n_periods < n_dropped + MIN_PERIODS:
        problem = f"{tick.size} ticks are {n_periods} periods"
        need = f"a fit needs {n_dropped + MIN_PERIODS}"
        raise CamtoolsError([f"record: {problem}, {need}; {_AGAIN}"])
    n = n_periods * grid.n_ticks
    periods = [np.asarray(row[-n:], np.float64).reshape(n_periods, -1) for row in (u_nm, y_nm)]
    u, y = periods
    _check(u[n_dropped:], y[n_dropped:])
    return SettledRecord(grid, u, y, quantum_nm, n_dropped)


def _check(u_nm: Floats, y_nm: Floats) -> None:
    off_nm = float(np.max(np.abs(u_nm - u_nm[0])))
    if off_nm > 1.0:
        problem = f"the set-points of two periods differ by {off_nm:.0f} nm"
        raise CamtoolsError([f"record: {problem}: U did not play the wave; {_AGAIN}"])
    if float(np.ptp(u_nm)) == 0 or float(np.ptp(y_nm)) == 0:
        what = "U was not excited" if float(np.ptp(u_nm)) == 0 else "U did not move"
        remedy = "see that its drive is enabled and its scale is connected"
        raise CamtoolsError([f"record: {what}; {remedy}"])
