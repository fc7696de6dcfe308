"""[piston.antithrust] of a part file: the half of the section that differs from the other.

>>> Antithrust(height_mm=[0, 60], drop_mm=[0.01, 0.03]).meet
'short-axis'
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, Tag, ValidationInfo, field_validator, model_validator

from camtools.part.model import LIST_OR_ONE, HeightMm, TomlTable, as_long, rising, wrong
from camtools.skirt.part.profile_keys import USUAL_OVERSHOOT_UM, OvershootUm

_LONG = Field(min_length=2, max_length=1000)
PhaseDeg = Annotated[float, Field(ge=-360, le=360)]
Beta = Annotated[float, Field(ge=-6.25, le=6.25)]
Exponent = Annotated[float, Field(ge=2, le=8)]
DropMm = Annotated[float, Field(ge=-15, le=15)]
OvalityMm = Annotated[float, Field(ge=0, le=4000)]
Phases = Annotated[
    Annotated[list[PhaseDeg], _LONG, Tag("(list)")] | Annotated[PhaseDeg, Tag("(one)")], LIST_OR_ONE
]
Betas = Annotated[
    Annotated[list[Beta], _LONG, Tag("(list)")] | Annotated[Beta, Tag("(one)")], LIST_OR_ONE
]
Exponents = Annotated[
    Annotated[list[Exponent], _LONG, Tag("(list)")] | Annotated[Exponent, Tag("(one)")], LIST_OR_ONE
]

OVALS = ("ellipse", "cosine", "double-ellipse", "power")
"""Shapes with a law of their own on either side."""


class Antithrust(TomlTable):
    """[piston.antithrust]: the other half of an oval, MATHS.md (77), (78).

    The tables profile, ovality and section describe the thrust side, whose middle is at 0 degrees
    where the sides meet at the short axis, at 90 degrees where they meet at the long axis; the
    middle of this side lies opposite.
    """

    meet: Literal["short-axis", "long-axis"] = "short-axis"
    blend_deg: Annotated[float, Field(ge=2, le=120)] = 30.0
    interpolation: Literal["linear", "pchip", "akima", "spline"] = "linear"
    overshoot_um: OvershootUm = USUAL_OVERSHOOT_UM
    height_mm: Annotated[list[HeightMm], _LONG]
    drop_mm: Annotated[list[DropMm], _LONG] | None = None
    ovality_mm: Annotated[list[OvalityMm], _LONG] | None = None
    phase_deg: Phases = 0.0
    beta: Betas | None = None
    exponent: Exponents | None = None

    _check_height = field_validator("height_mm")(rising)

    @field_validator("drop_mm", "ovality_mm", "phase_deg", "beta", "exponent")
    @classmethod
    def _check_length(cls, value: object, info: ValidationInfo) -> object:
        return as_long(value, info) if isinstance(value, list) else value

    @model_validator(mode="after")
    def _check_something(self) -> Self:
        if self.meet == "long-axis" and self.ovality_mm is None:
            context = {"field": "ovality_mm", "value": None}
            problem = (
                'is missing: sides that meet at the long axis differ by it (meet = "long-axis")'
            )
            raise wrong("needed", problem, "add it, one value for each height", **context)
        return self


def check_sides(other: Antithrust, shape: str, ends_mm: tuple[float, float]) -> None:
    """Refuse another side where the section has none, or which does not cover the profile.

    Raises
    ------
    PydanticCustomError
        With field, value and remedy.
    """
    if shape not in OVALS:
        context: dict[str, object] = {"field": "section.shape", "value": shape}
        problem = "has no sides: the table [piston.antithrust] is for ovals"
        raise wrong("sides", problem, f"remove it, or set one of: {', '.join(OVALS)}", **context)
    if other.height_mm[0] > ends_mm[0] or other.height_mm[-1] < ends_mm[1]:
        context = {"field": "antithrust.height_mm", "value": other.height_mm}
        problem = f"must cover the profile's heights {ends_mm[0]} .. {ends_mm[1]} mm"
        raise wrong("cover", problem, "add points at the ends", **context)
    for key, owner in (("beta", "double-ellipse"), ("exponent", "power")):
        if getattr(other, key) is not None and shape != owner:
            context = {"field": f"antithrust.{key}", "value": getattr(other, key)}
            problem = f'has no meaning for shape = "{shape}"'
            raise wrong("foreign", problem, f'remove it, or set shape = "{owner}"', **context)
