r"""Cam tables in the forms of other makers: where the points are, and what their numbers mean.

A new form is one entry of `FORMS`. Its lines but the points are blanked out, so that
`number_table` reads the rest with the numbers of its lines. Sources are the makers' pages:

| maker | page | angle, value |
|---|---|---|
| SEW | MOVI-C interpolation, "Curve point table" | units of the user |
| Kollmorgen | KAS IDE, "Import Cam Profile" | X relative to its largest, units of the user |
| ISG, TwinCAT CNC | "File format of the cam tables", "Table types" | integers: 1e-4 deg, 1e-4 mm |
| Schneider | Motion Sizer, "Interpolated Profile File Format" | even steps, scaled by the header |

Lenze's (Cam Loader, "Data format of motion profile data") needs no entry: two columns, a third of
torques and notes after `//`. Technosoft's (EasyMotion Studio, "CAM Tables Edit") are two columns
of counts; the file does not say what is counted.

>>> found = found_in("2\n0;0\n360;0\n", "a.csv")
>>> found.form.maker, found.settings, found.text
('SEW', {'lines': '2'}, '\n0;0\n360;0')
>>> FORMS["kas"].written([0.0, 360.0], [0.5, 0.5]).splitlines()[1:3]
['TABLE_BEGIN;;', '0.0;0.5;SPLINE']
"""

import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from camtools.base.errors import InputError
from camtools.base.number_table import NumberTable, is_blank_or_comment
from camtools.base.quantities import Floats


class Form(NamedTuple):
    """The layout of a maker's file of one cam; capitals do not matter."""

    maker: str
    known_by: str  # pattern at the begin of the file, without blank lines and comments
    begin: str = ""  # word of the last line before the points; without one it is the first line
    end: str = ""  # of the first line after them; without one the file ends with the points
    beside: str = ""  # pattern of what a row may have beside its numbers
    columns: tuple[int, ...] = (2,)  # how many there may be; 1: values at even distances
    is_closed: bool = False  # .. whose last is at the end of the turn
    fills_turn: bool = False  # X is relative to its largest, which ends the turn
    units: Mapping[str, float] = {}  # degrees and mm of 1, by the setting Tabletype; none: 1
    head: str = ""  # written before the points, `{n}` of them; without a row nothing is written
    row: str = ""
    tail: str = ""

    def written(self, x_deg: Sequence[float], y: Sequence[float]) -> str:
        """Return the text of points of a turn, both ends included."""
        rows = [self.row.format(x=x, y=value) for x, value in zip(x_deg, y, strict=True)]
        return self.head.format(n=len(rows)) + "".join(rows) + self.tail


FORMS = {
    "sew": Form(
        "SEW",
        known_by=r"[0-9]{1,9}[;,\s]*\n[^\n]*\S[;\s]",
        head="{n}\n",
        row="{x!r};{y!r}\n",
    ),
    "kas": Form(
        "Kollmorgen",
        known_by=r"(CYCLIC|TABLE_BEGIN)[;,]",
        begin="TABLE_BEGIN",
        end="TABLE_END",
        beside=r"[;,]\s*SPLINE\W*$",
        fills_turn=True,
        head="CYCLIC;YES;\nTABLE_BEGIN;;\n",
        row="{x!r};{y!r};SPLINE\n",
        tail="TABLE_END;;\n",
    ),
    "isg": Form(
        "ISG",
        known_by=r"(Table[ -]?(name|ID|type)|Function[ -]?type|Lines)\s*=",
        begin="Begintable",
        end="EndTable",
        beside=r"#.*",
        columns=(1, 2),
        # signed 16, 32 bits; real; two columns: real, signed 32 bits
        units={"1": 1e-4, "2": 1e-4, "3": 1.0, "6": 1.0, "7": 1e-4},
    ),
    "asc": Form(
        "Schneider",
        known_by=r"Header\s*=",
        begin="CamPoints",
        columns=(1,),
        is_closed=True,
    ),
}
WRITTEN = tuple(name for name, form in FORMS.items() if form.row)
_SETTING = re.compile(r"([\w-][\w -]*)[=;,]([^#]*)")
_COUNT = re.compile(r"[0-9]{1,9}")
_NEARLY = 0.9  # of a turn: a largest X from here on is that of a turn without its end
_SAME = 1e-9  # of a turn


class Found(NamedTuple):
    """A file in a maker's form."""

    form: Form
    settings: dict[str, str]  # of its header, by keys in small letters without blanks and hyphens
    text: str  # the rows of points alone, on the lines on which they were


def _line_of(word: str, lines: list[str]) -> int:
    """Return the index of the line that begins with a word, -1 where there is none."""
    words = (re.split(r"[\s;,#=]", line.strip(), maxsplit=1)[0].casefold() for line in lines)
    return next((i for i, found in enumerate(words) if found == word.casefold()), -1)


def found_in(text: str, file: str) -> Found | None:
    """Return the points of a text in a maker's form; nothing where it is in none.

    Raises InputError: the line before the points or the one after them is missing.
    """
    lines = text.splitlines()
    written = [i for i, line in enumerate(lines) if not is_blank_or_comment(line)][:2]
    begins = "\n".join(lines[i].strip() for i in written)
    forms = (form for form in FORMS.values() if re.match(form.known_by, begins, re.IGNORECASE))
    form = next(forms, None)
    if form is None:
        return None
    first = _line_of(form.begin, lines) if form.begin else written[0]
    last = _line_of(form.end, lines) if form.end else len(lines)
    for word, is_missing in ((form.begin, first < 0), (form.end, last < 0)):
        if is_missing:
            problem = f"a cam table of {form.maker} without the line {word}"
            remedy = "copy it again: it may have been cut short; or give two columns, X and Y"
            raise InputError(file, "", None, problem, remedy)
    rows = lines[first + 1 : last]
    if form.beside:
        rows = [re.sub(form.beside, "", row, flags=re.IGNORECASE) for row in rows]
    return Found(form, _settings(lines[: first + 1]), "\n".join([""] * (first + 1) + rows))


def _settings(header: list[str]) -> dict[str, str]:
    """Return the settings of a header; a number alone is that of the points."""
    last = header[-1].strip(' \t;,"')
    found = {"lines": last} if _COUNT.fullmatch(last) else {}
    for line in header:
        setting = _SETTING.match(line.strip())
        if setting:
            found[re.sub("[ -]", "", setting[1].casefold())] = setting[2].strip(" \t;,")
    return found


def check_rows(found: Found, table: NumberTable) -> None:
    """Refuse columns that the form has not, and another number of points than it states."""
    maker, columns = found.form.maker, found.form.columns
    if table.n_columns not in columns:
        problem = f"a cam table of {maker} with {table.n_columns} columns"
        read = " or ".join(str(n) for n in columns)
        raise InputError(table.file, table.place, None, problem, f"only those with {read} are read")
    stated = found.settings.get("lines", "")
    if _COUNT.fullmatch(stated) and int(stated) != len(table.rows):
        problem = f"says that it has {stated} points, but {len(table.rows)} follow"
        remedy = "copy it again: it may have been cut short; or correct the number"
        raise InputError(table.file, "", None, problem, remedy)


def _number(found: Found, key: str, usual: float, file: str) -> float:
    text = found.settings.get(key.casefold(), str(usual))
    try:
        value = float(text)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        problem, remedy = "is no finite number", "write one, decimals with a point"
        raise InputError(file, key, None, problem, remedy)
    return value


def _unit(found: Found, file: str) -> float:
    """Return degrees and mm of 1, by the type of the table where the form has types."""
    units = found.form.units
    if not units:
        return 1.0
    kind = found.settings.get("tabletype", "")
    if kind not in units:
        problem = f"a cam table of {found.form.maker} of another type than {', '.join(units)}"
        remedy = "set one of these types, or give two columns, X and Y"
        raise InputError(file, "Tabletype", None, problem, remedy)
    return units[kind]


def _fill_turn(x: Floats, turn: float, file: str) -> Floats:
    """Return X scaled so that its largest ends the turn; refuse a turn without its end."""
    share = float(x.max()) / turn
    if _NEARLY <= share < 1 - _SAME:
        problem = f"the largest X is {x.max():.9g}, nearly a turn, which is {turn:.9g}"
        raise InputError(file, "", None, problem, "end the table at the turn, or scale X")
    return x / share if share > 0 else x


def placed(found: Found, rows: dict[str, Floats], turn: float, file: str) -> dict[str, Floats]:
    """Return columns X and Y in the file's degrees and mm; `turn` is what X of a turn is long.

    Raises InputError: a setting that is no number or no type of the form, or a turn without its
    end.
    """
    form, unit = found.form, _unit(found, file)
    y_factor, y_offset, x_length, x_offset = (
        _number(found, key, usual, file)
        for key, usual in (("YFactor", 1), ("YOffset", 0), ("XFactor", turn), ("XOffset", 0))
    )
    y = rows["y"] * (y_factor * unit) + y_offset
    if "x" not in rows:
        steps = max(1, y.size - form.is_closed)
        return {"x": x_offset + x_length * np.arange(y.size) / steps, "y": y}
    x = rows["x"] * unit
    if form.fills_turn and found.settings.get("cyclic", "").upper() == "YES":
        x = _fill_turn(x, turn, file)
    return {"x": x, "y": y}
