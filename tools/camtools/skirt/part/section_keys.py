"""[piston.section] of a part file: the shape of the cross-sections.

>>> SectionShape(shape="ellipse-arc", trim_mm=0.3, joint_deg=50).base
'cosine'
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, StringConstraints, Tag, ValidationInfo, field_validator, model_validator

from camtools.part.model import LIST_OR_ONE, HeightMm, TomlTable, beside_the_part, rising, wrong
from camtools.skirt.part.antithrust_keys import Betas, Exponents, Phases
from camtools.skirt.part.curves import Interpolation

MAX_DELETE = 6

TrimMm = Annotated[float, Field(ge=-100, le=100)]
JointDeg = Annotated[float, Field(ge=10, le=80)]
EccentricityMm = Annotated[float, Field(ge=-1000, le=1000)]
DeleteCount = Annotated[int, Field(ge=0, le=MAX_DELETE)]
_LONG = Field(min_length=2, max_length=1000)
Trims = Annotated[
    Annotated[list[TrimMm], _LONG, Tag("(list)")] | Annotated[TrimMm, Tag("(one)")], LIST_OR_ONE
]
Joints = Annotated[
    Annotated[list[JointDeg], _LONG, Tag("(list)")] | Annotated[JointDeg, Tag("(one)")], LIST_OR_ONE
]
Eccentricities = Annotated[
    Annotated[list[EccentricityMm], _LONG, Tag("(list)")] | Annotated[EccentricityMm, Tag("(one)")],
    LIST_OR_ONE,
]
Delete = Annotated[
    Annotated[list[DeleteCount], Field(min_length=2, max_length=2), Tag("(list)")]
    | Annotated[Literal["optimise"], Tag("(one)")],
    LIST_OR_ONE,
]

_BELONGS_TO = {
    "base": ("ellipse-arc",),
    "trim_mm": ("ellipse-arc",),
    "joint_deg": ("ellipse-arc",),
    "eccentricity_mm": ("ellipse-arc",),
    "refit": ("ellipse-arc",),
    "exponent": ("power",),
    "csv": ("table", "points"),
    "files": ("points",),
    "harmonics": ("table",),
    "interpolation": ("table",),
    "single_height": ("table", "points"),
}
_NEEDED = ("trim_mm", "joint_deg", "exponent")
GIVEN_BY_POINTS = ("table", "points")  # shapes without an ovality of their own


class Refit(TomlTable):
    """[piston.section.refit]: the spline that replaces the corner, MATHS.md (14) .. (16).

    The drawing's contour is sampled once per degree; points next to the joint are left out.
    """

    spline: Literal["cubic", "quintic"] = "quintic"
    delete: Delete = "optimise"
    ends: Literal["mirror", "as-paper"] = "mirror"
    jerk_limit_mm_s3: Annotated[float, Field(gt=0, le=1e15)] | None = None
    deviation_um: Annotated[float, Field(gt=0, le=1000)] | None = None


class PointsAt(TomlTable):
    """[[piston.section.files]]: the points of one height."""

    z_mm: HeightMm
    csv: Annotated[str, StringConstraints(min_length=1, max_length=1000)]

    _beside_the_part = field_validator("csv")(beside_the_part)


class SectionShape(TomlTable):
    """[piston.section]: shape of every cross-section."""

    shape: Literal[
        "ellipse", "cosine", "double-ellipse", "power", "ellipse-arc", "table", "points"
    ] = "ellipse"
    base: Annotated[
        Literal["cosine", "ellipse", "double-ellipse"] | None, Field(validate_default=True)
    ] = None
    beta: Betas = 0.0
    exponent: Annotated[Exponents | None, Field(validate_default=True)] = None
    phase_deg: Phases = 0.0
    trim_mm: Annotated[Trims | None, Field(validate_default=True)] = None
    joint_deg: Annotated[Joints | None, Field(validate_default=True)] = None
    eccentricity_mm: Eccentricities | None = None
    refit: Refit | None = None
    csv: Annotated[
        Annotated[str, StringConstraints(min_length=1, max_length=1000)] | None,
        Field(validate_default=True),
    ] = None
    harmonics: Annotated[int, Field(ge=1, le=500)] | None = None
    files: Annotated[list[PointsAt], Field(min_length=2, max_length=1000)] | None = None
    interpolation: Interpolation | None = None
    single_height: bool | None = None
    overshoot_um: Annotated[float, Field(ge=0, le=1e6)] = 1.0

    @field_validator(*_BELONGS_TO)
    @classmethod
    def _check_key(cls, value: object, info: ValidationInfo) -> object:
        shape, key = info.data.get("shape"), str(info.field_name)
        owners = _BELONGS_TO[key]
        if value is not None and shape is not None and shape not in owners:
            problem = f'{key} has no meaning for shape = "{shape}"'
            raise wrong("foreign", problem, f'remove it, or set shape = "{owners[0]}"')
        if value is None and shape in owners and key in _NEEDED:
            raise wrong("needed", f'is missing for shape = "{shape}"', "add it")
        return value

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
            raise wrong(
                "foreign", problem, "remove it, and set index_offset_udeg of the controller"
            )
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
