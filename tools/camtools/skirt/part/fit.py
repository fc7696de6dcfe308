"""[piston.growth], [piston.coating] and [piston.bore]: a skirt that runs hot in its bore.

>>> Bore(diameter_mm=92.05, temperature_c=110).expansion_per_k
1.1e-05
"""

from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, Tag, model_validator

from camtools.part.model import (
    LIST_OR_ONE,
    SAME_MM,
    Entry,
    HeightMm,
    Points,
    TomlTable,
    as_long,
    rising,
    wrong,
)

MIN_BLEND_MM = 0.5  # of a coating's edge
Heights = Annotated[Points[HeightMm], AfterValidator(rising)]
PerHeight = Annotated[Points[Entry], AfterValidator(as_long)]
TemperatureC = Annotated[float, Field(ge=-60, le=1000)]
PerK = Annotated[float, Field(ge=0, le=1e-4)]
DropUm = Annotated[float, Field(ge=-10_000, le=10_000)]
ThicknessUm = Annotated[float, Field(ge=0, le=1000)]
ThicknessesUm = Annotated[
    Annotated[PerHeight[ThicknessUm], Tag("(list)")] | Annotated[ThicknessUm, Tag("(one)")],
    LIST_OR_ONE,
]

_PER_K = "linear expansion coefficient [1/K]"
_NEEDS = (  # keys, and what each cannot do without
    *(("expansion_per_k", "temperature_c"), ("temperature_c", "expansion_per_k")),
    *(("pin_temperature_c", "temperature_c"), ("antithrust_temperature_c", "temperature_c")),
    *(("cold_drop_um", "hot_drop_um"), ("hot_drop_um", "cold_drop_um")),
    *(("pin_cold_drop_um", "pin_hot_drop_um"), ("pin_hot_drop_um", "pin_cold_drop_um")),
    ("pin_hot_drop_um", "hot_drop_um"),
)


class Growth(TomlTable):
    """[piston.growth]: [from cold to hot](PISTONS.md#cold-and-hot), by temperatures or as measured.

    MATHS.md (245), (246). The part is turned cold, whatever the drawing shows.
    """

    drawn: Literal["cold", "hot"] = Field(description="state that the drawing shows")
    height_mm: Heights = Field(
        description="rising, covers the profile's range; heights of the lists of this table"
    )
    expansion_per_k: PerK | None = Field(None, description=_PER_K)
    reference_c: TemperatureC = Field(
        20.0, description="of the cold part and of the cold bore [°C]"
    )
    temperature_c: PerHeight[TemperatureC] | None = Field(
        None, description="per height, of the hot skirt along the thrust direction [°C]"
    )
    pin_temperature_c: PerHeight[TemperatureC] | None = Field(
        None, description="the same along the pin; without it the mean of both thrust sides [°C]"
    )
    antithrust_temperature_c: PerHeight[TemperatureC] | None = Field(
        None, description="the same opposite the thrust side; without it as there [°C]"
    )
    cold_drop_um: PerHeight[DropUm] | None = Field(
        None,
        description="instead of temperatures: measured cold, radius below a circle that is common "
        "to all four lists, along the thrust direction",
    )
    hot_drop_um: PerHeight[DropUm] | None = Field(
        None, description="the same hot; below 0 where it is outside the circle"
    )
    pin_cold_drop_um: PerHeight[DropUm] | None = Field(
        None, description="cold along the pin; without it the growth is the same all round"
    )
    pin_hot_drop_um: PerHeight[DropUm] | None = Field(None, description="the same hot")

    @model_validator(mode="after")
    def _check_way(self) -> Self:
        if all(getattr(self, key) is None for key, _ in _NEEDS):
            remedy = "give expansion_per_k and temperature_c, or cold_drop_um and hot_drop_um"
            raise wrong("no_growth", "has neither temperatures nor measured profiles", remedy)
        for key, needed in _NEEDS:
            if getattr(self, key) is not None and getattr(self, needed) is None:
                raise wrong(
                    "needed", f"is missing: {key} needs it", "add it", field=needed, value=None
                )
        if self.temperature_c is not None and self.cold_drop_um is not None:
            problem = "has no meaning beside temperature_c: a growth is calculated or measured"
            context: dict[str, object] = {"field": "cold_drop_um", "value": self.cold_drop_um}
            raise wrong("both", problem, "remove one of the two", **context)
        return self


class Coating(TomlTable):
    """[piston.coating]: on the turned skirt, such as graphite."""

    drawn: Literal["coated", "bare"] = Field(
        "coated", description="surface that the drawing shows; the bare one is turned"
    )
    height_mm: Heights | None = Field(None, description="rising; heights of a list of thicknesses")
    thickness_um: ThicknessesUm = Field(
        description="everywhere, or per height: between two heights a smooth step, beyond them as "
        "there"
    )

    @model_validator(mode="after")
    def _check_zones(self) -> Self:
        if isinstance(self.thickness_um, list) != (self.height_mm is not None):
            problem = "and a list of thickness_um belong together"
            context: dict[str, object] = {"field": "height_mm", "value": self.height_mm}
            raise wrong("zones", problem, "give both, or one thickness alone", **context)
        for (low, was), (high, um) in pairwise(self.points):
            if um != was and high - low < MIN_BLEND_MM - SAME_MM:
                problem = f"changes from {was:g} to {um:g} um within {high - low:.6g} mm"
                context = {"field": "thickness_um", "value": self.thickness_um}
                remedy = f"let it change over at least {MIN_BLEND_MM:g} mm"
                raise wrong("blend", problem, remedy, **context)
        return self

    @property
    def points(self) -> list[tuple[float, float]]:
        """Return heights and thicknesses of a list, none of one thickness."""
        if self.height_mm is None or not isinstance(self.thickness_um, list):
            return []
        return list(zip(self.height_mm, self.thickness_um, strict=True))


class Bore(TomlTable):
    """[piston.bore]: what the clearance is reckoned to; warns where it is below 0."""

    diameter_mm: float = Field(ge=1, le=4000, description="cold, at `reference_c` of the growth")
    expansion_per_k: PerK = Field(11e-6, description=f"{_PER_K}; that of grey cast iron")
    temperature_c: TemperatureC | None = Field(
        None, description="while the skirt is hot; without it the bore stays cold [°C]"
    )


def check_fit(
    growth: Growth | None,
    coating: Coating | None,
    bore: Bore | None,
    shape: str,
    ends_mm: tuple[float, float],
) -> None:
    """Refuse what does not cover the profile, or changes points that are turned as they are."""
    if growth is not None and (
        growth.height_mm[0] > ends_mm[0] or growth.height_mm[-1] < ends_mm[1]
    ):
        context: dict[str, object] = {"field": "growth.height_mm", "value": growth.height_mm}
        problem = f"must cover the profile's heights {ends_mm[0]} .. {ends_mm[1]} mm"
        raise wrong("cover", problem, "add points at the ends", **context)
    if growth is None and bore is not None and bore.temperature_c is not None:
        context = {"field": "bore.temperature_c", "value": bore.temperature_c}
        problem = "has no effect without [piston.growth]: the skirt stays cold"
        raise wrong("cold", problem, "add that table, or remove the key", **context)
    for name, table, state in (("growth", growth, "cold"), ("coating", coating, "bare")):
        drawn = getattr(table, "drawn", state)
        if shape == "points" and drawn != state:
            problem = 'has no meaning for shape = "points", which is turned as imported'
            remedy = f'set drawn = "{state}", or give the drawing by another shape'
            raise wrong("imported", problem, remedy, field=f"{name}.drawn", value=drawn)
