r"""A part file as it lies on the disk: read within bounds, parsed once, checked against a model.

>>> read_tree(b'[part]\nname = "a"\n', "a.toml")
{'part': {'name': 'a'}}
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from camtools.base.errors import CamtoolsError, InputError, one_line
from camtools.base.files import read_limited
from camtools.base.text import toml_tree
from camtools.part.model import TomlTable

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
    value = None if finding["type"] == "missing" else context.get("value", finding["input"])
    problem = _PROBLEMS.get(finding["type"], finding["msg"])
    return str(InputError(file, field, value, problem, remedy_for(finding["type"], context)))


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
        return toml_tree(data.decode("utf-8"))
    except UnicodeDecodeError as error:
        problem = f"not UTF-8 text (byte {error.start} is 0x{data[error.start]:02x})"
        raise InputError(file, "", None, problem, "save the file as UTF-8") from error
    except ValueError as error:
        problem, remedy = f"not TOML: {error}", "correct it; see tools/docs/PARTFILE.md"
        raise InputError(file, "", None, problem, remedy) from error


def files_named(tree: object) -> list[str]:
    """Return the paths of all files that the tables of a part file name."""
    if isinstance(tree, list):
        return [name for one in tree for name in files_named(one)]
    if not isinstance(tree, dict):
        return []
    own = [tree["csv"]] if isinstance(tree.get("csv"), str) else []
    return own + [name for key, one in tree.items() if key != "csv" for name in files_named(one)]


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
    try:
        return read_limited(path, MAX_FILE_BYTES)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        remedy = "give the path of a part file (TOML)"
        raise InputError(str(path), "", None, f"cannot be read: {reason}", remedy) from error
