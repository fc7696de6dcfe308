"""Tables that part files of all kinds share: which part it is, what the machine can do.

>>> MachineLimits().alpha_rad_s2
500.0
"""

from __future__ import annotations

from typing import Annotated, Protocol, Self

from pydantic import Field, StringConstraints, ValidationInfo, field_validator, model_validator

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import NM_PER_MM
from camtools.part.model import TomlTable, wrong

DEFAULT_ALPHA_RAD_S2 = 500.0  # 50 Nm on 0.1 kg m2
PartName = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,30}\z")]


class PartInfo(TomlTable):
    """[part]: which part this is."""

    name: PartName
    kind: str
    source: Annotated[str, StringConstraints(min_length=1, max_length=1000)]

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
    spindle_bandwidth_rad_s: Annotated[float, Field(ge=0.1, le=1000)] = 40.0
    spindle_ripple: Annotated[float, Field(ge=0, le=0.1)] = 0.002

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

    u_stroke_mm: Annotated[float, Field(ge=0.001, le=30)] = 30.0
    swing_deg: Annotated[float, Field(ge=0.1, le=80)] = 30.0
    swing_speed_deg_s: Annotated[float, Field(ge=0.1, le=1e6)] = 1000.0
    swing_acceleration_deg_s2: Annotated[float, Field(ge=1, le=1e9)] = 100_000.0


class Process(Protocol):
    """The keys of [process] that every kind has; a kind may have more."""

    @property
    def spindle_rpm(self) -> float:
        """Speed of the spindle [r/min]."""

    @property
    def feed_mm(self) -> float:
        """Feed per turn [mm]."""

    @property
    def depth_mm(self) -> float:
        """Depth of cut [mm]."""

    @property
    def direction(self) -> int:
        """Sense of the spindle, 1 or -1."""


class MachineTable(Protocol):
    """[machine] of every kind."""

    @property
    def limits(self) -> MachineLimits:
        """What the machine can do."""


class PartFile(Protocol):
    """A part of any kind, as its file describes it."""

    @property
    def part(self) -> PartInfo:
        """Which part it is."""

    @property
    def process(self) -> Process:
        """How it is cut."""

    @property
    def machine(self) -> MachineTable:
        """The machine for which its table is made."""

    @property
    def height_mm(self) -> float:
        """How high it is [mm]."""


def is_feed_within(part: PartFile, feed_mm: float) -> bool:
    """Return whether a part takes a turn at least, to the nanometre, as the firmware demands."""
    return round(feed_mm * NM_PER_MM) <= round(part.height_mm * NM_PER_MM)


def check_feed(part: PartFile) -> None:
    """Refuse a feed beyond the height of the part: the firmware would not cut its table.

    Raises
    ------
    CamtoolsError
        With the highest feed that would do.
    """
    feed_mm = part.process.feed_mm
    if not is_feed_within(part, feed_mm):
        problem = f"must be at most {part.height_mm:.9g}, the height of the part"
        raise CamtoolsError([f"process.feed_mm = {feed_mm:.9g}: {problem}; give mm per turn"])
