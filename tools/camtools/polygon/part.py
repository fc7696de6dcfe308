"""The part file of a polygon: its section, its length, and how it is turned.

Where the numbers come from, and how far they are confirmed: tools/docs/POLYGONS.md.

>>> PolygonSection(form="p3g", z_mm=[0, 30], size_mm=25).eccentricity_mm
0.8
"""

from typing import Annotated, Literal, Self

from pydantic import Field, Tag, field_validator, model_validator

from camtools.part.common import FormTolerances, Machine, PartInfo, SectionProcess, Tool
from camtools.part.model import LIST_OR_ONE, HeightMm, Only, TomlTable, rising, wrong

_P3G_SIZES = (
    *((14, 0.44), (16, 0.5), (18, 0.56), (20, 0.63), (22, 0.7), (25, 0.8), (28, 0.9), (30, 1.0)),
    *((32, 1.12), (35, 1.25), (40, 1.4), (45, 1.6), (50, 1.8), (55, 2.0), (60, 2.25), (65, 2.45)),
    *((70, 2.8), (75, 3.15), (80, 3.35), (85, 3.55), (90, 4.0), (95, 4.25), (100, 4.5)),
)
_P4C_SIZES = (
    *((14, 11, 1.6), (16, 13, 2), (18, 15, 2), (20, 17, 3), (22, 18, 3), (25, 21, 5)),
    *((28, 24, 5), (30, 25, 5), (32, 27, 5), (35, 30, 5), (40, 35, 6), (45, 40, 6)),
    *((50, 43, 6), (55, 48, 6), (60, 53, 6), (65, 58, 6), (70, 60, 6), (75, 65, 6)),
    *((80, 70, 8), (85, 75, 8), (90, 80, 8), (95, 85, 8), (100, 90, 8)),
)
# Of DIN 32711 the mean diameter d1 and e1; of DIN 32712 d1 of the corners, d2 across the flats, e.
P3G = {float(d1): (float(d1), float(e1)) for d1, e1 in _P3G_SIZES}
P4C = {float(d1): (float(d1), float(d2), float(e)) for d1, d2, e in _P4C_SIZES}
_SIZES: dict[str, dict[float, tuple[float, ...]]] = {"p3g": {**P3G}, "p4c": {**P4C}}
_SIZED = {
    "p3g": ("mean_diameter_mm", "eccentricity_mm"),
    "p4c": ("outer_diameter_mm", "inner_diameter_mm", "eccentricity_mm"),
}

MAX_SIDES = 16
DiameterMm = Annotated[float, Field(ge=1, le=4000)]
EccentricityMm = Annotated[float, Field(gt=0, le=100)]
CornerMm = Annotated[float, Field(ge=0, le=2000)]
PlaceMm = Annotated[float, Field(ge=-2000, le=2000)]
Point = Annotated[list[PlaceMm], Field(min_length=2, max_length=2)]
Corners = Annotated[list[Point], Field(min_length=3, max_length=64)]
CornerRadii = Annotated[
    Annotated[list[CornerMm], Field(min_length=3, max_length=64), Tag("(list)")]
    | Annotated[CornerMm, Tag("(one)")],
    LIST_OR_ONE,
]
_P3G, _P4C, _BOTH, _REGULAR, _CORNERS = (
    Only("form", forms, forms, ", or size_mm" if forms[0] in ("p3g", "p4c") else "")
    for forms in (("p3g",), ("p4c",), ("p3g", "p4c"), ("regular",), ("corners",))
)


class PolygonSection(TomlTable):
    """[polygon]: its section, and the heights between which it is cut.

    The drawing's angle 0 is the direction of a corner, of `form = "corners"` that of x.
    """

    form: Literal["p3g", "p4c", "regular", "corners"] = Field(
        description="DIN 32711, DIN 32712, equal sides and angles, any convex polygon"
    )
    z_mm: Annotated[list[HeightMm], Field(min_length=2, max_length=2)] = Field(
        description="where the polygon begins and ends, rising"
    )
    size_mm: Annotated[float | None, Only("form", ("p3g", "p4c"))] = Field(
        None,
        description="a [nominal size](POLYGONS.md#nominal-sizes), stands for the diameters and the "
        "eccentricity",
    )
    mean_diameter_mm: Annotated[DiameterMm | None, _P3G] = Field(
        None, description="d1, the width in every direction"
    )
    outer_diameter_mm: Annotated[DiameterMm | None, _P4C] = Field(
        None, description="d1, circle of the corners"
    )
    inner_diameter_mm: Annotated[DiameterMm | None, _P4C] = Field(
        None, description="d2, across the flats"
    )
    eccentricity_mm: Annotated[EccentricityMm | None, _BOTH] = Field(
        None, description="e1 of p3g, below a 16th of the mean diameter; e of p4c"
    )
    sides: Annotated[int | None, _REGULAR] = Field(None, ge=3, le=MAX_SIDES)
    across_flats_mm: Annotated[DiameterMm | None, _REGULAR] = Field(
        None, description="twice the distance of the sides from the axis"
    )
    corners_mm: Annotated[Corners | None, _CORNERS] = Field(
        None,
        description="points [x, y], convex, counter-clockwise, before rounding, no side steeper "
        "than 80 degrees off the circle; x points to angle 0",
    )
    corner_radius_mm: Annotated[CornerRadii | None, Only("form", ("regular", "corners"))] = Field(
        None, description="of corners also a radius for each; without it sharp, 0"
    )
    phase_deg: float = Field(
        0.0,
        ge=-360,
        le=360,
        description="turns the section [counter-clockwise](#the-drawings-angle); at 0 a corner of "
        "p3g, p4c and regular points to angle 0",
    )
    taper: float = Field(
        0.0,
        ge=-1,
        le=1,
        description="change of the outer circle's diameter per length along Z; the sizes are those "
        "of the first height [mm/mm]",
    )
    blend_um: float = Field(
        2.0,
        ge=0.01,
        le=1000,
        description="how far the cut may be off the drawing at the joints of its curves",
    )

    _check_z = field_validator("z_mm")(rising)

    @model_validator(mode="before")
    @classmethod
    def _take_size(cls, tree: object) -> object:
        if not isinstance(tree, dict):
            return tree
        form, size = tree.get("form"), tree.get("size_mm")
        if not isinstance(form, str) or form not in _SIZES:
            return tree
        known, keys = _SIZES[form], _SIZED[form]
        if isinstance(size, bool) or not isinstance(size, int | float):
            return tree
        if float(size) not in known:
            sizes = ", ".join(f"{nominal:g}" for nominal in known)
            remedy = f"use one of {sizes}, or give {' and '.join(keys)}"
            problem = f"no nominal size of {form}"
            raise wrong("size", problem, remedy, field="size_mm", value=size)
        given = dict(zip(keys, known[float(size)], strict=True))
        for key in given:
            if key in tree:
                problem = f"contradicts size_mm = {size:g}, which means {given[key]:g}"
                raise wrong("double", problem, "remove one of them", field=key, value=tree[key])
        return {**tree, **given}

    @model_validator(mode="after")
    def _check_radii(self) -> Self:
        radii = self.corner_radius_mm
        if not isinstance(radii, list):
            return self
        context = {"field": "corner_radius_mm", "value": radii}
        if self.form == "regular":
            raise wrong("one", "is a list, a regular polygon has one", "give one radius", **context)
        n = len(self.corners_mm or [])
        if len(radii) != n:
            problem = f"has {len(radii)} entries, corners_mm has {n}"
            raise wrong("length", problem, "give one number, or one for each corner", **context)
        return self

    @property
    def length_mm(self) -> float:
        """Return the length of the polygon [mm]."""
        return self.z_mm[1] - self.z_mm[0]


class PolygonPart(TomlTable):
    """The whole part file of a polygon."""

    part: PartInfo
    polygon: PolygonSection
    process: SectionProcess
    machine: Machine = Field(default_factory=Machine)
    tool: Tool = Field(default_factory=Tool)
    tolerances: FormTolerances = Field(default_factory=FormTolerances)

    @property
    def heights_mm(self) -> tuple[float, float]:
        """Return between which heights the tool follows the polygon, the air included [mm]."""
        low, high = self.polygon.z_mm
        return low - self.process.run_in_mm, high + self.process.run_out_mm

    @property
    def height_mm(self) -> float:
        """Return the length of the tool's path along Z [mm]."""
        low, high = self.heights_mm
        return high - low


def example_polygon() -> PolygonPart:
    """Return a P3G shaft of 25 mm, for examples."""
    return PolygonPart.model_validate(
        {
            "part": {"name": "p3g-25", "kind": "polygon", "source": "DIN 32711, size 25"},
            "polygon": {"form": "p3g", "size_mm": 25, "z_mm": [0, 30]},
            "process": {"spindle_rpm": 600, "feed_mm": 0.2},
            "tool": {"clearance_deg": 15},
            "machine": {"limits": {"u_stroke_mm": 8}},
        }
    )
