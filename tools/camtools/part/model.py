"""What all part files share: read within bounds, parsed once, checked; findings with a remedy.

>>> str(wrong("demo", "is {odd}", "make it even").message())
'is (odd)'
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import (
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    GetJsonSchemaHandler,
    StringConstraints,
    Tag,
    ValidationError,
    ValidationInfo,
)
from pydantic_core import ErrorDetails, PydanticCustomError, core_schema

from camtools.base.errors import CamtoolsError, InputError, one_line
from camtools.base.files import read_limited, utf8_text
from camtools.base.text import toml_tree

MIN_SPAN_MM = 1.0
MIN_STEP_MM = 0.01
SAME_MM = 1e-9  # decimal heights differ by less from what they are written as

Entry = TypeVar("Entry")
MAX_HEIGHT_MM = 1000
HeightMm = Annotated[float, Field(ge=-MAX_HEIGHT_MM, le=MAX_HEIGHT_MM)]
FilePath = Annotated[str, StringConstraints(min_length=1, max_length=1000)]
Points = Annotated[list[Entry], Field(min_length=2, max_length=1000)]


# Members have these tags: findings leave them out.
LIST_OR_ONE = Discriminator(lambda value: "(list)" if isinstance(value, list) else "(one)")
NumberOrPoints = Annotated[
    Annotated[Points[Entry], Tag("(list)")] | Annotated[Entry, Tag("(one)")], LIST_OR_ONE
]


class TomlTable(BaseModel):
    """A TOML table that knows all its keys."""

    model_config = ConfigDict(
        strict=True, extra="forbid", frozen=True, allow_inf_nan=False, validate_default=True
    )


def wrong(kind: str, problem: str, remedy: str, **context: Any) -> PydanticCustomError:  # noqa: ANN401
    """Return a finding with its remedy."""
    text = problem.replace("{", "(").replace("}", ")")
    return PydanticCustomError(kind, text, {"remedy": remedy, **context})


@dataclass(frozen=True)
class Only:
    """Annotation of a key that has a meaning for some choices of another key alone."""

    chooser: str  # the other key, which stands before this one
    choices: tuple[str, ...]
    needed: tuple[str, ...] = ()  # choices that cannot do without the key
    or_else: str = ""  # what else serves where the key is needed

    def check(self, value: object, info: ValidationInfo) -> object:
        """Refuse the key where it has no meaning, and its absence where it is needed."""
        chosen = info.data.get(self.chooser)
        if value is not None and chosen is not None and chosen not in self.choices:
            problem = f'{info.field_name} has no meaning for {self.chooser} = "{chosen}"'
            remedy = f'remove it, or set {self.chooser} = "{self.choices[0]}"'
            raise wrong("foreign", problem, remedy)
        if value is None and chosen in self.needed:
            problem = f'is missing for {self.chooser} = "{chosen}"'
            raise wrong("needed", problem, f"add it{self.or_else}")
        return value

    def __get_pydantic_core_schema__(
        self, source: object, handler: Callable[[object], core_schema.CoreSchema]
    ) -> core_schema.CoreSchema:
        return core_schema.with_info_after_validator_function(self.check, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        return handler(schema) | {"x-only": list(self.choices), "x-needed": bool(self.needed)}


def rising(height_mm: list[float]) -> list[float]:
    """Return heights that increase in steps and over a span that a lathe can resolve."""
    for lower, upper in pairwise(height_mm):
        if upper - lower < MIN_STEP_MM - SAME_MM:
            problem = f"heights must increase by at least {MIN_STEP_MM} mm, but {upper} mm "
            raise wrong("rising", problem + f"follows {lower} mm", "list the points upwards")
    if height_mm[-1] - height_mm[0] < MIN_SPAN_MM - SAME_MM:
        problem = f"the height range must be at least {MIN_SPAN_MM} mm"
        raise wrong("span", problem, "give heights in mm")
    return height_mm


def as_long(values: list[float], info: ValidationInfo) -> list[float]:
    """Return values, one for each of the heights given before them."""
    height_mm = info.data.get("height_mm")
    if height_mm is not None and len(values) != len(height_mm):
        problem = f"has {len(values)} entries, height_mm has {len(height_mm)}"
        raise wrong("length", problem, "give one value for each height")
    return values


def no_truth(value: object) -> object:
    """Refuse true for a direction: it equals 1 in Python, but not on a drawing."""
    if isinstance(value, bool):
        raise wrong("direction", "must be 1 or -1", "use one of: 1 or -1")
    return value


def beside_the_part(value: str | None, info: ValidationInfo) -> str | None:
    """Return a path that the part file gives relative to the part file's folder.

    Where the context says `is_confined` a path that leaves the folder is refused, by whatever
    links: text of somebody else must not read what is no part of his.
    """
    context = info.context or {}
    folder = context.get("folder")
    if value is not None and is_step(value):
        raise wrong("step", *STEP)
    if value is None or folder is None:
        return value
    if context.get("is_confined") and not is_inside(value, Path(folder)):
        remedy = "give the name of a file in the folder of the part, without .. or links"
        raise wrong("outside", "leads out of the folder of the part", remedy)
    return str(Path(folder) / value)


STEP = "STEP files are out of scope", "export the half profile as DXF, or points as CSV"


def is_step(name: str) -> bool:
    """Return whether the name of a file is that of a model in STEP."""
    return name.lower().endswith((".step", ".stp"))


def is_inside(name: str, folder: Path) -> bool:
    """Return whether a file is in a folder, by whatever links, and would be in a copy of it."""
    try:
        place = (folder / name).resolve()
        is_plain = not Path(name).is_absolute() and ".." not in Path(name).parts
        return is_plain and place.is_relative_to(folder.resolve())
    except (OSError, ValueError, RuntimeError):  # a NUL, a name too long, links in a circle
        return False


_PROBLEMS = {
    "missing": "is missing",
    "extra_forbidden": "unknown key",
    "string_pattern_mismatch": "not a usable name",
}
_REMEDIES = {
    "missing": "add it",
    "extra_forbidden": "remove it or correct its spelling; tools/docs/PARTFILE.md lists every key",
    "finite_number": "give a finite number",
    "float_type": "give a number without quotes",
    "string_type": 'give text in "quotes"',
    "list_type": "give a list: [value, value]",
    "model_type": "give a table: [name] on a line of its own",
    "model_attributes_type": "give a table: [name] on a line of its own",
    "greater_than_equal": "give at least {ge}",
    "greater_than": "give more than {gt}",
    "less_than_equal": "give at most {le}",
    "too_short": "give at least {min_length} entries",
    "too_long": "give at most {max_length} entries",
    "string_too_short": "give at least {min_length} characters",
    "string_too_long": "give at most {max_length} characters",
    "string_pattern_mismatch": "use 1 to 31 letters, digits, _ and -, a letter or digit first",
    "literal_error": "use one of: {expected}",
}


def remedy_for(kind: str, context: Mapping[str, Any]) -> str:
    """Return what the user can do about a pydantic error of this kind."""
    if "remedy" in context:
        return str(context["remedy"])
    return _REMEDIES.get(kind, "see tools/docs/PARTFILE.md").format_map(context)


def describe(file: str, finding: ErrorDetails) -> str:
    """Return one finding as one line."""
    context = finding.get("ctx", {})
    path = [str(step) for step in finding["loc"]] + [context.get("field", "")]
    shown = (step for step in path if step and not step.startswith("("))  # not a union's member
    field = one_line(".".join(shown))
    hides_value = finding["type"] in ("missing", "extra_forbidden")  # it may be of another kind
    value = None if hides_value else context.get("value", finding["input"])
    problem = _PROBLEMS.get(finding["type"], finding["msg"])
    remedy = remedy_for(finding["type"], context)
    if finding["type"] == "list_type" and isinstance(finding["input"], dict):
        value, remedy = None, f"write [[{field}]], in double brackets, for each entry"
    return str(InputError(file, field, value, problem, remedy))


def describe_all(file: str, error: ValidationError) -> list[str]:
    """Return all findings, a line each; of a part of unknown kind only the kind."""
    findings = error.errors(include_url=False)
    of_kind = [finding for finding in findings if finding["loc"] == ("part", "kind")]
    return [describe(file, finding) for finding in of_kind or findings]


Model = TypeVar("Model", bound=TomlTable)
MAX_FILE_BYTES = 1_000_000


def read_tree(data: bytes, file: str) -> dict[str, Any]:
    """Return the tables of a TOML file, or refuse what is no UTF-8 or no TOML."""
    try:
        return toml_tree(utf8_text(data, file))
    except ValueError as error:
        problem, remedy = f"not TOML: {error}", "correct it; see tools/docs/PARTFILE.md"
        raise InputError(file, "", None, problem, remedy) from error


FILE_KEYS = ("csv", "dxf")  # each names a file, in whatever table it stands


def files_named(tree: object) -> list[str]:
    """Return the paths of all files that the tables of a part file name."""
    if isinstance(tree, list):
        return [name for entry in tree for name in files_named(entry)]
    if not isinstance(tree, dict):
        return []
    own = [tree[key] for key in FILE_KEYS if isinstance(tree.get(key), str)]
    others = (entry for key, entry in tree.items() if key not in FILE_KEYS)
    return own + [name for entry in others for name in files_named(entry)]


def validated(
    model: type[Model], tree: dict[str, Any], file: str, context: dict[str, object]
) -> Model:
    """Return tables checked in a context: the folder of the file, the names of all kinds."""
    try:
        return model.model_validate(tree, context=context)
    except ValidationError as error:
        raise CamtoolsError(describe_all(file, error)) from error


def read_part_file(path: Path) -> bytes:
    """Return the content of a part file, or refuse what cannot be read or is too large."""
    if is_step(path.name):
        raise InputError(str(path), "", None, *STEP)
    try:
        return read_limited(path, MAX_FILE_BYTES)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        remedy = "give the path of a part file (TOML)"
        raise InputError(str(path), "", None, f"cannot be read: {reason}", remedy) from error
