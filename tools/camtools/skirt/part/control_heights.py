# SPDX-License-Identifier: Apache-2.0
"""At which heights a skirt is gauged: those of the drawing, where it names some.

>>> spread([0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 62.0], (0.0, 62.0), 0.5)
[0.5, 20.0, 30.0, 40.0, 61.5]
>>> spread([0.0, 60.0], (0.0, 60.0), 0.5)
[0.5, 15.0, 30.0, 45.0, 59.5]
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

_MOST = 5
_LEAST_NAMED = 3  # fewer are the ends of a law, no heights to be looked at
_MARGIN_FEEDS = 3.0  # from the ends, where passes on both sides of a height begin
_LEAST_MARGIN_MM = 0.5


def spread(
    named_mm: Sequence[float], ends_mm: tuple[float, float], margin_mm: float
) -> list[float]:
    """Return the heights of sections, rising: of many that are named five, spread evenly.

    Parameters
    ----------
    ends_mm : tuple of float
        Ends of the part; sections keep a margin from them.
    """
    low_mm, high_mm = ends_mm[0] + margin_mm, ends_mm[1] - margin_mm
    if high_mm - low_mm < margin_mm:
        return []
    heights = np.unique(np.clip(named_mm, low_mm, high_mm))
    if heights.size < _LEAST_NAMED:
        heights = np.linspace(low_mm, high_mm, _MOST)
        heights[1:-1] = np.linspace(*ends_mm, _MOST)[1:-1]
    chosen = np.linspace(0, heights.size - 1, min(_MOST, heights.size)).round().astype(np.int64)
    return [round(float(one), 6) for one in heights[chosen]]


def margin_mm(feed_mm: float) -> float:
    """Return how far sections keep from the ends of a part [mm].

    >>> margin_mm(0.1), margin_mm(0.5)
    (0.5, 1.5)
    """
    return max(_LEAST_MARGIN_MM, _MARGIN_FEEDS * feed_mm)
