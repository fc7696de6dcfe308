r"""Numbers and documents as text: CSV, JSON, TOML, times and sizes.

>>> csv_text({"name": (['"a"'], ""), "a_mm": ([0.5], 3), "b": ([-0.0], 0), "c": ([None], ".1e")})
'name,a_mm,b,c\n"a",0.500,0,\n'

>>> emit_json({"b": 1, "a": [0.5]})
'{\n "a": [\n  0.5\n ],\n "b": 1\n}\n'

>>> duration_text(8.04), duration_text(200), duration_text(5_000), duration_text(400_000)
('8 s', '3 min 20 s', '1 h 23 min', '4 d 15 h')
>>> size_text(3456), size_text(9_900_000)
('3.5 kB', '9.9 MB')

Its time rises with the square of the names of a dotted key: a file of 1 MB could take a day.

>>> toml_tree('[part]\nname = "a"\n')
{'part': {'name': 'a'}}
>>> toml_tree("a." * 40 + "a = 1")
Traceback (most recent call last):
    ...
ValueError: a key of more than 32 names
"""

import json
import re
import tomllib
from collections.abc import Iterable, Mapping
from itertools import pairwise
from typing import Any

from camtools.base.quantities import Floats

Columns = Mapping[str, tuple[Floats | Iterable[Any], int | str]]
"""Values by the name of the column, with their decimals or their format."""


def csv_text(columns: Columns) -> str:
    """Return columns of equal length; no minus zero among decimals, and None is empty."""
    formats = [f"z.{form}f" if isinstance(form, int) else form for _, form in columns.values()]
    lines = [",".join(columns)]
    for row in zip(*(values for values, _ in columns.values()), strict=True):
        cells = zip(row, formats, strict=True)
        lines.append(",".join("" if value is None else f"{value:{form}}" for value, form in cells))
    return "\n".join(lines) + "\n"


Json = dict[str, Any]


def emit_json(summary: Json) -> str:
    """Return a summary as JSON text: sorted keys, full double precision, deterministic."""
    return json.dumps(summary, indent=1, sort_keys=True, allow_nan=False) + "\n"


_STEPS = (("d", 86_400), ("h", 3_600), ("min", 60), ("s", 1))


def duration_text(seconds: float) -> str:
    """Return a time in its two largest units."""
    left = round(seconds)
    for (large, n_large), (small, n_small) in pairwise(_STEPS):
        if left >= n_large:
            whole, rest = divmod(left, n_large)
            return f"{whole} {large}" + (f" {rest // n_small} {small}" if rest >= n_small else "")
    return f"{left} s"


def size_text(n_bytes: float) -> str:
    """Return a size in the unit that leaves one to three digits before the point."""
    for unit in ("bytes", "kB", "MB"):
        if n_bytes < 1000:
            digits = 0 if unit == "bytes" or n_bytes >= 10 else 1
            return f"{n_bytes:.{digits}f} {unit}"
        n_bytes /= 1000
    return f"{n_bytes:.1f} GB"


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

    Raises ValueError: it is no TOML (tomllib.TOMLDecodeError), nested too deeply, or has a key of
    more than MOST_NAMES names.
    """
    if _LONG_KEY.search(STRINGS.sub("s", text)):
        raise ValueError(f"a key of more than {MOST_NAMES} names")
    try:
        return tomllib.loads(text)
    except RecursionError as error:
        raise ValueError("nested too deeply") from error
