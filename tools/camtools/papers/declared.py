"""Declared tables and notes: filled with quantities, compared with the printed values.

>>> WORDS.format("{depth_mm:.1f} mm", depth_mm=np.array([0.1, 0.25]))
'0.1, 0.2 mm'
>>> compared({"e_mm": [1.96, 0.1]}, {"e_mm": 2.058})["off"]["e_mm"].round(6)
np.float64(5.0)
"""

import string
import tomllib
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from textwrap import fill
from typing import Any, NamedTuple, TypeVar

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.project import ROOT
from camtools.part.common import PartFile
from camtools.pipeline.load import load
from camtools.skirt.geometry.corner import Corner
from camtools.skirt.geometry.skirt_geometry import Geometry, make_geometry
from camtools.skirt.part.part_file import SkirtPart

_HEAD = "| | what it shows | the paper | ours | difference, and why | file |\n" + 6 * "|---" + "|"
PartT = TypeVar("PartT", bound=PartFile)
Quantities = Mapping[str, Any]


class _Words(string.Formatter):
    """Formats each number of a list."""

    def format_field(self, value: Any, form: str) -> str:  # noqa: ANN401 - any quantity
        if isinstance(value, list | np.ndarray):
            return ", ".join(format(number, form) for number in value)
        return str(format(value, form))


WORDS = _Words()


class Row(NamedTuple):
    """A figure, a table or a statement of a paper beside ours."""

    item: str
    shows: str
    paper: str
    ours: str
    difference: str
    files: str  # names, a space between two


class Paper(NamedTuple):
    """A declared paper; the module of the paper gives quantities and the content of files."""

    key: str
    title: str
    case: Quantities
    rows: tuple[Row, ...]
    printed: Mapping[str, Any]


@cache
def declarations() -> dict[str, Any]:
    """Return what declared.toml holds."""
    return tomllib.loads(Path(__file__).with_name("declared.toml").read_text(encoding="utf-8"))


@cache
def declared(key: str) -> Paper:
    """Return a paper, its rows with unfilled names."""
    tree = next(paper for paper in declarations()["paper"] if paper["key"] == key)
    return Paper(**tree | {"rows": tuple(Row(*cells) for cells in tree["rows"])})


def printed(key: str, name: str) -> Any:  # noqa: ANN401 - a number or a list
    """Return a value that a paper prints."""
    return declared(key).printed[name][0]


def compared(printed: Mapping[str, Any], quantities: Quantities) -> dict[str, Any]:
    """Return the printed values, how far ours are off in per cent, and at most in their unit.

    The share of a printed 0 is not a number. Raises CamtoolsError where ours is off by more than
    the declared difference.
    """
    found: dict[str, dict[str, Any]] = {"paper": {}, "off": {}, "most": {}}
    for name, (value, allowed) in printed.items():
        ours, theirs = (
            np.asarray(values, dtype=np.float64) for values in (quantities[name], value)
        )
        most = float(np.abs(ours - theirs).max())
        if not most <= allowed:
            problem = f"{name}: {ours} differs from the printed {theirs} by more than {allowed}"
            raise CamtoolsError([f"{problem}; correct the part, or the row in declared.toml"])
        found["paper"][name] = value
        ratio = np.divide(ours, theirs, np.full_like(ours - theirs, np.nan), where=theirs != 0)
        found["off"][name] = 100 * (ratio - 1)
        found["most"][name] = most
    return found


def filled(key: str, quantities: Quantities) -> Paper:
    """Return a paper whose rows hold the quantities; errors as `compared`."""
    paper = declared(key)
    names = {"case": paper.case, **quantities, **compared(paper.printed, quantities)}
    rows = tuple(Row(*(WORDS.format(cell, **names) for cell in row)) for row in paper.rows)
    return paper._replace(rows=rows)


def page(papers: Iterable[Paper]) -> str:
    """Return the comparisons as Markdown, a table for each paper."""
    lines: list[str] = []
    for paper in papers:
        lines += [f"## {paper.key}: {paper.title}", "", _HEAD]
        lines += [
            f"| {' | '.join(row[:5])} | `{row.files.replace(' ', '` `')}` |" for row in paper.rows
        ]
        lines.append("")
    return "\n".join(lines)


def notes(name: str, quantities: Quantities, *, is_papers: bool) -> str:
    """Return declared notes, those beside the paper only for its own section (Markdown)."""
    tree = declarations()["notes"][name]
    text = WORDS.format(tree["text"] + (tree["beside"] if is_papers else ""), **quantities)
    return "".join(
        fill(line, 100, subsequent_indent="  ") + "\n" if line.startswith("- ") else line + "\n"
        for line in text.splitlines()
    )


def part_of(name: str, model: type[PartT]) -> PartT:
    """Return a part of the repository by the name of its file."""
    part = load(ROOT / "tools" / "parts" / f"{name}.toml").part
    assert isinstance(part, model)
    return part


@cache
def geometry_of(name: str) -> Geometry:
    """Return the exact geometry of a skirt of the repository."""
    return make_geometry(part_of(name, SkirtPart))


def corner_of(name: str) -> Corner:
    """Return the corner of a skirt of the repository."""
    corner = geometry_of(name).corner
    assert corner is not None
    return corner
