"""Cam tables of other makers: each form gives the law from which it was written, or a remedy."""

import re
from typing import NamedTuple

import numpy as np
import pytest

from camtools.base.errors import InputError
from camtools.base.quantities import Floats
from camtools.table.export import Export, export_files
from camtools.table.points import DEGREES_AND_MM, Reading, parse_points
from tests.tools.cases.cut_cases import made_of, skirt_of
from tests.tools.cases.part_cases import refused

LIFT_MM, HALF_DEG = 6.0, 80.0


def lift_mm(x_deg: Floats) -> Floats:
    """Return the 3-4-5 polynomial of a lobe whose nose is at 180 degrees."""
    u = np.clip(1 - np.abs(x_deg - 180) / HALF_DEG, 0, 1)
    return LIFT_MM * u**3 * (10 - 15 * u + 6 * u**2)


POINTS = [(x, float(lift_mm(np.array(x)))) for x in range(361)]  # both ends


def rows(line: str, end: str = "\n", x: float = 1, y: float = 1) -> str:
    """Return the points as lines, which may use their number; scales go to other units."""
    lines = [line.format(x * a, y * b, i) for i, (a, b) in enumerate(POINTS, start=1)]
    return end.join([*lines, ""])


def isg(kind: int, data: str) -> str:
    """Return a table of ISG or TwinCAT CNC."""
    n = len(data.splitlines())
    head = f"Tablename = Lobe # name\n Table-ID=404\nTabletype = {kind} # two columns\n"
    head += f"Function type = 5 # POLY5-LINE\nLines = {n} # number\nBegintable # Begin\n"
    return f"{head}{data}EndTable # End\n"


def asc(data: str, y_factor: str = "8") -> str:
    """Return a profile of Schneider's Motion Sizer."""
    return (
        f"Header=SoMachine Motion Builder\r\nVersion=4.2\r\nYFactor={y_factor}\r\nXFactor=360\r\n"
        "YOffset=-2\r\nXOffset=0\r\nStartSlope=0\r\nEndSlope=0\r\nInterpolationMode=1\r\n"
        f"CamPoints\r\n{data}"
    )


class Case(NamedTuple):
    """A file of a maker and how far its digits are from the law."""

    text: str
    off_mm: float = 1e-6
    reading: Reading = DEGREES_AND_MM


SHARES = "".join(f"{(y + 2) / 8!r}\r\n" for _, y in POINTS)
ALONE = "".join(f"{y!r}\n" for _, y in POINTS[:-1])
PAIRS = rows("{:.4f};{:.6f}")
CASES = {
    "SEW": Case("361\n" + rows("{};{:.6f}").replace(".", ",")),
    "SEW of a spreadsheet": Case("361;\n;;\n" + rows("{};{:.6f}").replace(".", ",")),
    "SEW with tabs": Case("# Lobe\n361\r\n" + rows("{:.1f}\t{:.6f}", "\r\n")),
    "Lenze": Case(rows("{:.1f}\t{:.6f} // point {}")),
    "Lenze with torques": Case(rows("{:.1f}\t{:.6f}\t0,0 // point {}")),
    "Kollmorgen": Case(f"CYCLIC;YES;\nTABLE_BEGIN;;\n{rows('{};{:.6f};SPLINE')}TABLE_END;;\n"),
    "Kollmorgen, of 1000": Case(
        f"CYCLIC;YES;\nTABLE_BEGIN;;\n{rows('{!r};{:.6f};SPLINE', x=1000 / 360)}TABLE_END;;\n"
    ),
    "ISG, numbers": Case(isg(6, rows("{} {:.6f} # {}"))),
    "ISG, integers": Case(isg(7, rows("{:.0f}\t{:.0f} # {}", x=1e4, y=1e4)), 0.5e-4),
    "ISG, other keys": Case(
        isg(7, rows("{:.0f}\t{:.0f}", x=1e4, y=1e4)).replace("Tabletype", "Table-Type"), 0.5e-4
    ),
    "ISG, values alone": Case(isg(3, ALONE)),
    "Schneider": Case(asc(SHARES)),
    "Technosoft": Case(
        rows("{:.0f}\t{:.0f}", x=32, y=1000), 0.5e-3, Reading(1, 1e-3, counts_per_turn=11520)
    ),
}


@pytest.mark.parametrize("name", list(CASES))
def test_each_form_gives_the_law(name: str) -> None:
    """360 points, a degree apart, within the digits that the file has."""
    case = CASES[name]
    found = parse_points(case.text, "a.csv", case.reading)
    [turn] = found.sections
    assert not found.has_motion
    np.testing.assert_allclose(turn.x_deg, np.arange(360), atol=1e-9)
    np.testing.assert_allclose(turn.y_mm, lift_mm(np.arange(360.0)), atol=1.01 * case.off_mm)


KAS = CASES["Kollmorgen"].text
REFUSED = [
    (f"361\n{PAIRS}".replace("\n7.0000;0.000000", ""), "says that it has 361 points, but 360 foll"),
    (isg(6, PAIRS).replace("= 361 #", "= \u00b2 #").replace("\n7.0", "\n6.0"), "angle 6 follows 6"),
    ("3\n0;1;2\n1;1;2\n2;1;2\n", "line 2: a cam table of SEW with 3 columns; only those with 2"),
    (KAS.replace("TABLE_END;;\n", ""), "Kollmorgen without the line TABLE_END; copy it again"),
    (KAS.replace("TABLE_BEGIN;;\n", ""), "Kollmorgen without the line TABLE_BEGIN"),
    (KAS.replace("YES", "NO").replace("\n360", "\n350.5"), "line 363: angle 350.5 follows 359"),
    (KAS.replace("\n5;0.0", "\n5;x"), "line 8: cell 2 is no finite number"),
    (KAS.replace("\n360;0.000000;SPLINE", ""), "the largest X is 359, nearly a turn, which is 360"),
    (isg(8, PAIRS), "Tabletype: a cam table of ISG of another type than 1, 2, 3, 6, 7; set"),
    (isg(6, PAIRS).replace("= 6", "= 0x1"), "Tabletype: a cam table of ISG of another type"),
    (isg(5, rows("{} {} 0 0")), "ISG with 4 columns; only those with 1 or 2 are read"),
    (isg(7, PAIRS).replace("Begintable", "Begin"), "ISG without the line Begintable"),
    (asc(SHARES, "8,0"), "YFactor: is no finite number; write one, decimals with a point"),
    (asc(SHARES, "password"), "YFactor: is no finite number"),
    (asc(SHARES.replace("0.25", "9", 1), "1e308"), "line 11: no finite number in degrees"),
    (asc(SHARES, "-inf"), "YFactor: is no finite number"),
]


@pytest.mark.parametrize(("text", "problem"), REFUSED)
def test_what_is_wrong_in_a_form_is_named(text: str, problem: str) -> None:
    """The line as it is in the file, or the word that is missing, and a remedy."""
    line = refused(lambda: parse_points(text, "a.csv"), InputError)
    assert line.startswith("a.csv: ") and problem in line and "; " in line
    assert "password" not in line


@pytest.mark.parametrize("form", ["sew", "kas"])
def test_written_forms_are_read_again(form: str) -> None:
    """By the reader and by hand: every number is the one that the form "text" has."""
    table = skirt_of("perkins240").table
    plain = export_files(table, Export("text", (20.0,)))
    files = export_files(table, Export(form, (20.0,)))
    assert sorted(files) == [f"perkins240_u_z20_{form}.csv", "perkins240_x_text.csv"]
    assert files["perkins240_x_text.csv"] == plain["perkins240_x_text.csv"]
    expected = np.loadtxt(plain["perkins240_u_z20_text.txt"].decode().splitlines())
    text = files[f"perkins240_u_z20_{form}.csv"].decode()
    if form == "sew":
        assert text.splitlines()[0] == "361"
    else:
        assert text.startswith("CYCLIC;YES;\nTABLE_BEGIN;;\n") and text.endswith("\nTABLE_END;;\n")
        assert text.count(";SPLINE\n") == 361
    by_hand = re.findall(r"^([^;\n]+);([\d.e+-]+)(?:;SPLINE)?$", text, re.MULTILINE)
    np.testing.assert_array_equal(np.array(by_hand, dtype=float), expected)
    [turn] = parse_points(text, "a.csv").sections
    np.testing.assert_array_equal(np.stack([turn.x_deg, turn.y_mm]), expected[:-1].T)


def test_a_cam_has_a_file_for_each_profile() -> None:
    """No height is needed; the lift at the nose is that of the drawing, 8 mm."""
    files = export_files(made_of("cam-345").table.table, Export("kas"))
    [turn] = parse_points(files["cam-345_lift_profile1_kas.csv"].decode(), "a.csv").sections
    assert turn.y_mm.max() == pytest.approx(8.0, abs=1e-5)


TURN = [float(x) for x in range(0, 360, 5)]
ORDERS = {
    "360 for 0": [360.0, *TURN[1:]],
    "from 180": [*TURN[36:], *TURN[:36]],
    "from 180, closed": [*TURN[36:], *TURN[:37]],
    "from 180, 360 for 0": [*TURN[36:], 360.0, *TURN[1:36]],
    "from -180": [x - 360 for x in TURN[36:]] + TURN[:36],
}


@pytest.mark.parametrize("name", list(ORDERS))
def test_a_turn_may_begin_anywhere(name: str) -> None:
    """Its angles fall once, from its end to its begin; the points are those of the law."""
    lines = [f"{x} {lift_mm(np.mod(np.array(x), 360)):.9f}\n" for x in ORDERS[name]]
    [turn] = parse_points("".join(lines), "a.csv").sections
    assert turn.x_deg.size == len(TURN) and (np.diff(turn.x_deg) > 0).all()
    np.testing.assert_allclose(turn.y_mm, lift_mm(np.mod(turn.x_deg, 360)), atol=1e-9)
    assert sorted(np.mod(turn.x_deg, 360)) == TURN


@pytest.mark.parametrize(
    ("angles", "problem"),
    [
        ([*TURN[:20], 10.0, *TURN[21:]], "line 21: angle 10 follows 95 degrees"),
        ([5.0, *TURN[1:]], "line 2: angle 5 follows 5 degrees"),
        ([*TURN, 36.0], "line 73: angle 36 follows 355 degrees"),
        (TURN[::-1], "line 2: angle 350 follows 355 degrees"),
    ],
)
def test_angles_that_do_not_rise_are_refused(angles: list[float], problem: str) -> None:
    """A mistyped angle is no turn that begins elsewhere."""
    text = "".join(f"{x} 1\n" for x in angles)
    assert problem in refused(lambda: parse_points(text, "a.csv"), InputError)
