# SPDX-License-Identifier: Apache-2.0
"""The keys of a lobe in a part file: where it sits on the shaft, and its law of lift.

>>> lobe = Lobe(z_mm=[0, 12], law="poly345", lift_mm=8, half_angle_deg=70)
>>> lobe.phase_deg, lobe.law
(0.0, 'poly345')
"""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, StringConstraints, Tag, ValidationInfo, field_validator, model_validator

from camtools.part.model import LIST_OR_ONE, HeightMm, TomlTable, beside_the_part, rising, wrong
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


def fits_turn(span_deg: float) -> bool:
    """Return whether points of this span close a turn, or leave a step of it."""
    return is_turn(span_deg) or is_step(360 - span_deg)


CRANK_HINT = {1: ', or set degrees_of = "crank"', 2: ""}  # by turns of the list's angle
_TURNS = {"cam": 1, "crank": 2}  # of the list's angle for one turn of the cam
_LONG = Field(min_length=MIN_POINTS, max_length=10_000)
Lifts = Annotated[
    Annotated[list[PointLiftMm], _LONG, Tag("(list)")] | Annotated[LiftMm, Tag("(one)")],
    LIST_OR_ONE,
]

RISES = (*("poly345", "cycloidal", "modified-sine", "modified-trapezoid", "harmonic"), "polydyne")
_BELONGS_TO = {
    "lift_mm": (*RISES, "list"),
    **dict.fromkeys(("rise_deg", "dwell_deg", "fall_deg", "half_angle_deg"), RISES),
    **dict.fromkeys(("design_rpm", "natural_hz"), ("polydyne",)),
    "disc_radius_mm": ("disc",),
    "offset_mm": ("disc",),
    "angle_deg": ("list",),
    "csv": ("list",),
    **dict.fromkeys(("degrees_of", "lift_unit", "largest_lift_mm"), ("list",)),
    **dict.fromkeys(("smooth_um", "ramp_height_mm", "ramp_um_per_deg"), ("list",)),
}
_NEEDED = dict.fromkeys(RISES, ("lift_mm", "half_angle_deg")) | {
    "polydyne": ("lift_mm", "half_angle_deg", "design_rpm", "natural_hz"),
    "disc": ("disc_radius_mm", "offset_mm"),
}


class Lobe(TomlTable):
    """[[cam.lobe]]: one lobe, where it sits on the shaft, and its law of lift.

    The angle of a law is counted from the middle of its nose, from its largest radius (disc) or
    from the zero of the list, in the sense in which the follower runs round the cam.
    """

    z_mm: Annotated[list[HeightMm], Field(min_length=2, max_length=2)]
    phase_deg: Annotated[float, Field(ge=-360, le=360)] = 0.0
    law: Literal[
        "cycloidal",
        "modified-sine",
        "modified-trapezoid",
        "harmonic",
        "polydyne",
        "poly345",
        "disc",
        "list",
    ]
    lift_mm: Annotated[Lifts | None, Field(validate_default=True)] = None
    rise_deg: FlankDeg | None = None
    dwell_deg: Annotated[float, Field(ge=0, le=355)] | None = None
    fall_deg: FlankDeg | None = None
    half_angle_deg: Annotated[
        Annotated[float, Field(ge=5, le=180)] | None, Field(validate_default=True)
    ] = None
    design_rpm: Annotated[
        Annotated[float, Field(gt=0, le=60_000)] | None, Field(validate_default=True)
    ] = None
    natural_hz: Annotated[
        Annotated[float, Field(gt=0, le=100_000)] | None, Field(validate_default=True)
    ] = None
    disc_radius_mm: Annotated[RadiusMm | None, Field(validate_default=True)] = None
    offset_mm: Annotated[LiftMm | None, Field(validate_default=True)] = None
    degrees_of: Literal["cam", "crank"] = "cam"
    angle_deg: Annotated[list[PointDeg] | None, _LONG] = None
    csv: Annotated[str, StringConstraints(min_length=1, max_length=1000)] | None = None
    lift_unit: Literal["mm", "inch"] = "mm"
    largest_lift_mm: LiftMm | None = None
    smooth_um: SmoothUm | None = None
    ramp_height_mm: LiftMm | None = None
    ramp_um_per_deg: Annotated[float, Field(ge=0.1, le=1000)] | None = None

    _check_z = field_validator("z_mm")(rising)

    @field_validator(*_BELONGS_TO)
    @classmethod
    def _check_key(cls, value: object, info: ValidationInfo) -> object:
        law, key = info.data.get("law"), str(info.field_name)
        owners = _BELONGS_TO[key]
        if law is None:
            return value
        if value is not None and law not in owners:
            problem = f'{key} has no meaning for law = "{law}"'
            raise wrong("foreign", problem, f'remove it, or set law = "{owners[0]}"')
        if key == "half_angle_deg" and (info.data.get("rise_deg") or info.data.get("fall_deg")):
            return value
        if value is None and key in _NEEDED.get(law, ()):
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
        if value and not fits_turn((value[-1] - value[0]) / turns):
            problem = (
                f"the points span {value[-1] - value[0]:.9g} degrees, neither a turn of the cam "
                f"({360 * turns}) nor {turns * MIN_STEP_DEG} degrees less"
            )
            is_longer = value[-1] - value[0] > 360 * turns
            raise wrong("turn", problem, "list one turn" + CRANK_HINT[turns] * is_longer)
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
            raise wrong(
                "fall", f"is missing, but {given[0]} needs it", "add it", field=name, value=None
            )
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
        given = {"lift_unit", "largest_lift_mm"} & self.model_fields_set
        if given and (self.csv is None or len(given) > 1):
            field = max(given)
            problem = "is for the lifts of a csv, lift_mm is in mm"
            remedy = "remove it, or move the points into a csv"
            if self.csv is not None:
                problem, remedy = "shares of largest_lift_mm have no unit", "remove one of both"
            raise wrong("unit", problem, remedy, field=field, value=getattr(self, field))
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
