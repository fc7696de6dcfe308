"""[piston.profile], [piston.ovality], [piston.section] and [piston.antithrust] of a part file.

>>> SectionShape(shape="ellipse-arc", trim_mm=0.3, joint_deg=50).base
'cosine'
>>> Antithrust(height_mm=[0, 60], drop_mm=[0.01, 0.03]).meet
'short-axis'
"""

from typing import Annotated, ClassVar, Literal, Self

from pydantic import (
    Field,
    ModelWrapValidatorHandler,
    PrivateAttr,
    Tag,
    ValidationInfo,
    field_validator,
    model_validator,
)

from camtools.part.model import (
    LIST_OR_ONE,
    FilePath,
    HeightMm,
    NumberOrPoints,
    Only,
    Points,
    TomlTable,
    as_long,
    beside_the_part,
    rising,
    wrong,
)
from camtools.part.smoothing import ORDER, SmoothUm
from camtools.skirt.part.curves import DrawnSegment, Interpolation, Piece, SegmentError, join
from camtools.skirt.part.imported import (
    CurveFile,
    DiameterMm,
    OvalityFile,
    ProfileFile,
    given_by_file,
)
from camtools.skirt.part.over_height import MAX_POINTS

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

    VALUE: ClassVar[str]  # its key

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
        found: float | None = getattr(self, self.VALUE)
        return found

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

    VALUE = "diameter_mm"
    diameter_mm: DiameterMm | None = Field(None, description=_AT_END)


class OvalitySegment(Segment):
    """[[piston.ovality.segment]]: as of the profile, in the plane of height and ovality."""

    VALUE = "ovality_mm"
    ovality_mm: OvalityMm | None = Field(None, description=_AT_END)


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
    ends = [None if segment.end is None else segment.end / scale for segment in segments]
    steps = [
        DrawnSegment(segment.to_mm, end, segment.kind, segment.radius_mm, segment.tangent)
        for segment, end in zip(segments, ends, strict=True)
    ]
    return join(start_mm, value / scale, tuple(steps))


def _points(
    heights: list[float], values: list[float], segments: Segments, key: str, scale: int
) -> tuple[list[float], list[float]]:
    """Return the points at which segments begin and end: those of the drawing and derived ones."""
    z_mm = rising([heights[0], *(segment.to_mm for segment in segments)])
    for i, segment in enumerate(segments):
        segment.check(key, is_first=i == 0)
    try:
        pieces = joined(heights[0], values[0], segments, scale)
    except SegmentError as error:
        context = {"field": f"segment.{error.index}.{error.key}", "value": None}
        raise wrong("segment", error.problem, error.remedy, **context) from error
    return z_mm, [values[0], *(scale * piece.value_mm for piece in pieces)]


def _check_smooth(curve: "Profile | Ovality") -> None:
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


def _completed(curve: "Profile | Ovality", key: str, scale: int) -> dict[str, list[float]]:
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


class _Drawn(TomlTable):
    """A curve over the height that is drawn by points or segments."""

    VALUE: ClassVar[str]  # key of the listed values
    SCALE: ClassVar[int]  # of the curve's values in the listed ones: diameters are twice the radius
    FILE: ClassVar[type[CurveFile]]  # whose keys stand for the lists

    _understood: str = PrivateAttr("")

    @model_validator(mode="wrap")
    @classmethod
    def _read_file(
        cls, value: object, handler: ModelWrapValidatorHandler[Self], info: ValidationInfo
    ) -> Self:
        """Put what a file gives in the place of the keys that name the file."""
        given = given_by_file(cls.FILE, value, info) if isinstance(value, dict) else None
        made = handler(value if given is None else given.keys)
        if given is not None:
            made._understood = given.words
        return made

    @property
    def understood(self) -> str:
        """Return how the file was understood that gave the curve, nothing without one."""
        return self._understood

    @model_validator(mode="after")
    def _complete(self) -> Self:
        added = _completed(self, self.VALUE, self.SCALE)  # type: ignore[arg-type] # one of the two
        return self.model_copy(update=added) if added else self


class Profile(ProfileFile, _Drawn):
    """[piston.profile]: long-axis diameter over skirt height."""

    VALUE, SCALE, FILE = "diameter_mm", 2, ProfileFile

    interpolation: Drawn = Field(
        "spline",
        description="[curve between the points](PISTONS.md#between-the-points-of-a-drawing); with "
        "segments both lists have the first point only",
    )
    height_mm: Annotated[list[HeightMm], _LONG] = Field(
        description="skirt heights, 2 or more, rising by at least 0.01, at least 1 in all; the "
        "table covers this range",
        json_schema_extra={"x-or": ["csv", "dxf"]},
    )
    diameter_mm: Annotated[list[DiameterMm], _LONG] = Field(
        description="long-axis diameter, one per height",
        json_schema_extra={"x-or": ["csv", "dxf"]},
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


class Ovality(OvalityFile, _Drawn):
    """[piston.ovality]: G = 2a - 2b over height; not with `shape = "table"` or `"points"`."""

    VALUE, SCALE, FILE = "ovality_mm", 1, OvalityFile

    interpolation: Drawn = Field(
        "linear",
        description="spline: not-a-knot, or a line or parabola through 2 or 3 points; also of "
        "`trim_mm` and `joint_deg`, which are linear with segments",
    )
    height_mm: Annotated[list[HeightMm], _LONG] = Field(
        description="as of the profile, whose range it covers; independent of its heights",
        json_schema_extra={"x-or": ["csv"]},
    )
    ovality_mm: Annotated[list[OvalityMm], _LONG] = Field(
        description="long minus short axis (diametral), one per height, below the smallest "
        "diameter",
        json_schema_extra={"x-or": ["csv"]},
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


PlaceMm = Annotated[float, Field(ge=-4000, le=4000)]
CentreMm = Annotated[list[PlaceMm], Field(min_length=2, max_length=2)]
MAX_DELETE = 6

DeleteCount = Annotated[int, Field(ge=0, le=MAX_DELETE)]
DropMm = Annotated[float, Field(ge=-15, le=15)]
Phases = NumberOrPoints[Annotated[float, Field(ge=-360, le=360)]]
Betas = NumberOrPoints[Annotated[float, Field(ge=-6.25, le=6.25)]]
Exponents = NumberOrPoints[Annotated[float, Field(ge=2, le=8)]]
Trims = NumberOrPoints[Annotated[float, Field(ge=-100, le=100)]]
Joints = NumberOrPoints[Annotated[float, Field(ge=10, le=80)]]
Eccentricities = NumberOrPoints[Annotated[float, Field(ge=-1000, le=1000)]]
Delete = Annotated[
    Annotated[list[DeleteCount], Field(min_length=2, max_length=2), Tag("(list)")]
    | Annotated[Literal["optimise"], Tag("(one)")],
    LIST_OR_ONE,
]

GIVEN_BY_POINTS = ("table", "points")  # shapes without an ovality of their own
OVALS = ("ellipse", "cosine", "double-ellipse", "power")  # with a law of their own on either side
PARAMETERS = {"double-ellipse": "beta", "power": "exponent"}  # key of a law; others have none
_AS_SECTION = "as of the section; without it that of the section"
_POWER = Only("shape", ("power",), ("power",))
_ARC = Only("shape", ("ellipse-arc",))
_NEEDED_ARC = Only("shape", ("ellipse-arc",), ("ellipse-arc",))
_MEASURED = Only("shape", GIVEN_BY_POINTS)
_TABLE = Only("shape", ("table",))


class Refit(TomlTable):
    """[piston.section.refit]: replaces the corner, for a table; an analysis does without.

    MATHS.md (14) .. (16). The drawing's contour is sampled once per degree; points next to the
    joint are left out.
    """

    spline: Literal["cubic", "quintic"] = Field("quintic", description="through a point per degree")
    delete: Delete = Field(
        "optimise", description="points left out on the side of the oval and of the circle"
    )
    ends: Literal["mirror", "as-paper"] = "mirror"
    jerk_limit_mm_s3: float | None = Field(
        None,
        gt=0,
        le=1e15,
        description="of the jerk beyond the corner, for `optimise`; without it none, as-paper 1e7",
    )
    deviation_um: float | None = Field(
        None,
        gt=0,
        le=1000,
        description="largest deviation of the refit from the drawing, beyond which the part is "
        "refused with the nearest deletion; without it three quarters of `form_error_um`",
    )


class PointsAt(TomlTable):
    """[[piston.section.files]]: points: a file per height, rising."""

    z_mm: HeightMm
    csv: FilePath = Field(description="path relative to the part file")

    _beside_the_part = field_validator("csv")(beside_the_part)


class SectionShape(TomlTable):
    """[piston.section]: shape of every cross-section."""

    shape: Literal[
        "ellipse", "cosine", "double-ellipse", "power", "ellipse-arc", "table", "points"
    ] = Field(
        "ellipse",
        description="exact; (G/4)(1 - cos 2phi); fourth harmonic; power of the sine; oval and "
        "eccentric circle; measured; [imported](TABLES.md#export-and-import)",
    )
    base: Annotated[Literal["cosine", "ellipse", "double-ellipse"] | None, _ARC] = Field(
        None, description="the oval; without it cosine"
    )
    beta: Betas = Field(
        0.0,
        description="of double-ellipse, per height of the ovality: weight of the fourth harmonic, "
        "G beta / 50 more at 45 degrees",
    )
    exponent: Annotated[Exponents | None, _POWER] = Field(
        None,
        description="per height of the ovality: (G/2) |sin phi|^exponent; 2 is the cosine form",
    )
    phase_deg: Phases = Field(
        0.0,
        description="of an oval per height of the ovality: rotation of the whole section; not for "
        "ellipse-arc",
    )
    trim_mm: Annotated[Trims | None, _NEEDED_ARC] = Field(
        None, description="per height of the ovality: radial, below the oval at the short axis"
    )
    joint_deg: Annotated[Joints | None, _NEEDED_ARC] = Field(
        None, description="per height of the ovality: where the circle begins"
    )
    eccentricity_mm: Annotated[Eccentricities | None, _ARC] = Field(
        None, description="per height of the ovality: only checked, to 1 um at the joint"
    )
    refit: Annotated[Refit | None, _ARC] = None
    csv: Annotated[FilePath | None, _MEASURED] = Field(
        None,
        description="path relative to the part file: `angle_deg,z_mm,reduction_um`, or [other "
        "units and separators](PISTONS.md#measured-sections-scan-and-replay); of points [any "
        "columns](TABLES.md#export-and-import)",
    )
    centre_mm: Annotated[CentreMm | None, _TABLE] = Field(
        None,
        description="x and y of the part's axis in the coordinates of an [outline]"
        "(PISTONS.md#measured-sections-scan-and-replay) `x_mm,y_mm`; without it 0, 0",
    )
    harmonics: Annotated[int | None, _TABLE] = Field(
        None, ge=1, le=500, description="keeps waves up to this number per turn"
    )
    files: Annotated[
        Annotated[list[PointsAt], Field(min_length=2, max_length=1000)] | None,
        Only("shape", ("points",)),
    ] = None
    interpolation: Annotated[Interpolation | None, _TABLE] = Field(
        None, description="between the heights; without it spline from 4 heights up, else linear"
    )
    single_height: Annotated[bool | None, _MEASURED] = Field(
        None, description="the file has one height, which serves all"
    )
    overshoot_um: OvershootUm = Field(
        USUAL_OVERSHOOT_UM,
        description="of a table: beyond the neighbouring points, over height and over gaps in the "
        "angle",
    )

    @field_validator("base")
    @classmethod
    def _default_base(cls, value: str | None, info: ValidationInfo) -> str | None:
        return "cosine" if value is None and info.data.get("shape") == "ellipse-arc" else value

    @field_validator("beta")
    @classmethod
    def _check_beta(cls, value: float | list[float], info: ValidationInfo) -> float | list[float]:
        shape = info.data.get("shape", "double-ellipse")
        if isinstance(value, list) and shape == "ellipse-arc":
            problem = 'is a list, shape = "ellipse-arc" takes one number'
            raise wrong("one", problem, "give the beta of all heights")
        if value != 0 and "double-ellipse" not in (shape, info.data.get("base")):
            problem = f'beta has no meaning for shape = "{shape}"'
            raise wrong("beta", problem, 'set it to 0, or shape = "double-ellipse"')
        return value

    @field_validator("phase_deg")
    @classmethod
    def _check_phase(cls, value: float | list[float], info: ValidationInfo) -> float | list[float]:
        shape = info.data.get("shape")
        if value != 0 and shape == "ellipse-arc":
            problem = 'phase_deg has no meaning for shape = "ellipse-arc"'
            remedy = "remove it, and set index_offset_udeg of the controller"
            raise wrong("foreign", problem, remedy)
        if isinstance(value, list) and shape in GIVEN_BY_POINTS:
            problem = f'is a list, shape = "{shape}" has no heights of ovality'
            raise wrong("one", problem, "give one number")
        return value

    @field_validator("files")
    @classmethod
    def _check_files(cls, value: list[PointsAt] | None) -> list[PointsAt] | None:
        rising([file.z_mm for file in value or []] or [0.0, 1.0])
        return value

    @model_validator(mode="after")
    def _check_source(self) -> Self:
        if self.shape == "table" and self.csv is None:
            problem = 'is missing for shape = "table"'
            raise wrong("needed", problem, "add it", field="csv", value=None)
        if self.shape == "points" and (self.csv is None) == (self.files is None):
            problem = 'shape = "points" needs either csv or [[piston.section.files]]'
            raise wrong("points", problem, "give one of them", field="csv", value=self.csv)
        return self

    _beside_the_part = field_validator("csv")(beside_the_part)

    @property
    def centre(self) -> tuple[float, float] | None:
        """Return x and y of the axis in the coordinates of an outline [mm]."""
        return None if self.centre_mm is None else (self.centre_mm[0], self.centre_mm[1])


class Antithrust(TomlTable):
    """[piston.antithrust]: the [other half](PISTONS.md#thrust-and-anti-thrust-sides) of an oval.

    MATHS.md (77), (78). The tables profile, ovality and section describe the thrust side, whose
    middle is at 0 degrees where the sides meet at the short axis, at 90 degrees where they meet at
    the long axis; the middle of this side is opposite.
    """

    meet: Literal["short-axis", "long-axis"] = Field(
        "short-axis",
        description="where the sides meet: this side is the half about 180 degrees, or about 270",
    )
    blend_deg: float = Field(30.0, ge=2, le=120, description="width of the two transition zones")
    interpolation: Interpolation = Field("linear", description="of the lists of this side")
    overshoot_um: OvershootUm = Field(
        USUAL_OVERSHOOT_UM, description="as of the profile, for `drop_mm` and `ovality_mm`"
    )
    height_mm: Points[HeightMm] = Field(
        description="rising, covers the profile's range; heights of the lists of this side"
    )
    drop_mm: Points[DropMm] | None = Field(
        None,
        description="per height: its radius at the long axis is less than the profile's by this; "
        "without it 0",
    )
    ovality_mm: Points[OvalityMm] | None = Field(
        None,
        description="per height: long minus short axis of this side (diametral); without it the "
        'short axis is common; needed with `meet = "long-axis"`',
    )
    phase_deg: Phases = Field(0.0, description="rotation of this side alone")
    beta: Betas | None = Field(None, description=_AS_SECTION)
    exponent: Exponents | None = Field(None, description=_AS_SECTION)

    _check_height = field_validator("height_mm")(rising)

    @field_validator("drop_mm", "ovality_mm", "phase_deg", *PARAMETERS.values())
    @classmethod
    def _check_length(cls, value: object, info: ValidationInfo) -> object:
        return as_long(value, info) if isinstance(value, list) else value

    @model_validator(mode="after")
    def _check_something(self) -> Self:
        if self.meet == "long-axis" and self.ovality_mm is None:
            context = {"field": "ovality_mm", "value": None}
            problem = "is missing: sides that meet at the long axis differ by it"
            problem += ' (meet = "long-axis")'
            raise wrong("needed", problem, "add it, one value for each height", **context)
        return self


def check_sides(antithrust: Antithrust, shape: str, ends_mm: tuple[float, float]) -> None:
    """Refuse another side where the section has none, or which does not cover the profile."""
    if shape not in OVALS:
        context: dict[str, object] = {"field": "section.shape", "value": shape}
        problem = "has no sides: the table [piston.antithrust] is for ovals"
        raise wrong("sides", problem, f"remove it, or set one of: {', '.join(OVALS)}", **context)
    if antithrust.height_mm[0] > ends_mm[0] or antithrust.height_mm[-1] < ends_mm[1]:
        context = {"field": "antithrust.height_mm", "value": antithrust.height_mm}
        problem = f"must cover the profile's heights {ends_mm[0]} .. {ends_mm[1]} mm"
        raise wrong("cover", problem, "add points at the ends", **context)
    for owner, key in PARAMETERS.items():
        if getattr(antithrust, key) is not None and shape != owner:
            context = {"field": f"antithrust.{key}", "value": getattr(antithrust, key)}
            problem = f'has no meaning for shape = "{shape}"'
            raise wrong("foreign", problem, f'remove it, or set shape = "{owner}"', **context)
