"""Every table of numbers is read by the same rules, whichever program wrote it."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from camtools.base.errors import InputError
from camtools.base.files import utf8_text
from camtools.base.number_table import Column, NumberTable, read_whole_table
from camtools.base.quantities import Floats
from camtools.identify.foreign_record import MIN_ROWS, parse_record
from camtools.link.kept_values import learned_values
from camtools.link.kept_values import parse as parse_parameters
from camtools.measured.points import HEADER as GAUGED
from camtools.measured.points import parse_points as parse_gauged
from camtools.part.model import read_tree
from camtools.sim.machine_file import machine_bytes, read_machine
from camtools.skirt.geometry.section_file import HEADER as SCAN
from camtools.skirt.geometry.section_file import parse_sections
from camtools.table.points import parse_points
from camtools.tune import parameters

Rows = list[list[str]]


class Reader(NamedTuple):
    """A reader of one kind of table, and a table of it."""

    read: Callable[[str, str], object]  # text and name of the file
    numbers: Callable[[str], Floats]  # what it makes of a text
    header: str
    rows: Rows


def gauged(text: str) -> Floats:
    """Return angle, height and deviation."""
    return np.stack(parse_gauged(text, "a.csv")[:3])


def section(text: str) -> Floats:
    """Return angles and values of the only height."""
    found = parse_sections(text, "a.csv")
    return np.stack([found.angles_deg[0], found.values_mm[0]])


def turn(text: str) -> Floats:
    """Return angles and values of the only turn."""
    return np.stack(parse_points(text, "a.csv").sections[0][:2])


def record(text: str) -> Floats:
    """Return command and position."""
    return np.stack(parse_record(text, "a.csv")[1:3])


TURN = [[f"{15 * i}.0", f"{i % 7}.125"] for i in range(24)]
READERS = {
    "gauged": Reader(parse_gauged, gauged, GAUGED, [[a, "2.5", y] for a, y in TURN]),
    "scan": Reader(parse_sections, section, SCAN, [[a, "2.5", y] for a, y in TURN]),
    "points": Reader(parse_points, turn, "angle_deg,lift_mm", TURN),
    "record": Reader(
        parse_record,
        record,
        "time_s,command_um,position_um",
        [[f"{i / 1000:.3f}", f"{i % 7}.5", f"{i % 5}.25"] for i in range(MIN_ROWS)],
    ),
}


def text_of(lines: Rows, separator: str = ",", end: str = "\n") -> str:
    """Return lines of cells as text."""
    return "".join(separator.join(cells) + end for cells in lines)


def each(change: Callable[[str], str], lines: Rows) -> Rows:
    """Return lines with each of their cells changed."""
    return [[change(cell) for cell in cells] for cells in lines]


def comma(cell: str) -> str:
    """Return a number with a decimal comma."""
    return cell.replace(".", ",")


def quoted(cell: str) -> str:
    """Return a cell in quotes."""
    return f'"{cell}"'


def fortran(cell: str) -> str:
    """Return a number with an exponent of Fortran."""
    return f"{float(cell) * 100:+.6f}D-02"


WRITERS: dict[str, Callable[[Rows], str]] = {
    "blanks after commas": lambda lines: text_of(lines, ", "),
    "semicolons": lambda lines: text_of(lines, ";"),
    "semicolons and decimal commas": lambda lines: text_of(each(comma, lines), " ; "),
    "tabs": lambda lines: text_of(lines, "\t"),
    "padded tabs": lambda lines: text_of(each(lambda cell: f" {cell} ", lines), "\t"),
    "a further column after tabs": lambda lines: text_of(
        [
            ["no name", *lines[0], "Remarks"],
            *(["", *row, ("", "dust, wiped off")[i % 2]] for i, row in enumerate(lines[1:])),
        ],
        "\t",
    ),
    "tabs under blanks": lambda lines: text_of(lines[:1], "\t") + text_of(lines[1:], "\t\t"),
    "addresses and slashes": lambda lines: text_of(
        [
            ["file", *lines[0]],
            *([("https://a/b", '"a // b"')[i % 2], *row] for i, row in enumerate(lines[1:])),
        ]
    ),
    "blanks": lambda lines: text_of([["", *cells, ""] for cells in lines], "  "),
    "blanks and decimal commas": lambda lines: text_of(each(comma, lines), " "),
    "Windows": lambda lines: text_of(lines, end="\r\n"),
    "capitals": lambda lines: text_of([[name.upper() for name in lines[0]], *lines[1:]]),
    "quotes": lambda lines: text_of(each(quoted, lines)),
    "quotes and decimal commas": lambda lines: text_of(each(quoted, each(comma, lines)), "; "),
    "quotes and tabs": lambda lines: text_of(each(quoted, lines), "\t"),
    "R": lambda lines: text_of(
        [['""', *map(quoted, lines[0])], *([f'"{i}"', *row] for i, row in enumerate(lines[1:]))]
    ),
    "a note in a further column": lambda lines: text_of(
        [[*lines[0], "note"], *([*row, '"dust, wiped off"'] for row in lines[1:])]
    ),
    "an empty further column": lambda lines: text_of(
        [[*lines[0], "area"], *([*row, ""] for row in lines[1:])]
    ),
    "Excel": lambda lines: text_of(
        [["", ""], *([*cells, "", ""] for cells in lines), ["", "", ""]], ";"
    ),
    "blank lines": lambda lines: "\n \n" + text_of(lines, end="\n\n") + "\t\n",
    "comments": lambda lines: (
        "# a tester\n//\n"
        + text_of(lines, end=" // a point\n#\n,,,// no point\n")
        + "(* end *)\n# end"
    ),
    "Fortran": lambda lines: text_of([lines[0], *each(fortran, lines[1:])], "   "),
}


@pytest.mark.parametrize("name", list(READERS))
@pytest.mark.parametrize("writer", list(WRITERS))
def test_every_reader_reads_every_program(name: str, writer: str) -> None:
    """Separator, quotes, notes and further columns change nothing."""
    reader = READERS[name]
    lines = [reader.header.split(","), *reader.rows]
    expected = reader.numbers(text_of(lines))
    assert expected.shape[1] == len(reader.rows)
    found = reader.numbers(WRITERS[writer](lines))
    np.testing.assert_allclose(found, expected, rtol=1e-12)


@pytest.mark.parametrize("separator", [",", ", ", ";", "\t", " "])
def test_motion_may_follow_and_the_header_be_missing(separator: str) -> None:
    """Two or four columns of points need no header; columns that nobody asks for may be there."""
    phi = np.radians(np.arange(0, 360, 15))
    columns = [np.degrees(phi), 1 - np.cos(phi), np.sin(phi) * np.pi / 180]
    columns.append(np.cos(phi) * (np.pi / 180) ** 2)
    rows = [[f"{value:.9f}" for value in row] for row in np.stack(columns).T.tolist()]
    moving = parse_points(text_of(rows, separator), "a.csv")
    assert moving.has_motion
    header = ["angle_deg", "lift_mm", "V_mm_per_deg", "A_mm_per_deg2"]
    named = parse_points(text_of([header, *rows], separator), "a.csv")
    np.testing.assert_array_equal(named.sections[0], moving.sections[0])
    alone = parse_points(text_of([row[:2] for row in rows], separator), "a.csv")
    assert not alone.has_motion
    np.testing.assert_array_equal(alone.sections[0][:2], moving.sections[0][:2])
    aligned = [[f"{cell:>12}" for cell in row] for row in rows]  # the first row all with blanks
    for text in (text_of(aligned), text_of(rows, ", ")):
        np.testing.assert_array_equal(parse_points(text, "a.csv").sections[0], moving.sections[0])
    jerk = [[*header[:2], "J", "more"], *rows]
    assert not parse_points(text_of(jerk, separator), "a.csv").has_motion


@pytest.mark.parametrize(
    ("header", "place"),
    [
        ("X_deg;Y_mm;V_mm/deg;A_mm/deg2", 3),
        ("height_mm;X_deg;Y_mm", 1),
        ("X_deg;lift [mm]", 2),
        ("angle(deg);lift_mm", 1),
        ("X_deg;Y_mm;z_cm", 3),
    ],
)
def test_misspelt_names_of_points_are_refused(header: str, place: int) -> None:
    """They must not count as further columns; words that only begin alike do."""
    row = ";".join("0" for _ in header.split(";"))
    with pytest.raises(InputError, match=f"line 1: column {place} has an unknown unit or name; "):
        parse_points(f"{header}\n{row}\n", "a.csv")
    further = [["X_deg", "Y_mm", "area", "x\u00e4", "positions", "note"]]
    further += [[*row, "", "", "", ""] for row in TURN]
    np.testing.assert_array_equal(turn(text_of(further, ";")), turn(text_of(TURN)))


KINDS = {"angle": {"angle_deg": 1.0}, "lift": {"lift_mm": 1.0, "lift_um": 1e-3}}
HEADER = "angle_deg,lift_mm"
REFUSED = [
    ("", "line 1: needs one column of the angle: angle_deg; has none; write a header as"),
    ("# a\n1,2\n", "line 2: needs one column of the angle: angle_deg; has none"),
    ("angle,lift_mm\n", "line 1: needs one column of the angle"),
    ("angle_deg,lift\n", "line 1: needs one column of the lift: lift_mm, lift_um; has none"),
    ("angle_deg,lift_mm,lift_um\n", "has lift_mm, lift_um; rename all but one of them"),
    ("angle_deg,lift_mm,Lift_mm\n", "has lift_mm, lift_mm; rename all but one of them"),
    (f"{HEADER}\n0,1\n0,2,2\n", "line 3: has 3 cells, the header names 2; separate by s"),
    (f"{HEADER}\n0,2,2,176\n", "line 2: has 4 cells, the header names 2; separate"),
    (f"{HEADER}\n\n#\n0\n", "line 4: has 1 cell, the header names 2"),
    ("angle_deg;lift_mm\n0,1\n", "has 1 cell, the header names 2; separate the cells as in line 1"),
    (f"{HEADER}\n0;1\n", "line 2: has 1 cell, the header names 2"),
    ("angle_deg\tlift_mm\tnote\n0\t1\ta b\tc\n", "line 2: has 4 cells, the header names 3"),
    (f"{HEADER}\n0,nan\n", "line 2: cell 2 (lift_mm) is no finite number; write"),
    (f"{HEADER}\n-inf,1\n", "line 2: cell 1 (angle_deg) is no finite number"),
    (f"{HEADER}\n0,\n", "line 2: cell 2 (lift_mm) is no finite number"),
    (f'{HEADER}\n"0","0,5"\n', "line 2: cell 2 (lift_mm) is no finite number"),
    ("angle_deg,lift_um\n0,1\n1,1e309\n", "line 3: cell 2 (lift_um) is no finite number"),
    ("angle_deg,lift_um\n0,1e15\n1,-1e308\n", "line 3: cell 2 (lift_um) is beyond 1e+15; c"),
    (f"{HEADER}\n1.1D12,0\n", "line 2: cell 1 (angle_deg) is beyond 1e+12; correct the number"),
    (f"{HEADER}\n0,1.2.3\n", "a number there, decimals with a point"),
    ("angle_deg lift_mm\n0 1.2.3\n", "a number there, decimals with a point or a comma"),
    (f"{HEADER}\n0,word\n", "line 2: cell 2 (lift_mm) is no finite number"),
    (f"{HEADER}\n" + "0,1\n" * 9, "a.csv: has 9 rows, at most 8 are read; leave out rows"),
]


@pytest.mark.parametrize(("text", "message"), REFUSED)
def test_bad_tables_are_refused(text: str, message: str) -> None:
    """One line with file, line, problem and remedy."""
    with pytest.raises(InputError) as caught:
        table = NumberTable(text, "a.csv", 8)
        table.values(table.columns(KINDS, HEADER))
    [line] = caught.value.lines
    assert line.startswith("a.csv: ") and message in line


def test_lines_without_header_have_as_many_cells_as_the_first() -> None:
    """Its line is named."""
    table = NumberTable("#\n0 1\n1 2 3\n", "a.csv", 8)
    assert (table.names, table.n_columns, table.place) == ([], 2, "line 2")
    with pytest.raises(InputError, match=r"line 3: has 3 cells, line 2 has 2; separ"):
        table.values([Column(0)])


@pytest.mark.parametrize("name", list(READERS))
@pytest.mark.filterwarnings("error")
def test_numbers_beyond_any_use_are_refused(name: str) -> None:
    """With line, cell and limit, before anything overflows."""
    reader = READERS[name]
    for place, column in enumerate(reader.header.split(",")):
        rows = [[*row] for row in reader.rows]
        rows[5][place] = "-1e308"
        message = rf"line 7: cell {place + 1} \({column}\) is beyond [\d.e+]+; correct the number"
        with pytest.raises(InputError, match=message):
            reader.read(f"{reader.header}\n{text_of(rows)}", "a.csv")


SECRET = "operator,hunter2,7031"


@pytest.mark.parametrize("name", list(READERS))
def test_no_word_of_a_foreign_file_is_shown(name: str, tmp_path: Path) -> None:
    """A part file from somebody else may name a list of passwords."""
    reader = READERS[name]
    header, good = reader.header, text_of(reader.rows)
    path = tmp_path / "given.csv"
    for text in (
        SECRET,
        f"{header}\n{SECRET}\n",
        f"7031 4711 12\n{SECRET}\n",
        f"{header}\n{good}{SECRET}\n",
        f"{header}\n{good}1,2,x\n",
        "40007031",
        f"7031,{'4711' * 40}",
        f"{header}\n{good}40007031\n",
        f"{header}\n7031,1e40007031,4711\n",
    ):
        path.write_text(text)
        with pytest.raises(InputError) as info:
            reader.read(read_whole_table(path, 10**6), "given.csv")
        [line] = info.value.lines
        assert line.startswith("given.csv: ") and ";" in line
        assert not any(word in line for word in ("operator", "hunter2", "7031", "4711"))


TOML: dict[str, Callable[[bytes], object]] = {
    "part": lambda data: read_tree(data, "a.toml"),
    "machine": lambda data: read_machine(utf8_text(data, "a.toml"), "a.toml"),
    "parameters": lambda data: parse_parameters(data, "a.toml"),
}


def test_marks_of_windows_are_no_matter(tmp_path: Path) -> None:
    """Tables and TOML files may begin with a byte-order mark; UTF-16 is named."""
    text = "spindle_mrpm = 1\n"
    for read in TOML.values():
        assert read(text.encode("utf-8-sig")) == read(text.encode()) == {"spindle_mrpm": 1}
    path = tmp_path / "a.toml"
    path.write_text(text, "utf-8-sig")
    assert parameters.read_tree(path) == {"spindle_mrpm": 1}
    assert read_whole_table(path, 100) == text
    assert machine_bytes(str(path)) == text.encode()
    for encoding in ("utf-16", "utf-16-le", "utf-16-be"):
        path.write_text(text, encoding)
        for refused in (
            lambda: read_whole_table(path, 100),
            lambda: parameters.read_tree(path),
            lambda: read_tree(path.read_bytes(), "a.toml"),
            lambda: parse_parameters(path.read_bytes(), "a.toml"),
            lambda: learned_values(path.read_bytes(), "a.toml"),
        ):
            with pytest.raises(InputError, match="not UTF-8 text but UTF-16; save the file as UTF"):
                refused()


@pytest.mark.parametrize("data", [b"\0\0\xff\0", b"\0\1\xff", b"a\0\xff"])
def test_binaries_are_not_taken_for_utf16(data: bytes) -> None:
    """Its first letter has a single byte of 0, and its bytes are in pairs."""
    with pytest.raises(InputError, match=r"not UTF-8 text \(byte"):
        utf8_text(data, "a.bin")


@pytest.mark.parametrize(("end", "is_read"), [("1,2.5", False), ("secret", False), ("# 1", True)])
def test_tables_that_stop_within_a_line_are_refused(
    tmp_path: Path, end: str, is_read: bool
) -> None:
    """A number may have lost digits, a comment has no numbers."""
    (tmp_path / "a.csv").write_text(f"{HEADER}\n{end}")
    if is_read:
        assert read_whole_table(tmp_path / "a.csv", 100).endswith(end)
        return
    with pytest.raises(InputError, match=r"^a.csv: line 2: the file stops within this line"):
        read_whole_table(tmp_path / "a.csv", 100)
