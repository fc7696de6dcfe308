"""The part file: what a TOML file may say, with units, ranges and defaults.

>>> part = example_part()
>>> part.part.name, part.process.spindle_rpm, part.machine.limits.u_stroke_mm
('example', 2500.0, 1.2)
"""

from __future__ import annotations

import tomllib
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    StringConstraints,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic_core import PydanticCustomError

from camtools.errors import CamtoolsError, InputError
from camtools.part_errors import describe_all

MAX_FILE_BYTES = 1_000_000
MIN_SPAN_MM = 1.0
MIN_STEP_MM = 0.01

HeightMm = Annotated[float, Field(ge=-1000, le=1000)]
DiameterMm = Annotated[float, Field(ge=1, le=4000)]
OvalityMm = Annotated[float, Field(ge=0, le=4000)]
SlopeMmPerMm = Annotated[float, Field(ge=-100, le=100)]
PartName = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,30}\z")]


class _Table(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid", frozen=True, allow_inf_nan=False)


def _wrong(kind: str, problem: str, remedy: str, **context: Any) -> PydanticCustomError:  # noqa: ANN401
    text = problem.replace("{", "(").replace("}", ")")
    return PydanticCustomError(kind, text, {"remedy": remedy, **context})


def _rising(height_mm: list[float]) -> list[float]:
    for lower, upper in pairwise(height_mm):
        if upper - lower < MIN_STEP_MM:
            problem = f"heights must increase by at least {MIN_STEP_MM} mm, but {upper} mm "
            raise _wrong("rising", problem + f"follows {lower} mm", "list the points upwards")
    if height_mm[-1] - height_mm[0] < MIN_SPAN_MM:
        problem = f"the height range must be at least {MIN_SPAN_MM} mm"
        raise _wrong("span", problem, "give heights in mm")
    return height_mm


def _as_long(values: list[float], info: ValidationInfo) -> list[float]:
    height_mm = info.data.get("height_mm")
    if height_mm is not None and len(values) != len(height_mm):
        problem = f"has {len(values)} entries, height_mm has {len(height_mm)}"
        raise _wrong("length", problem, "give one value for each height")
    return values


class PartInfo(_Table):
    """[part]: which part this is."""

    name: PartName
    kind: Literal["piston"]
    source: Annotated[str, StringConstraints(min_length=1, max_length=1000)]


class Profile(_Table):
    """[piston.profile]: long-axis diameter over skirt height."""

    height_mm: Annotated[list[HeightMm], Field(min_length=2, max_length=1000)]
    diameter_mm: Annotated[list[DiameterMm], Field(min_length=2, max_length=1000)]
    spline: Literal["clamped", "not-a-knot", "natural"] = "not-a-knot"
    end_slopes: Annotated[list[SlopeMmPerMm], Field(min_length=2, max_length=2)] | None = Field(
        None, validate_default=True
    )

    _check_height = field_validator("height_mm")(_rising)
    _check_length = field_validator("diameter_mm")(_as_long)

    @field_validator("end_slopes")
    @classmethod
    def _check_slopes(cls, value: list[float] | None, info: ValidationInfo) -> list[float] | None:
        spline = info.data.get("spline")
        if spline == "clamped" and value is None:
            remedy = 'give [lower, upper] slope of the radius in mm/mm, or spline = "not-a-knot"'
            raise _wrong("slopes_missing", "a clamped spline needs end slopes", remedy)
        if spline is not None and spline != "clamped" and value is not None:
            problem = f'end slopes have no meaning for spline = "{spline}"'
            raise _wrong("slopes_extra", problem, 'remove them, or set spline = "clamped"')
        return value


class Ovality(_Table):
    """[piston.ovality]: diametral ovality G = 2a - 2b over height."""

    height_mm: Annotated[list[HeightMm], Field(min_length=2, max_length=1000)]
    ovality_mm: Annotated[list[OvalityMm], Field(min_length=2, max_length=1000)]
    interpolation: Literal["linear", "spline"] = "linear"

    _check_height = field_validator("height_mm")(_rising)
    _check_length = field_validator("ovality_mm")(_as_long)


class SectionShape(_Table):
    """[piston.section]: shape of every cross-section."""

    shape: Literal["ellipse", "cosine", "double-ellipse"] = "ellipse"
    beta: Annotated[float, Field(ge=-6.25, le=6.25)] = 0.0

    @field_validator("beta")
    @classmethod
    def _check_beta(cls, value: float, info: ValidationInfo) -> float:
        shape = info.data.get("shape", "double-ellipse")
        if value != 0 and shape != "double-ellipse":
            problem = f'beta has no meaning for shape = "{shape}"'
            raise _wrong("beta", problem, 'set it to 0, or shape = "double-ellipse"')
        return value


class Piston(_Table):
    """[piston]: the skirt."""

    profile: Profile
    ovality: Ovality
    section: SectionShape = Field(default_factory=SectionShape)

    @model_validator(mode="after")
    def _check_together(self) -> Self:
        profile, ovality = self.profile, self.ovality
        first, last = profile.height_mm[0], profile.height_mm[-1]
        if ovality.height_mm[0] > first or ovality.height_mm[-1] < last:
            problem = f"must cover the profile's heights {first} .. {last} mm"
            remedy = "add points of ovality at the ends"
            context = {"field": "ovality.height_mm", "value": ovality.height_mm}
            raise _wrong("cover", problem, remedy, **context)
        smallest = min(profile.diameter_mm)
        if max(ovality.ovality_mm) >= smallest:
            problem = f"must be smaller than the smallest diameter, {smallest} mm"
            remedy = "give long minus short axis in mm"
            context = {"field": "ovality.ovality_mm", "value": ovality.ovality_mm}
            raise _wrong("ovality", problem, remedy, **context)
        return self


class Process(_Table):
    """[process]: how the part is cut."""

    spindle_rpm: Annotated[float, Field(ge=1, le=60_000)]
    feed_mm: Annotated[float, Field(ge=0.000_1, le=10)]
    depth_mm: Annotated[float, Field(ge=0, le=100)] = 0.1
    direction: Literal[1, -1] = 1

    @field_validator("direction", mode="before")
    @classmethod
    def _check_direction(cls, value: object) -> object:
        if isinstance(value, bool):  # true equals 1 in Python, but not on a drawing
            raise _wrong("direction", "must be 1 or -1", "use one of: 1 or -1")
        return value


class Limits(_Table):
    """[machine.limits]: what the machine can do; feasibility is judged against it."""

    u_stroke_mm: Annotated[float, Field(ge=0.001, le=30)] = 1.2
    u_speed_mm_s: Annotated[float, Field(ge=0.001, le=100_000)] = 400.0
    u_acceleration_mm_s2: Annotated[float, Field(ge=1, le=1_000_000_000)] = 250_000.0
    spindle_rpm: Annotated[float, Field(ge=1, le=60_000)] = 3000.0


class Machine(_Table):
    """[machine]: the machine for which the table is made."""

    limits: Limits = Field(default_factory=Limits)


class Magnify(_Table):
    """[magnify]: the papers' demonstration, all deviations enlarged (maths.md 10.8)."""

    factor: Annotated[float, Field(ge=1, le=1000)]


class Part(_Table):
    """The whole part file."""

    part: PartInfo
    piston: Piston
    process: Process
    machine: Machine = Field(default_factory=Machine)
    magnify: Magnify | None = None


def parse_part(data: bytes, file: str) -> Part:
    """Return the part that the bytes of a TOML file describe.

    Parameters
    ----------
    data : bytes
        Whole content of the file, UTF-8.
    file : str
        Name for error messages.

    Raises
    ------
    CamtoolsError
        Not UTF-8, not TOML, or fields wrong: one line each, in the file's order of tables.
    """
    try:
        tree = tomllib.loads(data.decode("utf-8"))
    except UnicodeDecodeError as error:
        problem = f"not UTF-8 text (byte {error.start} is 0x{data[error.start]:02x})"
        raise InputError(file, "", None, problem, "save the file as UTF-8") from error
    except (tomllib.TOMLDecodeError, RecursionError, ValueError) as error:
        problem = f"not TOML: {error}"
        raise InputError(file, "", None, problem, "correct it; see tools/README.md") from error
    try:
        return Part.model_validate(tree)
    except ValidationError as error:
        raise CamtoolsError(describe_all(file, error)) from error


def load_part(path: Path) -> Part:
    """Return the part described by a TOML file.

    Raises
    ------
    CamtoolsError
        The file cannot be read, or see `parse_part`.
    """
    try:
        with path.open("rb") as stream:
            data = stream.read(MAX_FILE_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        remedy = "give the path of a part file (TOML)"
        raise InputError(str(path), "", None, f"cannot be read: {reason}", remedy) from error
    if len(data) > MAX_FILE_BYTES:
        problem = f"larger than {MAX_FILE_BYTES} bytes"
        raise InputError(str(path), "", None, problem, "give a part file (TOML)")
    return parse_part(data, str(path))


def example_part() -> Part:
    """Return the Perkins-240-like skirt of maths.md 2 (invented numbers), for examples."""
    return Part.model_validate(
        {
            "part": {"name": "example", "kind": "piston", "source": "maths.md 2, invented"},
            "piston": {
                "profile": {
                    "height_mm": [0, 10, 20, 30, 40, 50, 62],
                    "diameter_mm": [91.940, 91.985, 92.0, 91.985, 91.940, 91.866, 91.737],
                    "spline": "clamped",
                    "end_slopes": [0.0029818594, -0.0062619048],
                },
                "ovality": {"height_mm": [0, 20, 62], "ovality_mm": [0.15, 0.20, 0.30]},
            },
            "process": {"spindle_rpm": 2500, "feed_mm": 0.1},
        }
    )
