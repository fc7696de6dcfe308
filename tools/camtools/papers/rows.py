"""What a chapter is made of: rows of the page of comparisons, and files that are made on demand.

>>> row = Row("Table 1", "depth of cut", "rises", "0.1 .. 0.2 mm", "none", "s0_table1.csv")
>>> print(page([Chapter("S0", "equal volume", (row,), {"s0_table1.csv": lambda: b""})]))
## S0: equal volume
<BLANKLINE>
| | what it shows | the paper | ours | difference, and why | file |
|---|---|---|---|---|---|
| Table 1 | depth of cut | rises | 0.1 .. 0.2 mm | none | `s0_table1.csv` |
<BLANKLINE>
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import NamedTuple, TypeVar

from matplotlib.figure import Figure

from camtools.base.project_paths import ROOT
from camtools.part.common import PartFile
from camtools.pipeline.load import load
from camtools.plots.panels import pictures

_HEAD = "| | what it shows | the paper | ours | difference, and why | file |\n" + 6 * "|---" + "|"
PartT = TypeVar("PartT", bound=PartFile)

Maker = Callable[[], bytes]
"""Makes the content of a file."""


class Row(NamedTuple):
    """A figure or a table of a paper beside ours."""

    item: str
    shows: str
    paper: str
    ours: str
    difference: str
    file: str


class Chapter(NamedTuple):
    """A paper: what is compared, and the files by their name."""

    key: str
    title: str
    rows: tuple[Row, ...]
    files: Mapping[str, Maker]


def page(chapters: Iterable[Chapter]) -> str:
    """Return the comparisons as Markdown, a table for each paper."""
    lines: list[str] = []
    for chapter in chapters:
        lines += [f"## {chapter.key}: {chapter.title}", "", _HEAD]
        lines += [
            f"| {row.item} | {row.shows} | {row.paper} | {row.ours} | {row.difference} "
            f"| `{row.file}` |"
            for row in chapter.rows
        ]
        lines.append("")
    return "\n".join(lines)


def png(draw: Callable[[], Figure]) -> Maker:
    """Return what makes a picture as PNG."""
    return lambda: pictures({"": draw})[""]


def part_path(name: str) -> Path:
    """Return a part file of the repository by its name."""
    return ROOT / "tools" / "parts" / f"{name}.toml"


def part_of(name: str, model: type[PartT]) -> PartT:
    """Return a part of the repository by the name of its file."""
    part = load(part_path(name)).part
    assert isinstance(part, model)
    return part


def percent(ours: float, paper: float) -> str:
    """Return by how much ours differs from a printed number.

    >>> percent(748205, 8e5), percent(3.41e6, 3.48e6)
    ('-6.5 %', '-2.0 %')
    """
    return f"{100 * (ours / paper - 1):+.1f} %"


def um(mm: float, decimals: int = 3) -> str:
    """Return a length in micrometres."""
    return f"{1000 * mm:z.{decimals}f} um"
