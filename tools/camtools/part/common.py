"""Tables that part files of all kinds share: part, tolerances, tool, machine, passes, feed law.

>>> Tool().is_round, Tool(nose_radius_mm=0.8).is_round
(False, True)
"""

from itertools import pairwise
from typing import Annotated, Literal, Protocol, Self

import numpy as np
from pydantic import (
    AliasChoices,
    Field,
    StringConstraints,
    ValidationInfo,
    field_validator,
    model_validator,
)
from scipy.interpolate import PchipInterpolator

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import NM_PER_MM, UM_PER_MM, Floats
from camtools.part.model import HeightMm, Points, TomlTable, as_long, no_truth, rising, wrong

DEFAULT_ALPHA_RAD_S2 = 500.0  # 50 Nm on 0.1 kg m2
_OF_Z = "of a ring-helix, whose ramps of Z follow from it, and of the simulated machine"
_QUOTIENT = "instead of `spindle_acceleration_rad_s2`: torque over inertia"
MAX_FEED_MM = 10
FeedMm = Annotated[float, Field(ge=0.000_1, le=MAX_FEED_MM)]
SpindleRpm = Annotated[float, Field(ge=1, le=60_000)]
PartName = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,30}\z")]


class PartInfo(TomlTable):
    """[part]: which part this is."""

    name: PartName = Field(
        description="names the files and the table: 1 to 31 of `A-Z a-z 0-9 _ -`, a letter or "
        "digit first"
    )
    kind: str
    source: str = Field(min_length=1, max_length=1000, description="origin of the numbers")

    @field_validator("kind", mode="before")
    @classmethod
    def _check_kind(cls, value: object, info: ValidationInfo) -> object:
        names = (info.context or {}).get("kinds")
        if names is not None and value not in names:
            *others, last = [repr(name) for name in names]
            expected = " or ".join([", ".join(others), last] if others else [last])
            raise wrong("kind", f"Input should be {expected}", f"use one of: {expected}")
        return value


class MachineLimits(TomlTable):
    """[machine.limits]: what the machine can do; feasibility is judged against it."""

    u_stroke_mm: float = Field(
        1.2,
        ge=0.001,
        le=30,
        description="travel peak to peak, centred on U = 0; usable: the inner half, with "
        '`u_zero = "mean"` all of it',
    )
    u_speed_mm_s: float = Field(400.0, ge=0.001, le=100_000)
    u_acceleration_mm_s2: float = Field(250_000.0, ge=1, le=1_000_000_000)
    z_speed_mm_s: float = Field(200.0, ge=0.1, le=10_000, description=_OF_Z)
    z_acceleration_mm_s2: float = Field(2000.0, ge=10, le=1_000_000, description=_OF_Z)
    spindle_rpm: float = Field(3000.0, ge=1, le=60_000)
    tick_hz: int = Field(
        20_000, ge=500, le=100_000, description="rate of the controller's interrupt"
    )
    spindle_torque_nm: float | None = Field(None, gt=0, le=100_000, description=_QUOTIENT)
    spindle_inertia_kgm2: float | None = Field(None, gt=0, le=10_000, description=_QUOTIENT)
    spindle_acceleration_rad_s2: float | None = Field(
        None,
        ge=1,
        le=1_000_000,
        description="for equal-volume turning; without it and the quotient 500",
    )
    spindle_bandwidth_rad_s: float = Field(
        40.0,
        ge=0.1,
        le=1000,
        description="of the spindle's speed loop: a modulated speed falls by at most this "
        "fraction per second",
    )
    spindle_ripple: float = Field(
        0.002, ge=0, le=0.1, description="amplitude of the spindle's own speed ripple / speed"
    )

    @model_validator(mode="after")
    def _check_spindle(self) -> Self:
        pair = (self.spindle_torque_nm, self.spindle_inertia_kgm2)
        is_half, is_double = pair.count(None) == 1, self.spindle_acceleration_rad_s2 is not None
        if is_half or (is_double and None not in pair):
            context = {"field": "spindle_torque_nm", "value": self.spindle_torque_nm}
            remedy = "give torque and inertia, or spindle_acceleration_rad_s2 alone"
            raise wrong("spindle", "does not give the spindle acceleration", remedy, **context)
        return self

    @property
    def alpha_rad_s2(self) -> float:
        """Return the spindle's highest acceleration [rad/s2]; 500 where nothing is given."""
        if self.spindle_torque_nm is not None and self.spindle_inertia_kgm2 is not None:
            return self.spindle_torque_nm / self.spindle_inertia_kgm2
        given = self.spindle_acceleration_rad_s2
        return DEFAULT_ALPHA_RAD_S2 if given is None else given


class SwingLimits(MachineLimits):
    """[machine.limits]: a lathe or grinder for lobes, whose stroke is that of a lift."""

    u_stroke_mm: float = Field(
        30.0,
        ge=0.001,
        le=30,
        description="travel peak to peak, centred on the base circle: twice the lift is needed",
    )
    swing_deg: float = Field(30.0, ge=0.1, le=80, description="to either side")
    swing_speed_deg_s: float = Field(1000.0, ge=0.1, le=1e6)
    swing_acceleration_deg_s2: float = Field(100_000.0, ge=1, le=1e9)


class Process(TomlTable):
    """[process]: the keys that every kind has; a kind may have more."""

    spindle_rpm: SpindleRpm = Field(description="mean speed if it is modulated")
    feed_mm: FeedMm = Field(
        description="per turn, at most the height of the part with its runs; with "
        "`[process.feed_law]` its mean, which is left out",
        json_schema_extra={"x-or": ["feed_law"]},
    )
    depth_mm: float = Field(0.1, ge=0, le=100, description="cutting depth at the long axis")
    direction: Literal[1, -1] = Field(
        1, description="1 is M3, -1 is M4; [the part is the same](#the-drawings-angle)"
    )

    _check_direction = field_validator("direction", mode="before")(no_truth)


class Machine(TomlTable):
    """[machine]: the machine for which the table is made."""

    limits: MachineLimits = Field(default_factory=MachineLimits)


class PartFile(Protocol):
    """A part of any kind, as its file describes it."""

    @property
    def part(self) -> PartInfo:
        """Which part it is."""

    @property
    def process(self) -> Process:
        """How it is cut."""

    @property
    def machine(self) -> Machine:
        """The machine for which its table is made."""

    @property
    def height_mm(self) -> float:
        """How high it is [mm]."""


def is_feed_within(part: PartFile, feed_mm: float) -> bool:
    """Return whether a part takes a turn at least, to the nanometre, as the firmware demands."""
    return round(feed_mm * NM_PER_MM) <= round(part.height_mm * NM_PER_MM)


def check_feed(part: PartFile) -> None:
    """Refuse a feed beyond the height of the part: the firmware would not cut its table."""
    feed_mm = part.process.feed_mm
    if not is_feed_within(part, feed_mm):
        problem = f"must be at most {part.height_mm:.9g}, the height of the part"
        raise CamtoolsError([f"process.feed_mm = {feed_mm:.9g}: {problem}; give mm per turn"])


LengthUm = Annotated[float, Field(ge=0.001, le=1000)]
_DIAMETER = "plus and minus: long and short axis; ovality (diametral)"


class FormTolerances(TomlTable):
    """[tolerances]: in addition to `form_error_um`; [sheets](REPORT.md#sheets) use them."""

    roundness_um: LengthUm | None = Field(
        None, description="RONt of the deviation from the drawing, of the radius, minimum zone"
    )
    straightness_um: LengthUm | None = Field(
        None, description="STRt likewise, from the drawn profile"
    )


class SectionTolerances(FormTolerances):
    """What a drawing states of sections, all over the part or in a zone."""

    diameter_um: LengthUm | None = Field(None, description=_DIAMETER)
    ovality_um: LengthUm | None = Field(None, description=_DIAMETER)
    phase_deg: Annotated[float, Field(gt=0, le=45)] | None = Field(
        None, description="plus and minus: direction of the long axis"
    )
    scallop_um: LengthUm | None = Field(
        None, description="height of the ridges that feed and nose radius leave between tracks"
    )
    roughness_um: LengthUm | None = Field(
        None, description="mean roughness Ra that they leave; both refuse a larger feed"
    )
    runout_um: LengthUm | None = Field(
        None, description="run-out of a section to the axis of `[piston.datum]` (radial)"
    )


class Tolerances(SectionTolerances):
    """[tolerances]: in addition to `form_error_um`; [sheets](REPORT.md#sheets) use them."""

    taper_um: LengthUm | None = Field(
        None, description="plus and minus: taper deviation over the part (diametral)"
    )


MIN_NOSE_MM = 0.01

ClearanceDeg = Annotated[float, Field(ge=0.1, le=45)]


class Tool(TomlTable):
    """[tool]: [the tool](PISTONS.md#the-tool) that turns sections."""

    nose_radius_mm: float = Field(
        0.0,
        ge=0,
        le=100,
        description=f"radius of the nose in the plane of the axis, at least {MIN_NOSE_MM:g}; "
        "0 is a point",
    )
    clearance_deg: ClearanceDeg = Field(
        7.0,
        description="of the flank below the edge, in the plane of a section; a tool whose heel "
        "rubs is refused with the clearance that it needs",
    )
    wear_um: float = Field(
        0.0,
        ge=0,
        le=1000,
        description="sets the simulated tip back and offsets X by as much, MATHS.md (112); the "
        "table does not change",
    )

    @field_validator("nose_radius_mm")
    @classmethod
    def _check_nose(cls, value: float) -> float:
        if 0 < value < MIN_NOSE_MM:
            problem = f"must be 0 or at least {MIN_NOSE_MM:g} mm"
            raise wrong("nose", problem, "give 0 for a tool with a point")
        return value

    @property
    def is_round(self) -> bool:
        """Whether the nose is a circle."""
        return self.nose_radius_mm > 0


def check_tracks(tool: Tool, feed_mm: float) -> None:
    """Refuse a feed [mm per turn] at which metal stays between the tracks of a round nose."""
    widest_mm = 2 * tool.nose_radius_mm
    if tool.is_round and feed_mm >= widest_mm:
        problem = f"tracks of a nose of {tool.nose_radius_mm:g} mm do not meet, metal stays"
        raise CamtoolsError([f"feed of {feed_mm:g} mm: {problem}; feed less than {widest_mm:g} mm"])


class SwungTool(TomlTable):
    """[tool]: turns lobes and swings with the normal of the contact."""

    clearance_deg: ClearanceDeg = Field(
        7.0, description="between the flank of the tool and the profile at the contact"
    )
    heel_mm: float = Field(
        5.0, ge=0, le=100, description="length of that flank; beyond it, it is ground away"
    )


_PIECES, _NODES = 64, 8  # of the integral over the height, between two points of the law
_OF_PASS = "of this pass; without it that of `[process]`; with a feed law its mean"
RunMm = Annotated[
    float,
    Field(
        ge=0,
        le=200,
        description="the tool starts this far below the first height and ends this far above the "
        "last, in the air",
    ),
]


class Pass(TomlTable):
    """[[process.pass]]: passes in cutting order at a constant spindle speed, from `depth_mm` on."""

    allowance_um: float = Field(
        ge=0,
        le=10_000,
        description="stock that the pass leaves on the radius, falling; 0 in the last pass",
    )
    feed_mm: FeedMm | None = Field(None, description=_OF_PASS)
    spindle_rpm: SpindleRpm | None = Field(None, description=_OF_PASS)


class SectionProcess(Process):
    """[process]: how a section is turned."""

    form_error_um: float = Field(
        5.0, ge=0.01, le=1000, description="accepted form error of the cut against the drawing"
    )
    u_zero: Literal["long-axis", "mean"] = Field(
        "long-axis",
        description="tip at U = 0: on the long axis, or in the middle of all reductions, which "
        "[needs half the stroke](PISTONS.md#room-of-the-machine)",
    )
    run_in_mm: RunMm = 0.0
    run_out_mm: RunMm = 0.0
    passes: list[Pass] = Field(
        default_factory=list, max_length=16, validation_alias=AliasChoices("pass", "passes")
    )  # TOML calls it "pass", which is no name in Python

    @property
    def runs_mm(self) -> tuple[float, float]:
        """Return run-in and run-out."""
        return self.run_in_mm, self.run_out_mm

    @field_validator("passes")
    @classmethod
    def _check_passes(cls, value: list[Pass], info: ValidationInfo) -> list[Pass]:
        """Refuse passes that do not come down to the drawing, each by some depth."""
        stock = [
            info.data.get("depth_mm", 0.0) * UM_PER_MM,
            *(planned.allowance_um for planned in value),
        ]
        for number, (before, after) in enumerate(pairwise(stock), start=1):
            if after >= before:
                problem = f"number {number} leaves {after:g} um of {before:g} um"
                remedy = "give less from pass to pass; the first begins with process.depth_mm"
                raise wrong("pass_order", problem, remedy)
        if value and stock[-1] != 0:
            problem = f"the last one leaves {stock[-1]:g} um"
            raise wrong("pass_last", problem, "give the last pass allowance_um = 0")
        return value


class FeedLaw(TomlTable):
    """[process.feed_law]: [feed against height](PISTONS.md#passes-and-feed-against-height)."""

    height_mm: Points[HeightMm] = Field(
        description="rising by 0.01 or more; beyond the ends the feed is constant"
    )
    feed_mm: Points[FeedMm] = Field(
        description="per height, at least 4 % of the mean; a monotone cubic between the points, "
        'MATHS.md (103); with `path = "helix"`'
    )

    _check_height = field_validator("height_mm")(rising)
    _check_length = field_validator("feed_mm")(as_long)

    def at_mm(self, z_mm: Floats, derivative: int = 0) -> Floats:
        """Return the feed at heights [mm], monotone between points, or its derivative."""
        low, high = self.height_mm[0], self.height_mm[-1]
        curve = PchipInterpolator(self.height_mm, self.feed_mm)
        inside = np.asarray(curve(np.clip(z_mm, low, high), nu=derivative), dtype=np.float64)
        return inside if derivative == 0 else np.where((z_mm < low) | (z_mm > high), 0.0, inside)

    def turns(self, z_first_mm: float, z_mm: Floats) -> Floats:
        """Return the turns that Z takes from a height to others, rising."""
        knots = np.array(self.height_mm)
        inside = knots[(knots > z_first_mm) & (knots < z_mm[-1])]
        ends = np.unique(np.concatenate([[z_first_mm], inside, z_mm]))
        x, w = np.polynomial.legendre.leggauss(_NODES)
        share = (np.arange(_PIECES)[:, None] + (x + 1) / 2) / _PIECES
        at = ends[:-1, None, None] + np.diff(ends)[:, None, None] * share
        sums = (w / 2 / self.at_mm(at)).sum(axis=(1, 2)) * np.diff(ends) / _PIECES
        total = np.concatenate([[0.0], np.cumsum(sums)])
        return np.asarray(total[np.searchsorted(ends, z_mm)], dtype=np.float64)

    def mean_mm(self, z_first_mm: float, z_last_mm: float) -> float:
        """Return the mean feed: the height over the turns that it takes."""
        turns = float(self.turns(z_first_mm, np.array([z_last_mm]))[-1])
        return (z_last_mm - z_first_mm) / turns
