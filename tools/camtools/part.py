"""The part file: what a TOML file may say, with units, ranges and defaults.

>>> part = example_part()
>>> part.part.name, part.process.spindle_rpm, part.machine.limits.u_stroke_mm
('example', 2500.0, 1.2)
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal, Self, TypeVar

from pydantic import (
    Field,
    StringConstraints,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)

from camtools.errors import CamtoolsError, InputError
from camtools.input_file import read_limited
from camtools.part_base import HeightMm, Table, as_long, no_truth, rising, wrong
from camtools.part_errors import describe_all
from camtools.part_section import SectionShape

Model = TypeVar("Model", bound=Table)

MAX_FILE_BYTES = 1_000_000
DEFAULT_ALPHA_RAD_S2 = 500.0  # 50 Nm on 0.1 kg m2

DiameterMm = Annotated[float, Field(ge=1, le=4000)]
OvalityMm = Annotated[float, Field(ge=0, le=4000)]
SlopeMmPerMm = Annotated[float, Field(ge=-100, le=100)]
PartName = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,30}\z")]


class PartInfo(Table):
    """[part]: which part this is."""

    name: PartName
    kind: Literal["piston", "cam"]
    source: Annotated[str, StringConstraints(min_length=1, max_length=1000)]


class Profile(Table):
    """[piston.profile]: long-axis diameter over skirt height."""

    height_mm: Annotated[list[HeightMm], Field(min_length=2, max_length=1000)]
    diameter_mm: Annotated[list[DiameterMm], Field(min_length=2, max_length=1000)]
    spline: Literal["clamped", "not-a-knot", "natural"] = "not-a-knot"
    end_slopes: Annotated[list[SlopeMmPerMm], Field(min_length=2, max_length=2)] | None = Field(
        None, validate_default=True
    )

    _check_height = field_validator("height_mm")(rising)
    _check_length = field_validator("diameter_mm")(as_long)

    @field_validator("end_slopes")
    @classmethod
    def _check_slopes(cls, value: list[float] | None, info: ValidationInfo) -> list[float] | None:
        spline = info.data.get("spline")
        if spline == "clamped" and value is None:
            remedy = 'give [lower, upper] slope of the radius in mm/mm, or spline = "not-a-knot"'
            raise wrong("slopes_missing", "a clamped spline needs end slopes", remedy)
        if spline is not None and spline != "clamped" and value is not None:
            problem = f'end slopes have no meaning for spline = "{spline}"'
            raise wrong("slopes_extra", problem, 'remove them, or set spline = "clamped"')
        return value


class Ovality(Table):
    """[piston.ovality]: diametral ovality G = 2a - 2b over height."""

    height_mm: Annotated[list[HeightMm], Field(min_length=2, max_length=1000)]
    ovality_mm: Annotated[list[OvalityMm], Field(min_length=2, max_length=1000)]
    interpolation: Literal["linear", "spline"] = "linear"

    _check_height = field_validator("height_mm")(rising)
    _check_length = field_validator("ovality_mm")(as_long)


class Piston(Table):
    """[piston]: the skirt."""

    profile: Profile
    section: SectionShape = Field(default_factory=SectionShape)
    ovality: Annotated[Ovality | None, Field(validate_default=True)] = None

    @field_validator("ovality")
    @classmethod
    def _check_ovality(cls, value: Ovality | None, info: ValidationInfo) -> Ovality | None:
        section = info.data.get("section")
        is_measured = section is not None and section.shape == "table"
        if value is None and section is not None and not is_measured:
            raise wrong("no_ovality", "is missing", f'add it: shape = "{section.shape}" needs it')
        if value is not None and is_measured:
            problem = 'has no meaning for shape = "table": the points tell it'
            raise wrong("extra_ovality", problem, "remove [piston.ovality]")
        return value

    @model_validator(mode="after")
    def _check_together(self) -> Self:
        if self.ovality is not None:
            _check_cover(self.profile, self.ovality)
            _check_size(self.profile, self.ovality)
            _check_lists(self.section, self.ovality)
        return self


def _check_cover(profile: Profile, ovality: Ovality) -> None:
    first, last = profile.height_mm[0], profile.height_mm[-1]
    if ovality.height_mm[0] > first or ovality.height_mm[-1] < last:
        problem = f"must cover the profile's heights {first} .. {last} mm"
        remedy = "add points of ovality at the ends"
        context = {"field": "ovality.height_mm", "value": ovality.height_mm}
        raise wrong("cover", problem, remedy, **context)


def _check_size(profile: Profile, ovality: Ovality) -> None:
    smallest = min(profile.diameter_mm)
    if max(ovality.ovality_mm) >= smallest:
        problem = f"must be smaller than the smallest diameter, {smallest} mm"
        remedy = "give long minus short axis in mm"
        context = {"field": "ovality.ovality_mm", "value": ovality.ovality_mm}
        raise wrong("ovality", problem, remedy, **context)


def _check_lists(section: SectionShape, ovality: Ovality) -> None:
    """Demand that a list of the section goes with the heights of the ovality."""
    n = len(ovality.height_mm)
    for key in ("trim_mm", "joint_deg", "eccentricity_mm"):
        value = getattr(section, key)
        if isinstance(value, list) and len(value) != n:
            problem = f"has {len(value)} entries, ovality.height_mm has {n}"
            context = {"field": f"section.{key}", "value": value}
            raise wrong("length", problem, "give one number, or one for each height", **context)


class Process(Table):
    """[process]: how the part is cut."""

    spindle_rpm: Annotated[float, Field(ge=1, le=60_000)]
    feed_mm: Annotated[float, Field(ge=0.000_1, le=10)]
    depth_mm: Annotated[float, Field(ge=0, le=100)] = 0.1
    direction: Literal[1, -1] = 1
    mode: Literal["uniform", "equal-volume"] = "uniform"
    parts: Annotated[int, Field(ge=2, le=1000)] = 30
    path: Literal["helix", "ring-helix"] = "helix"
    form_error_um: Annotated[float, Field(ge=0.01, le=1000)] = 5.0

    @field_validator("mode")
    @classmethod
    def _check_mode(cls, value: str, info: ValidationInfo) -> str:
        if value == "equal-volume" and info.data.get("depth_mm") == 0:
            problem = "needs a cutting depth: without it the spindle would have to run infinitely"
            raise wrong("mode", f"{problem} fast at the long axis", "set process.depth_mm above 0")
        return value

    @field_validator("path")
    @classmethod
    def _check_path(cls, value: str, info: ValidationInfo) -> str:
        if value == "ring-helix" and info.data.get("mode") == "equal-volume":
            problem = "is for a constant spindle speed: Z's ramps are made for one"
            raise wrong("path", problem, 'set process.mode = "uniform", or path = "helix"')
        return value

    _check_direction = field_validator("direction", mode="before")(no_truth)


class Limits(Table):
    """[machine.limits]: what the machine can do; feasibility is judged against it."""

    u_stroke_mm: Annotated[float, Field(ge=0.001, le=30)] = 1.2
    u_speed_mm_s: Annotated[float, Field(ge=0.001, le=100_000)] = 400.0
    u_acceleration_mm_s2: Annotated[float, Field(ge=1, le=1_000_000_000)] = 250_000.0
    z_speed_mm_s: Annotated[float, Field(ge=0.1, le=10_000)] = 200.0
    z_acceleration_mm_s2: Annotated[float, Field(ge=10, le=1_000_000)] = 2000.0
    spindle_rpm: Annotated[float, Field(ge=1, le=60_000)] = 3000.0
    tick_hz: Annotated[int, Field(ge=500, le=100_000)] = 20_000
    spindle_torque_nm: Annotated[float, Field(gt=0, le=100_000)] | None = None
    spindle_inertia_kgm2: Annotated[float, Field(gt=0, le=10_000)] | None = None
    spindle_acceleration_rad_s2: Annotated[float, Field(ge=1, le=1_000_000)] | None = None

    @model_validator(mode="after")
    def _check_spindle(self) -> Self:
        pair = (self.spindle_torque_nm, self.spindle_inertia_kgm2)
        is_half, is_double = pair.count(None) == 1, self.spindle_acceleration_rad_s2 is not None
        if is_half or (is_double and None not in pair):
            context = {"field": "spindle_torque_nm", "value": self.spindle_torque_nm}
            remedy = "give torque and inertia, or spindle_acceleration_rad_s2 alone"
            raise wrong("spindle", "does not tell the spindle's acceleration", remedy, **context)
        return self

    @property
    def alpha_rad_s2(self) -> float:
        """Return the spindle's highest acceleration [rad/s2]; 500 where nothing is given."""
        if self.spindle_torque_nm is not None and self.spindle_inertia_kgm2 is not None:
            return self.spindle_torque_nm / self.spindle_inertia_kgm2
        given = self.spindle_acceleration_rad_s2
        return DEFAULT_ALPHA_RAD_S2 if given is None else given


class Machine(Table):
    """[machine]: the machine for which the table is made."""

    limits: Limits = Field(default_factory=Limits)


class Magnify(Table):
    """[magnify]: the papers' demonstration, all deviations enlarged, MATHS.md (7)."""

    factor: Annotated[float, Field(ge=1, le=1000)]


class Part(Table):
    """The whole part file."""

    part: PartInfo
    piston: Piston
    process: Process
    machine: Machine = Field(default_factory=Machine)
    magnify: Magnify | None = None


def read_tree(data: bytes, file: str) -> dict[str, Any]:
    """Return the tables of a TOML file.

    Parameters
    ----------
    data : bytes
        Whole content of the file, UTF-8.
    file : str
        Name for error messages.

    Raises
    ------
    InputError
        Not UTF-8 or not TOML.
    """
    try:
        return tomllib.loads(data.decode("utf-8"))
    except UnicodeDecodeError as error:
        problem = f"not UTF-8 text (byte {error.start} is 0x{data[error.start]:02x})"
        raise InputError(file, "", None, problem, "save the file as UTF-8") from error
    except (tomllib.TOMLDecodeError, RecursionError, ValueError) as error:
        problem = f"not TOML: {error}"
        raise InputError(file, "", None, problem, "correct it; see tools/README.md") from error


def is_cam(tree: dict[str, Any]) -> bool:
    """Tell whether the tables of a part file say that it is a cam."""
    part = tree.get("part")
    return isinstance(part, dict) and part.get("kind") == "cam"


def validated(model: type[Model], tree: dict[str, Any], file: str, folder: Path) -> Model:
    """Return the tables of a part file as a model; see `parse_part`."""
    try:
        return model.model_validate(tree, context={"folder": folder})
    except ValidationError as error:
        raise CamtoolsError(describe_all(file, error)) from error


def parse_part(data: bytes, file: str, folder: Path = Path()) -> Part:
    """Return the piston that the bytes of a TOML file describe.

    Parameters
    ----------
    data : bytes
        Whole content of the file, UTF-8.
    file : str
        Name for error messages.
    folder : Path
        Where files that the part names are looked for.

    Raises
    ------
    CamtoolsError
        Not UTF-8, not TOML, a cam, or fields wrong: one line each, in the file's order of tables.
    """
    tree = read_tree(data, file)
    if is_cam(tree):
        problem, remedy = "cams are for mktables and run", "give the part file of a piston"
        raise InputError(file, "part.kind", "cam", problem, remedy)
    return validated(Part, tree, file, folder)


def read_part_file(path: Path) -> bytes:
    """Return the content of a part file.

    Raises
    ------
    InputError
        It cannot be read, is no file, or is too large.
    """
    try:
        return read_limited(path, MAX_FILE_BYTES)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        remedy = "give the path of a part file (TOML)"
        raise InputError(str(path), "", None, f"cannot be read: {reason}", remedy) from error


def load_part(path: Path) -> Part:
    """Return the piston described by a TOML file.

    Raises
    ------
    CamtoolsError
        The file cannot be read, or see `parse_part`.
    """
    return parse_part(read_part_file(path), str(path), path.parent)


def example_part() -> Part:
    """Return the Perkins-240-like skirt of MATHS.md (6), invented numbers, for examples."""
    return Part.model_validate(
        {
            "part": {"name": "example", "kind": "piston", "source": "MATHS.md (6), invented"},
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
