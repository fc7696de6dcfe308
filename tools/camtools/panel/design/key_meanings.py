# SPDX-License-Identifier: Apache-2.0
"""Meaning of each key of a part file, read from the tables of tools/docs/PARTFILE.md.

>>> meaning_of("piston", ("process", "depth_mm"))
'cutting depth at the long axis'
>>> meaning_of("polygon", ("process", "depth_mm"))
'cutting depth at the long axis'
"""

from __future__ import annotations

import re
from functools import cache

from camtools.base.project_paths import ROOT

_PAGE = ROOT / "tools" / "docs" / "PARTFILE.md"
# The section of a kind; the other sections have the keys of pistons and those that all kinds share.
_SECTIONS = {"cam": "Cams", "polygon": "Polygons"}
_ROW = re.compile(r"^\| (\*\*\[|`)(.*)\|$", re.MULTILINE)
_TABLE = re.compile(r"\[+([a-z_.]+)\]+")
_KEY = re.compile(r"`([a-z_0-9]+)`")
_LINK = re.compile(r"\[([^\]]*)\]\([^)]*\)")
_CELL = re.compile(r"(?<!\\)\|")


def _plain(cell: str) -> str:
    """Return a cell without the marks of Markdown."""
    text = _LINK.sub(r"\1", cell).replace("`", "").replace("**", "").replace("\\|", "|")
    return text.replace("&#124;", "|").strip()


@cache
def _section(title: str) -> str:
    """Return a section of the manual, or with "" what is in no kind's section."""
    try:
        text = _PAGE.read_text(encoding="utf-8")
    except OSError:
        return ""  # the form does without
    sections = dict(one.partition("\n")[::2] for one in text.split("\n## "))
    if title:
        return sections.get(title, "")
    return "\n".join(body for name, body in sections.items() if name not in _SECTIONS.values())


@cache
def _meanings(title: str) -> dict[tuple[str, ...], str]:
    """Return the meaning of tables and keys of a section, by their names without numbers."""
    found: dict[tuple[str, ...], str] = {}
    tables: list[tuple[str, ...]] = []
    for row in _ROW.finditer(_section(title)):
        cells = [one.strip() for one in _CELL.split(row[0])[1:-1]]
        if len(cells) != 4:
            continue
        if row[1] == "**[":
            tables = [tuple(name.split(".")) for name in _TABLE.findall(cells[0])]
            for table in tables:
                found.setdefault(table, _plain(cells[3]))
            continue
        for table in tables:
            for key in _KEY.findall(cells[0]):
                found.setdefault((*table, key), _plain(cells[3]))
    return found


def meaning_of(kind: str, path: tuple[str | int, ...]) -> str:
    """Return what a key or a table means; "" if the manual does not say."""
    names = tuple(one for one in path if isinstance(one, str) and not one.isdigit())
    own = _meanings(_SECTIONS[kind]) if kind in _SECTIONS else {}
    return own.get(names) or _meanings("").get(names, "")
