"""Areas of a turned surface: [[piston.window]] and [[tolerances.zone]] of a part file.

>>> bore = Area(90.0, 0.0, 30.0, 30.0, 30.0, 0.0, 0.5)
>>> bore.holds(np.array([0.25, 0.3, 0.31]), np.full(3, 30.0), np.full(3, 46.0)).tolist()
[True, True, False]

>>> bore = Window(angle_deg=90, height_mm=30, diameter_mm=25, both_sides=True)
>>> [area.angle_deg for area in bore.areas]
[90.0, 270.0]
>>> Zone(name="skirt", from_mm=0, to_mm=20, form_error_um=2).area.width_deg
360.0
"""

import re
from collections.abc import Sequence
from itertools import combinations, pairwise
from typing import Annotated, NamedTuple, Self

import numpy as np
from pydantic import AfterValidator, AliasChoices, Field, field_validator, model_validator

from camtools.base.quantities import Bools, Floats
from camtools.base.text import Json
from camtools.part.common import SectionTolerances, Tolerances
from camtools.part.model import HeightMm, Points, TomlTable, wrong

LINES_DEG = (0.0, 90.0, 180.0, 270.0)  # profiles along the axis that the gauge takes
_SAME_DEG = 1e-9
MAX_WINDOWS = 32  # two areas each at most, and grooves: host_sim/part/sim_area.h
MAX_ZONES = 16
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9 _-]{0,29}")


def _checked_name(value: str) -> str:
    if not _NAME.fullmatch(value):
        remedy = "use 1 to 30 letters, digits, spaces, _ and -, a letter or digit first"
        raise wrong("name", "not a usable name", remedy)
    return value


AreaName = Annotated[str, AfterValidator(_checked_name)]
AngleDeg = Annotated[float, Field(ge=-360, le=360)]
OffsetUm = Annotated[float, Field(ge=-1000, le=1000)]


class Area(NamedTuple):
    """A box, or a bore; its axis has the direction of its middle and its lower height."""

    angle_deg: float  # of its middle, 0 .. 360
    width_deg: float  # 0 of a bore
    low_mm: float
    high_mm: float
    diameter_mm: float = 0.0  # 0 of a box
    offset_mm: float = 0.0  # of a bore's axis from that of the part, towards rising angles
    margin_mm: float = 0.0  # without a verdict, on the surface

    def document(self) -> Json:
        """Return it as the gauge reads it, host_sim/part/sim_area.h."""
        return self._asdict()

    def holds(self, turn: Floats, z_mm: Floats, radius_mm: Floats, margin_mm: float = 0.0) -> Bools:
        """Return which places of a surface it holds, enlarged by a margin [mm] on all sides."""
        off_rad = np.radians(np.remainder(360 * turn - self.angle_deg + 180, 360) - 180)
        if self.diameter_mm:
            reach_mm = self.diameter_mm / 2 + margin_mm
            across_mm = radius_mm * np.sin(off_rad) - self.offset_mm
            is_near = np.hypot(across_mm, z_mm - self.low_mm) < reach_mm
            return np.asarray(is_near & (np.cos(off_rad) > 0), dtype=np.bool_)
        half_rad = np.radians(self.width_deg) / 2 + margin_mm / radius_mm
        is_high = (z_mm >= self.low_mm - margin_mm) & (z_mm <= self.high_mm + margin_mm)
        return np.asarray(is_high & (np.abs(off_rad) <= half_rad), dtype=np.bool_)

    def overlaps(self, other: "Area") -> bool:
        """Return whether two boxes have more in common than an edge."""
        apart_deg = abs((self.angle_deg - other.angle_deg + 180) % 360 - 180)
        is_beside = apart_deg >= (self.width_deg + other.width_deg) / 2 - _SAME_DEG
        return self.low_mm < other.high_mm and other.low_mm < self.high_mm and not is_beside


class Window(TomlTable):
    """[[piston.window]]: where [there is no material](PISTONS.md#windows)."""

    name: AreaName = Field("window", description="in reports")
    angle_deg: AngleDeg = Field(description="of its middle")
    height_mm: HeightMm | None = Field(None, description="round: of its centre")
    diameter_mm: Annotated[float, Field(ge=0.1, le=4000)] | None = Field(
        None, description="round: of a bore, whose axis is normal to that of the part"
    )
    offset_mm: Annotated[float, Field(ge=-100, le=100)] = Field(
        0.0, description="round: of that axis from the part's, towards rising angles"
    )
    width_deg: Annotated[float, Field(gt=0, le=360)] | None = Field(
        None, description="box: its extent in angle"
    )
    from_mm: HeightMm | None = Field(None, description="box: its lower end")
    to_mm: HeightMm | None = Field(None, description="box: its upper end")
    margin_mm: float = Field(
        0.5, ge=0, le=50, description="on the surface; so near its edge there is no verdict"
    )
    both_sides: bool = Field(False, description="the same again at the opposite angle")

    @model_validator(mode="after")
    def _check_kind(self) -> Self:
        box = {"width_deg": self.width_deg, "from_mm": self.from_mm, "to_mm": self.to_mm}
        bore = {"height_mm": self.height_mm, "diameter_mm": self.diameter_mm}
        given = [key for key, value in (box | bore).items() if value is not None]
        if set(given) not in (set(box), set(bore)):
            problem = f"has {', '.join(given) or 'no extent'}"
            remedy = f"give {' and '.join(bore)} for a bore, or {', '.join(box)} for a box"
            raise wrong("window", problem, remedy, value=None)
        if self.from_mm is not None and self.to_mm is not None:
            check_ends(self.from_mm, self.to_mm)
        if self.offset_mm and self.diameter_mm is None:
            context = {"field": "offset_mm", "value": self.offset_mm}
            raise wrong("offset", "has no meaning for a box", "remove it", **context)
        return self

    @property
    def areas(self) -> tuple[Area, ...]:
        """Return the window, and that on the opposite side."""
        low_mm = self.height_mm if self.from_mm is None else self.from_mm
        high_mm = self.height_mm if self.to_mm is None else self.to_mm
        assert low_mm is not None and high_mm is not None
        extent = self.width_deg or 0.0, low_mm, high_mm, self.diameter_mm or 0.0
        sides = ((0.0, 1), (180.0, -1)) if self.both_sides else ((0.0, 1),)
        return tuple(
            Area((self.angle_deg + deg) % 360, *extent, sign * self.offset_mm, self.margin_mm)
            for deg, sign in sides
        )


def check_ends(from_mm: float, to_mm: float) -> None:
    """Refuse ends that do not rise."""
    if not from_mm < to_mm:
        context = {"field": "to_mm", "value": to_mm}
        raise wrong("ends", f"must be above from_mm = {from_mm:g}", "exchange them", **context)


_ALL_ROUND = tuple(key for key in SectionTolerances.model_fields if key != "straightness_um")


class Zone(SectionTolerances):
    """[[tolerances.zone]]: what holds [in a zone](PISTONS.md#zones-of-tolerance).

    What a zone does not state is that of `[tolerances]` and of `[process] form_error_um`. Zones do
    not overlap.
    """

    name: AreaName = Field(description="in reports and sheets, each another")
    from_mm: HeightMm
    to_mm: HeightMm
    angle_deg: AngleDeg = Field(0.0, description="of its middle")
    width_deg: float = Field(360.0, gt=0, le=360, description="its extent in angle")
    form_error_um: Annotated[float, Field(ge=0.01, le=1000)] | None = Field(
        None, description="accepted form error in the zone"
    )
    height_mm: Points[HeightMm] | None = Field(
        None,
        description="rising; heights of a band of the profile, beside the form error; beyond them "
        "its end values hold",
    )
    lower_um: Points[OffsetUm] | None = Field(
        None, description="per height: least deviation of the radius; above 0 is metal left"
    )
    upper_um: Points[OffsetUm] | None = Field(
        None, description="per height: largest deviation of the radius; lines between the points"
    )

    @field_validator("height_mm")
    @classmethod
    def _check_heights(cls, value: list[float] | None) -> list[float] | None:
        for lower, upper in pairwise(value or []):
            if not lower < upper:
                problem = f"heights must rise, but {upper:g} mm follows {lower:g} mm"
                raise wrong("rising", problem, "list the points upwards")
        return value

    @model_validator(mode="after")
    def _check_zone(self) -> Self:
        check_ends(self.from_mm, self.to_mm)
        if self.straightness_um is not None and not any(map(self.has_line, LINES_DEG)):
            context = {"field": "straightness_um", "value": self.straightness_um}
            problem = "needs a profile that is gauged: at 0, 90, 180 or 270 degrees"
            raise wrong("line", problem, "remove it, or make the zone wider", **context)
        for key in _ALL_ROUND:
            if self.width_deg < 360 and getattr(self, key) is not None:
                context = {"field": key, "value": getattr(self, key)}
                problem = f"needs a zone all round, this has {self.width_deg:g} degrees"
                raise wrong("round", problem, "remove it, or leave out width_deg", **context)
        self._check_band()
        return self

    def _check_band(self) -> None:
        band = {"height_mm": self.height_mm, "lower_um": self.lower_um, "upper_um": self.upper_um}
        lengths = {key: len(value) for key, value in band.items() if value is not None}
        if lengths and (len(lengths) < len(band) or len(set(lengths.values())) > 1):
            found = ", ".join(f"{key} with {n}" for key, n in lengths.items())
            remedy = f"give {', '.join(band)} with as many entries each"
            raise wrong("band", f"has a band of {found} entries", remedy, value=None)
        if self.lower_um is None or self.upper_um is None:
            return
        for lower, upper in zip(self.lower_um, self.upper_um, strict=True):
            if lower >= upper:
                context = {"field": "lower_um", "value": lower}
                problem = f"must be below upper_um, {upper:g}"
                raise wrong("band", problem, "exchange them", **context)

    def tolerance_um(self, of_part_um: float) -> float:
        """Return the accepted form error in the zone."""
        return self.form_error_um or of_part_um

    def narrowed(self, um: float) -> Self:
        """Return the zone with form error and band less what smoothing takes of them."""
        form_um = self.form_error_um
        found = {
            "form_error_um": None if form_um is None else form_um - um,
            "lower_um": None if self.lower_um is None else [low + um for low in self.lower_um],
            "upper_um": None if self.upper_um is None else [high - um for high in self.upper_um],
        }
        return self.model_copy(update=found)

    @property
    def area(self) -> Area:
        """Return its extent."""
        return Area(self.angle_deg % 360, self.width_deg, self.from_mm, self.to_mm)

    def has_line(self, angle_deg: float) -> bool:
        """Return whether it holds a profile along the axis."""
        turn, z_mm, radius_mm = np.array([angle_deg / 360, self.from_mm, 1.0])
        return bool(self.area.holds(turn, z_mm, radius_mm))


class ZonedTolerances(Tolerances):
    """[tolerances]: in addition to `form_error_um`; [sheets](REPORT.md#sheets) use them."""

    zones: list[Zone] = Field(
        default_factory=list,
        max_length=MAX_ZONES,
        validation_alias=AliasChoices("zone", "zones"),
    )

    @field_validator("zones")
    @classmethod
    def _check_zones(cls, value: list[Zone]) -> list[Zone]:
        for zone, other in combinations(value, 2):
            if zone.name == other.name:
                remedy = "give every zone a name of its own"
                raise wrong("zone", f'has "{zone.name}" twice', remedy, value=None)
            if zone.area.overlaps(other.area):
                problem = f'"{zone.name}" and "{other.name}" overlap'
                raise wrong("zone", problem, "change their heights or angles", value=None)
        return value

    def zone_at(self, z_mm: float) -> Zone | None:
        """Return the zone all round that holds a height, if any."""
        found = (zone for zone in self.zones if zone.width_deg == 360)
        return next((zone for zone in found if zone.from_mm <= z_mm <= zone.to_mm), None)

    def form_error_at(self, z_mm: float, of_part_um: float) -> float | None:
        """Return the form error accepted all round at a height; nothing where zones share it."""
        here = [zone for zone in self.zones if zone.from_mm <= z_mm <= zone.to_mm]
        if any(zone.width_deg < 360 for zone in here):
            return None
        return here[0].tolerance_um(of_part_um) if here else of_part_um

    def stated_at(self, z_mm: float) -> SectionTolerances:
        """Return what holds all round at a height: of its zone, else of the part."""
        keys, zone = set(SectionTolerances.model_fields), self.zone_at(z_mm)
        stated = zone.model_dump(include=keys, exclude_none=True) if zone is not None else {}
        return SectionTolerances(**self.model_dump(include=keys) | stated)


def in_any(areas: Sequence[Area], turn: Floats, z_mm: Floats, radius_mm: Floats) -> Bools:
    """Return which places lie in a window or its margin."""
    found = np.zeros(np.shape(turn), dtype=np.bool_)
    for area in areas:
        found |= area.holds(turn, z_mm, radius_mm, area.margin_mm)
    return found
