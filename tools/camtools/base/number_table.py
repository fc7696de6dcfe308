r"""Tables of numbers that people hand over as text: the same rules for every kind of table.

Cells are separated by semicolons, commas, tabs or blanks. The first line with numbers or names
shows which; unless they are commas, a decimal comma is read as well as a point. Names are compared
without regard to case, further columns are ignored. Blank lines and lines that begin with `#`, `//`
or `(*` may be anywhere; `//` after a blank or at the begin of a cell begins a note, unless quoted.
Names and numbers may be in quotes, exponents may be written with D, and cells that follow the last
column may be there if empty.

>>> table = NumberTable('# a tester\n"Angle_deg";Note;Lift_um\n0,5;a;1,5D3\n', "a.csv", 100)
>>> table.names, table.lines.tolist()
(['angle_deg', 'note', 'lift_um'], [3])
>>> kinds = {"angle": {"angle_deg": 1.0}, "lift": {"lift_mm": 1.0, "lift_um": 1e-3}}
>>> table.values(table.columns(kinds, "angle_deg,lift_mm")).tolist()
[[0.5], [1.5]]

Each line has as many cells as the header names, or as the first line of numbers.

>>> table = NumberTable("angle_deg,lift_mm\n0,1,5\n", "a.csv", 100)
>>> try:
...     table.values(table.columns({"lift": {"lift_mm": 1.0}}, "angle_deg,lift_mm"))
... except InputError as error:
...     str(error).split("; ")[0]
'a.csv: line 2: has 3 cells, the header names 2'

A part file from somebody else may name any file of the reader's, a list of passwords for one:
errors name the file and the number of the line, never the text of a line or of a heading.
"""

import csv
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from camtools.base.errors import InputError
from camtools.base.files import read_text
from camtools.base.quantities import Floats

Units = Mapping[str, float]
"""What a unit is worth, by the name of a column in this unit."""

_COMMENTS = ("#", "//", "(*")
_QUOTED_OR_NOTE = re.compile(r'(?<![^\s;,])(?:"(?:[^"]|"")*+"|//.*)')  # where a cell may begin
_MOST = 1e12  # of a number in the unit of the reader: squares and sums of many stay finite
_NOTHING = ' \t,;"'  # a line of nothing else is blank: a spreadsheet's empty row


def is_blank_or_comment(line: str) -> bool:
    """Return whether a line has no cells, or empty ones alone, or is a comment."""
    return not line.strip().strip(_NOTHING) or line.lstrip().startswith(_COMMENTS)


def read_whole_table(path: Path, most_bytes: int) -> str:
    """Return the text of a table that a part file names, as `read_text`.

    Raises InputError: its last line does not end: a file that was cut short may stop within a
    number.
    """
    text = read_text(path, most_bytes)
    last = text.splitlines()[-1] if text else ""
    if not text.endswith(("\n", "\r")) and not is_blank_or_comment(last):
        problem = "the file stops within this line, so it may have been cut short"
        remedy = "copy it again, or end the line if it is complete"
        place = f"line {len(text.splitlines())}"
        raise InputError(path.name, place, None, problem, remedy)
    return text


class Column(NamedTuple):
    """Where a quantity is in each line, and what its unit is worth."""

    place: int
    per_unit: float = 1.0
    name: str = ""


def _number_or_nan(cell: str) -> float:
    """Return a number, which may have an exponent of Fortran."""
    try:
        return float(cell.upper().replace("D", "E"))
    except ValueError:
        return np.nan


def _is_number(cell: str) -> bool:
    return bool(np.isfinite(_number_or_nan(cell)))


def _cells(line: str, separator: str | None) -> list[str]:
    """Return the cells of a line; without a separator any blanks and tabs separate."""
    if separator is None:
        return [word.strip('"').rstrip(",").replace(",", ".") for word in line.split()]
    if '"' in line:
        try:
            [quoted] = csv.reader([line], delimiter=separator, skipinitialspace=True)
        except csv.Error:  # a cell of more than 131 072 characters
            quoted = []
    else:
        quoted = line.split(separator)
    return quoted if separator == "," else [cell.replace(",", ".") for cell in quoted]


def _is_padded(words: list[str]) -> bool:
    """Return whether commas before blanks separate the words, and none is a decimal sign."""
    has_sign = any("," in word[:-1] for word in words)
    return not has_sign and all(word.endswith(",") for word in words[:-1])


def _is_tabbed(line: str, *, is_spaced: bool) -> bool:
    """Return whether a tab is between every two cells; names may have blanks, not numbers."""
    cells = [cell.strip() for cell in line.rstrip().split("\t")]
    if len(cells) == 1 or not all(cell and not cell.endswith(",") for cell in cells):
        return False
    return len(cells) == len(line.split()) or not is_spaced


def _separator_of(line: str) -> str | None:
    """Return what separates the cells of the first line; numbers between blanks have commas."""
    if ";" in line:
        return ";"
    words = line.split()
    if "," in line and _is_padded(words):
        return ","
    is_spaced = len(words) > 1 and all(map(_is_number, _cells(line, None)))
    if _is_tabbed(line, is_spaced=is_spaced):
        return "\t"
    return "," if "," in line and not is_spaced else None


def _without_note(line: str) -> str:
    if "//" not in line:
        return line
    return _QUOTED_OR_NOTE.sub(lambda found: found[0] if found[0][0] == '"' else "", line)


def _written(text: str) -> list[tuple[int, str]]:
    """Return the lines that are neither blank nor comments, by number, without their notes.

    Tabs at their ends stay: empty cells may be there.
    """
    lines = ((i, _without_note(line)) for i, line in enumerate(text.splitlines(), start=1))
    return [(i, line.strip(" ")) for i, line in lines if not is_blank_or_comment(line)]


class NumberTable:
    """The lines of a table of at most so many rows; its numbers are read when asked for."""

    def __init__(self, text: str, file: str, most_rows: int) -> None:
        """Raise InputError: it has more rows."""
        self.file = file
        written = _written(text)
        number, first = written[0] if written else (1, "")
        self.place = f"line {number}"  # of the header, or of the first row
        self._separator = _separator_of(first)
        cells = [cell.strip() for cell in _cells(first, self._separator)]
        while cells and not cells[-1]:
            cells.pop()
        self.n_columns = len(cells)
        is_header = not all(map(_is_number, cells))
        self.names = [cell.casefold() for cell in cells] if is_header else []
        rows = written[1:] if is_header else written
        if len(rows) > most_rows:
            problem = f"has {len(rows)} rows, at most {most_rows} are read"
            raise InputError(file, "", None, problem, "leave out rows")
        self.rows = [line for _, line in rows]
        self.lines = np.array([i for i, _ in rows], dtype=np.int64)  # number of each row's line

    def columns(self, kinds: Mapping[str, Units], header: str) -> list[Column]:
        """Return the column of each quantity, by the names that it may have.

        `header` is an example. Raises InputError: a quantity has no column, or several.
        """
        return [self._column(what, units, header) for what, units in kinds.items()]

    def _column(self, what: str, units: Units, header: str) -> Column:
        found = [name for name in self.names if name in units]
        if len(found) == 1:
            return Column(self.names.index(found[0]), units[found[0]], found[0])
        has = ", ".join(found) or "none"
        problem = f"needs one column of the {what}: {', '.join(units)}; has {has}"
        remedy = f'write a header as "{header}", separated by , or ; or blanks'
        if found:
            remedy = "rename all but one of them"
        raise InputError(self.file, self.place, None, problem, remedy)

    def values(self, columns: Sequence[Column]) -> Floats:
        """Return numbers in the units of the reader, shape (columns, rows).

        Raises InputError with the line: too many or too few cells, or a number is not finite, or
        beyond 1e12.
        """
        places = [column.place for column in columns]
        rows: list[list[float]] = []
        for line in self.rows:
            cells = self._checked(len(rows), line)
            try:
                rows.append([float(cells[place]) for place in places])
            except ValueError:
                rows.append([_number_or_nan(cells[place]) for place in places])
        with np.errstate(over="ignore"):
            units = np.array([column.per_unit for column in columns])
            found: Floats = np.array(rows, dtype=np.float64).reshape(-1, len(places)) * units
        wrong = np.argwhere(~(np.abs(found) <= _MOST))
        if wrong.size:
            row, column = (int(k) for k in wrong[0])
            raise self._no_number(row, columns[column], is_finite=np.isfinite(rows[row][column]))
        return found.T

    def _checked(self, row: int, line: str) -> list[str]:
        """Return as many cells of a line as there are columns, or refuse it."""
        cells = _cells(line, self._separator)
        n = self.n_columns
        if len(cells) == n or (len(cells) > n and not any(map(str.strip, cells[n:]))):
            return cells
        if self._separator == "\t" and len(line.split()) == n:  # aligned by blanks or more tabs
            return _cells(line, None)
        expected = f"the header names {n}" if self.names else f"{self.place} has {n}"
        remedy = f"separate the cells as in {self.place}, one for each column"
        if self._separator == ",":
            remedy = f"separate by semicolons if the comma is the decimal sign, or {remedy}"
        has = "1 cell" if len(cells) == 1 else f"{len(cells)} cells"
        raise self.refusal(row, f"has {has}, {expected}", remedy)

    def _no_number(self, row: int, column: Column, *, is_finite: bool) -> InputError:
        heading = self.names[column.place] if self.names else ""
        cell = f"cell {column.place + 1} ({heading})" if heading else f"cell {column.place + 1}"
        if is_finite:
            most = _MOST / abs(column.per_unit)
            return self.refusal(row, f"{cell} is beyond {most:.6g}", "correct the number")
        sign = "a point" if self._separator == "," else "a point or a comma"
        remedy = f"write a number there, decimals with {sign}"
        return self.refusal(row, f"{cell} is no finite number", remedy)

    def refusal(self, row: int, problem: str, remedy: str) -> InputError:
        """Return the error of a row."""
        return InputError(self.file, f"line {self.lines[row]}", None, problem, remedy)
