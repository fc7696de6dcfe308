"""The part file of a polygon: its section, its length, and how it is turned.

>>> PolygonSection(form="p3g", z_mm=[0, 30], size_mm=25).eccentricity_mm
0.8
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, Tag, ValidationInfo, field_validator, model_validator

from camtools.part.common import MachineLimits, PartInfo
from camtools.part.model import LIST_OR_ONE, HeightMm, TomlTable, no_truth, rising, wrong
from camtools.part.passes import Pass, Passes, check_passes
from camtools.part.tolerances import FormTolerances
from camtools.part.tool import Tool
from camtools.polygon.standard_sizes import P3G, P4C

MAX_SIDES = 16
DiameterMm = Annotated[float, Field(ge=1, le=4000)]
EccentricityMm = Annotated[float, Field(gt=0, le=100)]
CornerMm = Annotated[float, Field(ge=0, le=2000)]
RunMm = Annotated[float, Field(ge=0, le=200)]
PlaceMm = Annotated[float, Field(ge=-2000, le=2000)]
Point = Annotated[list[PlaceMm], Field(min_length=2, max_length=2)]
Corners = Annotated[list[Point], Field(min_length=3, max_length=64)]
CornerRadii = Annotated[
    Annotated[list[CornerMm], Field(min_length=3, max_length=64), Tag("(list)")]
    | Annotated[CornerMm, Tag("(one)")],
    LIST_OR_ONE,
]
_NEEDED = {
    "p3g": ("mean_diameter_mm", "eccentricity_mm"),
    "p4c": ("outer_diameter_mm", "inner_diameter_mm", "eccentricity_mm"),
    "regular": ("sides", "across_flats_mm"),
    "corners": ("corners_mm",),
}
_MAY = {
    "p3g": ("size_mm",),
    "p4c": ("size_mm",),
    "regular": ("corner_radius_mm",),
    "corners": ("corner_radius_mm",),
}
_ALL = sorted({key for keys in (*_NEEDED.values(), *_MAY.values()) for key in keys})


def _of_size(form: str, size_mm: float) -> dict[str, float]:
    """Return the keys that a nominal size of a standard stands for."""
    if form == "p3g":
        mean, eccentricity = P3G[size_mm]
        return {"mean_diameter_mm": mean, "eccentricity_mm": eccentricity}
    outer, inner, eccentricity = P4C[size_mm]
    return {"outer_diameter_mm": outer, "inner_diameter_mm": inner, "eccentricity_mm": eccentricity}


class PolygonSection(TomlTable):
    """[polygon]: the section, and the heights between which it is cut.

    The drawing's angle 0 is the direction of a corner, of `form = "corners"` that of x.
    """

    form: Literal["p3g", "p4c", "regular", "corners"]
    z_mm: Annotated[list[HeightMm], Field(min_length=2, max_length=2)]
    size_mm: float | None = None
    mean_diameter_mm: DiameterMm | None = None
    outer_diameter_mm: DiameterMm | None = None
    inner_diameter_mm: DiameterMm | None = None
    eccentricity_mm: EccentricityMm | None = None
    sides: Annotated[int, Field(ge=3, le=MAX_SIDES)] | None = None
    across_flats_mm: DiameterMm | None = None
    corners_mm: Corners | None = None
    corner_radius_mm: CornerRadii | None = None
    phase_deg: Annotated[float, Field(ge=-360, le=360)] = 0.0
    taper: Annotated[float, Field(ge=-1, le=1)] = 0.0
    blend_um: Annotated[float, Field(ge=0.01, le=1000)] = 2.0

    _check_z = field_validator("z_mm")(rising)

    @model_validator(mode="before")
    @classmethod
    def _take_size(cls, tree: object) -> object:
        if not isinstance(tree, dict):
            return tree
        form, size = tree.get("form"), tree.get("size_mm")
        sizes_of = {"p3g": tuple(P3G), "p4c": tuple(P4C)}
        known = sizes_of.get(form if isinstance(form, str) else "")
        if known is None or isinstance(size, bool) or not isinstance(size, int | float):
            return tree
        if float(size) not in known:
            sizes = ", ".join(f"{one:g}" for one in known)
            remedy = f"use one of {sizes}, or give {' and '.join(_NEEDED[str(form)])}"
            problem = f"no nominal size of {form}"
            raise wrong("size", problem, remedy, field="size_mm", value=size)
        given = _of_size(str(form), float(size))
        for key in given:
            if key in tree:
                problem = f"stands beside size_mm = {size:g}, which says {given[key]:g}"
                raise wrong("double", problem, "remove one of them", field=key, value=tree[key])
        return {**tree, **given}

    @model_validator(mode="after")
    def _check_keys(self) -> Self:
        needed, may = _NEEDED[self.form], _MAY[self.form]
        for key in _ALL:
            value = getattr(self, key)
            if value is None and key in needed:
                remedy = "add it, or size_mm" if "size_mm" in may else "add it"
                problem = f'is missing for form = "{self.form}"'
                raise wrong("needed", problem, remedy, field=key, value=None)
            if value is not None and key not in (*needed, *may):
                problem = f'{key} has no meaning for form = "{self.form}"'
                raise wrong("foreign", problem, "remove it", field=key, value=value)
        return self

    @model_validator(mode="after")
    def _check_radii(self) -> Self:
        radii = self.corner_radius_mm
        if not isinstance(radii, list):
            return self
        n = self.sides if self.form == "regular" else len(self.corners_mm or [])
        context = {"field": "corner_radius_mm", "value": radii}
        if self.form == "regular":
            raise wrong("one", "is a list, a regular polygon has one", "give one radius", **context)
        if len(radii) != n:
            problem = f"has {len(radii)} entries, corners_mm has {n}"
            raise wrong("length", problem, "give one number, or one for each corner", **context)
        return self

    @property
    def length_mm(self) -> float:
        """Return the length of the polygon [mm]."""
        return self.z_mm[1] - self.z_mm[0]


class PolygonProcess(TomlTable):
    """[process]: how the polygon is turned."""

    spindle_rpm: Annotated[float, Field(ge=1, le=60_000)]
    feed_mm: Annotated[float, Field(ge=0.000_1, le=10)]
    depth_mm: Annotated[float, Field(ge=0, le=100)] = 0.1
    direction: Literal[1, -1] = 1
    form_error_um: Annotated[float, Field(ge=0.01, le=1000)] = 5.0
    u_zero: Literal["long-axis", "mean"] = "long-axis"
    run_in_mm: RunMm = 0.0
    run_out_mm: RunMm = 0.0
    passes: Passes = []  # noqa: RUF012 (pydantic copies it)

    @field_validator("passes")
    @classmethod
    def _check_passes(cls, value: list[Pass], info: ValidationInfo) -> list[Pass]:
        check_passes(value, info.data.get("depth_mm", 0.0))
        return value

    _check_direction = field_validator("direction", mode="before")(no_truth)


class PolygonMachine(TomlTable):
    """[machine]: the machine for which the table is made."""

    limits: MachineLimits = Field(default_factory=MachineLimits)


class PolygonPart(TomlTable):
    """The whole part file of a polygon."""

    part: PartInfo
    polygon: PolygonSection
    process: PolygonProcess
    machine: PolygonMachine = Field(default_factory=PolygonMachine)
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
