"""Gauged points by height: the traces of an instrument, or bands of a surface cut along a helix.

>>> turn, z_mm = np.tile(np.arange(72) / 72, 5), np.repeat(np.linspace(0, 40, 5), 72)
>>> found = by_height(GaugedPoints(turn, z_mm, np.zeros(360)))
>>> [height.z_mm for height in found.heights], found.most_order
([0.0, 10.0, 20.0, 30.0, 40.0], 16)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats, Ints
from camtools.cut.correction import nodes_of
from camtools.measured.points import GaugedPoints

DEFAULT_ORDER = 16
MIN_HEIGHTS = 3
_MAX_TRACES = 128
_APART_MM, _LEVEL_MM = 2e-3, 0.02  # traces are so far apart, and each of them is so level
_PER_ORDER = 4  # points of a height per wave that is asked of it by default
_OVER = 1.5  # points per unknown
_GAP_WAVES = 0.5  # of the highest order, that may lack points


class Height(NamedTuple):
    """The points of a height."""

    z_mm: float
    rows: Ints


class Heights(NamedTuple):
    """Heights with enough points to fit their waves, rising, and the highest order fitted."""

    heights: list[Height]
    most_order: int
    n_left_out: int  # heights with too few points, or with a gap


def widest_gap(turn: Floats) -> float:
    """Return the widest angle without a point [turn].

    >>> widest_gap(np.array([0.9, 0.1, 0.2]))
    0.7
    """
    rising = np.sort(turn)
    return float(np.diff(rising, append=rising[0] + 1).max())


def _suffices(turn: Floats, order: int) -> bool:
    """Return whether points at these angles suffice to fit waves up to an order."""
    if turn.size < _OVER * (2 * order + 1):
        return False
    return widest_gap(turn) * order <= _GAP_WAVES


def _traces(z_mm: Floats) -> list[Ints] | None:
    """Return the rows of each trace, nothing where the heights run through."""
    order = np.argsort(z_mm, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(z_mm[order]) > _APART_MM) + 1)
    is_level = all(float(np.ptp(z_mm[group])) <= _LEVEL_MM for group in groups)
    return groups if is_level and len(groups) <= _MAX_TRACES else None


def _bands(points: GaugedPoints, order: int) -> list[Ints]:
    """Return the rows of bands as narrow as a fit allows, narrower at the ends."""
    rising = np.argsort(points.z_mm, kind="stable")
    ends_mm = float(points.z_mm[rising[0]]), float(points.z_mm[rising[-1]])
    inner_mm = nodes_of(ends_mm)[1:-1]
    found: list[Ints] = []
    rest = np.empty(0, dtype=np.int64)
    for group in np.split(rising, np.searchsorted(points.z_mm[rising], inner_mm)):
        rest = np.concatenate([rest, group])
        if rest.size and _suffices(points.turn[rest], order):
            found.append(rest)
            rest = np.empty(0, dtype=np.int64)
    if found and rest.size:
        found[-1] = np.concatenate([found[-1], rest])
    return found or [rest]


def by_height(points: GaugedPoints, most_order: int | None = None) -> Heights:
    """Return the points by height.

    Parameters
    ----------
    most_order : int, optional
        Highest order of waves that is wanted; by default 16, or less where there are few angles.

    Raises
    ------
    CamtoolsError
        Too few heights have enough points all round.
    """
    groups = _traces(points.z_mm)
    order = most_order or DEFAULT_ORDER
    if groups is None:
        groups = _bands(points, order)
    elif most_order is None:
        order = max(1, min(order, int(np.median([group.size for group in groups])) // _PER_ORDER))
    good = [group for group in groups if _suffices(points.turn[group], order)]
    if len(good) < MIN_HEIGHTS:
        raise CamtoolsError([_too_few(points, groups, len(good), order, most_order)])
    heights = [Height(float(points.z_mm[group].mean()), group) for group in good]
    return Heights(heights, order, len(groups) - len(good))


def _too_few(
    points: GaugedPoints, groups: list[Ints], n_good: int, order: int, asked: int | None
) -> str:
    """Return why heights do not suffice, with the numbers of the best one."""
    best = max(groups, key=lambda group: group.size)
    gap_deg = 360 * widest_gap(points.turn[best])
    needed = int(np.ceil(_OVER * (2 * order + 1)))
    option = "--measured" if asked is None else f"--keep-harmonics {asked}"
    problem = (
        f"{n_good} of {len(groups)} heights have enough points all round, {MIN_HEIGHTS} are "
        f"needed; harmonics up to {order} need {needed} points and no gap above "
        f"{360 * _GAP_WAVES / order:.3g} degrees, the best height has {best.size} and a gap of "
        f"{gap_deg:.3g} degrees"
    )
    remedy = "gauge more angles and heights" + ("" if asked is None else ", or keep fewer")
    return f"{option}: {problem}; {remedy}"
