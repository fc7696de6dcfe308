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

from camtools.base.quantities import Bools, Floats
from camtools.cut.correction import Complexes

_ROUNDS = 8
_HUBER = 2.0  # standard deviations from which on a point counts less
_FAR = 6.0  # .. and from which on it does not count
_TO_SIGMA = 1.4826  # of the median of magnitudes of a normal distribution
_LEAST = 1e-12


class HeightWaves(NamedTuple):
    """The waves of one height."""

    waves: Complexes  # (order + 1,): value = Re sum c_k e^(-j k phi)
    sigma: float  # standard deviation of a point about the waves
    variances: Floats  # (order + 1,) of the waves, real and imaginary part together
    is_far: Bools  # of each point, whether it is beyond six standard deviations and does not count


class _Basis:
    """Waves at angles, and the normal equations of a fit: sums along the points, no matrix."""

    def __init__(self, turn: Floats, order: int) -> None:
        self.order = order
        k = np.arange(order + 1)
        self._both, self._apart = k[:, None] + k, np.abs(k[:, None] - k)
        self._is_below = k[:, None] < k
        steps = np.exp(2j * np.pi * turn)
        self._powers = np.ones((2 * order + 1, turn.size), dtype=np.complex128)
        for i in range(1, 2 * order + 1):
            self._powers[i] = self._powers[i - 1] * steps

    def fitted(self, weight: Floats, values: Floats) -> Complexes:
        """Return the waves of least squares with these weights."""
        n = self.order + 1
        sums = np.einsum("i,ki->k", weight, self._powers)
        right = np.einsum("i,ki->k", weight * values, self._powers[:n])
        both, apart = sums[self._both], sums[self._apart]
        apart = np.where(self._is_below, apart.conj(), apart)  # of e^(j (k - l) phi)
        normal = np.empty((2 * n - 1, 2 * n - 1))  # the mean has no sine
        normal[:n, :n], normal[:n, n:] = (apart + both).real, (both - apart).imag[:, 1:]
        normal[n:, :n], normal[n:, n:] = (both + apart).imag[1:], (apart - both).real[1:, 1:]
        normal /= 2
        found = np.linalg.solve(normal, np.concatenate([right.real, right.imag[1:]]))
        waves = found[:n].astype(np.complex128)
        waves[1:] += 1j * found[n:]
        return waves

    def values(self, waves: Complexes) -> Floats:
        """Return waves at the angles."""
        found = np.einsum("k,ki->i", waves.conj(), self._powers[: self.order + 1])
        return np.asarray(found.real, dtype=np.float64)


def fit_waves(turn: Floats, values: Floats, order: int) -> HeightWaves:
    """Return the waves up to an order through the points of a height."""
    basis, n_unknown = _Basis(turn, order), 2 * order + 1
    weight, sigma = np.ones(turn.size), 0.0
    for _ in range(_ROUNDS):
        waves = basis.fitted(weight, values)
        off = np.abs(values - basis.values(waves))
        sigma = _TO_SIGMA * float(np.median(off)) * np.sqrt(off.size / (off.size - n_unknown))
        limit = max(sigma, _LEAST)
        weight = np.minimum(1.0, _HUBER * limit / np.maximum(off, _LEAST))
        weight[off > _FAR * limit] = 0.0
        if np.count_nonzero(weight) <= n_unknown:
            weight = np.ones(turn.size)
            break
    variances = np.full(order + 1, 4 * sigma**2 / turn.size)
    variances[0] /= 4
    return HeightWaves(waves, sigma, variances, weight == 0)
