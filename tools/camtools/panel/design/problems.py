# SPDX-License-Identifier: Apache-2.0
r"""What is wrong with a part file, each with its place: field, line, text with value and remedy.

>>> [one] = problems_of(["process.feed_mm = 0: must be above 0; give mm"], "[process]\nfeed_mm=0")
>>> one.field, one.line, one.text
('process.feed_mm', 2, 'process.feed_mm = 0: must be above 0; give mm')
"""

from __future__ import annotations

import re
from typing import NamedTuple

from camtools.panel.design.key_lines import line_of, lines_of, path_of

_FIELD = re.compile(r"([a-z_][a-z0-9_]*(?:\.(?:[a-z_][a-z0-9_]*|\d+))+)\b")
_AT_LINE = re.compile(r"at line (\d+)")
_NUMBER = re.compile(r"process\.pass number (\d+): ")


class Problem(NamedTuple):
    """One thing that is wrong."""

    field: str  # dotted; "" where no field is to blame
    line: int | None  # of the text, from 1 on
    text: str  # place, value, what is wrong, remedy


def problems_of(lines: list[str], text: str, file: str = "") -> list[Problem]:
    """Return messages with their places in the text of the part file.

    Parameters
    ----------
    file : str
        Name that the messages begin with; it is left out.
    """
    places = lines_of(text)
    found = []
    for one in lines:
        told = one.removeprefix(f"{file}: ") if file else one
        at_line = _AT_LINE.search(told) if told.startswith("not TOML") else None
        named = _FIELD.match(_NUMBER.sub("", told))
        field = named[1] if named else ""
        line = int(at_line[1]) if at_line else line_of(places, path_of(field)) if field else None
        found.append(Problem(field, line, told))
    return found
