# SPDX-License-Identifier: Apache-2.0
r"""TOML of strangers: what would keep tomllib busy for hours, or end it, is one error.

Its time rises with the square of the names of a dotted key: a file of 1 MB could take a day.

>>> toml_tree('[part]\nname = "a"\n')
{'part': {'name': 'a'}}
>>> toml_tree("a." * 40 + "a = 1")
Traceback (most recent call last):
    ...
ValueError: a key of more than 32 names
"""

from __future__ import annotations

import re
import tomllib
from typing import Any

MOST_NAMES = 32
# Strings and comments, also those that nobody closed: so each character is looked at once.
STRINGS = re.compile(
    r'"""(?:\\.|[^\\])*?(?:"""|\Z)'  # a basic string of several lines, then a literal one
    r"|'''.*?(?:'''|\Z)"
    r'|"(?:\\.|[^"\\\n])*+"?'
    r"|'[^'\n]*+'?"
    r"|#[^\n]*+",
    re.DOTALL,
)
_LONG_KEY = re.compile(rf"(?<![\w-])(?:[\w-]++[ \t]*+\.[ \t]*+){{{MOST_NAMES}}}")


def toml_tree(text: str) -> dict[str, Any]:
    """Return the tables of a TOML text.

    Raises
    ------
    ValueError
        It is no TOML (tomllib.TOMLDecodeError), nested too deeply, or has a key of more than
        MOST_NAMES names.
    """
    if _LONG_KEY.search(STRINGS.sub("s", text)):
        raise ValueError(f"a key of more than {MOST_NAMES} names")
    try:
        return tomllib.loads(text)
    except RecursionError as error:
        raise ValueError("nested too deeply") from error
