"""[[piston.land]] of a part file: ring lands and crown, turned in one program with the skirt.

>>> top = Land(from_mm=56, to_mm=60, diameter_mm=85.5, taper_um=100)
>>> grooves([Land(from_mm=52, to_mm=54, diameter_mm=85.6), top], 0, 50), top.upper_mm
([(50, 52.0), (54.0, 56.0)], 85.4)
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated, NamedTuple, Self

from pydantic import Field, model_validator

from camtools.base.quantities import UM_PER_MM
from camtools.part.areas import AreaName, check_ends
from camtools.part.common import FeedMm
from camtools.part.model import HeightMm, TomlTable, wrong
from camtools.skirt.part.imported import DiameterMm

MAX_LANDS, MAX_LAND_PASSES = 8, 16
MAX_GROOVE_MM = 50.0
AllowanceUm = Annotated[float, Field(ge=0, le=10_000)]


class BandPass(NamedTuple):
    """A pass over a band."""

    allowance_mm: float  # stock that it leaves on the radius
    feed_mm: float  # per turn


class Band(NamedTuple):
    """The skirt or a land: what is turned between two grooves."""

    name: str
    low_mm: float
    high_mm: float
    passes: tuple[BandPass, ...]


class Land(TomlTable):
    """[[piston.land]]: a [band of its own](PISTONS.md#ring-belt-and-crown) beside the skirt."""

    name: AreaName = Field("land", description="in reports")
    from_mm: HeightMm = Field(description="its lower end, above or below the profile's heights")
    to_mm: HeightMm = Field(description="its upper end")
    diameter_mm: DiameterMm = Field(description="long-axis diameter at its lower end")
    taper_um: float = Field(
        0.0, ge=-10_000, le=10_000, description="by which the diameter is less at its upper end"
    )
    ovality_mm: float = Field(
        0.0, ge=0, le=4000, description="long minus short axis, by the law of the section; 0: round"
    )
    feed_mm: FeedMm | None = Field(
        None, description="per turn; without it that of the skirt, pass by pass"
    )
    allowance_um: list[AllowanceUm] = Field(
        default_factory=list,
        max_length=MAX_LAND_PASSES,
        description="stock that each of its passes leaves on the radius, falling to 0; without it "
        "its passes are those of the skirt",
    )

    @model_validator(mode="after")
    def _check_land(self) -> Self:
        check_ends(self.from_mm, self.to_mm)
        stock = self.allowance_um
        if stock and (stock[-1] != 0 or any(a <= b for a, b in pairwise(stock))):
            context = {"field": "allowance_um", "value": stock}
            raise wrong("passes", "must fall from pass to pass, to 0", "correct it", **context)
        return self

    @property
    def upper_mm(self) -> float:
        """Return its long-axis diameter at the upper end."""
        return self.diameter_mm - self.taper_um / UM_PER_MM

    @property
    def diameters_mm(self) -> tuple[float, float]:
        """Return the least and the largest long-axis diameter."""
        return min(self.diameter_mm, self.upper_mm), max(self.diameter_mm, self.upper_mm)

    def band(self, skirt: Sequence[BandPass]) -> Band:
        """Return the land and its passes, by those of the skirt where it has none."""
        passes = [BandPass(um / UM_PER_MM, skirt[-1].feed_mm) for um in self.allowance_um] or skirt
        own = [step._replace(feed_mm=self.feed_mm or step.feed_mm) for step in passes]
        return Band(self.name, self.from_mm, self.to_mm, tuple(own))


def extended(lands: Sequence[Land], first_mm: float, last_mm: float) -> tuple[float, float]:
    """Return the ends of a part: of the profile and all lands."""
    ends = [first_mm, last_mm, *(z for land in lands for z in (land.from_mm, land.to_mm))]
    return min(ends), max(ends)


def grooves(lands: Sequence[Land], first_mm: float, last_mm: float) -> list[tuple[float, float]]:
    """Return the heights between skirt and lands, rising, which nothing is turned at.

    Raises a pydantic error: two of them overlap, or have no groove between them, or a wide one.
    """
    bands = sorted([(first_mm, last_mm), *((land.from_mm, land.to_mm) for land in lands)])
    found = [(below[1], above[0]) for below, above in pairwise(bands)]
    for low, high in found:
        problem = f"has no groove between {high:g} and {low:g} mm" if high <= low else ""
        if high - low > MAX_GROOVE_MM:
            problem = f"leaves {high - low:g} mm without a band from {low:g} mm on"
        if problem:
            remedy = f"leave a groove of at most {MAX_GROOVE_MM:g} mm between two bands"
            raise wrong("groove", problem, remedy, field="land", value=None)
    return found
