# SPDX-License-Identifier: Apache-2.0
"""Following error over the angle, the last turns over each other, told in small changes.

A chart has a series for each few turns. An update tells only the series that got samples since the
last one, so that what is sent stays small however many samples are shown.

>>> turns = Ticks(np.array([7, 7]), np.array([0.25, 0.5]), np.array([0.1, -0.3]))
>>> Trail().changes(turns)[0]
Series(slot=1, age=0, points=[[90.0, 0.1], [180.0, -0.3]])
>>> statistics(turns)
Statistics(max_um=0.3, rms_um=0.22360679774997896, turns=1, samples=2)
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]
SHOWN_TURNS = 50
TURNS_PER_SERIES = 5
SLOTS = SHOWN_TURNS // TURNS_PER_SERIES + 1  # the oldest and the newest of them are not whole
MOST_POINTS = 600  # of a series
BINS = 72  # of the mean over the angle: 5 degrees each
_WIDE_BINS = 6  # a gap that no line may cross
_DEG = 360.0
Points = list[list[float]]


@dataclass(frozen=True)
class Ticks:
    """Single ticks; arrays of the same length, in the order of time."""

    turn: Whole  # whole turns, rising from each enable on
    angle_turn: Floats  # drawing's angle [turn], 0 .. 1
    error_um: Floats  # following error of U in the same tick [um]


@dataclass(frozen=True)
class Series:
    """A series that changes."""

    slot: int  # its number in the chart, 0 .. SLOTS - 1
    age: int  # 0 is the newest
    points: Points | None  # angle [degrees] and error [um]; None: those of before stay


@dataclass(frozen=True)
class Statistics:
    """Of all samples that are shown."""

    max_um: float
    rms_um: float
    turns: int
    samples: int


def recent(samples: Ticks) -> Ticks:
    """Return the samples of the last SHOWN_TURNS turns since the count of turns began anew."""
    if not len(samples.turn):
        return samples
    is_shown = samples.turn > samples.turn[-1] - SHOWN_TURNS
    falls = np.flatnonzero(np.diff(samples.turn) < -1)  # by 1 also where a spindle turns back
    if len(falls):
        is_shown[: falls[-1] + 1] = False
    return Ticks(samples.turn[is_shown], samples.angle_turn[is_shown], samples.error_um[is_shown])


def statistics(samples: Ticks) -> Statistics:
    """Return the statistics of samples; nan where there are none."""
    if not len(samples.turn):
        return Statistics(float("nan"), float("nan"), 0, 0)
    error_um = samples.error_um
    return Statistics(
        float(np.max(np.abs(error_um))),
        float(np.sqrt(np.mean(error_um**2))),
        int(samples.turn[-1] - samples.turn[0]) + 1,
        len(error_um),
    )


def mean_by_angle(samples: Ticks) -> list[list[float | None]]:
    """Return the mean error in each of BINS parts of a turn; None where a wide part was not seen.

    A line may join the parts over narrow ones in which there is no sample.

    Returns
    -------
    list
        of angle [degrees], the middle of a part, and mean error [um]
    """
    which = np.minimum((samples.angle_turn * BINS).astype(np.int64), BINS - 1)
    n = np.bincount(which, minlength=BINS)
    total = np.bincount(which, weights=samples.error_um, minlength=BINS)
    width_deg = _DEG / BINS
    means = [round(float(t / k), 4) if k else None for t, k in zip(total, n, strict=True)]
    told: list[list[float | None]] = []
    last = -1
    for i, mean in enumerate(means):
        if mean is not None:
            told += [[i * width_deg, None]] if i - last > _WIDE_BINS else []
            told.append([(i + 0.5) * width_deg, mean])
            last = i
    return told


def _points(samples: Ticks, is_in: npt.NDArray[np.bool_]) -> Points:
    """Return the points of a series, thinned evenly where there are too many."""
    angle = np.round(samples.angle_turn[is_in] * _DEG, 1)
    error = np.round(samples.error_um[is_in], 3)
    stride = -(-len(angle) // MOST_POINTS) if len(angle) else 1
    pairs: Points = np.column_stack((angle, error))[::stride].tolist()
    return pairs


class Trail:
    """What one chart has been told."""

    def __init__(self) -> None:
        self._told: dict[int, tuple[int, tuple[int, float] | None, int]] = {}

    def changes(self, samples: Ticks) -> list[Series]:
        """Return the series that differ from what the chart was told last."""
        shown = recent(samples)
        groups = shown.turn // TURNS_PER_SERIES
        newest = int(groups[-1]) if len(groups) else 0
        there = {int(group): groups == group for group in np.unique(groups)}
        changed = [
            series
            for group, is_in in there.items()
            if (series := self._series(shown, group, newest - group, is_in)) is not None
        ]
        taken = {group % SLOTS for group in there}
        for slot in sorted(self._told.keys() - taken):
            del self._told[slot]
            changed.append(Series(slot, SLOTS - 1, []))
        return changed

    def _series(
        self, shown: Ticks, group: int, age: int, is_in: npt.NDArray[np.bool_]
    ) -> Series | None:
        last = int(np.flatnonzero(is_in)[-1])
        mark = (int(shown.turn[last]), float(shown.angle_turn[last]))
        slot = group % SLOTS
        before = self._told.get(slot)
        if before == (group, mark, age):
            return None
        self._told[slot] = (group, mark, age)
        is_grown = before is None or before[:2] != (group, mark)
        return Series(slot, age, _points(shown, is_in) if is_grown else None)
