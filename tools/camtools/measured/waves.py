"""The waves of one height: least squares that single wrong points do not bend, MATHS.md (157).

>>> turn = np.arange(360) / 360
>>> values = 0.5 + 2 * np.cos(4 * np.pi * turn - 1)
>>> values[7] += 1000
>>> found = fit_waves(turn, values, 4)
>>> np.abs(found.waves).round(6).tolist(), float(np.angle(found.waves[2]).round(6))
([0.5, 0.0, 2.0, 0.0, 0.0], 1.0)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camtools.base.quantities import Floats
from camtools.cut.correction import Complexes

_ROUNDS = 8
_HUBER = 2.0  # standard deviations from which on a point counts less
_FAR = 6.0  # .. and from which on it does not count
_TO_SIGMA = 1.4826  # of the median of magnitudes of a normal distribution
_LEAST = 1e-12


class HeightWaves(NamedTuple):
    """What one height tells."""

    waves: Complexes  # (order + 1,): value = Re sum c_k e^(-j k phi)
    sigma: float  # standard deviation of a point about the waves
    variances: Floats  # (order + 1,) of the waves, real and imaginary part together
    n_far: int  # points beyond six standard deviations, which do not count


def basis(turn: Floats, order: int) -> Floats:
    """Return 1, cosines and sines at angles, shape (n, 2 order + 1)."""
    phi = 2 * np.pi * turn[:, None] * np.arange(1, order + 1)
    return np.hstack([np.ones((turn.size, 1)), np.cos(phi), np.sin(phi)])


def fit_waves(turn: Floats, values: Floats, order: int) -> HeightWaves:
    """Return the waves up to an order through the points of a height."""
    a = basis(turn, order)
    weight, sigma = np.ones(turn.size), 0.0
    for _ in range(_ROUNDS):
        weighted = a * weight[:, None]
        found = np.linalg.solve(a.T @ weighted, weighted.T @ values)
        off = np.abs(values - a @ found)
        sigma = _TO_SIGMA * float(np.median(off)) * np.sqrt(off.size / (off.size - a.shape[1]))
        limit = max(sigma, _LEAST)
        weight = np.minimum(1.0, _HUBER * limit / np.maximum(off, _LEAST))
        weight[off > _FAR * limit] = 0.0
        if np.count_nonzero(weight) < a.shape[1] + 1:
            weight = np.ones(turn.size)
            break
    waves = np.concatenate([found[:1], found[1 : order + 1] + 1j * found[order + 1 :]])
    variances = np.full(order + 1, 4 * sigma**2 / turn.size)
    variances[0] /= 4
    return HeightWaves(waves, sigma, variances, int(np.count_nonzero(weight == 0)))
