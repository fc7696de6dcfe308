"""The part file: what a TOML file may say, with units, ranges and defaults.

>>> part = example_part()
>>> part.part.name, part.process.spindle_rpm, part.machine.limits.u_stroke_mm
('example', 2500.0, 1.2)
"""

from collections.abc import Sequence
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import AliasChoices, Field, Tag, ValidationInfo, field_validator, model_validator

from camtools.part.areas import MAX_WINDOWS, Area, Window, ZonedTolerances, in_any
from camtools.part.common import FeedLaw, Machine, PartInfo, SectionProcess, Tool
from camtools.part.datum import Datum
from camtools.part.model import TomlTable, wrong
from camtools.skirt.part.curves import LAW_OR_POINTS, PeakOvality, PowerProfile
from camtools.skirt.part.fit import Bore, Coating, Growth, check_fit
from camtools.skirt.part.keys import (
    GIVEN_BY_POINTS,
    Antithrust,
    Ovality,
    Profile,
    SectionShape,
    check_sides,
)


class Piston(TomlTable):
    """[piston]: the skirt."""

    profile: Annotated[
        Annotated[PowerProfile, Tag("(law)")] | Annotated[Profile, Tag("(points)")], LAW_OR_POINTS
    ]
    section: SectionShape = Field(default_factory=SectionShape)
    ovality: (
        Annotated[
            Annotated[PeakOvality, Tag("(law)")] | Annotated[Ovality, Tag("(points)")],
            LAW_OR_POINTS,
        ]
        | None
    ) = None
    antithrust: Antithrust | None = None
    datum: Datum | None = None
    windows: list[Window] = Field(
        default_factory=list,
        max_length=MAX_WINDOWS,
        validation_alias=AliasChoices("window", "windows"),
    )
    growth: Growth | None = None
    coating: Coating | None = None
    bore: Bore | None = None

    @field_validator("ovality")
    @classmethod
    def _check_ovality(
        cls, value: Ovality | PeakOvality | None, info: ValidationInfo
    ) -> Ovality | PeakOvality | None:
        section = info.data.get("section")
        is_measured = section is not None and section.shape in GIVEN_BY_POINTS
        if value is None and section is not None and not is_measured:
            raise wrong("no_ovality", "is missing", f'add it: shape = "{section.shape}" needs it')
        if value is not None and is_measured:
            assert section is not None
            problem = f'has no meaning for shape = "{section.shape}": the points determine it'
            raise wrong("extra_ovality", problem, "remove [piston.ovality]")
        return value

    @property
    def window_areas(self) -> tuple[Area, ...]:
        """Return all windows, those on opposite sides apart."""
        return tuple(area for window in self.windows for area in window.areas)

    @model_validator(mode="after")
    def _check_together(self) -> Self:
        first, last = self.profile.height_mm[0], self.profile.height_mm[-1]
        if self.antithrust is not None:
            check_sides(self.antithrust, self.section.shape, (first, last))
        self._check_windows(first, last)
        check_fit(self.growth, self.coating, self.bore, self.section.shape, (first, last))
        if self.ovality is None:
            return self
        heights_mm = self.ovality.height_mm
        if heights_mm[0] > first or heights_mm[-1] < last:
            problem = f"must cover the profile's heights {first} .. {last} mm"
            context = {"field": "ovality.height_mm", "value": heights_mm}
            raise wrong("cover", problem, "add points of ovality at the ends", **context)
        smallest = min(self.profile.diameter_mm)
        if max(self.ovality.ovality_mm) >= smallest:
            problem = f"must be smaller than the smallest diameter, {smallest} mm"
            context = {"field": "ovality.ovality_mm", "value": self.ovality.ovality_mm}
            raise wrong("ovality", problem, "give long minus short axis in mm", **context)
        self._check_lists(len(heights_mm))
        return self

    def _check_windows(self, first: float, last: float) -> None:
        """Refuse windows beside the part, and bores wider than it."""
        radius_mm = min(self.profile.diameter_mm) / 2
        for i, area in ((i, area) for i, w in enumerate(self.windows) for area in w.areas):
            reach_mm, field = area.diameter_mm / 2, f"window.{i}"
            if abs(area.offset_mm) + reach_mm >= radius_mm:
                problem = f"does not lie within the part's radius, {radius_mm:.6g} mm"
                remedy = "correct diameter_mm and offset_mm"
                raise wrong("bore", problem, remedy, field=field, value=None)
            if area.high_mm + reach_mm <= first or area.low_mm - reach_mm >= last:
                problem = f"lies beside the part's heights, {first:g} .. {last:g} mm"
                raise wrong("place", problem, "correct its height", field=field, value=None)

    @property
    def has_fit(self) -> bool:
        """Return whether more is known than one state: growth, coating or bore."""
        return any(table is not None for table in (self.growth, self.coating, self.bore))

    def _check_lists(self, n: int) -> None:
        for key, value in self.section:
            if isinstance(value, list) and len(value) != n:
                problem = f"has {len(value)} entries, ovality.height_mm has {n}"
                context = {"field": f"section.{key}", "value": value}
                raise wrong("length", problem, "give one number, or one for each height", **context)


class SkirtProcess(SectionProcess):
    """[process]: how the part is cut."""

    mode: Literal["uniform", "equal-volume"] = Field(
        "uniform", description="constant spindle speed, or an even removal rate"
    )
    ripple_percent: float | None = Field(
        None,
        gt=0,
        le=100,
        description="equal-volume: largest ripple of the removal rate, beyond which the part is "
        "refused with the highest `spindle_rpm` that keeps it",
    )
    parts: int = Field(
        30,
        ge=2,
        le=1000,
        description="equal parts of a quarter turn, for `analyse`; blocks of a quarter turn, for "
        "`mkgcode --axes cxzu`",
    )
    path: Literal["helix", "ring-helix", "stepped"] = Field(
        "helix",
        description="[Z over the turns](PATHS.md#ring-helix); ring-helix: closed rings `feed_mm` "
        'apart, for `mode = "uniform"`; stepped: Z stands during each turn, for `analyse` and '
        "`mkgcode`",
    )
    feed_law: FeedLaw | None = None

    @model_validator(mode="before")
    @classmethod
    def _take_feed_law(cls, value: object) -> object:
        """Let the law stand for the feed: `SkirtPart` works out its mean over the heights."""
        law = value.get("feed_law") if isinstance(value, dict) else None
        feeds = law.get("feed_mm") if isinstance(law, dict) else None
        if not isinstance(value, dict) or not isinstance(feeds, list) or not feeds:
            return value
        if "feed_mm" in value:
            problem = "cannot be combined with [process.feed_law], which sets the mean feed"
            raise wrong("law_feed", problem, "remove one of the two", field="feed_mm")
        return {"feed_mm": feeds[0], **value}

    @model_validator(mode="after")
    def _check_passes_of_mode(self) -> Self:
        if self.passes and self.mode == "equal-volume":
            problem = "need a constant spindle speed, because a speed law is made for one depth"
            remedy = 'set process.mode = "uniform", or give one depth_mm and no passes'
            raise wrong("pass_mode", problem, remedy, field="pass", value=None)
        return self

    @field_validator("feed_law")
    @classmethod
    def _check_law(cls, value: FeedLaw | None, info: ValidationInfo) -> FeedLaw | None:
        if value is not None and info.data.get("path", "helix") != "helix":
            problem = "needs a helix: rings and steps have a fixed distance, the feed"
            raise wrong("law_path", problem, 'set process.path = "helix", or remove the law')
        return value

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
            problem = "needs a constant spindle speed, because the ramps of Z are made for one"
            raise wrong("path", problem, 'set process.mode = "uniform", or path = "helix"')
        return value


class Magnify(TomlTable):
    """[magnify]: enlarges all deviations, for demonstration, MATHS.md (7)."""

    factor: float = Field(ge=1, le=1000, description="G' = factor G; D' = Dmax - factor (Dmax - D)")
    of: Literal["all", "ovality"] = Field("all", description="ovality: D' = D")

    @property
    def profile_factor(self) -> float:
        """Return how many times the profile's deviation from its largest diameter is enlarged."""
        return self.factor if self.of == "all" else 1.0

    @property
    def words(self) -> str:
        """Return what is enlarged, for titles."""
        return f"{'deviations' if self.of == 'all' else 'ovality'} enlarged {self.factor:g} times"


class SkirtPart(TomlTable):
    """The whole part file."""

    part: PartInfo
    piston: Piston
    process: SkirtProcess
    machine: Machine = Field(default_factory=Machine)
    tool: Tool = Field(default_factory=Tool)
    magnify: Magnify | None = None
    tolerances: ZonedTolerances = Field(default_factory=ZonedTolerances)

    @model_validator(mode="after")
    def _check_zones(self) -> Self:
        first, last = self.piston.profile.height_mm[0], self.piston.profile.height_mm[-1]
        for i, zone in enumerate(self.tolerances.zones):
            if not first <= zone.from_mm < zone.to_mm <= last:
                problem = f"must lie within the part's heights, {first:g} .. {last:g} mm"
                context = {"field": f"tolerances.zone.{i}", "value": None}
                raise wrong("zone", problem, "correct from_mm and to_mm", **context)
            form_um = zone.tolerance_um(self.process.form_error_um)
            band = zip(zone.lower_um or (), zone.upper_um or (), strict=True)
            for lower, upper in band:
                if lower >= form_um or upper <= -form_um:
                    problem = f"has a band of {lower:g} .. {upper:g} um beyond its form error, "
                    context = {"field": f"tolerances.zone.{i}", "value": None}
                    problem += f"{form_um:g} um"
                    raise wrong("band", problem, "set form_error_um of the zone", **context)
        return self

    @model_validator(mode="after")
    def _take_mean_feed(self) -> Self:
        """Make process.feed_mm the mean of a law over all that is fed."""
        process, law = self.process, self.process.feed_law
        if law is not None:
            heights_mm = self.piston.profile.height_mm
            ends = heights_mm[0] - process.run_in_mm, heights_mm[-1] + process.run_out_mm
            mean = process.model_copy(update={"feed_mm": law.mean_mm(*ends)})
            object.__setattr__(self, "process", mean)  # the model is frozen, and this is its making
        return self

    @model_validator(mode="after")
    def _check_magnified(self) -> Self:
        if self.magnify is not None and self.piston.has_fit:
            problem = "has no meaning with piston.growth, .coating or .bore: shapes enlarged for a "
            problem += "demonstration fit no bore"
            raise wrong("magnified", problem, "remove one of them", field="magnify", value=None)
        return self

    @property
    def tightest_um(self) -> float:
        """Return the least form error that is accepted anywhere, half a band included [um]."""
        least_um = [self.process.form_error_um]
        for zone in self.tolerances.zones:
            least_um.append(zone.tolerance_um(self.process.form_error_um))
            band = zip(zone.lower_um or (), zone.upper_um or (), strict=True)
            least_um += [(upper - lower) / 2 for lower, upper in band]
        return min(least_um)

    @property
    def height_mm(self) -> float:
        """Return the height over which the tool is fed [mm], run-in and run-out included."""
        heights_mm = self.piston.profile.height_mm
        return heights_mm[-1] - heights_mm[0] + self.process.run_in_mm + self.process.run_out_mm


def example_part() -> SkirtPart:
    """Return the Perkins-240-like skirt of MATHS.md (6), invented numbers, for examples."""
    return SkirtPart.model_validate(
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


_MOST = 5
_LEAST_NAMED = 3  # fewer are the ends of a law, no heights to be looked at
_MARGIN_FEEDS = 3.0  # from the ends, where passes on both sides of a height begin
_LEAST_MARGIN_MM = 0.5


def spread(
    named_mm: Sequence[float], ends_mm: tuple[float, float], margin_mm: float
) -> list[float]:
    """Return the heights of sections, a margin from the part's ends: five, spread evenly.

    >>> spread([0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 62.0], (0.0, 62.0), 0.5)
    [0.5, 20.0, 30.0, 40.0, 61.5]
    >>> spread([0.0, 60.0], (0.0, 60.0), 0.5)
    [0.5, 15.0, 30.0, 45.0, 59.5]
    """
    low_mm, high_mm = ends_mm[0] + margin_mm, ends_mm[1] - margin_mm
    if high_mm - low_mm < margin_mm:
        return []
    heights = np.unique(np.clip(named_mm, low_mm, high_mm))
    if heights.size < _LEAST_NAMED:
        heights = np.linspace(low_mm, high_mm, _MOST)
        heights[1:-1] = np.linspace(*ends_mm, _MOST)[1:-1]
    chosen = np.linspace(0, heights.size - 1, min(_MOST, heights.size)).round().astype(np.int64)
    return [round(float(mm), 6) for mm in heights[chosen]]


_MOST_SECTIONS = 16  # of the gauge


_ZONE_SHARES = (0.5, 0.25, 0.75, 0.125, 0.875)  # of a zone's height, the first that is material


def with_zones(
    heights_mm: list[float], tolerances: ZonedTolerances, windows: Sequence[Area] = ()
) -> list[float]:
    """Return heights of sections that windows leave, and of each zone that has none of its own.

    >>> skirt = {"name": "skirt", "from_mm": 4, "to_mm": 9}
    >>> groove = Area(0.0, 360.0, 5.0, 7.0, 0.0, 0.0, 0.5)
    >>> tolerances = ZonedTolerances.model_validate({"zone": [skirt]})
    >>> with_zones([0.5, 20.0], tolerances), with_zones([0.5, 20.0], tolerances, [groove])
    ([0.5, 6.5, 20.0], [0.5, 7.75, 20.0])
    """
    found = [z_mm for z_mm in heights_mm if _is_open(z_mm, windows)]
    for zone in tolerances.zones:
        is_there = any(zone.from_mm <= z_mm <= zone.to_mm for z_mm in found)
        span_mm = zone.to_mm - zone.from_mm
        places = (zone.from_mm + share * span_mm for share in _ZONE_SHARES)
        inside = (min(max(z_mm, heights_mm[0]), heights_mm[-1]) for z_mm in places if heights_mm)
        own = next((z_mm for z_mm in inside if _is_open(z_mm, windows)), None)
        if own is not None and not is_there and len(found) < _MOST_SECTIONS:
            found = sorted({*found, round(own, 6)})
    return found


def _is_open(z_mm: float, windows: Sequence[Area]) -> bool:
    """Return whether half of a turn is material; a radius of 1 m makes margins small."""
    turn = np.arange(360) / 360
    return bool(in_any(windows, turn, np.full(360, z_mm), np.full(360, 1e3)).mean() < 0.5)


def margin_mm(feed_mm: float) -> float:
    """Return how far sections keep from the ends of a part [mm]."""
    return max(_LEAST_MARGIN_MM, _MARGIN_FEEDS * feed_mm)
