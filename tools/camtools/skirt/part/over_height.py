"""Values over the height in text, as drawings and CAD export them.

>>> HEIGHT.names()["z_inch"]
25.4
"""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from camtools.base.errors import InputError
from camtools.base.number_table import Column, NumberTable, read_whole_table
from camtools.base.quantities import Floats
from camtools.part.model import MAX_HEIGHT_MM, MIN_STEP_MM, SAME_MM
from camtools.table.points import LENGTHS

MAX_POINTS = 1000
_MAX_BYTES = 1_000_000
_DIGITS = 10  # of mm: below them is the rounding of inches
_UNIT_OF = {mm: unit for unit, mm in LENGTHS.items()}
_SPELT = {"mm": "mm", "um": "um", "µm".casefold(): "um", "inch": "inch", "in": "inch"}
_MM_PER = {word: LENGTHS[unit] for word, unit in _SPELT.items()}


class Quantity(NamedTuple):
    """What a column may hold."""

    name: str
    words: tuple[str, ...]  # of a header, alone or with a unit: dia, dia_mm, Dia [mm]
    unit_mm: float  # where the header names no unit
    range_mm: tuple[float, float]

    def names(self) -> dict[str, float]:
        """Return mm per unit by the names of a column."""
        plain = dict.fromkeys(self.words, self.unit_mm)
        return plain | {f"{word}_{unit}": mm for word in self.words for unit, mm in _MM_PER.items()}


HEIGHT = Quantity("height", ("height", "z"), 1.0, (-MAX_HEIGHT_MM, MAX_HEIGHT_MM))


class OverHeight(NamedTuple):
    """A quantity over the height, arrays of shape (n,)."""

    z_mm: Floats  # rising
    values_mm: Floats
    name: str  # of the quantity
    words: str  # how the text was understood


def read_over_height(
    path: Path, height: Quantity, kinds: Sequence[Quantity], places: Sequence[int] | None = None
) -> OverHeight:
    """Return two columns of a file: the height, and one of some kinds of quantities.

    `places` count the columns from 1; without them the header names columns in any order, or there
    are no others. Raises InputError with line and column: nothing states what a column holds; a
    number is missing or out of range; heights neither rise nor fall.
    """
    table = NumberTable(read_whole_table(path, _MAX_BYTES), path.name, MAX_POINTS)
    names = {name for kind in (height, *kinds) for name in kind.names()}
    plain = (re.sub(r"[\W_]+", "_", name).strip("_") for name in table.names)
    table.names = [name if name in names else "" for name in plain]  # others are not quoted
    if places is None and not table.names and table.n_columns == 2:
        places = (1, 2)
    at = places or (None, None)
    found = [_column(table, [height], at[0]), _column(table, kinds, at[1])]
    values = np.round(table.values([column for column, _ in found]), _DIGITS)
    for row, (column, quantity) in zip(values, found, strict=True):
        _check_range(table, row, column, quantity)
    is_falling = _falls(table, values[0])
    z_mm, values_mm = values[:, ::-1] if is_falling else values
    words = [
        f"{z_mm.size} points at {z_mm[0]:g} .. {z_mm[-1]:g} mm",
        *(["listed downwards"] if is_falling else []),
        *(f"{quantity.name} in {_UNIT_OF[column.per_unit]}" for column, quantity in found),
    ]
    return OverHeight(z_mm, values_mm, found[1][1].name, ", ".join(words))


def _column(
    table: NumberTable, quantities: Sequence[Quantity], place: int | None
) -> tuple[Column, Quantity]:
    """Return a column and what it holds, by its number or by the header."""
    by_name = {name: kind for kind in quantities for name in kind.names()}
    named = [i for i, name in enumerate(table.names, start=1) if name in by_name]
    found = named if place is None else [place]
    if named and place is not None and place not in named:
        name = table.names[named[0] - 1]
        problem = (
            f"column {place} is to be the {quantities[0].name}, but column {named[0]} has the "
        )
        remedy = "correct the key columns, or the header"
        raise InputError(table.file, table.place, None, f"{problem}name {name}", remedy)
    if len(found) == 1 and found[0] <= table.n_columns:
        name = table.names[found[0] - 1] if table.names else ""
        if name in by_name or len(quantities) == 1:
            quantity = by_name.get(name, quantities[0])
            per_unit = quantity.names().get(name, quantity.unit_mm)
            return Column(found[0] - 1, per_unit, name), quantity
    what = " or ".join(dict.fromkeys(kind.name for kind in quantities))
    words = ", ".join(dict.fromkeys(word for kind in quantities for word in kind.words))
    has = f"{len(named)} columns of that name" if table.names else "no header"
    problem = f"of {table.n_columns} columns one must be the {what} ({words}), has {has}"
    remedy = "name it in the header, or give the keys columns = [1, 2] and values"
    if place is not None and place > table.n_columns:
        problem, remedy = f"has {table.n_columns} columns, no column {place}", "correct columns"
    raise InputError(table.file, table.place, None, problem, remedy)


def _check_range(table: NumberTable, row: Floats, column: Column, quantity: Quantity) -> None:
    low_mm, high_mm = quantity.range_mm
    is_wrong = (row < low_mm) | (row > high_mm)
    if is_wrong.any():
        cell = f"cell {column.place + 1}, the {quantity.name}, is beyond"
        remedy = "correct it, or its unit in the header (z_inch) or in the part file"
        problem = f"{cell} {low_mm:g} .. {high_mm:g} mm"
        raise table.refusal(int(is_wrong.argmax()), problem, remedy)


def _falls(table: NumberTable, z_mm: Floats) -> bool:
    """Return whether heights fall; refuse those that neither rise nor fall."""
    if z_mm.size < 2:
        problem, remedy = f"has {z_mm.size} points, needs 2", "give a line for each point"
        raise InputError(table.file, "", None, problem, remedy)
    is_falling = bool(z_mm[-1] < z_mm[0])
    is_wrong = np.diff(z_mm) * (-1 if is_falling else 1) < MIN_STEP_MM - SAME_MM
    if is_wrong.any():
        order = "less" if is_falling else "more"
        problem = f"the height is not {MIN_STEP_MM} mm {order} than in the line before"
        remedy = "list the heights upwards or downwards, each once"
        raise table.refusal(int(is_wrong.argmax()) + 1, problem, remedy)
    return is_falling
