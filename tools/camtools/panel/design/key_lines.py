# SPDX-License-Identifier: Apache-2.0
r"""Where a field of a part file stands: the line of its key, for messages beside the text.

>>> lines = lines_of('[process]\nspindle_rpm = 100 # slow\n[[cam.lobe]]\nz_mm = [\n0, 1]\n')
>>> lines[("process", "spindle_rpm")], lines[("cam", "lobe", 0)], lines[("cam", "lobe", 0, "z_mm")]
(2, 3, 4)
>>> line_of(lines, ("process", "feed_mm"))
1
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from camtools.base.toml_text import STRINGS

Path = tuple[str | int, ...]

_HEADER = re.compile(r"\s*+(\[\[?)([^\[\]]++)\]\]?\s*+(?:#.*)?$")
_KEY = re.compile(
    r"""\s*((?:[A-Za-z0-9_-]+|"[^"\n]*"|'[^'\n]*')(?:\s*\.\s*[A-Za-z0-9_"'-]+)*)\s*="""
)
_PART = re.compile(r"""[A-Za-z0-9_-]+|"[^"]*"|'[^']*'""")


def _blanked(text: str) -> str:
    """Return text whose strings of values and comments hold nothing that looks like syntax."""

    def hide(found: re.Match[str]) -> str:
        word = found[0]
        if word[0] in "\"'" and re.match(r"\s*[=.\]]", text[found.end() : found.end() + 3]):
            return word  # a quoted key
        return "".join("\n" if one == "\n" else " " for one in word)

    return STRINGS.sub(hide, text)


def _names(dotted: str) -> tuple[str, ...]:
    return tuple(one.strip("\"'") for one in _PART.findall(dotted))


def _logical(text: str) -> Iterator[tuple[int, str]]:
    """Yield the number and the text of each line that begins outside of a list."""
    depth = 0
    for number, line in enumerate(_blanked(text).split("\n"), start=1):
        if depth == 0:
            yield number, line
            if _HEADER.match(line):
                continue
        depth = max(0, depth + sum(line.count(c) for c in "[{") - sum(line.count(c) for c in "]}"))


def lines_of(text: str) -> dict[Path, int]:
    """Return the line, from 1 on, of every key and header; lists of tables count from 0."""
    found: dict[Path, int] = {}
    counts: dict[Path, int] = {}
    table: Path = ()

    def resolved(names: tuple[str, ...]) -> Path:
        path: Path = ()
        for name in names:
            path = (*path, name)
            if path in counts:
                path = (*path, counts[path])
        return path

    for number, line in _logical(text):
        if header := _HEADER.match(line):
            *above, last = _names(header[2]) or ("",)
            path = (*resolved(tuple(above)), last)
            if header[1] == "[[":
                counts[path] = counts.get(path, -1) + 1
                path = (*path, counts[path])
            table = path
            found.setdefault(table, number)
        elif key := _KEY.match(line):
            path = table
            for name in _names(key[1]):
                path = (*path, name)
                found.setdefault(path, number)
    return found


def line_of(lines: dict[Path, int], path: Path) -> int | None:
    """Return the line of a field, of a missing one that of its table; None where neither is."""
    while path:
        if path in lines:
            return lines[path]
        path = path[:-1]
    return None


def path_of(dotted: str) -> Path:
    """Return the path that a message names by dots; whole numbers are places in a list."""
    return tuple(int(one) if one.isdigit() else one for one in dotted.split("."))
