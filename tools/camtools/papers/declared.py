"""Declared tables, notes and pictures: filled with quantities, compared with the printed values.

>>> WORDS.format("{depth_mm:.1f} mm", depth_mm=np.array([0.1, 0.25]))
'0.1, 0.2 mm'
>>> compared({"e_mm": [1.96, 0.1]}, {"e_mm": 2.058})["off"]["e_mm"].round(6)
np.float64(5.0)

>>> label_of("spindle_acceleration_rad_s2"), label_of("depth_mm"), label_of("s1")
(('spindle acceleration', 'rad/s²'), ('depth', 'mm'), ('s1', ''))
"""

from __future__ import annotations

import string
import tomllib
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from pathlib import Path
from textwrap import fill
from typing import Any, NamedTuple, TypeVar

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase

from camtools.base.errors import CamtoolsError
from camtools.base.project import ROOT
from camtools.base.text import Columns, csv_text
from camtools.part.common import PartFile
from camtools.pipeline.load import load
from camtools.plots.style import GREY, legend_below, new_figure, pictures, stroke_of

_HEAD = "| | what it shows | the paper | ours | difference, and why | file |\n" + 6 * "|---" + "|"
PartT = TypeVar("PartT", bound=PartFile)
Quantities = Mapping[str, Any]


class _Words(string.Formatter):
    """Formats each number of a list."""

    def format_field(self, value: Any, form: str) -> str:  # noqa: ANN401 - any quantity
        if isinstance(value, list | np.ndarray):
            return ", ".join(format(one, form) for one in value)
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
    tree = next(one for one in declarations()["paper"] if one["key"] == key)
    return Paper(**tree | {"rows": tuple(Row(*cells) for cells in tree["rows"])})


def printed(key: str, name: str) -> Any:  # noqa: ANN401 - a number or a list
    """Return a value that a paper prints."""
    return declared(key).printed[name][0]


def compared(printed: Mapping[str, Any], quantities: Quantities) -> dict[str, Any]:
    """Return the printed values, how far ours are off in per cent, and at most in their unit.

    Raises CamtoolsError where ours is off by more than the declared difference.
    """
    found: dict[str, dict[str, Any]] = {"paper": {}, "off": {}, "most": {}}
    for name, (value, allowed) in printed.items():
        ours, theirs = (np.asarray(one, dtype=np.float64) for one in (quantities[name], value))
        most = float(np.abs(ours - theirs).max())
        if not most <= allowed:
            problem = f"{name}: {ours} differs from the printed {theirs} by more than {allowed}"
            raise CamtoolsError([f"{problem}; correct the part, or the row in declared.toml"])
        found["paper"][name] = value
        found["off"][name] = 100 * (ours / theirs - 1)
        found["most"][name] = most
    return found


def filled(key: str, quantities: Quantities) -> Paper:
    """Return a paper whose rows hold the quantities.

    Raises CamtoolsError where a quantity is off by more than the declared difference.
    """
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


def png(draw: Callable[[], Figure]) -> Callable[[], bytes]:
    """Return the maker of a picture as PNG."""
    return lambda: pictures({"": draw})[""]


def csv(columns: Callable[[], Columns]) -> Callable[[], bytes]:
    """Return the maker of a table as CSV."""
    return lambda: csv_text(columns()).encode()


_UNITS = {
    "mm_s3": "mm/s³",
    "mm_s2": "mm/s²",
    "rad_s2": "rad/s²",
    "deg_s2": "degrees/s²",
    "mm3_s": "mm³/s",
    "mm_s": "mm/s",
    "deg_s": "degrees/s",
    "mm_rad": "mm/rad",
    "mm2": "mm²",
    "mm": "mm",
    "um": "µm",
    "deg": "degrees",
    "rpm": "r/min",
    "ms": "ms",
    "n": "N",
    "w": "W",
}


def label_of(name: str) -> tuple[str, str]:
    """Return the words and the unit of a column's name."""
    for end, unit in _UNITS.items():
        if name.endswith(f"_{end}"):
            return name.removesuffix(f"_{end}").replace("_", " "), unit
    return name.replace("_", " "), ""


def _plot(
    axes: Axes, columns: Columns, picture: Mapping[str, Any], names: list[str], of: str
) -> None:
    """Draw columns in a panel; `of` names the table where there are several."""
    x = np.asarray(columns[picture["x"]][0])
    if x.dtype.kind == "U":
        axes.set_xticks(range(x.size), x)
        x = np.arange(x.size)
    for i, name in enumerate(names):
        values = np.array(columns[name][0], dtype=np.float64)
        values[np.abs(values) > picture.get("most", np.inf)] = np.nan
        stroke, label = stroke_of(len(axes.lines) + len(axes.containers)), of or label_of(name)[0]
        if np.isnan(values).all():
            continue
        if picture.get("kind") == "bars":
            width = 0.8 / len(names)
            shown = x + width * (i - (len(names) - 1) / 2)
            axes.bar(shown, np.abs(values), width, color=stroke["color"], label=label)
        else:
            marker = "o" if picture.get("kind") == "dots" else ""
            axes.plot(x, values, lw=1.3, label=label, marker=marker, ms=3, **stroke)


def fill_panels(figure: FigureBase, topic: str, tables: Mapping[str, Columns]) -> None:
    """Draw a declared picture of tables, by name where there are several, on a figure."""
    picture = declarations()["pictures"][topic]
    panels = figure.subplots(len(picture["panels"]), 1, sharex=True, squeeze=False)[:, 0]
    for axes, names in zip(panels, picture["panels"], strict=True):
        for of, columns in tables.items():
            _plot(axes, columns, picture, names, of)
        words, unit = label_of(names[0])
        axes.set_ylabel(f"{words},\n{unit}" if unit else words)
        axes.grid(alpha=0.3)
        if len(names) > 1:
            axes.legend(frameon=False, fontsize=8)
        axes.set(**picture.get("settings", {}).get(names[0], {}))
        for at in picture.get("limits", {}).get(names[0], ()):
            axes.axhline(at, color=GREY, ls="--", lw=1)
    panels[-1].set(
        xlabel=", ".join(filter(None, label_of(picture["x"]))), **picture.get("axis", {})
    )
    figure.align_ylabels(list(panels))


def draw_table(topic: str, title: str, tables: Mapping[str, Columns]) -> Figure:
    """Return a declared picture of a table, or of several in the same panels."""
    figure = new_figure(9, 1.2 + 1.9 * len(declarations()["pictures"][topic]["panels"]))
    figure.suptitle(title)
    fill_panels(figure, topic, tables)
    if len(tables) > 1:
        legend_below(figure, figure.axes[0], 3)
    return figure
