"""Profile and ovality that a file gives: keys of the part file, and the lists that they stand for.

>>> ProfileFile(csv="skirt.csv", values="drop-um", nominal_mm=92).quantities()[0].unit_mm
0.001
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Self

from pydantic import AfterValidator, Field, ValidationError, ValidationInfo, model_validator

from camtools.base.errors import CamtoolsError
from camtools.part.model import FilePath, TomlTable, beside_the_part, remedy_for, wrong
from camtools.skirt.part.dxf_contour import MAX_RADIUS_MM, MIN_RADIUS_MM, read_contour
from camtools.skirt.part.over_height import HEIGHT, Quantity, read_over_height
from camtools.table.points import MM_PER_INCH

DiameterMm = Annotated[float, Field(ge=2 * MIN_RADIUS_MM, le=2 * MAX_RADIUS_MM)]
ColumnNumber = Annotated[int, Field(ge=1)]
PartsFile = Annotated[FilePath, AfterValidator(beside_the_part)]
Unit = Literal["mm", "inch"]
_NEEDS = {
    **dict.fromkeys(("values", "columns", "nominal_mm"), ("csv",)),
    **dict.fromkeys(("layer", "axis"), ("dxf",)),
    "unit": ("csv", "dxf"),
}
_LISTED = {"radius": 2, "drop": -2}  # what 1 mm of a quantity is in the list of the part file


class Given(NamedTuple):
    """What a file gives."""

    keys: dict[str, Any]  # in place of those of the file
    words: str  # how it was understood


class CurveFile(TomlTable):
    """Keys that name a file with a curve over the height, and state what it does not."""

    VALUE: ClassVar[str]  # its list in the part file
    KINDS: ClassVar[dict[str, Quantity]]  # what its values may be

    csv: PartsFile | None = Field(
        None,
        description="instead of the lists: [a table](PISTONS.md#from-csv-and-dxf); path relative "
        "to the part file",
    )
    values: str | None = None
    columns: Annotated[list[ColumnNumber], Field(min_length=2, max_length=2)] | None = Field(
        None, description="of `csv`: numbers of height and value; without it by the header, or 1, 2"
    )
    unit: Unit | None = Field(None, description="of `csv`, where its header names none; usually mm")

    @model_validator(mode="after")
    def _check_together(self) -> Self:
        """Refuse two files, and keys of a file that is not named."""
        files = [name for name in ("csv", "dxf") if getattr(self, name, None) is not None]
        if len(files) > 1:
            raise wrong("two", "cannot be combined with csv", "remove one", field="dxf", value=None)
        for key, owners in _NEEDS.items():
            value = getattr(self, key, None)
            if value is not None and not set(owners) & set(files):
                problem = f"has no meaning without {' or '.join(owners)}"
                raise wrong("foreign", problem, "remove it", field=key, value=value)
        return self

    def quantities(self) -> list[Quantity]:
        """Return what the values of the table may be."""
        kinds = [self.KINDS[self.values]] if self.values else self.KINDS.values()
        return [self._in_unit(kind) for kind in kinds]

    def _in_unit(self, kind: Quantity) -> Quantity:
        is_inch = self.unit == "inch" and kind.unit_mm == 1
        return kind._replace(unit_mm=MM_PER_INCH) if is_inch else kind

    def given(self) -> Given:
        """Return what the file gives, or raise CamtoolsError with line and column."""
        path = Path(self.csv or "")
        found = read_over_height(path, self._in_unit(HEIGHT), self.quantities(), self.columns)
        nominal_mm = getattr(self, "nominal_mm", None)
        if (found.name == "drop") != (nominal_mm is not None):
            problem, remedy = "is missing: the file gives drops", "add the diameter above them"
            if nominal_mm is not None:
                problem, remedy = f"has no meaning: the file gives the {found.name}", "remove it"
            raise wrong("nominal", problem, remedy, field="nominal_mm", value=nominal_mm)
        values = (nominal_mm or 0.0) + found.values_mm * _LISTED.get(found.name, 1)
        keys = {"height_mm": found.z_mm.tolist(), self.VALUE: values.tolist()}
        return Given(keys, f"{path.name}: {found.words}")


class ProfileFile(CurveFile):
    """Keys of a file with a profile."""

    VALUE = "diameter_mm"
    KINDS: ClassVar[dict[str, Quantity]] = {
        "diameter": Quantity("diameter", ("diameter", "dia", "d"), 1.0, (1, 2 * MAX_RADIUS_MM)),
        "radius": Quantity("radius", ("radius", "r"), 1.0, (MIN_RADIUS_MM, MAX_RADIUS_MM)),
        "drop-um": Quantity("drop", ("drop",), 1e-3, (-15, 15)),
    }

    values: Literal["diameter", "radius", "drop-um"] | None = Field(
        None, description="of `csv`, where its header does not name them; drops are of the radius"
    )
    nominal_mm: DiameterMm | None = Field(None, description="diameter from which drops count")
    dxf: PartsFile | None = Field(
        None, description="instead of the lists: lines and arcs of the half profile; path likewise"
    )
    layer: FilePath | None = Field(None, description="of `dxf`, where several have entities")
    axis: Literal["y", "x"] | None = Field(None, description="of the part in `dxf`; usually y")
    unit: Unit | None = Field(
        None,
        description="of `csv`, where its header names none, usually mm; of `dxf`, usually by "
        "$INSUNITS",
    )

    def given(self) -> Given:
        """See `CurveFile.given`; a contour gives its segments."""
        if self.dxf is None:
            return super().given()
        path = Path(self.dxf)
        edges, words = read_contour(path, self.layer, self.axis or "y", self.unit)
        segments = []
        for edge in edges:
            arc = {"kind": "arc", "radius_mm": edge.radius_mm} if edge.radius_mm else {}
            segments.append({"to_mm": edge.high[0], "diameter_mm": 2 * edge.high[1], **arc})
        first = {"height_mm": [edges[0].low[0]], "diameter_mm": [2 * edges[0].low[1]]}
        keys = {"interpolation": "segments", **first, "segment": segments}
        return Given(keys, f"{path.name}: {words}")


class OvalityFile(CurveFile):
    """Keys of a file with an ovality."""

    VALUE = "ovality_mm"
    KINDS: ClassVar[dict[str, Quantity]] = {
        "ovality-um": Quantity("ovality", ("ovality", "oval"), 1e-3, (0, 2 * MAX_RADIUS_MM)),
        "ovality": Quantity("ovality", ("ovality", "oval"), 1.0, (0, 2 * MAX_RADIUS_MM)),
    }

    values: Literal["ovality", "ovality-um"] | None = Field(
        None, description="of `csv`, where its header does not name them: in `unit`, or in µm"
    )


def given_by_file(
    model: type[CurveFile], table: Mapping[str, Any], info: ValidationInfo
) -> Given | None:
    """Return a table with what its file gives in place of the file's keys; None without a file.

    Raises PydanticCustomError: keys or file are wrong, or the table has what the file gives.
    """
    own = {key: table[key] for key in model.model_fields if table.get(key) is not None}
    if not own:
        return None
    try:
        found = model.model_validate(own, context=info.context).given()
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        about = {"value": first["input"]} | first.get("ctx", {})
        about["field"] = ".".join([*map(str, first["loc"]), about.get("field", "")]).strip(".")
        remedy = about.pop("remedy", "") or remedy_for(first["type"], about)
        raise wrong("key", first["msg"], remedy, **about) from error
    except CamtoolsError as error:
        problem, _, remedy = error.lines[0].partition("; ")
        name = "csv" if "csv" in own else "dxf"
        raise wrong("file", problem, remedy, field=name, value=None) from error
    for key in (*found.keys, "segment"):
        if key in table:
            problem = "cannot be combined with a file, which gives it"
            raise wrong("twice", problem, "remove one of them", field=key, value=None)
    others = {key: value for key, value in table.items() if key not in model.model_fields}
    return found._replace(keys=others | found.keys)
