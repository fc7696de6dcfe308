"""Tables of a part file for several passes and for a feed that changes with the height.

>>> law = FeedLaw(height_mm=[0.0, 10.0], feed_mm=[0.1, 0.2])
>>> f"{law.mean_mm(0.0, 10.0):.6f}"
'0.144270'
"""

from itertools import pairwise
from typing import Annotated, Literal

import numpy as np
from pydantic import AliasChoices, Field, ValidationInfo, field_validator
from scipy.interpolate import PchipInterpolator

from camtools.base.quantities import UM_PER_MM, Floats
from camtools.part.common import FeedMm, Process, SpindleRpm
from camtools.part.model import HeightMm, Points, TomlTable, as_long, rising, wrong

_PIECES, _NODES = 64, 8  # of the integral over the height, between two points of the law
_OF_PASS = "of this pass; without it that of `[process]`; with a feed law its mean"
RunMm = Annotated[
    float,
    Field(
        ge=0,
        le=200,
        description="the tool starts this far below the first height and ends this far above the "
        "last, in the air",
    ),
]


class Pass(TomlTable):
    """[[process.pass]]: passes in cutting order at a constant spindle speed, from `depth_mm` on."""

    allowance_um: float = Field(
        ge=0,
        le=10_000,
        description="stock that the pass leaves on the radius, falling; 0 in the last pass",
    )
    feed_mm: FeedMm | None = Field(None, description=_OF_PASS)
    spindle_rpm: SpindleRpm | None = Field(None, description=_OF_PASS)


class SectionProcess(Process):
    """[process]: how a section is turned."""

    form_error_um: float = Field(
        5.0, ge=0.01, le=1000, description="accepted form error of the cut against the drawing"
    )
    u_zero: Literal["long-axis", "mean"] = Field(
        "long-axis",
        description="tip at U = 0: on the long axis, or in the middle of all reductions, which "
        "[needs half the stroke](PISTONS.md#room-of-the-machine)",
    )
    run_in_mm: RunMm = 0.0
    run_out_mm: RunMm = 0.0
    passes: list[Pass] = Field(
        default_factory=list, max_length=16, validation_alias=AliasChoices("pass", "passes")
    )  # TOML calls it "pass", which is no name in Python

    @field_validator("passes")
    @classmethod
    def _check_passes(cls, value: list[Pass], info: ValidationInfo) -> list[Pass]:
        """Refuse passes that do not come down to the drawing, each by some depth."""
        stock = [info.data.get("depth_mm", 0.0) * UM_PER_MM, *(one.allowance_um for one in value)]
        for number, (before, after) in enumerate(pairwise(stock), start=1):
            if after >= before:
                problem = f"number {number} leaves {after:g} um of {before:g} um"
                remedy = "give less from pass to pass; the first begins with process.depth_mm"
                raise wrong("pass_order", problem, remedy)
        if value and stock[-1] != 0:
            problem = f"the last one leaves {stock[-1]:g} um"
            raise wrong("pass_last", problem, "give the last pass allowance_um = 0")
        return value


class FeedLaw(TomlTable):
    """[process.feed_law]: [feed against height](PISTONS.md#passes-and-feed-against-height)."""

    height_mm: Points[HeightMm] = Field(
        description="rising by 0.01 or more; beyond the ends the feed is constant"
    )
    feed_mm: Points[FeedMm] = Field(
        description="per height, at least 4 % of the mean; a monotone cubic between the points, "
        'MATHS.md (103); with `path = "helix"`'
    )

    _check_height = field_validator("height_mm")(rising)
    _check_length = field_validator("feed_mm")(as_long)

    def at_mm(self, z_mm: Floats, derivative: int = 0) -> Floats:
        """Return the feed at heights [mm], monotone between points, or its derivative."""
        low, high = self.height_mm[0], self.height_mm[-1]
        curve = PchipInterpolator(self.height_mm, self.feed_mm)
        inside = np.asarray(curve(np.clip(z_mm, low, high), nu=derivative), dtype=np.float64)
        return inside if derivative == 0 else np.where((z_mm < low) | (z_mm > high), 0.0, inside)

    def turns(self, z_first_mm: float, z_mm: Floats) -> Floats:
        """Return the turns that Z takes from a height to others, rising."""
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
