"""Tables of a part file for several passes and for a feed that changes with the height.

>>> law = FeedLaw(height_mm=[0.0, 10.0], feed_mm=[0.1, 0.2])
>>> f"{law.mean_mm(0.0, 10.0):.6f}"
'0.144270'
>>> Pass(allowance_um=0.0).feed_mm is None
True
"""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated

import numpy as np
from pydantic import AliasChoices, Field, field_validator
from scipy.interpolate import PchipInterpolator

from camtools.base.quantities import Floats
from camtools.part.model import HeightMm, TomlTable, as_long, rising, wrong

_PIECES, _NODES = 64, 8  # of the integral over the height, between two points of the law
_UM_PER_MM = 1000.0


class Pass(TomlTable):
    """[[process.pass]]: one of several passes, in the order of cutting."""

    allowance_um: Annotated[float, Field(ge=0, le=10_000)]
    feed_mm: Annotated[float, Field(ge=0.000_1, le=10)] | None = None
    spindle_rpm: Annotated[float, Field(ge=1, le=60_000)] | None = None


Passes = Annotated[
    list[Pass], Field(max_length=16, validation_alias=AliasChoices("pass", "passes"))
]  # TOML calls it "pass", which is no name in Python


def check_passes(passes: list[Pass], depth_mm: float) -> None:
    """Refuse passes that do not come down to the drawing, each by some depth."""
    if not passes:
        return
    stock = [depth_mm * _UM_PER_MM, *(one.allowance_um for one in passes)]
    for number, (before, after) in enumerate(pairwise(stock), start=1):
        if after >= before:
            problem = f"number {number} leaves {after:g} um of {before:g} um"
            remedy = "give less from pass to pass; the first begins with process.depth_mm"
            raise wrong("pass_order", problem, remedy)
    if passes[-1].allowance_um != 0:
        problem = f"the last one leaves {passes[-1].allowance_um:g} um"
        raise wrong("pass_last", problem, "give the last pass allowance_um = 0")


class FeedLaw(TomlTable):
    """[process.feed_law]: feed per turn over the height, MATHS.md (103)."""

    height_mm: Annotated[list[HeightMm], Field(min_length=2, max_length=1000)]
    feed_mm: Annotated[
        list[Annotated[float, Field(ge=0.000_1, le=10)]], Field(min_length=2, max_length=1000)
    ]

    _check_height = field_validator("height_mm")(rising)
    _check_length = field_validator("feed_mm")(as_long)

    def at_mm(self, z_mm: Floats, derivative: int = 0) -> Floats:
        """Return the feed at heights [mm], or its derivative; it stays beyond the first and last.

        Between the points it follows a monotone cubic: no feed is larger or smaller than its
        neighbours.
        """
        low, high = self.height_mm[0], self.height_mm[-1]
        curve = PchipInterpolator(self.height_mm, self.feed_mm)
        inside = np.asarray(curve(np.clip(z_mm, low, high), nu=derivative), dtype=np.float64)
        return inside if derivative == 0 else np.where((z_mm < low) | (z_mm > high), 0.0, inside)

    def turns(self, z_first_mm: float, z_mm: Floats) -> Floats:
        """Return the turns that Z takes from a height to others, rising.

        Parameters
        ----------
        z_mm : ndarray, shape (n,)
            Rising heights from z_first_mm on.
        """
        knots = np.array(self.height_mm)
        inside = knots[(knots > z_first_mm) & (knots < z_mm[-1])]
        ends = np.unique(np.concatenate([[z_first_mm], inside, z_mm]))
        x, w = np.polynomial.legendre.leggauss(_NODES)
        share = (np.arange(_PIECES)[:, None] + (x + 1) / 2) / _PIECES
        at = ends[:-1, None, None] + np.diff(ends)[:, None, None] * share
        sums = (w / 2 / self.at_mm(at)).sum(axis=(1, 2)) * np.diff(ends) / _PIECES
        total = np.concatenate([[0.0], np.cumsum(sums)])
        return np.asarray(total[np.searchsorted(ends, z_mm)], dtype=np.float64)

    def mean_mm(self, z_first_mm: float, z_last_mm: float) -> float:
        """Return the mean feed: the height over the turns that it takes."""
        turns = float(self.turns(z_first_mm, np.array([z_last_mm]))[-1])
        return (z_last_mm - z_first_mm) / turns
