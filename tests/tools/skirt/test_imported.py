"""Profile and ovality from CSV and DXF: what is understood, and what is refused."""

from itertools import count, pairwise
from math import atan2, degrees, radians, sqrt, tan
from pathlib import Path

import numpy as np
import pytest

from camtools.part.model import files_named, validated
from camtools.pipeline.load import load
from camtools.skirt.geometry.profile import profile_spline
from camtools.skirt.part.keys import Profile
from camtools.skirt.part.part_file import Piston
from camtools.skirt.report.summary import import_facts
from tests.tools.cases.part_cases import refused

Table = dict[str, object]
OVALITY: Table = {"height_mm": [-10.0, 100.0], "ovality_mm": [0.1, 0.2]}


def piston(folder: Path, profile: Table, ovality: Table = OVALITY) -> tuple[Piston, Profile]:
    """Return the piston with these tables of a part file, and its profile."""
    tree = {"profile": profile, "ovality": ovality}
    found = validated(Piston, tree, "p.toml", {"folder": folder, "is_confined": True})
    assert isinstance(found.profile, Profile)
    return found, found.profile


ROWS = (0, 45.97), (20, 46), (62, 45.868)
# The same drawing, as different people export it: heights 0, 20, 62, diameters 91.94, 92, 91.736.
CSV: dict[str, tuple[Table, str]] = {
    "header": ({}, "height,diameter\n0,91.94\n20,92\n62,91.736\n"),
    "spreadsheet": ({}, '\ufeff"Dia [mm]";Note;"Z (mm)"\r\n91,736;a;62\r\n92;;20\r\n91,94;b;0\r\n'),
    "radius": ({}, "# a comment\n\nz\tr_mm\n0\t45.97\n20\t46\n62\t45.868\n"),
    "inch": ({"unit": "inch"}, "z r\n" + "".join(f"{z / 25.4!r} {r / 25.4!r}\n" for z, r in ROWS)),
    "drop": ({"values": "drop-um", "nominal_mm": 92.0}, "62;132\n20;0\n0;30\n"),
    "drop in mm": ({"nominal_mm": 92.0}, "z_mm;drop_mm\n0;0,030\n20;0\n62;0,132\n"),
    "columns": ({"values": "diameter", "columns": [3, 1]}, "91.94,9,0\n92,9,20\n91.736,9,62\n"),
    "one of two": ({"values": "radius"}, "z,r,d\n0,45.97,1\n20,46,1\n62,45.868,1\n"),
}


@pytest.mark.parametrize("form", CSV)
def test_every_form_of_a_table_gives_the_same_profile(form: str, tmp_path: Path) -> None:
    """Separators, decimals, order, units, radius, diameter or drop."""
    keys, text = CSV[form]
    (tmp_path / "a.csv").write_text(text, "utf-8")
    _, found = piston(tmp_path, {"csv": "a.csv", **keys})
    assert found.height_mm == pytest.approx([0, 20, 62], abs=1e-9)
    assert found.diameter_mm == pytest.approx([91.94, 92, 91.736], abs=1e-9)


def test_ovality_in_um_or_mm(tmp_path: Path) -> None:
    """Also beside the diameters of one table; the summary states how it was understood."""
    barrel: Table = {"height_mm": [0.0, 62.0], "diameter_mm": [92.0, 91.736]}
    forms: tuple[tuple[Table, str, str], ...] = (
        ({}, "height;ovality_um\n62;300\n0;150\n", "ovality in um"),
        ({"values": "ovality-um"}, "0 150\n62 300\n", "ovality in um"),
        ({}, "d,z,oval\n92,0,0.15\n91,62,0.3\n", "ovality in mm"),
    )
    for keys, text, kind in forms:
        (tmp_path / "o.csv").write_text(text)
        found, _ = piston(tmp_path, barrel, {"csv": "o.csv", **keys})
        assert found.ovality is not None
        assert found.ovality.height_mm == [0, 62]
        assert found.ovality.ovality_mm == pytest.approx([0.15, 0.3], abs=1e-12)
        [words] = import_facts(found).values()
        assert words.startswith("o.csv: 2 points at 0 .. 62 mm") and words.endswith(kind)


WRONG_CSV: list[tuple[Table, str, str]] = [
    ({}, "z,d\n0,92\n20,x\n", "a.csv: line 3: cell 2 (d) is no finite number"),
    ({}, "z,d\n0,92\n20,9200\n", "line 3: cell 2, the diameter, is beyond 1 .. 4000 mm"),
    ({}, "z,d\n0,92\n\n20,92\n10,92\n40,92\n", "line 5: the height is not 0.01 mm more"),
    ({}, "z,d\n40,92\n20,92\n20,92\n10,92\n", "line 4: the height is not 0.01 mm less"),
    ({}, "0,92\n20,92\n", "line 1: of 2 columns one must be the diameter or radius or drop"),
    ({"values": "radius"}, "z,d\n0,92\n20,92\n", "line 1: of 2 columns one must be the radius"),
    ({}, "z,d,r\n0,92,46\n20,92,46\n", "has 2 columns of that name; name it in the header"),
    ({}, "z,drop\n0,1\n20,2\n", "profile.nominal_mm: is missing"),
    ({"nominal_mm": 92.0}, "z,d\n0,92\n20,92\n", "nominal_mm = 92.0: has no meaning"),
    ({"values": "D"}, "", "profile.values = 'D': Input should be"),
    ({"height_mm": [0, 1]}, "z,d\n0,92\n20,92\n", "profile.height_mm: cannot be combined"),
]


# A half profile: a hollow arc, a convex one, a line. Points and centres are (radius, height).
R_CONVEX, R_HOLLOW = 3300.0, 500.0
AT_5, AT_62 = -3254 + sqrt(R_CONVEX**2 - 20**2), -3254 + sqrt(R_CONVEX**2 - 37**2)
CONVEX, HOLLOW = (-3254.0, 25.0), (AT_5 + sqrt(R_HOLLOW**2 - 3**2), 2.0)
POINTS = [(HOLLOW[0] - sqrt(R_HOLLOW**2 - 2**2), 0.0), (AT_5, 5.0), (AT_62, 62.0), (45.0, 70.0)]
HEIGHTS_MM = (0.0, 5.0, 62.0, 70.0)


def drawn_mm(z_mm: float) -> float:
    """Return the radius at a height."""
    if z_mm > 62:
        return AT_62 + (45 - AT_62) * (z_mm - 62) / 8
    centre, radius, side = (HOLLOW, R_HOLLOW, -1) if z_mm < 5 else (CONVEX, R_CONVEX, 1)
    return centre[0] + side * sqrt(radius**2 - (z_mm - centre[1]) ** 2)


def angle_deg(centre: tuple[float, float], i: int) -> float:
    """Return the angle of a point about a centre."""
    return degrees(atan2(POINTS[i][1] - centre[1], POINTS[i][0] - centre[0])) % 360


HOLLOW_DEG = angle_deg(HOLLOW, 0) - angle_deg(HOLLOW, 1)  # clockwise where the contour rises
CONVEX_DEG = (angle_deg(CONVEX, 2) - angle_deg(CONVEX, 1)) % 360
BULGES = [-tan(radians(HOLLOW_DEG) / 4), tan(radians(CONVEX_DEG) / 4), 0.0, 0.0]
UP = [(x, y, bulge) for (x, y), bulge in zip(POINTS, BULGES, strict=True)]
DOWN = [(*UP[3][:2], 0.0), (*UP[2][:2], -BULGES[1]), (*UP[1][:2], -BULGES[0]), UP[0]]


def tags(*pairs: tuple[int, object]) -> str:
    """Return group codes and values as a DXF file has them."""
    return "".join(f"{code}\n{value}\n" for code, value in pairs)


def drawing(*entities: str, unit: int = 4) -> str:
    """Return a drawing with these entities."""
    begin = ((0, "SECTION"), (2, "HEADER"), (9, "$ACADVER"), (1, "AC1015"), (9, "$INSUNITS"))
    header = tags(*begin, (70, unit), (0, "ENDSEC"), (0, "SECTION"), (2, "ENTITIES"))
    return header + "".join(entities) + tags((0, "ENDSEC"), (0, "EOF"))


HANDLES = count(40)


def entity(kind: str, name: str, *pairs: tuple[int, object], layer: str = "Skirt") -> str:
    """Return an entity; `name` is that of its class."""
    return tags((0, kind), (5, next(HANDLES)), (100, "AcDbEntity"), (8, layer), (100, name), *pairs)


def polyline(vertices: list[tuple[float, float, float]], *more: tuple[int, object]) -> str:
    """Return a polyline of points with bulges."""
    rows = [pair for x, y, b in vertices for pair in ((10, repr(x)), (20, repr(y)), (42, repr(b)))]
    return entity("LWPOLYLINE", "AcDbPolyline", (90, len(vertices)), (70, 0), *more, *rows)


def line(start: tuple[float, float], end: tuple[float, float], layer: str = "Skirt") -> str:
    """Return a line."""
    ends = (10, start[0]), (20, start[1]), (11, end[0]), (21, end[1])
    return entity("LINE", "AcDbLine", *ends, layer=layer)


def arc(centre: tuple[float, float], radius: float, start_deg: float, end_deg: float) -> str:
    """Return an arc, counter-clockwise."""
    place = (10, repr(centre[0])), (20, repr(centre[1])), (40, radius)
    return entity("ARC", "AcDbCircle", *place, (100, "AcDbArc"), (50, start_deg), (51, end_deg))


ARCS = (
    arc(CONVEX, R_CONVEX, angle_deg(CONVEX, 1), angle_deg(CONVEX, 2)),
    arc(HOLLOW, R_HOLLOW, angle_deg(HOLLOW, 1), angle_deg(HOLLOW, 0)),
)
AXIS, BELOW = line((0, -5), (0, 80), layer="Axis"), ((210, 0), (220, 0), (230, -1))
DXF: dict[str, tuple[Table, str]] = {
    "downwards": ({}, drawing(polyline(DOWN))),
    "seen from below": ({}, drawing(polyline([(-x, y, -b) for x, y, b in UP], *BELOW))),
    "axis x": ({"axis": "x"}, drawing(polyline([(y, x, -b) for x, y, b in UP]))),
    "inch": ({}, drawing(polyline([(x / 25.4, y / 25.4, b) for x, y, b in UP]), unit=1)),
    "no unit": ({"unit": "mm"}, drawing(polyline(UP), unit=0)),
    "entities": ({"layer": "skirt"}, drawing(line(POINTS[3], POINTS[2]), ARCS[0], AXIS, ARCS[1])),
}


@pytest.mark.parametrize("form", DXF)
def test_lines_and_arcs_are_followed_exactly(form: str, tmp_path: Path) -> None:
    """The circles of the drawing, to a picometre of the radius, kinks included."""
    keys, text = DXF[form]
    (tmp_path / "a.dxf").write_text(text)
    _, profile = piston(tmp_path, {"dxf": "a.dxf", **keys})
    assert profile.height_mm == list(HEIGHTS_MM)
    z_mm = np.concatenate([np.linspace(*ends, 99) for ends in pairwise(HEIGHTS_MM)])[1:-1]
    curve = profile_spline(profile)
    assert max(abs(float(curve(z)) - drawn_mm(float(z))) for z in z_mm) < 1e-9
    assert profile.understood.startswith("a.dxf: layer Skirt, 3 segments at 0 .. 70 mm, unit ")


SPLINE = entity("SPLINE", "AcDbSpline", (70, 8), (71, 3), (72, 0), (73, 0))


WRONG_DXF: list[tuple[Table, str, str]] = [
    (
        {},
        drawing(polyline(UP), SPLINE),
        f"entity {SPLINE.split()[3]} (SPLINE) of layer Skirt: is none of lines",
    ),
    ({"layer": "B"}, drawing(polyline(UP), AXIS), 'layer "B" is empty; set layer to'),
    ({}, drawing(polyline(UP), AXIS), "in model space: Axis, Skirt"),
    ({}, drawing(polyline(UP), unit=6), 'neither mm nor inch; set unit = "mm"'),
    ({}, drawing(line(POINTS[0], POINTS[1]), line(POINTS[2], POINTS[3])), "from the end of"),
    ({}, drawing(polyline([*UP, (20.0, 70.0, 0.0)])), "rises by less than 0.01 mm at height"),
    ({}, drawing(arc((45, 30), 5, 300, 60), arc((45, 30), 5, 60, 90)), "turns back over the"),
    ({}, drawing(line((-1, 0), (45, 60))), ": height 0, radius -1 mm is beyond"),
    ({}, "z,d\n0,92\n", "a.dxf: cannot be read: it is no DXF drawing; give"),
    ({}, drawing(polyline(UP))[:-40], "a.dxf: cannot be read: it is no DXF drawing"),
]
WRONG = [*(("csv", "", *row) for row in WRONG_CSV), *(("dxf", "dxf: a.dxf", *r) for r in WRONG_DXF)]


@pytest.mark.parametrize(("key", "place", "keys", "text", "words"), WRONG)
def test_a_wrong_file_is_refused_with_its_place(
    key: str, place: str, keys: Table, text: str, words: str, tmp_path: Path
) -> None:
    """File, line and column or handle and layer, and remedy."""
    (tmp_path / f"a.{key}").write_text(text)
    line = refused(lambda: piston(tmp_path, {key: f"a.{key}", **keys}))
    assert line.startswith(f"p.toml: profile.{place}")
    assert words in line and "; " in line


def test_files_are_confined_and_step_is_out_of_scope(tmp_path: Path) -> None:
    """A drawing goes along with its part like a table; a STEP file is refused everywhere."""
    assert files_named({"piston": {"profile": {"dxf": "a.dxf"}}}) == ["a.dxf"]
    for name, words in (("../a.dxf", "leads out of the folder"), ("a.STP", "STEP files are out")):
        line = refused(lambda: piston(tmp_path, {"dxf": name}))  # noqa: B023
        assert line.startswith(f"p.toml: profile.dxf = {name!r}: {words}")
    assert "export the half profile as DXF" in refused(lambda: load(tmp_path / "piston.step"))
