"""What a sample of cuts says: quantiles, the share within tolerance, which unknown matters.

>>> share_within(98, 100).share
0.98
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy import stats

from camtools.base.quantities import Floats

_CONFIDENCE = 0.95
_Z = float(stats.norm.ppf(0.5 + _CONFIDENCE / 2))
LEAST_FOR_RANKING = 64  # of a RBD-FAST or PAWN with any meaning
_SLICES = 10  # of PAWN
_RESAMPLES = 100
_NOTHINGS = 100  # random columns, which show what an index is of what has no effect


class Share(NamedTuple):
    """A share of a sample with its interval of 95 % confidence."""

    share: float
    low: float
    high: float


class Quantile(NamedTuple):
    """A quantile with its interval; infinite where it lies among cuts without a result."""

    percent: float
    value: float
    low: float
    high: float


class Effect(NamedTuple):
    """How much an unknown matters for the form error.

    Attributes
    ----------
    first_order, first_order_conf : float
        Share of the variance of the error's logarithm that it explains alone, and half the width of
        its interval of 95 %.
    """

    key: str  # of the unknown
    pawn: float  # how far its knowledge moves the distribution of the error, 0 .. 1
    first_order: float
    first_order_conf: float
    is_noise: bool  # of numbers that have no effect, 5 % seem to move the distribution as far


def share_within(n_within: int, n: int) -> Share:
    """Return a share with Wilson's interval, MATHS.md (164)."""
    share, spread = n_within / n, _Z * _Z / n
    middle = (share + spread / 2) / (1 + spread)
    half = _Z / (1 + spread) * float(np.sqrt(share * (1 - share) / n + spread / (4 * n)))
    return Share(share, max(0.0, middle - half), min(1.0, middle + half))


def quantile(errors: Floats, percent: float) -> Quantile:
    """Return a quantile of a sample with the interval of its order statistics, MATHS.md (163).

    Parameters
    ----------
    errors : ndarray, shape (n,)
        Infinite for cuts without a result.
    """
    ordered, n, share = np.sort(errors), errors.size, percent / 100
    place = min(max(int(np.ceil(share * n)), 1), n)
    low = int(stats.binom.ppf((1 - _CONFIDENCE) / 2, n, share))
    high = int(stats.binom.ppf((1 + _CONFIDENCE) / 2, n, share)) + 1
    lower = float(ordered[low - 1]) if low >= 1 else 0.0
    upper = float(ordered[high - 1]) if high <= n else float("inf")
    return Quantile(percent, float(ordered[place - 1]), lower, upper)


def _problem(inputs: Floats) -> dict[str, Any]:
    """Return what SALib wants to know of columns of numbers."""
    ranges = [[float(column.min()), float(column.max())] for column in inputs.T]
    names = [str(place) for place in range(len(ranges))]
    return {"num_vars": len(names), "names": names, "bounds": ranges}


def effects(keys: list[str], inputs: Floats, errors: Floats, *, seed: int) -> list[Effect]:
    """Return how much each unknown matters, the strongest first; MATHS.md (165).

    Parameters
    ----------
    keys : list of str
        Of the unknowns.
    inputs : ndarray, shape (n, len(keys))
    errors : ndarray, shape (n,)
        Finite, above 0.
    """
    from SALib.analyze import pawn, rbd_fast  # slow to load

    logs = np.log(np.maximum(errors, 1e-9))
    if errors.size < LEAST_FOR_RANKING or np.ptp(logs) == 0.0:
        return []
    nothing = np.random.default_rng(seed).random((errors.size, _NOTHINGS))
    drawn = np.column_stack([inputs, nothing])
    moved = pawn.analyze(_problem(drawn), drawn, logs, S=_SLICES, seed=seed)["median"]
    floor = float(np.quantile(moved[len(keys) :], _CONFIDENCE))
    first = rbd_fast.analyze(_problem(inputs), inputs, logs, num_resamples=_RESAMPLES, seed=seed)
    found = [
        Effect(
            key,
            float(moved[place]),
            float(first["S1"][place]),
            float(first["S1_conf"][place]),
            float(moved[place]) <= floor,
        )
        for place, key in enumerate(keys)
    ]
    return sorted(found, key=lambda effect: -effect.pawn)
