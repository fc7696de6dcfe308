"""The part file: what a TOML file may say, with units, ranges and defaults.

>>> part = example_part()
>>> part.part.name, part.process.spindle_rpm, part.machine.limits.u_stroke_mm
('example', 2500.0, 1.2)
"""

from collections.abc import Sequence
from operator import attrgetter
from typing import Annotated, Literal, Self

import numpy as np
from pydantic import AliasChoices, Field, Tag, ValidationInfo, field_validator, model_validator

from camtools.base.quantities import UM_PER_MM
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
from camtools.skirt.part.land import MAX_LANDS, Band, BandPass, Land, extended, grooves

_OF_LANDS = ("ellipse", "cosine", "double-ellipse")  # shapes


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
    lands: list[Land] = Field(
        default_factory=list, max_length=MAX_LANDS, validation_alias=AliasChoices("land", "lands")
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
        """Return all windows, those on opposite sides apart, and the grooves beside lands."""
        own = tuple(area for window in self.windows for area in window.areas)
        return (*own, *(Area(0.0, 360.0, *groove) for groove in self.grooves_mm))

    @property
    def grooves_mm(self) -> list[tuple[float, float]]:
        """Return the heights between skirt and lands, which are not turned, rising."""
        return grooves(self.lands, *self.skirt_mm)

    @property
    def skirt_mm(self) -> tuple[float, float]:
        """Return the ends of the profile."""
        return float(self.profile.height_mm[0]), float(self.profile.height_mm[-1])

    @property
    def ends_mm(self) -> tuple[float, float]:
        """Return the ends of the part: of the profile and all lands."""
        return extended(self.lands, *self.skirt_mm)

    @model_validator(mode="after")
    def _check_together(self) -> Self:
        first, last = self.skirt_mm
        if self.antithrust is not None:
            check_sides(self.antithrust, self.section.shape, (first, last))
        self._check_lands()
        self._check_windows(*self.ends_mm)
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
        lands_mm = [land.diameters_mm[0] for land in self.lands]
        radius_mm = min(*self.profile.diameter_mm, *lands_mm) / 2
        for i, area in ((i, area) for i, w in enumerate(self.windows) for area in w.areas):
            reach_mm, field = area.diameter_mm / 2, f"window.{i}"
            if abs(area.offset_mm) + reach_mm >= radius_mm:
                problem = f"does not lie within the part's radius, {radius_mm:.6g} mm"
                remedy = "correct diameter_mm and offset_mm"
                raise wrong("bore", problem, remedy, field=field, value=None)
            if area.high_mm + reach_mm <= first or area.low_mm - reach_mm >= last:
                problem = f"lies beside the part's heights, {first:g} .. {last:g} mm"
                raise wrong("place", problem, "correct its height", field=field, value=None)

    def _check_lands(self) -> None:
        """Refuse lands without a groove, and shapes that do not go on beside the skirt."""
        if not self.grooves_mm:
            return
        foreign = "antithrust", "growth", "coating", "bore"
        found = next((name for name in foreign if getattr(self, name) is not None), None)
        if found is not None:
            problem = "has no meaning with [[piston.land]], which is drawn cold, bare and plain"
            raise wrong("land_fit", problem, "remove one of the two", field=found, value=None)
        lists = any(isinstance(value, list) for _, value in self.section)
        if self.section.shape not in _OF_LANDS or lists:
            problem = f'needs an oval alike at all heights, not shape = "{self.section.shape}"'
            problem += " with lists" if lists else ""
            remedy = f"set shape to one of {', '.join(_OF_LANDS)}, with one number each"
            raise wrong("land_shape", problem, remedy, field="land", value=None)
        for i, land in enumerate(self.lands):
            if land.ovality_mm >= land.diameters_mm[0]:
                context = {"field": f"land.{i}.ovality_mm", "value": land.ovality_mm}
                raise wrong(
                    "ovality", "must be smaller than its diameters", "correct it", **context
                )

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
        first, last = self.piston.ends_mm
        for i, zone in enumerate(self.tolerances.zones):
            grooves = self.piston.grooves_mm
            is_in_groove = any(a <= zone.from_mm and zone.to_mm <= b for a, b in grooves)
            if is_in_groove or not first <= zone.from_mm < zone.to_mm <= last:
                problem = f"must lie within the part's heights, {first:g} .. {last:g} mm"
                problem += ", and not in a groove" if is_in_groove else ""
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
            first, last = self.piston.skirt_mm
            ends = first - process.run_in_mm, last + process.run_out_mm
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

    @model_validator(mode="after")
    def _check_program(self) -> Self:
        """Refuse what a program of skirt and lands cannot do."""
        process = self.process
        problems = {
            "path": process.path != "helix" and 'needs path = "helix"',
            "mode": process.mode != "uniform" and 'needs mode = "uniform"',
            "feed_law": process.feed_law and "has a feed for each band instead: feed_mm",
            "run_in_mm": process.run_in_mm and "runs into each band by itself",
            "run_out_mm": process.run_out_mm and "runs out of each band by itself",
            "pass": any(p.spindle_rpm for p in process.passes) and "has one spindle_rpm for all",
            "magnify": self.magnify and "is not magnified",
        }
        for key, problem in problems.items():
            if self.piston.lands and problem:
                field = key if key == "magnify" else f"process.{key}"
                problem = f"a part with [[piston.land]] {problem}"
                raise wrong("program", problem, "remove it", field=field, value=None)
        return self

    @model_validator(mode="after")
    def _check_stock(self) -> Self:
        """Refuse a first pass over a land that leaves more than the blank has there."""
        lands = self.piston.lands
        lands_mm = [land.diameters_mm[1] for land in lands]
        blank_mm = max(*self.piston.profile.diameter_mm, *lands_mm) / 2 + self.process.depth_mm
        for i, land in enumerate(lands):
            room_um = (blank_mm - lands_mm[i] / 2) * UM_PER_MM
            if land.allowance_um and land.allowance_um[0] >= max(room_um, 1e-9):
                context = {"field": f"piston.land.{i}.allowance_um", "value": land.allowance_um}
                problem = f"must be below {room_um:g}, the stock of the blank there"
                raise wrong("stock", problem, "give less, or a larger process.depth_mm", **context)
        return self

    @property
    def bands(self) -> tuple[Band, ...]:
        """Return skirt and lands of a part with lands, rising; nothing of any other."""
        if not self.piston.lands:
            return ()
        process, skirt_mm = self.process, self.piston.skirt_mm
        passes = [
            BandPass(planned.allowance_um / UM_PER_MM, planned.feed_mm or process.feed_mm)
            for planned in process.passes
        ] or [BandPass(0.0, process.feed_mm)]
        bands = [land.band(passes) for land in self.piston.lands]
        return tuple(
            sorted([Band("skirt", *skirt_mm, tuple(passes)), *bands], key=attrgetter("low_mm"))
        )

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
        first, last = self.piston.ends_mm
        return last - first + self.process.run_in_mm + self.process.run_out_mm


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
