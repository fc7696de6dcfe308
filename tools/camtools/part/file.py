r"""A part file as it lies on the disk: read within bounds, parsed once, checked against a model.

>>> read_tree(b'[part]\nname = "a"\n', "a.toml")
{'part': {'name': 'a'}}
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from camtools.base.errors import CamtoolsError, InputError
from camtools.base.input_file import read_limited
from camtools.base.toml_text import toml_tree
from camtools.part.findings import describe_all
from camtools.part.model import TomlTable

Model = TypeVar("Model", bound=TomlTable)
MAX_FILE_BYTES = 1_000_000


def read_tree(data: bytes, file: str) -> dict[str, Any]:
    """Return the tables of a TOML file.

    Parameters
    ----------
    data : bytes
        Whole content of the file, UTF-8.
    file : str
        Name for error messages.

    Raises
    ------
    InputError
        Not UTF-8 or not TOML.
    """
    try:
        return toml_tree(data.decode("utf-8"))
    except UnicodeDecodeError as error:
        problem = f"not UTF-8 text (byte {error.start} is 0x{data[error.start]:02x})"
        raise InputError(file, "", None, problem, "save the file as UTF-8") from error
    except ValueError as error:
        problem = f"not TOML: {error}"
        raise InputError(
            file, "", None, problem, "correct it; see tools/docs/PARTFILE.md"
        ) from error


def files_named(tree: object) -> list[str]:
    """Return the paths of all files that the tables of a part file name.

    >>> files_named({"cam": {"lobe": [{"csv": "a.csv"}, {"csv": "b.csv"}]}})
    ['a.csv', 'b.csv']
    """
    if isinstance(tree, list):
        return [name for one in tree for name in files_named(one)]
    if not isinstance(tree, dict):
        return []
    own = [tree["csv"]] if isinstance(tree.get("csv"), str) else []
    return own + [name for key, one in tree.items() if key != "csv" for name in files_named(one)]


def validated(
    model: type[Model], tree: dict[str, Any], file: str, context: dict[str, object]
) -> Model:
    """Return the tables of a part file as a model.

    Parameters
    ----------
    context : dict
        What the fields are checked against: the folder of the file, the names of all kinds.

    Raises
    ------
    CamtoolsError
        Fields are wrong: one line each, in the file's order of tables.
    """
    try:
        return model.model_validate(tree, context=context)
    except ValidationError as error:
        raise CamtoolsError(describe_all(file, error)) from error


def read_part_file(path: Path) -> bytes:
    """Return the content of a part file.

    Raises
    ------
    InputError
        It cannot be read, is no file, or is too large.
    """
    try:
        return read_limited(path, MAX_FILE_BYTES)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        remedy = "give the path of a part file (TOML)"
        raise InputError(str(path), "", None, f"cannot be read: {reason}", remedy) from error
