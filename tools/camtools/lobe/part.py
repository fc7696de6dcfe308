"""The part file of a camshaft: base circle, roller, lobes, and how they are turned or ground.

>>> LobeProcess(operation="turning", spindle_rpm=60).feed_mm
0.1
"""

from __future__ import annotations

from itertools import pairwise
from math import floor
from typing import Annotated, Literal, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from camtools.base.quantities import NM_PER_MM
from camtools.lobe.lobe_keys import Lobe, RadiusMm
from camtools.part.common import FeedMm, Machine, PartInfo, Process, SwingLimits, SwungTool
from camtools.part.model import TomlTable, wrong

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
