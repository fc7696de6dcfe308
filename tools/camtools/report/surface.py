"""The gauged surface in numbers: the worst point of each cell of a map.

>>> points = GaugedSurface(*np.array([[0.5, 0.5], [1.0, 1.0], [46.0, 46.0], [0.1, -0.3]]))
>>> cells_of(points, (0.0, 2.0), 2).error_um[1, 180]
np.float64(-0.3)
"""

from typing import NamedTuple

import numpy as np

from camtools.base.quantities import Floats, Ints
from camtools.sim.results import GaugedSurface

N_COLUMNS, MAX_ROWS = 360, 256


class Cells(NamedTuple):
    """The worst points of cells of equal height and angle; NaN where nothing was gauged."""

    z_mm: Floats  # middle of each row, shape (n_rows,)
    turn: Floats  # of the points, 0 .. 1, shape (n_rows, n_columns) as all that follow
    height_mm: Floats
    radius_mm: Floats
    error_um: Floats


def map_rows(span_mm: float, feed_mm: float) -> int:
    """Return how many rows of the map leave none without a turn: camsim's 256, halved as needed."""
    n_rows = MAX_ROWS
    while n_rows > 1 and span_mm / n_rows < feed_mm:
        n_rows //= 2
    return n_rows


def worst_of(index: Ints, error_um: Floats, n: int) -> Ints:
    """Return for each of n cells the point with the largest error, -1 for none."""
    worst = np.full(n, -1)
    by_size = np.argsort(np.abs(error_um), kind="stable")
    worst[index[by_size]] = by_size  # the worst is written last and stays
    return worst


def cells_of(
    surface: GaugedSurface, z_range_mm: tuple[float, float], n_rows: int, n_columns: int = N_COLUMNS
) -> Cells:
    """Return the worst point of every cell, rows by rising height, columns by angle."""
    low, high = z_range_mm
    row = ((surface.z_mm - low) / (high - low) * n_rows).astype(np.int64).clip(0, n_rows - 1)
    column = (surface.turn * n_columns).astype(np.int64).clip(0, n_columns - 1)
    worst = worst_of(row * n_columns + column, surface.error_um, n_rows * n_columns)
    points = (np.append(values, np.nan)[worst] for values in surface)  # -1 is the NaN
    middle_mm = low + (np.arange(n_rows) + 0.5) * (high - low) / n_rows
    return Cells(middle_mm, *(values.reshape(n_rows, n_columns) for values in points))


def over_turn(turn: Floats, values: Floats, n: int) -> Floats:
    """Return angle [degrees], smallest, largest, mean of values in n bins that have any, (4, m)."""
    place = (np.mod(turn, 1) * n).astype(np.int64).clip(0, n - 1)
    count = np.bincount(place, minlength=n)
    least, most = np.full(n, np.inf), np.full(n, -np.inf)
    np.minimum.at(least, place, values)
    np.maximum.at(most, place, values)
    mean = np.bincount(place, values, minlength=n) / np.maximum(count, 1)
    degrees = (np.arange(n) + 0.5) * (360 / n)
    return np.stack([degrees, least, most, mean])[:, count > 0]
