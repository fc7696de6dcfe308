# SPDX-License-Identifier: Apache-2.0
"""Small linear programs of many rows: the dual simplex method, MATHS.md (199).

HiGHS (scipy.optimize.linprog) finds the same to 1e-15 but takes 15 times as long, which the 200
programs of a report would show.

>>> rows = np.array([[1.0, 1.0], [-1.0, 1.0], [0.5, 1.0]])  # y + x >= 1, y - x >= 0, y + x / 2 >= 0
>>> solve(rows, np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0]), [0, 1]).round(12).tolist()
[0.5, 0.5]
"""

from __future__ import annotations

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats

_MOST_STEPS = 1000
_ROUNDING = 1e-13
_LEAST = 1e-6  # of the bounds, below which all of them are rounding


def solve(rows: Floats, least: Floats, cost: Floats, begin: list[int]) -> Floats:
    """Return the y that minimises cost y with rows y >= least.

    Each step takes the row that is violated most and lets go of the one that keeps the
    multipliers of all others from becoming negative; the cost never falls.

    Parameters
    ----------
    rows : ndarray, shape (m, n)
        In numbers near 1; m may be some thousands, n is 3 or 4.
    least : ndarray, shape (m,)
        Bounds.
    cost : ndarray, shape (n,)
        What each unknown costs.
    begin : list of int, n of them
        Rows of which cost is a combination with weights of at least 0.

    Returns
    -------
    ndarray, shape (n,)
        The unknowns; rows are kept within 1e-13 of the largest bound.

    Raises
    ------
    CamtoolsError
        It came to no end, which happens for values that are no profile.
    """
    basis = list(begin)
    allowed = _ROUNDING * max(float(np.abs(least).max()), _LEAST)
    for _ in range(_MOST_STEPS):
        held = rows[basis]
        y = np.linalg.solve(held, least[basis])
        short = least - rows @ y
        worst = int(short.argmax())
        if short[worst] <= allowed or worst in basis:
            return np.asarray(y, dtype=np.float64)
        weights = np.linalg.solve(held.T, np.stack([cost, rows[worst]], axis=1))
        basis[_leaving(weights[:, 0], weights[:, 1])] = worst
    problem = "a zone of the profile cannot be found"
    raise CamtoolsError([f"{problem}; report it with the file of the sections"])


def _leaving(multiplier: Floats, change: Floats) -> int:
    """Return which row of the basis a new one replaces: the first to lose its multiplier."""
    grows = change > _ROUNDING
    ratio = np.full(change.size, np.inf)
    ratio[grows] = np.maximum(multiplier[grows], 0) / change[grows]
    return int(ratio.argmin())
