"""The quintics between neighbouring knots, MATHS.md (46).

>>> segment_coefficients(np.array([[0, 0, 0], [1, 0, 0]]), periodic=False).tolist()
[[0, 0, 0, 10, -15, 6]]
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np
import numpy.typing as npt

Numbers = TypeVar("Numbers", npt.NDArray[np.int64], npt.NDArray[np.float64])


def segment_coefficients(knots: Numbers, *, periodic: bool) -> Numbers:
    """Return the quintics between neighbouring knots, of integers exactly, MATHS.md (46).

    Parameters
    ----------
    knots : ndarray of int64 or float64, shape (..., n, 3)
        Triples (p, v, a) along the second last axis.
    periodic : bool
        Whether the first knot follows the last one.

    Returns
    -------
    ndarray, shape (..., n, 6) or (..., n - 1, 6)
        c0 .. c5 of each segment in t = 0 .. 1, LSB as the knots.
    """
    left = knots if periodic else knots[..., :-1, :]
    right = np.roll(knots, -1, axis=-2) if periodic else knots[..., 1:, :]
    p, v, a = left[..., 0], left[..., 1], left[..., 2]
    dp = right[..., 0] - p - v - a
    dv = right[..., 1] - v - 2 * a
    da = right[..., 2] - a
    c3, c4, c5 = 10 * dp - 4 * dv + da, -15 * dp + 7 * dv - 2 * da, 6 * dp - 3 * dv + da
    return np.stack([p, v, a, c3, c4, c5], axis=-1)
