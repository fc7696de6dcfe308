r"""From a part file to its kind and its part.

>>> text = b'[part]\nname = "a"\nkind = "cam"\nsource = "b"\n'
>>> parse(text, "a.toml")
Traceback (most recent call last):
    ...
camtools.base.errors.CamtoolsError: a.toml: cam: is missing; add it
a.toml: process: is missing; add it
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from camtools.base.errors import InputError
from camtools.part.common import PartFile
from camtools.part.file import read_part_file, read_tree, validated
from camtools.pipeline.kind import AnyKind
from camtools.pipeline.registry import kind_of, kinds

PartT = TypeVar("PartT", bound=PartFile)


class Loaded(NamedTuple):
    """A part with its kind."""

    kind: AnyKind
    part: Any  # of the kind's model


def parse(data: bytes, file: str, folder: Path = Path(), *, is_confined: bool = False) -> Loaded:
    """Return the part that the bytes of a TOML file describe.

    Files that the part names are looked for in the folder; `file` names it in messages. A confined
    part may name no file outside of it.

    Raises
    ------
    CamtoolsError
        Not UTF-8, not TOML, or fields wrong: one line each, in the file's order of tables.
    """
    return _checked(read_tree(data, file), file, folder, is_confined=is_confined)


def parse_for(
    command: str, model: type[PartT], data: bytes, file: str, folder: Path = Path()
) -> PartT:
    """Return the part for a command that not every kind can do.

    Parameters
    ----------
    command : str
        Name of the command, as in `Kind.commands`.
    model : type
        Of the parts that the command works on.

    Raises
    ------
    CamtoolsError
        The command has no use for this kind, or see `parse`.
    """
    part = parse_able(command, data, file, folder)
    if not isinstance(part, model):
        raise InputError(file, "part.kind", part.part.kind, "is of the wrong kind", "give another")
    return part


def parse_able(command: str, data: bytes, file: str, folder: Path = Path()) -> PartFile:
    """Return the part, of whatever kind the command can do; errors as `parse_for`."""
    tree = read_tree(data, file)
    kind = kind_of(tree)
    if command not in kind.commands:
        able = " or ".join(f"a {other.name}" for other in kinds() if command in other.commands)
        *others, last = kind.commands
        problem = f"{kind.plural} are for {', '.join(others)} and {last}"
        raise InputError(file, "part.kind", kind.name, problem, f"give the part file of {able}")
    part: PartFile = _checked(tree, file, folder).part
    return part


def _checked(tree: dict[str, Any], file: str, folder: Path, *, is_confined: bool = False) -> Loaded:
    kind = kind_of(tree)
    context: dict[str, object] = {"folder": folder, "kinds": [one.name for one in kinds()]}
    if is_confined:
        context["is_confined"] = True
    return Loaded(kind, validated(kind.model, tree, file, context))


def load(path: Path) -> Loaded:
    """Return the part of a file; errors as `parse`, or the file cannot be read."""
    return parse(read_part_file(path), str(path), path.parent)


def load_for(command: str, model: type[PartT], path: Path) -> PartT:
    """Return the part of a file for a command; errors as `parse_for`."""
    return parse_for(command, model, read_part_file(path), str(path), path.parent)


def load_able(command: str, path: Path) -> PartFile:
    """Return the part of a file, of whatever kind the command can do; errors as `parse_for`."""
    return parse_able(command, read_part_file(path), str(path), path.parent)
