"""Waves over the height: how much of them is noise, and what is left when it is smoothed away.

>>> z = np.linspace(0, 60, 40)
>>> rng = np.random.default_rng(3)
>>> noise = rng.normal(0, 0.1, (2, 40))
>>> noisy = 2 * np.exp(1j * z / 30) + noise[0] + 1j * noise[1]
>>> found = Smoother(z).smooth(noisy, scatter(z, noisy))
>>> bool(np.abs(found.values - 2 * np.exp(1j * z / 30)).max() < 0.12)
True
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camtools.base.quantities import Floats
from camtools.cut.correction import Complexes

_MEDIAN_COMPLEX, _MEDIAN_REAL = float(np.log(2)), 0.454936  # of |noise|^2 over its mean
_CAUTION = 1.5  # of each degree of freedom in Mallows' criterion
_GRID = 10.0 ** np.arange(-6, 10, 0.125)
_KEPT_WHOLE = 6.0  # energy over that of the noise from which on a wave is kept at all
_LOCAL = 2.0  # standard errors that are taken off at a height
MIN_FOR_SCATTER = 6


def neighbour_weights(z_mm: Floats) -> tuple[Floats, Floats]:
    """Return the shares of both neighbours in the line through them at each inner height."""
    below = (z_mm[2:] - z_mm[1:-1]) / (z_mm[2:] - z_mm[:-2])
    return below, 1 - below


def off_neighbours(z_mm: Floats, values: Complexes) -> Complexes:
    """Return by how much values leave the line through their neighbours, over its noise."""
    below, above = neighbour_weights(z_mm)
    off = values[..., 1:-1] - below * values[..., :-2] - above * values[..., 2:]
    return np.asarray(off / np.sqrt(1 + below**2 + above**2), dtype=np.complex128)


def scatter(z_mm: Floats, values: Complexes, *, is_real: bool = False) -> float:
    """Return the variance of values that change smoothly over the height but for noise.

    MATHS.md (158); 0 where there are too few heights.
    """
    if z_mm.size < MIN_FOR_SCATTER:
        return 0.0
    median = _MEDIAN_REAL if is_real else _MEDIAN_COMPLEX
    return float(np.median(np.abs(off_neighbours(z_mm, values)) ** 2)) / median


class Smoothed(NamedTuple):
    """A wave over the height."""

    values: Complexes  # (n,)
    errors: Floats  # (n,) standard errors


class Smoother:
    """Natural cubic smoothing splines over heights, MATHS.md (159)."""

    def __init__(self, z_mm: Floats) -> None:
        n, h = z_mm.size, np.diff(z_mm) / float(np.ptp(z_mm))
        i = np.arange(n - 2)
        q, r = np.zeros((n, n - 2)), np.zeros((n - 2, n - 2))
        q[i, i], q[i + 1, i], q[i + 2, i] = 1 / h[:-1], -1 / h[:-1] - 1 / h[1:], 1 / h[1:]
        r[i, i] = (h[:-1] + h[1:]) / 3
        r[i[:-1], i[1:]] = r[i[1:], i[:-1]] = h[1:-1] / 6
        bends, self._modes = np.linalg.eigh(q @ np.linalg.solve(r, q.T))
        self._bends = np.where(np.arange(n) < 2, 0.0, np.maximum(bends, 0.0))

    def smooth(self, values: Complexes, variance: float) -> Smoothed:
        """Return the curve with the least expected error for a noise of this variance."""
        modes = self._modes.T @ values
        energy = np.abs(modes) ** 2
        kept = 1 / (1 + self._bends / np.median(self._bends[2:]) / _GRID[:, None])
        risk = ((1 - kept) ** 2 @ energy) + 2 * _CAUTION * variance * kept.sum(axis=1)
        share = kept[int(np.argmin(risk))]
        errors = np.sqrt(variance * (self._modes**2 @ share**2))
        return Smoothed(np.asarray(self._modes @ (share * modes), dtype=np.complex128), errors)


def shares_kept(one: Smoothed) -> Floats:
    """Return which share of a wave is kept at each height: what stands above its noise."""
    energy, noise = np.abs(one.values) ** 2, one.errors**2
    if energy.sum() <= _KEPT_WHOLE * noise.sum():
        return np.zeros(energy.size)
    least = np.finfo(float).tiny
    return np.asarray(np.maximum(0.0, 1 - _LOCAL**2 * noise / np.maximum(energy, least)))
