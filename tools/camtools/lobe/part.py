"""The part file of a camshaft: circles, lobes with their laws, and how they are turned or ground.

>>> LobeProcess(operation="turning", spindle_rpm=60).feed_mm
0.1
"""

from itertools import pairwise
from math import floor
from typing import Annotated, Literal, Self

from pydantic import Field, Tag, ValidationInfo, field_validator, model_validator

from camtools.base.quantities import NM_PER_MM
from camtools.part.common import FeedMm, Machine, PartInfo, Process, SwingLimits, SwungTool
from camtools.part.model import (
    LIST_OR_ONE,
    FilePath,
    HeightMm,
    Only,
    TomlTable,
    beside_the_part,
    rising,
    wrong,
)
from camtools.part.smoothing import SmoothUm

MAX_LIFT_MM = 15.0
MIN_POINTS = 8
MIN_STEP_DEG = 0.01
SAME_DEG = 1e-6  # decimal angles differ by less from what they are written as

RadiusMm = Annotated[float, Field(ge=0.1, le=2000)]
LiftMm = Annotated[float, Field(gt=0, le=MAX_LIFT_MM)]
PointLiftMm = Annotated[float, Field(ge=0, le=MAX_LIFT_MM)]
FlankDeg = Annotated[float, Field(ge=5, le=355)]
PointDeg = Annotated[float, Field(ge=-360, le=720)]


def is_turn(span_deg: float) -> bool:
    """Return whether points of this span end where they began."""
    return abs(span_deg - 360) < SAME_DEG


def is_step(step_deg: float) -> bool:
    """Return whether two angles are far enough apart for a spline."""
    return step_deg >= MIN_STEP_DEG - SAME_DEG


CRANK_HINT = {1: ', or set degrees_of = "crank"', 2: ""}  # by turns of the list's angle
_TURNS = {"cam": 1, "crank": 2}  # of the list's angle for one turn of the cam
_LONG = Field(min_length=MIN_POINTS, max_length=10_000)
Lifts = Annotated[
    Annotated[list[PointLiftMm], _LONG, Tag("(list)")] | Annotated[LiftMm, Tag("(one)")],
    LIST_OR_ONE,
]

RISES = (*("poly345", "cycloidal", "modified-sine", "modified-trapezoid", "harmonic"), "polydyne")
_ANGLES = "of a flank, instead of `half_angle_deg`, 360 together; 0 is the middle of the nose"
_RAMP = "up to this lift the curve opens and closes at most this fast, per degree of the cam"
_FLANK = Only("law", RISES)
_POLYDYNE = Only("law", ("polydyne",), ("polydyne",))
_DISC = Only("law", ("disc",), ("disc",))
_LIST = Only("law", ("list",))


class Lobe(TomlTable):
    """[[cam.lobe]]: upwards, 0.2 mm apart, at most 64 with 42 profiles of 2048 knots per turn.

    Lobes that differ in place and phase alone share a profile. The angle of a law is counted from
    the middle of its nose, from its largest radius (disc) or from the zero of the list, in the
    sense in which the follower runs round the cam.
    """

    z_mm: Annotated[list[HeightMm], Field(min_length=2, max_length=2)] = Field(
        description="from, to, at least 1 mm long; between two lobes the follower goes down to the "
        "base circle"
    )
    phase_deg: float = Field(0.0, ge=-360, le=360, description="drawing's angle of the law's zero")
    law: Literal[
        "cycloidal",
        "modified-sine",
        "modified-trapezoid",
        "harmonic",
        "polydyne",
        "poly345",
        "disc",
        "list",
    ] = Field(description="[flanks](CAMS.md#laws-of-the-flanks), a disc, points")
    lift_mm: Annotated[Lifts | None, Only("law", (*RISES, "list"), RISES)] = Field(
        None, description="of a flank: the lift at the nose; of a list: one per angle"
    )
    rise_deg: Annotated[FlankDeg | None, _FLANK] = Field(None, description=_ANGLES)
    dwell_deg: Annotated[float | None, _FLANK] = Field(
        None, ge=0, le=355, description=f"{_ANGLES}; without it 0"
    )
    fall_deg: Annotated[FlankDeg | None, _FLANK] = Field(None, description=_ANGLES)
    half_angle_deg: Annotated[float | None, _FLANK] = Field(
        None,
        ge=5,
        le=180,
        description="of a flank: from the nose to the base circle, on both sides",
    )
    design_rpm: Annotated[float | None, _POLYDYNE] = Field(
        None, gt=0, le=60_000, description="speed of the cam in the engine"
    )
    natural_hz: Annotated[float | None, _POLYDYNE] = Field(
        None, gt=0, le=100_000, description="natural frequency of the valve train"
    )
    disc_radius_mm: Annotated[RadiusMm | None, _DISC] = Field(
        None, description="less `offset_mm` the base circle's radius"
    )
    offset_mm: Annotated[LiftMm | None, _DISC] = Field(
        None, description="of the centre of the disc"
    )
    degrees_of: Annotated[Literal["cam", "crank"], _LIST] = Field(
        "cam",
        validate_default=False,
        description="the angles are degrees of the cam, or of the crank, which turns twice as far",
    )
    angle_deg: Annotated[Annotated[list[PointDeg], _LONG] | None, _LIST] = Field(
        None,
        description="rising angles of one turn, its end repeated or at least 0.01 degrees away; "
        "[periodic quintic spline](CAMS.md#tables-of-rounded-lifts), refused if it leaves 0 .. the "
        "largest lift by more than 1 um",
    )
    csv: Annotated[FilePath | None, _LIST] = Field(
        None,
        description="path relative to the part file: up to 100 000 lines of `angle_deg,lift_mm` "
        "instead, or [points of another system](TABLES.md#export-and-import)",
    )
    lift_unit: Annotated[Literal["mm", "inch"], _LIST] = Field(
        "mm", validate_default=False, description="of the lifts of a csv whose header names none"
    )
    largest_lift_mm: Annotated[LiftMm | None, _LIST] = Field(
        None, description="the lifts of the csv are shares 0 .. 1 of it"
    )
    counts_per_mm: Annotated[float | None, _LIST] = Field(
        None, ge=1e-3, le=1e9, description="the lifts of the csv are counts of an encoder"
    )
    counts_per_turn: Annotated[float | None, _LIST] = Field(
        None,
        ge=1,
        le=1e9,
        description="the angles of the csv are counts of an encoder: of cam or crank, `degrees_of`",
    )
    smooth_um: Annotated[SmoothUm | None, _LIST] = Field(
        None,
        description="the smoothest curve within this of every point; points of zero lift stay 0",
    )
    ramp_height_mm: Annotated[LiftMm | None, _LIST] = Field(None, description=_RAMP)
    ramp_um_per_deg: Annotated[float | None, _LIST] = Field(
        None, ge=0.1, le=1000, description=_RAMP
    )

    _check_z = field_validator("z_mm")(rising)

    @field_validator("half_angle_deg")
    @classmethod
    def _check_half(cls, value: float | None, info: ValidationInfo) -> float | None:
        law = info.data.get("law")
        is_given = value or info.data.get("rise_deg") or info.data.get("fall_deg")
        if law in RISES and not is_given:
            raise wrong("needed", f'is missing for law = "{law}"', "add it")
        return value

    @field_validator("lift_mm")
    @classmethod
    def _check_lift(cls, value: object, info: ValidationInfo) -> object:
        law = info.data.get("law")
        if law in RISES and isinstance(value, list):
            raise wrong("one", f'is a list, law = "{law}" has one lift', "give the largest lift")
        if law == "list" and isinstance(value, float):
            raise wrong("many", 'is one number, law = "list" needs one per angle', "give a list")
        return value

    @field_validator("angle_deg")
    @classmethod
    def _check_angles(cls, value: list[float] | None, info: ValidationInfo) -> list[float] | None:
        turns = _TURNS.get(info.data.get("degrees_of", "cam"), 1)
        for before, behind in pairwise(value or []):
            if not is_step((behind - before) / turns):
                least_deg = turns * MIN_STEP_DEG
                problem = f"angles must rise by at least {least_deg} degrees, but {behind:g} "
                raise wrong("rising", problem + f"follows {before:g}", "sort the points")
        span = value[-1] - value[0] if value else 360.0 * turns
        if not is_turn(span / turns) and not is_step(360 - span / turns):
            problem = (
                f"the points span {span:.9g} degrees, neither a turn of the cam ({360 * turns}) "
                f"nor {turns * MIN_STEP_DEG} degrees less"
            )
            hint = CRANK_HINT[turns] if span > 360 * turns else ""
            raise wrong("turn", problem, f"list one turn{hint}")
        return value

    _beside_the_part = field_validator("csv")(beside_the_part)

    @model_validator(mode="after")
    def _check_flanks(self) -> Self:
        flanks = {"rise_deg": self.rise_deg, "fall_deg": self.fall_deg}
        given = [name for name, value in flanks.items() if value is not None]
        if self.half_angle_deg is not None and (given or self.dwell_deg is not None):
            problem = "cannot be combined with rise_deg, dwell_deg or fall_deg"
            context = {"field": "half_angle_deg", "value": self.half_angle_deg}
            raise wrong("flanks", problem, "give either of them", **context)
        if len(given) == 1:
            [name] = flanks.keys() - given
            problem = f"is missing, but {given[0]} needs it"
            raise wrong("fall", problem, "add it", field=name, value=None)
        if given and sum(self.angles_deg) > 360 + SAME_DEG:
            problem = f"rise, dwell and fall take {sum(self.angles_deg):g} degrees"
            context = {"field": "rise_deg", "value": self.rise_deg}
            raise wrong("turn", problem, "give 360 degrees at most", **context)
        return self

    @property
    def angles_deg(self) -> tuple[float, float, float]:
        """Return the angles of rise, dwell at the nose, and fall."""
        if self.half_angle_deg is not None:
            return self.half_angle_deg, 0.0, self.half_angle_deg
        return self.rise_deg or 0.0, self.dwell_deg or 0.0, self.fall_deg or 0.0

    @model_validator(mode="after")
    def _check_points(self) -> Self:
        if self.law != "list":
            return self
        is_listed = self.lift_mm is not None or self.angle_deg is not None
        if is_listed == (self.csv is not None):
            problem = 'law = "list" needs either angle_deg and lift_mm, or csv'
            raise wrong("points", problem, "give one of them", field="csv", value=self.csv)
        self._check_units()
        if not is_listed:
            return self
        if not isinstance(self.lift_mm, list) or self.angle_deg is None:
            problem = "angle_deg and lift_mm belong together"
            raise wrong("half", problem, "give both", value=None)
        if len(self.lift_mm) != len(self.angle_deg):
            problem = f"has {len(self.lift_mm)} entries, angle_deg has {len(self.angle_deg)}"
            context = {"field": "lift_mm", "value": self.lift_mm}
            raise wrong("length", problem, "give one value for each angle", **context)
        return self

    def _check_units(self) -> None:
        """Refuse units of a file where there is none or where they disagree, and half a ramp."""
        of_lift = {"lift_unit", "largest_lift_mm", "counts_per_mm"} & self.model_fields_set
        given = of_lift | ({"counts_per_turn"} & self.model_fields_set)
        if given and self.csv is None:
            field = max(given)
            problem = "is for a csv, the lists of the part file are degrees and mm"
            remedy = "remove it, or move the points into a csv"
            raise wrong("unit", problem, remedy, field=field, value=getattr(self, field))
        if len(of_lift) > 1:
            field, other = sorted(of_lift, reverse=True)[:2]
            problem = f"says what the lifts of the csv are, and so does {other}"
            raise wrong("unit", problem, "keep one", field=field, value=getattr(self, field))
        if (self.ramp_height_mm is None) != (self.ramp_um_per_deg is None):
            missing = "ramp_height_mm" if self.ramp_height_mm is None else "ramp_um_per_deg"
            problem = "is missing, the other key of the ramp needs it"
            raise wrong("ramp", problem, "add it", field=missing, value=None)

    @property
    def turns_listed(self) -> int:
        """Return the turns of the list's angle for one turn of the cam."""
        return _TURNS[self.degrees_of]

    @property
    def largest_mm(self) -> float:
        """Return the largest lift; of a CSV file, which is read later, the largest there may be."""
        if self.law == "disc":
            return 2 * (self.offset_mm or 0.0)
        if self.csv is not None or self.lift_mm is None:
            return MAX_LIFT_MM
        return max(self.lift_mm) if isinstance(self.lift_mm, list) else self.lift_mm


MIN_GAP_MM = 0.2
MAX_LOBES = 64  # of a part file; fewer where the bytes of a channel do not last
MAX_CENTRE_MM = 2000.0  # places in a table: firmware/table/cam_table.c, max_height_nm
MIN_RPM, MAX_RPM = 1.0, 60_000.0
_PLUNGE = "plunge grinding, needed there"


class Camshaft(TomlTable):
    """[cam]: the shaft's base circle, the follower, the wheel, and the lobes."""

    base_radius_mm: RadiusMm = Field(
        description="r; r + r1 (ground: r + Rw) + the largest lift up to 2000 mm"
    )
    roller_radius_mm: RadiusMm = Field(description="r1")
    wheel_radius_mm: RadiusMm | None = Field(None, description="Rw; needed for grinding")
    wheel_width_mm: float | None = Field(
        None, ge=0.1, le=500, description="of plunge grinding, needed there"
    )
    follower: Literal["roller", "flat"] = Field(
        "roller",
        description="whose lift the laws give ([flat faces](CAMS.md#laws-of-the-flanks)); with "
        '`"flat"` r1 is the radius of the circle on which the tip of a swung tool runs',
    )
    lobe: Annotated[list[Lobe], Field(min_length=1)]

    @field_validator("lobe")
    @classmethod
    def _check_number(cls, value: list[Lobe]) -> list[Lobe]:
        if len(value) > MAX_LOBES:
            problem = f"has {len(value)} lobes, a part file at most {MAX_LOBES}"
            raise wrong("lobes", problem, "make tables of fewer lobes each", value=None)
        return value

    @field_validator("lobe")
    @classmethod
    def _check_places(cls, value: list[Lobe]) -> list[Lobe]:
        for i, (lower, upper) in enumerate(pairwise(value), start=1):
            gap_nm = round(upper.z_mm[0] * NM_PER_MM) - round(lower.z_mm[1] * NM_PER_MM)
            if gap_nm < round(MIN_GAP_MM * NM_PER_MM):
                problem = (
                    f"a lobe from {upper.z_mm[0]:g} mm follows one that ends at "
                    f"{lower.z_mm[1]:g} mm: the gap must be at least {MIN_GAP_MM} mm"
                )
                remedy = "list the lobes upwards, apart from each other"
                raise wrong("gap", problem, remedy, field=f"{i}.z_mm", value=upper.z_mm)
        return value

    @field_validator("lobe")
    @classmethod
    def _check_discs(cls, value: list[Lobe], info: ValidationInfo) -> list[Lobe]:
        base_mm = info.data.get("base_radius_mm")
        for i, lobe in enumerate(value):
            if base_mm is None or lobe.disc_radius_mm is None or lobe.offset_mm is None:
                continue
            least_mm = lobe.disc_radius_mm - lobe.offset_mm
            if abs(least_mm - base_mm) > 1e-6:
                problem = (
                    f"disc_radius_mm - offset_mm is {least_mm:g} mm, but base_radius_mm is "
                    f"{base_mm:g} mm"
                )
                context = {"field": f"{i}.disc_radius_mm", "value": lobe.disc_radius_mm}
                raise wrong("disc", problem, "make them equal", **context)
        return value


class LobeProcess(Process):
    """[process]: turned with a swinging tool, or ground by a wheel."""

    feed_mm: FeedMm = Field(0.1, description="per turn; not of plunge grinding")
    depth_mm: float = Field(0.1, ge=0, le=100, description="cutting depth; not of plunge grinding")
    operation: Literal["turning", "grinding", "plunge-grinding"]
    speed: Literal["uniform", "constant-surface"] = "uniform"
    infeed_um: float | None = Field(None, ge=0.1, le=1000, description=f"{_PLUNGE}: of X per turn")
    stock_um: float | None = Field(None, ge=1, le=10_000, description=f"{_PLUNGE}: on the radius")
    spark_out_turns: int = Field(3, ge=0, le=100, description="plunge grinding: without infeed")
    wheel_wear_um_per_lobe: float = Field(
        0.0, ge=0, le=1000, description="plunge grinding: radius that the wheel loses by each lobe"
    )
    form_error_um: float = Field(
        1.0,
        ge=0.01,
        le=1000,
        description="accepted form error of the cut against the drawing, along the normals of the "
        "profile",
    )

    @property
    def is_plunge(self) -> bool:
        """Return whether the wheel stands in each lobe while X feeds in."""
        return self.operation == "plunge-grinding"

    @model_validator(mode="after")
    def _check_plunge(self) -> Self:
        needed = ("infeed_um", "stock_um")
        own = (*needed, "spark_out_turns", "wheel_wear_um_per_lobe")
        foreign = ("feed_mm", "depth_mm") if self.is_plunge else own
        for name in foreign:
            if name in self.model_fields_set:
                context = {"field": name, "value": getattr(self, name)}
                problem = f'has no meaning for operation = "{self.operation}"'
                raise wrong("plunge", problem, "remove it", **context)
        for name in needed:
            if self.is_plunge and getattr(self, name) is None:
                problem = 'is missing for operation = "plunge-grinding"'
                raise wrong("plunge", problem, "add it", field=name, value=None)
        if self.is_plunge and self.speed != "uniform":
            problem = "a plunge cut is ground at uniform speed"
            raise wrong("plunge", problem, 'set "uniform"', field="speed", value=self.speed)
        return self


class LobeMachine(Machine):
    """[machine]: the machine for which the table is made."""

    limits: SwingLimits = Field(default_factory=SwingLimits)


class LobePart(TomlTable):
    """The whole part file of a camshaft."""

    part: PartInfo
    cam: Camshaft
    process: LobeProcess
    machine: LobeMachine = Field(default_factory=LobeMachine)
    tool: SwungTool = Field(default_factory=SwungTool)

    @model_validator(mode="after")
    def _check_tool(self) -> Self:
        if "tool" in self.model_fields_set and self.process.operation != "turning":
            problem = f'has no meaning for operation = "{self.process.operation}"'
            raise wrong("tool", problem, "remove it, or turn the part", field="tool", value=None)
        return self

    @model_validator(mode="after")
    def _check_wheel(self) -> Self:
        width_mm, process = self.cam.wheel_width_mm, self.process
        of = f'for operation = "{process.operation}"'
        if process.operation != "turning" and self.cam.wheel_radius_mm is None:
            field = "cam.wheel_radius_mm"
            raise wrong("wheel", f"is missing {of}", "add it", field=field, value=None)
        if process.is_plunge != (width_mm is not None):
            problem = "is missing" if process.is_plunge else "has no meaning"
            remedy, field = "add it" if process.is_plunge else "remove it", "cam.wheel_width_mm"
            raise wrong("wheel", f"{problem} {of}", remedy, field=field, value=width_mm)
        return self

    @model_validator(mode="after")
    def _check_centre(self) -> Self:
        key = "roller_radius_mm" if self.process.operation == "turning" else "wheel_radius_mm"
        rest_mm = self.cam.base_radius_mm + max(lobe.largest_mm for lobe in self.cam.lobe)
        if rest_mm + self.follower_radius_mm > MAX_CENTRE_MM + 1e-9:  # of a nanometre at most
            problem = (
                f"with base_radius_mm and the largest lift it is "
                f"{rest_mm + self.follower_radius_mm:.7g} mm, a table holds {MAX_CENTRE_MM:g} mm"
            )
            context = {"field": f"cam.{key}", "value": self.follower_radius_mm}
            most_mm = floor((MAX_CENTRE_MM - rest_mm) * 1000) / 1000
            remedy = f"give at most {most_mm:.7g}, or a smaller base circle"
            raise wrong("centre", problem, remedy, **context)
        return self

    @property
    def height_mm(self) -> float:
        """Return the height from the first lobe to the last [mm]."""
        return self.cam.lobe[-1].z_mm[1] - self.cam.lobe[0].z_mm[0]

    @property
    def follower_radius_mm(self) -> float:
        """Return the radius of what touches the lobe: the wheel, or for turning the roller."""
        if self.process.operation == "turning":
            return self.cam.roller_radius_mm
        assert self.cam.wheel_radius_mm is not None
        return self.cam.wheel_radius_mm
