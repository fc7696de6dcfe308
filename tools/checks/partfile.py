"""Make the tables of PARTFILE.md from the models of the kinds of parts.

The text before the first kind and after the last stays as it is in the page.

>>> main([])
0
"""

from __future__ import annotations

import json
import sys

from camtools.base.project import ROOT
from camtools.part.schema import Key, Table
from camtools.pipeline.kind import AnyKind
from camtools.pipeline.load import keys_of, kinds
from checks.lookup import table
from checks.page_command import page_command

_PAGE = "tools/docs/PARTFILE.md"
_LAST = "\n## The drawing's angle\n"


def _heading(kind: AnyKind) -> str:
    return f"\n## {kind.plural.capitalize()}\n"


def _row_of(key: Key) -> list[str]:
    """Return range, default and meaning of a key."""
    default = "" if key.is_required or key.is_needed else "none"
    if isinstance(key.default, float):
        default = f"{key.default:.9g}"
    elif key.default is not None:
        default = json.dumps(key.default)
    return [key.range_text, default, key.meaning]


def _rows(
    section: Table, known: dict[tuple[str, str], tuple[list[str], str]], kind: str
) -> list[list[str]]:
    """Return the rows of a table; keys that another kind has, too, are only named."""
    title = f"[[{section.title}]]" if section.most is not None else f"[{section.title}]"
    most = f"up to {section.most}" if section.most else ""
    rows = [[f"**{title}**", most, section.without, section.meaning]]
    alike: dict[str, list[str]] = {}
    for key in section.keys:
        name, cells = f"`{key.name}`", _row_of(key)
        there, owner = known.setdefault((section.title, key.name), (cells, kind))
        if owner != kind and there == cells:
            alike.setdefault(owner, []).append(name)
        elif rows[-1][1:] == cells:
            rows[-1][0] += f", {name}"
        else:
            rows.append([name, *cells])
    return rows + [[", ".join(names), "", "", f"as for {owner}"] for owner, names in alike.items()]


def pages() -> dict[str, str]:
    """Return the text of PARTFILE.md by its path in the project."""
    text = (ROOT / _PAGE).read_text("utf-8")
    before, after = text.partition(_heading(kinds()[0]))[0], text.partition(_LAST)[2]
    known: dict[tuple[str, str], tuple[list[str], str]] = {}
    for kind in kinds():
        rows = [["key", "range", "default", "meaning"]]
        for section in keys_of(kind.name).tables():
            rows += _rows(section, known, kind.plural)
        before += f"{_heading(kind)}\n{table(rows)}"
    return {_PAGE: before + _LAST + after}


def main(words: list[str] | None = None) -> int:
    """Compare PARTFILE.md with its sources, or write it anew."""
    return page_command("partfile", __doc__, ROOT, pages, words)


if __name__ == "__main__":
    sys.exit(main())
