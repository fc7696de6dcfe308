"""[piston.profile] and [piston.ovality] of a part file: what varies over the height.

>>> barrel = {"to_mm": 60, "diameter_mm": 91.7, "kind": "arc", "radius_mm": 6000}
>>> cone = {"to_mm": 2, "diameter_mm": 91.95}
>>> start = {"interpolation": "segments", "height_mm": [0], "diameter_mm": [91]}
>>> Profile.model_validate(start | {"segment": [cone, barrel]}).diameter_mm
[91.0, 91.95, 91.7]
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, ValidationInfo, field_validator, model_validator

from camtools.part.model import HeightMm, TomlTable, as_long, rising, wrong
from camtools.part.smoothing import ORDER, SmoothUm
from camtools.skirt.part.segments import DrawnSegment, Piece, SegmentError, join

MAX_POINTS = 1000
DiameterMm = Annotated[float, Field(ge=1, le=4000)]
OvalityMm = Annotated[float, Field(ge=0, le=4000)]
SlopeMmPerMm = Annotated[float, Field(ge=-100, le=100)]
USUAL_OVERSHOOT_UM = 1.0  # what a curve may leave its points by without a word
OvershootUm = Annotated[float, Field(ge=0, le=1e6)]
RadiusMm = Annotated[float, Field(ge=-1e6, le=1e6)]
Drawn = Literal["linear", "pchip", "akima", "spline", "segments"]
_LONG = Field(max_length=MAX_POINTS)
_AT_END = "at its end; without it it follows from `tangent`"


class Segment(TomlTable):
    """A line or an arc up to a height; subclasses have the value there."""

    to_mm: HeightMm = Field(description="height of its end")
    kind: Literal["line", "arc"] = "line"
    radius_mm: RadiusMm | None = Field(
        None,
        description="of an arc, not 0; positive is convex, negative hollow; without it it follows "
        "from `tangent`",
    )
    tangent: bool = Field(
        False,
        description="continues the direction of the previous segment; if all numbers are given, "
        "checked to 0.01 degrees",
    )

    @property
    def end(self) -> float | None:
        """Return the value at its end, if it is given."""
        raise NotImplementedError

    def check(self, key: str, *, is_first: bool) -> None:
        """Refuse what leaves the segment open, or says it twice."""
        if is_first and self.tangent:
            raise wrong("tangent", "has no segment before it", "leave out tangent of the first")
        if self.kind == "line" and self.radius_mm is not None:
            raise wrong("radius", "a line has no radius_mm", 'remove it, or set kind = "arc"')
        if self.kind == "arc" and not self.radius_mm and not self.tangent:
            problem = "an arc needs radius_mm (not 0), or tangent = true and its end"
            raise wrong("radius", problem, "add one of them")
        is_open = not self.tangent or (self.kind == "arc" and not self.radius_mm)
        if is_open and self.end is None:
            raise wrong("end", f"needs {key}, which does not follow", f"add {key}")


class ProfileSegment(Segment):
    """[[piston.profile.segment]]: upwards, with `interpolation = "segments"`."""

    diameter_mm: DiameterMm | None = Field(None, description=_AT_END)

    @property
    def end(self) -> float | None:
        """See `Segment.end`."""
        return self.diameter_mm


class OvalitySegment(Segment):
    """[[piston.ovality.segment]]: as of the profile, in the plane of height and ovality."""

    ovality_mm: OvalityMm | None = Field(None, description=_AT_END)

    @property
    def end(self) -> float | None:
        """See `Segment.end`."""
        return self.ovality_mm


Segments = list[ProfileSegment] | list[OvalitySegment]


def _checked_heights(value: list[float], info: ValidationInfo) -> list[float]:
    """Return heights that rise; with segments the first may be the only one."""
    if info.data.get("interpolation") == "segments" and len(value) == 1:
        return value
    if len(value) < 2:
        raise wrong("short", "has too few entries", "give at least 2 entries")
    return rising(value)


def joined(start_mm: float, value: float, segments: Segments, scale: int) -> tuple[Piece, ...]:
    """Return segments with all their numbers, see `join`; values are divided by scale."""
    ends = [None if one.end is None else one.end / scale for one in segments]
    steps = [
        DrawnSegment(one.to_mm, end, one.kind, one.radius_mm, one.tangent)
        for one, end in zip(segments, ends, strict=True)
    ]
    return join(start_mm, value / scale, tuple(steps))


def _points(
    heights: list[float], values: list[float], segments: Segments, key: str, scale: int
) -> tuple[list[float], list[float]]:
    """Return the points at which segments begin and end: those of the drawing and derived ones."""
    z_mm = rising([heights[0], *(one.to_mm for one in segments)])
    for i, one in enumerate(segments):
        one.check(key, is_first=i == 0)
    try:
        pieces = joined(heights[0], values[0], segments, scale)
    except SegmentError as error:
        context = {"field": f"segment.{error.index}.{error.key}", "value": None}
        raise wrong("segment", error.problem, error.remedy, **context) from error
    return z_mm, [values[0], *(scale * one.value_mm for one in pieces)]


def _check_smooth(curve: Profile | Ovality) -> None:
    """Refuse smoothing of what it cannot change."""
    if curve.smooth_um is None:
        return
    problem, n = "", len(curve.height_mm)
    if curve.segment:
        problem = "lines and arcs are exact, only points are smoothed"
    elif n <= ORDER:
        problem = f"smoothing changes nothing with {n} points, it needs {ORDER + 1}"
    if problem:
        context = {"field": "smooth_um", "value": curve.smooth_um}
        raise wrong("smooth", problem, "remove it, or list more points", **context)


def _completed(curve: Profile | Ovality, key: str, scale: int) -> dict[str, list[float]]:
    """Return the points of a curve over the height with the ends of its segments, if it has any."""
    if (curve.interpolation == "segments") != (len(curve.segment) > 0):
        problem = 'interpolation = "segments" and the tables "segment" belong together'
        context = {"field": "interpolation", "value": curve.interpolation}
        raise wrong("segments", problem, "give both or neither", **context)
    _check_smooth(curve)
    if not curve.segment:
        return {}
    z_mm, values = _points(curve.height_mm, getattr(curve, key), curve.segment, key, scale)
    return {"height_mm": z_mm, key: values}


class Profile(TomlTable):
    """[piston.profile]: long-axis diameter over skirt height."""

    interpolation: Drawn = Field(
        "spline",
        description="[curve between the points](PISTONS.md#between-the-points-of-a-drawing); with "
        "segments both lists have the first point only",
    )
    height_mm: Annotated[list[HeightMm], _LONG] = Field(
        description="skirt heights, 2 or more, rising by at least 0.01, at least 1 in all; the "
        "table covers this range"
    )
    diameter_mm: Annotated[list[DiameterMm], _LONG] = Field(
        description="long-axis diameter, one per height"
    )
    spline: Literal["clamped", "not-a-knot", "natural"] = Field(
        "not-a-knot", description="ends of the cubic spline"
    )
    end_slopes: Annotated[list[SlopeMmPerMm], Field(min_length=2, max_length=2)] | None = Field(
        None, description="of the radius at the lower and upper end, with `clamped` only [mm/mm]"
    )
    overshoot_um: OvershootUm = Field(
        USUAL_OVERSHOOT_UM,
        description="how far the diameter may exceed the two neighbouring points; not checked on "
        "an arc with given `radius_mm`",
    )
    smooth_um: SmoothUm | None = Field(
        None,
        description="[smoothing](PISTONS.md#rounded-points): the points move by at most this; not "
        "with segments",
    )
    segment: list[ProfileSegment] = Field(default_factory=list, max_length=MAX_POINTS)

    _check_height = field_validator("height_mm")(_checked_heights)
    _check_length = field_validator("diameter_mm")(as_long)

    @field_validator("spline")
    @classmethod
    def _check_spline(cls, value: str, info: ValidationInfo) -> str:
        kind = info.data.get("interpolation")
        if kind is not None and kind != "spline" and value != "not-a-knot":
            problem = f'has no meaning for interpolation = "{kind}"'
            raise wrong("foreign", problem, 'remove it, or set interpolation = "spline"')
        return value

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

    @model_validator(mode="after")
    def _complete(self) -> Self:
        """Add the ends of the segments to the points."""
        added = _completed(self, "diameter_mm", 2)
        return self.model_copy(update=added) if added else self


class Ovality(TomlTable):
    """[piston.ovality]: G = 2a - 2b over height; not with `shape = "table"` or `"points"`."""

    interpolation: Drawn = Field(
        "linear",
        description="spline: not-a-knot, or a line or parabola through 2 or 3 points; also of "
        "`trim_mm` and `joint_deg`, which are linear with segments",
    )
    height_mm: Annotated[list[HeightMm], _LONG] = Field(
        description="as of the profile, whose range it covers; independent of the profile's heights"
    )
    ovality_mm: Annotated[list[OvalityMm], _LONG] = Field(
        description="long minus short axis (diametral), one per height, below the smallest diameter"
    )
    overshoot_um: OvershootUm = Field(
        USUAL_OVERSHOOT_UM,
        description="as of the profile, for the ovality and `trim_mm` (`joint_deg`: 0.1 degrees)",
    )
    smooth_um: SmoothUm | None = Field(
        None, description="as of the profile, of the ovality; never below 0"
    )
    segment: list[OvalitySegment] = Field(default_factory=list, max_length=MAX_POINTS)

    _check_height = field_validator("height_mm")(_checked_heights)
    _check_length = field_validator("ovality_mm")(as_long)

    @model_validator(mode="after")
    def _complete(self) -> Self:
        """Add the ends of the segments to the points."""
        added = _completed(self, "ovality_mm", 1)
        return self.model_copy(update=added) if added else self
