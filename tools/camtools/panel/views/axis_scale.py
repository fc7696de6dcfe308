# SPDX-License-Identifier: Apache-2.0
"""A scale of a plot that does not jump: steps of 1, 2 and 5, up at once and down late.

>>> scale = Scale(0.1)
>>> [scale.follow(peak) for peak in (0.03, 0.3, 0.3, 0.15)]
[0.1, 0.5, 0.5, 0.5]
"""

from __future__ import annotations

from math import floor, isfinite, log10

_STEPS = (1.0, 2.0, 5.0, 10.0)
_ROOM = 1.05  # of the scale above the peak
_DOWN_SHARE = 0.8  # of the smaller step, below which it is enough
_DOWN_TIMES = 30  # for so many updates in a row: three seconds


def step_above(value: float) -> float:
    """Return the first of 1, 2, 5, 10, 20 .. that is not below a positive value.

    >>> step_above(0.11), step_above(5.0), step_above(51)
    (0.2, 5.0, 100.0)
    """
    decade = 10.0 ** floor(log10(value))
    # The last step is above every value of the decade, so one is always found.
    return next(
        float(f"{step * decade:.6g}") for step in _STEPS if step * decade >= value * (1 - 1e-9)
    )


class Scale:
    """Full scale of a plot that is symmetric about 0.

    Parameters
    ----------
    least : float
        it never gets smaller; a step of 1, 2 or 5
    """

    def __init__(self, least: float) -> None:
        self.full = self._least = least
        self._low_times = 0

    def follow(self, peak: float) -> float:
        """Take the largest magnitude that is to be shown, and return the full scale."""
        if not isfinite(peak):
            return self.full
        wanted = max(self._least, step_above(max(peak, 1e-12) * _ROOM))
        if wanted > self.full:
            self.full, self._low_times = wanted, 0
        elif wanted < self.full and peak <= wanted * _DOWN_SHARE:
            self._low_times += 1
            if self._low_times >= _DOWN_TIMES:
                self.full, self._low_times = wanted, 0
        else:
            self._low_times = 0
        return self.full
