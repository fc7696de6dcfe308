"""Quintics over the turns of the spindle, along which Z and X move between two places.

Turns are counted by a station that advances by the feed of the table as Z does on a plain helix
(TABLE_FORMAT.md, "Stations").

>>> rise = Stretch(10, 4, (0.0, 0.0), (1.0, 0.0))
>>> sampled([rise], np.array([10.0, 12.0, 14.0]))[:, 0].tolist()
[0.0, 0.5, 1.0]
>>> is_gentle(1.0, 12, 0.1, 0.1), is_gentle(1.0, 13, 0.1, 0.1)
(False, True)
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from camtools.base.quantities import Floats
from camtools.table.channel import Channel
from camtools.table.header import quantise, with_bounds

AHEAD_MM = 40.0  # by which the station may run ahead of Z: a channel holds 67 mm of difference
_BEND = 5.774  # largest second derivative of a quintic step of 1 over 1
_MOST_BEND_PER_MM, _MOST_CHANGE = 3.8, 1.9  # of a slope per station and per spacing


class Stretch(NamedTuple):
    """A quintic from the turn `at` on; value, slope per turn at both ends, no second derivative."""

    at: float
    turns: float
    low: tuple[float, float]
    high: tuple[float, float]

    def values(self, turn: Floats) -> Floats:
        """Return value and two derivatives per turn; shape (n, 3)."""
        t, n = (turn - self.at) / self.turns, self.turns
        p0, v0 = self.low[0], self.low[1] * n
        p1, v1 = self.high[0], self.high[1] * n
        rise, bend = p1 - p0 - v0, v1 - v0
        c3, c4, c5 = 10 * rise - 4 * bend, -15 * rise + 7 * bend, 6 * rise - 3 * bend
        value = p0 + t * (v0 + t**2 * (c3 + t * (c4 + t * c5)))
        first = v0 + t**2 * (3 * c3 + t * (4 * c4 + t * 5 * c5))
        second = t * (6 * c3 + t * (12 * c4 + t * 20 * c5))
        return np.stack([value, first / n, second / n**2], axis=-1)


def sampled(pieces: Sequence[Stretch], turn: Floats) -> Floats:
    """Return value and derivatives of pieces one after the other; shape (n, 3)."""
    which = np.searchsorted([piece.at for piece in pieces], turn, side="right") - 1
    found = np.zeros((turn.size, 3))
    for i, piece in enumerate(pieces):
        found[which == i] = piece.values(turn[which == i])
    return found


def is_gentle(size_mm: float, turns: int, feed_mm: float, spacing_mm: float) -> bool:
    """Return whether no axis minds the bend of a step, with knots so far apart."""
    bend = _BEND * size_mm / (turns * feed_mm) ** 2
    return bend <= min(_MOST_BEND_PER_MM, _MOST_CHANGE / spacing_mm)


def over_turns(kind: int, exact: Floats, knots: float, range_nm: tuple[int, int]) -> Channel:
    """Return a channel over the station, of so many knots per turn.

    `exact` has value and two derivatives per turn at each knot [nm], shape (n, 3). Raises
    TooLargeError: the format does not hold them.
    """
    stored = exact / np.array([1.0, knots, 2.0 * knots**2])
    return with_bounds(quantise(kind, stored[:, None], 0, range_nm))
