r"""Columns of numbers as CSV text.

>>> csv_text({"name": (['"a"'], ""), "a_mm": ([0.5], 3), "b": ([-0.0], 0), "c": ([None], ".1e")})
'name,a_mm,b,c\n"a",0.500,0,\n'
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from camtools.base.quantities import Floats

Columns = Mapping[str, tuple[Floats | Iterable[Any], int | str]]
"""Values by the name of the column, with their decimals or their format."""


def csv_text(columns: Columns) -> str:
    """Return columns of equal length; no minus zero among decimals, and None is empty."""
    formats = [f"z.{one}f" if isinstance(one, int) else one for _, one in columns.values()]
    lines = [",".join(columns)]
    for row in zip(*(values for values, _ in columns.values()), strict=True):
        cells = zip(row, formats, strict=True)
        lines.append(",".join("" if value is None else f"{value:{form}}" for value, form in cells))
    return "\n".join(lines) + "\n"
