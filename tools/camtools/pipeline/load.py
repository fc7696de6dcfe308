r"""From a part file to its kind, its part, and the files of its table.

>>> text = b'[part]\nname = "a"\nkind = "cam"\nsource = "b"\n'
>>> parse(text, "a.toml")
Traceback (most recent call last):
    ...
camtools.base.errors.CamtoolsError: a.toml: cam: is missing; add it
a.toml: process: is missing; add it
"""

import pkgutil
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import camtools
from camtools.base.errors import CamtoolsError, InputError
from camtools.base.text import emit_json
from camtools.cut.correction import Correction
from camtools.part.common import PartFile
from camtools.part.model import read_part_file, read_tree, validated
from camtools.part.schema import Keys
from camtools.pipeline.kind import AnyKind, Kind
from camtools.sim.machine_file import machine_schema
from camtools.table.summary import table_files


def kinds() -> list[AnyKind]:
    """Return all kinds by their rank."""
    found: list[AnyKind] = []
    for package in pkgutil.iter_modules(camtools.__path__, "camtools."):
        name = f"{package.name}.kind"
        if package.ispkg and name != Kind.__module__ and find_spec(name) is not None:
            kind = import_module(name).KIND
            assert isinstance(kind, Kind), name
            found.append(kind)
    return sorted(found, key=lambda kind: (kind.rank, kind.name))


@cache
def keys_of(name: str) -> Keys:
    """Return the keys of the part files of a kind."""
    known = {kind.name: kind.model for kind in kinds()}
    return Keys(known[name], tuple(known))


def schemas() -> dict[str, str]:
    """Return the JSON schemas of the files that people write, by the names of their files."""
    found = {kind.name: Keys(kind.model, (kind.name,)).published(kind.plural) for kind in kinds()}
    found["machine"] = machine_schema()
    return {f"{name}.schema.json": emit_json(schema) for name, schema in found.items()}


def kind_of(tree: dict[str, Any]) -> AnyKind:
    """Return the kind that the tables of a part file name, the first one where they name none."""
    part, known = tree.get("part"), kinds()
    name = part.get("kind") if isinstance(part, dict) else None
    return next((kind for kind in known if kind.name == name), known[0])


PartT = TypeVar("PartT", bound=PartFile)


class Loaded(NamedTuple):
    """A part with its kind."""

    kind: AnyKind
    part: Any  # of the kind's model


def parse(data: bytes, file: str, folder: Path = Path(), *, is_confined: bool = False) -> Loaded:
    """Return the part that the bytes of a TOML file describe; `file` names it in messages.

    Files that it names are looked for in the folder; a confined part may name no file outside of
    it. Raises `CamtoolsError` where fields are wrong: one line each, in the file's order of tables.
    """
    return _checked(read_tree(data, file), file, folder, is_confined=is_confined)


def parse_for(
    command: str, model: type[PartT], data: bytes, file: str, folder: Path = Path()
) -> PartT:
    """Return the part of a model for a command, or refuse a kind that it has no use for."""
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
    names = [known.name for known in kinds()]
    context: dict[str, object] = {"folder": folder, "kinds": names, "is_confined": is_confined}
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


class Made(NamedTuple):
    """A table with its kind."""

    kind: AnyKind
    table: Any  # what the kind knows about it

    def text(self) -> str:
        """Return what is known about the table, in a few lines for people."""
        return self.kind.text(self.kind.summary(self.table))

    def files(self, *, with_plots: bool) -> dict[str, bytes]:
        """Return the content of every file of the table, by file name."""
        image = self.table.table
        files = table_files(image, self.kind.summary(self.table))
        if with_plots:
            plots = self.kind.report().pictures(self.table)
            files |= {f"{image.part_name}_{topic}.png": png for topic, png in plots.items()}
        return files


def make(
    loaded: Loaded,
    file: Path | str,
    *,
    tolerance_nm: float | None = None,
    rpm: float | None = None,
    correction: Correction | None = None,
) -> Made:
    """Return the table of a part, for another speed where it matters; errors name the file."""
    kind, part = loaded
    try:
        part = kind.at_speed(part, rpm)
        if correction is None:
            return Made(kind, kind.make(part, tolerance_nm))
        return Made(kind, kind.make_corrected(part, tolerance_nm, correction))
    except CamtoolsError as error:
        hint = "; or leave the high waves of the correction out by --keep-harmonics"
        hints = (hint if correction and ".u_" in line else "" for line in error.lines)
        lines = [f"{file}: {line}{more}" for line, more in zip(error.lines, hints, strict=True)]
        raise CamtoolsError(lines) from error
