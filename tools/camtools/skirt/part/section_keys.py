"""[piston.section] and [piston.antithrust] of a part file: the shape of the cross-sections.

>>> SectionShape(shape="ellipse-arc", trim_mm=0.3, joint_deg=50).base
'cosine'
>>> Antithrust(height_mm=[0, 60], drop_mm=[0.01, 0.03]).meet
'short-axis'
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, Tag, ValidationInfo, field_validator, model_validator

from camtools.part.model import (
    LIST_OR_ONE,
    FilePath,
    HeightMm,
    NumberOrPoints,
    Only,
    Points,
    TomlTable,
    as_long,
    beside_the_part,
    rising,
    wrong,
)
from camtools.skirt.part.curves import Interpolation
from camtools.skirt.part.profile_keys import USUAL_OVERSHOOT_UM, OvalityMm, OvershootUm

MAX_DELETE = 6

DeleteCount = Annotated[int, Field(ge=0, le=MAX_DELETE)]
DropMm = Annotated[float, Field(ge=-15, le=15)]
Phases = NumberOrPoints[Annotated[float, Field(ge=-360, le=360)]]
Betas = NumberOrPoints[Annotated[float, Field(ge=-6.25, le=6.25)]]
Exponents = NumberOrPoints[Annotated[float, Field(ge=2, le=8)]]
Trims = NumberOrPoints[Annotated[float, Field(ge=-100, le=100)]]
Joints = NumberOrPoints[Annotated[float, Field(ge=10, le=80)]]
Eccentricities = NumberOrPoints[Annotated[float, Field(ge=-1000, le=1000)]]
Delete = Annotated[
    Annotated[list[DeleteCount], Field(min_length=2, max_length=2), Tag("(list)")]
    | Annotated[Literal["optimise"], Tag("(one)")],
    LIST_OR_ONE,
]

GIVEN_BY_POINTS = ("table", "points")  # shapes without an ovality of their own
OVALS = ("ellipse", "cosine", "double-ellipse", "power")  # with a law of their own on either side
PARAMETERS = {"double-ellipse": "beta", "power": "exponent"}  # key of a law; others have none
_AS_SECTION = "as of the section; without it that of the section"
_POWER = Only("shape", ("power",), ("power",))
_ARC = Only("shape", ("ellipse-arc",))
_NEEDED_ARC = Only("shape", ("ellipse-arc",), ("ellipse-arc",))
_MEASURED = Only("shape", GIVEN_BY_POINTS)
_TABLE = Only("shape", ("table",))


class Refit(TomlTable):
    """[piston.section.refit]: replaces the corner, for a table; an analysis does without.

    MATHS.md (14) .. (16). The drawing's contour is sampled once per degree; points next to the
    joint are left out.
    """

    spline: Literal["cubic", "quintic"] = Field("quintic", description="through a point per degree")
    delete: Delete = Field(
        "optimise", description="points left out on the side of the oval and of the circle"
    )
    ends: Literal["mirror", "as-paper"] = "mirror"
    jerk_limit_mm_s3: float | None = Field(
        None,
        gt=0,
        le=1e15,
        description="of the jerk beyond the corner, for `optimise`; without it none, as-paper 1e7",
    )
    deviation_um: float | None = Field(
        None,
        gt=0,
        le=1000,
        description="largest deviation of the refit from the drawing, beyond which the part is "
        "refused with the nearest deletion; without it three quarters of `form_error_um`",
    )


class PointsAt(TomlTable):
    """[[piston.section.files]]: points: a file per height, rising."""

    z_mm: HeightMm
    csv: FilePath = Field(description="path relative to the part file")

    _beside_the_part = field_validator("csv")(beside_the_part)


class SectionShape(TomlTable):
    """[piston.section]: shape of every cross-section."""

    shape: Literal[
        "ellipse", "cosine", "double-ellipse", "power", "ellipse-arc", "table", "points"
    ] = Field(
        "ellipse",
        description="exact; (G/4)(1 - cos 2phi); fourth harmonic; power of the sine; oval and "
        "eccentric circle; measured; [imported](TABLES.md#export-and-import)",
    )
    base: Annotated[Literal["cosine", "ellipse", "double-ellipse"] | None, _ARC] = Field(
        None, description="the oval; without it cosine"
    )
    beta: Betas = Field(
        0.0,
        description="of double-ellipse, per height of the ovality: weight of the fourth harmonic, "
        "G beta / 50 more at 45 degrees",
    )
    exponent: Annotated[Exponents | None, _POWER] = Field(
        None,
        description="per height of the ovality: (G/2) |sin phi|^exponent; 2 is the cosine form",
    )
    phase_deg: Phases = Field(
        0.0,
        description="of an oval per height of the ovality: rotation of the whole section; not for "
        "ellipse-arc",
    )
    trim_mm: Annotated[Trims | None, _NEEDED_ARC] = Field(
        None, description="per height of the ovality: radial, below the oval at the short axis"
    )
    joint_deg: Annotated[Joints | None, _NEEDED_ARC] = Field(
        None, description="per height of the ovality: where the circle begins"
    )
    eccentricity_mm: Annotated[Eccentricities | None, _ARC] = Field(
        None, description="per height of the ovality: only checked, to 1 um at the joint"
    )
    refit: Annotated[Refit | None, _ARC] = None
    csv: Annotated[FilePath | None, _MEASURED] = Field(
        None,
        description="path relative to the part file: `angle_deg,z_mm,reduction_um`, or [other "
        "units and separators](PISTONS.md#measured-sections-scan-and-replay); of points [any "
        "columns](TABLES.md#export-and-import)",
    )
    harmonics: Annotated[int | None, _TABLE] = Field(
        None, ge=1, le=500, description="keeps waves up to this number per turn"
    )
    files: Annotated[
        Annotated[list[PointsAt], Field(min_length=2, max_length=1000)] | None,
        Only("shape", ("points",)),
    ] = None
    interpolation: Annotated[Interpolation | None, _TABLE] = Field(
        None, description="between the heights; without it spline from 4 heights up, else linear"
    )
    single_height: Annotated[bool | None, _MEASURED] = Field(
        None, description="the file has one height, which serves all"
    )
    overshoot_um: OvershootUm = Field(
        USUAL_OVERSHOOT_UM,
        description="of a table: beyond the neighbouring points, over height and over gaps in the "
        "angle",
    )

    @field_validator("base")
    @classmethod
    def _default_base(cls, value: str | None, info: ValidationInfo) -> str | None:
        return "cosine" if value is None and info.data.get("shape") == "ellipse-arc" else value

    @field_validator("beta")
    @classmethod
    def _check_beta(cls, value: float | list[float], info: ValidationInfo) -> float | list[float]:
        shape = info.data.get("shape", "double-ellipse")
        if isinstance(value, list) and shape == "ellipse-arc":
            problem = 'is a list, shape = "ellipse-arc" takes one number'
            raise wrong("one", problem, "give the beta of all heights")
        if value != 0 and "double-ellipse" not in (shape, info.data.get("base")):
            problem = f'beta has no meaning for shape = "{shape}"'
            raise wrong("beta", problem, 'set it to 0, or shape = "double-ellipse"')
        return value

    @field_validator("phase_deg")
    @classmethod
    def _check_phase(cls, value: float | list[float], info: ValidationInfo) -> float | list[float]:
        shape = info.data.get("shape")
        if value != 0 and shape == "ellipse-arc":
            problem = 'phase_deg has no meaning for shape = "ellipse-arc"'
            remedy = "remove it, and set index_offset_udeg of the controller"
            raise wrong("foreign", problem, remedy)
        if isinstance(value, list) and shape in GIVEN_BY_POINTS:
            problem = f'is a list, shape = "{shape}" has no heights of ovality'
            raise wrong("one", problem, "give one number")
        return value

    @field_validator("files")
    @classmethod
    def _check_files(cls, value: list[PointsAt] | None) -> list[PointsAt] | None:
        rising([one.z_mm for one in value or []] or [0.0, 1.0])
        return value

    @model_validator(mode="after")
    def _check_source(self) -> Self:
        if self.shape == "table" and self.csv is None:
            problem = 'is missing for shape = "table"'
            raise wrong("needed", problem, "add it", field="csv", value=None)
        if self.shape == "points" and (self.csv is None) == (self.files is None):
            problem = 'shape = "points" needs either csv or [[piston.section.files]]'
            raise wrong("points", problem, "give one of them", field="csv", value=self.csv)
        return self

    _beside_the_part = field_validator("csv")(beside_the_part)


class Antithrust(TomlTable):
    """[piston.antithrust]: the [other half](PISTONS.md#thrust-and-anti-thrust-sides) of an oval.

    MATHS.md (77), (78). The tables profile, ovality and section describe the thrust side, whose
    middle is at 0 degrees where the sides meet at the short axis, at 90 degrees where they meet at
    the long axis; the middle of this side is opposite.
    """

    meet: Literal["short-axis", "long-axis"] = Field(
        "short-axis",
        description="where the sides meet: this side is the half about 180 degrees, or about 270",
    )
    blend_deg: float = Field(30.0, ge=2, le=120, description="width of the two transition zones")
    interpolation: Interpolation = Field("linear", description="of the lists of this side")
    overshoot_um: OvershootUm = Field(
        USUAL_OVERSHOOT_UM, description="as of the profile, for `drop_mm` and `ovality_mm`"
    )
    height_mm: Points[HeightMm] = Field(
        description="rising, covers the profile's range; heights of the lists of this side"
    )
    drop_mm: Points[DropMm] | None = Field(
        None,
        description="per height: its radius at the long axis is less than the profile's by this; "
        "without it 0",
    )
    ovality_mm: Points[OvalityMm] | None = Field(
        None,
        description="per height: long minus short axis of this side (diametral); without it the "
        'short axis is common; needed with `meet = "long-axis"`',
    )
    phase_deg: Phases = Field(0.0, description="rotation of this side alone")
    beta: Betas | None = Field(None, description=_AS_SECTION)
    exponent: Exponents | None = Field(None, description=_AS_SECTION)

    _check_height = field_validator("height_mm")(rising)

    @field_validator("drop_mm", "ovality_mm", "phase_deg", "beta", "exponent")
    @classmethod
    def _check_length(cls, value: object, info: ValidationInfo) -> object:
        return as_long(value, info) if isinstance(value, list) else value

    @model_validator(mode="after")
    def _check_something(self) -> Self:
        if self.meet == "long-axis" and self.ovality_mm is None:
            context = {"field": "ovality_mm", "value": None}
            problem = "is missing: sides that meet at the long axis differ by it"
            problem += ' (meet = "long-axis")'
            raise wrong("needed", problem, "add it, one value for each height", **context)
        return self


def check_sides(other: Antithrust, shape: str, ends_mm: tuple[float, float]) -> None:
    """Refuse another side where the section has none, or which does not cover the profile."""
    if shape not in OVALS:
        context: dict[str, object] = {"field": "section.shape", "value": shape}
        problem = "has no sides: the table [piston.antithrust] is for ovals"
        raise wrong("sides", problem, f"remove it, or set one of: {', '.join(OVALS)}", **context)
    if other.height_mm[0] > ends_mm[0] or other.height_mm[-1] < ends_mm[1]:
        context = {"field": "antithrust.height_mm", "value": other.height_mm}
        problem = f"must cover the profile's heights {ends_mm[0]} .. {ends_mm[1]} mm"
        raise wrong("cover", problem, "add points at the ends", **context)
    for owner, key in PARAMETERS.items():
        if getattr(other, key) is not None and shape != owner:
            context = {"field": f"antithrust.{key}", "value": getattr(other, key)}
            problem = f'has no meaning for shape = "{shape}"'
            raise wrong("foreign", problem, f'remove it, or set shape = "{owner}"', **context)
