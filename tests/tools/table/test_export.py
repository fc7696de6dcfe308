"""Tables as text for other controllers, and sections that come back from such text."""

from pathlib import Path

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError, InputError
from camtools.cli.mktables import main as mktables
from camtools.pipeline.load import load
from camtools.skirt.table.generate import generate
from camtools.table.channel import KIND_U
from camtools.table.evaluate import evaluate_at
from camtools.table.export import Export, export_files
from camtools.table.image import Table, pack
from camtools.table.points import parse_points, quintics_of
from tests.tools.cases.cut_cases import PARTS, evaluated, made_of, skirt_of
from tests.tools.cases.part_cases import PERKINS, refused

NM_PER_MM, XYVA = 1e6, Export("xyva")
IMPORTED = '[piston.section]\nshape = "points"\n'


def imported(part: Path, folder: Path, section: str) -> Path:
    """Write the part file of a skirt whose section comes from an export."""
    head, _, rest = part.read_text().partition("[piston.ovality]")
    path = folder / "again.toml"
    path.write_text(f"{head}{IMPORTED}{section}{rest[rest.index('[process]') :]}")
    return path


def export(table: Table, folder: Path, what: Export = XYVA) -> list[str]:
    """Write the files of an export; return their names."""
    files = export_files(table, what)
    for name, data in files.items():
        (folder / name).write_bytes(data)
    return sorted(files)


@pytest.mark.parametrize("name", ["perkins240", "double_ellipse"])
def test_export_and_import_give_the_same_table(name: str, tmp_path: Path) -> None:
    """An oval and one cut with M4: to the byte, so to the nanometre."""
    made = skirt_of(name)
    export(made.table, tmp_path)
    path = imported(PARTS / f"{name}.toml", tmp_path, f'csv = "{name}_u_xyva.csv"\n')
    again = generate(load(path).part)
    assert again.table.channels[0].knots.tobytes() == made.table.channels[0].knots.tobytes()
    assert abs(len(pack(again.table)) - len(pack(made.table))) <= 256


def test_a_file_for_each_height(tmp_path: Path) -> None:
    """Three heights of their own: the part is straight between them, the firmware plays that."""
    made = skirt_of("perkins240")
    heights = (0.0, 20.0, 62.0)
    names = export(made.table, tmp_path, Export("xyva", heights))
    assert [name for name in names if "_z" in name] == [
        f"perkins240_u_z{z}_xyva.txt" for z in ("0", "20", "62")
    ]
    section = "".join(
        f'[[piston.section.files]]\nz_mm = {z}\ncsv = "perkins240_u_z{z:g}_xyva.txt"\n'
        for z in heights
    )
    again = generate(load(imported(PERKINS, tmp_path, section)).part)
    turn, z_mm = (one.ravel() for one in np.meshgrid([0.1, 0.3, 0.77], [0, 10, 20, 41, 62.0]))
    u = evaluated(tmp_path, again.table, turn, z_mm)["u_nm"].reshape(5, 3).T
    exact = made.geometry.delta(2 * np.pi * np.repeat([0.1, 0.3, 0.77], 3), np.tile(heights, 3))
    assert np.abs(u[:, [0, 2, 4]].ravel() - NM_PER_MM * exact.delta).max() < 2.0
    assert np.abs(u[:, 1] - (u[:, 0] + u[:, 2]) / 2).max() < 2.0


CAM = """\
[part]
name = "again"
kind = "cam"
source = "an export"
[cam]
base_radius_mm = {base}
roller_radius_mm = {roller}
{wheel}
[[cam.lobe]]
z_mm = [0, 12]
law = "list"
csv = "{csv}"
[process]
"""


@pytest.mark.parametrize(
    ("name", "base", "roller", "wheel"),
    [
        ("cam-345", 20, 10, ""),
        # the path of the wheel's centre is the lift of a roller as large as the wheel
        ("cam-disc", 20, 200, "wheel_radius_mm = 200"),
    ],
)
def test_a_cam_comes_back(
    name: str, base: float, roller: float, wheel: str, tmp_path: Path
) -> None:
    """An exported lobe as law "list" cuts the same part: every value within 1 nm."""
    path, made = PARTS / f"{name}.toml", made_of(name).table
    export(made.table, tmp_path)
    csv = f"{name}_lift_profile1_xyva.txt"
    text = CAM.format(base=base, roller=roller, wheel=wheel, csv=csv)
    rest = path.read_text().partition("[process]")[2]
    (tmp_path / "again.toml").write_text(text + rest)
    loaded = load(tmp_path / "again.toml")
    again = loaded.kind.make(loaded.part)
    turn = np.linspace(0, 1, 3001)
    z_nm = np.full(turn.size, 5e6)
    first, second = (
        evaluate_at(one.table.channel(KIND_U), turn, z_nm).value for one in (made, again)
    )
    assert np.abs(first - second).max() <= 1.0


def test_a_polygon_comes_back_as_a_skirt(tmp_path: Path) -> None:
    """Points know no kind: P4C 35, exported, is a skirt of diameter 35 with the same knots."""
    made = made_of("p4c-35").table
    export(made.table, tmp_path)
    rest = (PARTS / "p4c-35.toml").read_text().partition("[process]")[2]
    (tmp_path / "again.toml").write_text(
        '[part]\nname = "again"\nkind = "piston"\nsource = "an export"\n'
        "[piston.profile]\nheight_mm = [0, 40]\ndiameter_mm = [35, 35]\n"
        f'{IMPORTED}csv = "p4c-35_u_xyva.csv"\n[process]{rest}'
    )
    again = generate(load(tmp_path / "again.toml").part)
    assert again.table.channels[0].knots.tobytes() == made.table.channels[0].knots.tobytes()


def test_profiles_of_a_shaft(tmp_path: Path) -> None:
    """One file for each profile; at a height of a lobe its phase is in the angles."""
    table = made_of("camshaft").table.table
    names = sorted(export_files(table, Export("xyva")))
    assert [name for name in names if "_lift_" in name] == [
        f"camshaft_lift_profile{i}_xyva.txt" for i in range(1, 1 + len(names) // 2)
    ]
    for lobe in table.lobes:
        z = (lobe.z_first_nm + lobe.z_last_nm) / 2e6
        text = export_files(table, Export("text", (z,)))[f"camshaft_lift_z{z:g}_text.txt"].decode()
        x, lift = np.array([line.split() for line in text.splitlines()], dtype=float).T
        got = evaluated(tmp_path, table, x / 360, np.full(x.size, z))["u_nm"]
        assert np.abs(NM_PER_MM * lift - got).max() < 0.5
    between = (table.lobes[0].z_last_nm + table.lobes[1].z_first_nm) / 2e6
    with pytest.raises(CamtoolsError, match="lies between two lobes"):
        export_files(table, Export("text", (between,)))


def test_exported_points_are_what_the_firmware_plays(tmp_path: Path) -> None:
    """Value, velocity and acceleration of a file against camsim eval, off the slices, with M4."""
    made = skirt_of("double_ellipse")
    files = export_files(made.table, Export("xyva", (13.7,), 90))
    text = files["double_ellipse_u_z13.7_xyva.txt"].decode()
    assert text.splitlines()[0] == "X_deg;Y_mm;V_mm_per_deg;A_mm_per_deg2"
    x, y, v, a = np.array([line.split(";") for line in text.split()[1:]], dtype=float).T
    assert x.tolist() == [4.0 * i for i in range(91)]
    got = evaluated(tmp_path, made.table, x / 360, np.full(x.size, 13.7))
    per_rad = 180 / np.pi * NM_PER_MM
    assert np.abs(NM_PER_MM * y - got["u_nm"]).max() < 0.02
    first, second = got["u1_nm_per_rad"], got["u2_nm_per_rad2"]
    assert np.abs(per_rad * v - first).max() < 1e-5 * np.abs(first).max()
    assert np.abs(per_rad * 180 / np.pi * a - second).max() < 1e-4 * np.abs(second).max()


def test_two_columns_come_back(tmp_path: Path) -> None:
    """A point per degree without velocity: a periodic quintic spline is within 1 nm of an oval."""
    made = skirt_of("perkins240")
    files = export_files(made.table, Export("text", (20.0,)))
    text = files["perkins240_u_z20_text.txt"].decode()
    assert len(text.splitlines()) == 361 and text.startswith("0.0 0.0\n")
    (tmp_path / "one.txt").write_text(text)
    again = generate(load(imported(PERKINS, tmp_path, 'csv = "one.txt"\n')).part)
    phi = np.linspace(0, 2 * np.pi, 1000)
    off = again.geometry.delta(phi, 40.0).delta - made.geometry.delta(phi, 20.0).delta
    assert np.abs(off).max() * NM_PER_MM < 1.0


def test_points_of_other_systems() -> None:
    """Units, and no header at all, give the same points."""
    angle = np.arange(0, 361, 30)
    y = 0.2 * np.sin(np.radians(angle)) ** 2
    v = 0.2 * np.sin(np.radians(2 * angle))
    a = 0.4 * np.cos(np.radians(2 * angle))
    columns = np.stack([angle, y, v * np.pi / 180, a * (np.pi / 180) ** 2])
    rows: list[list[float]] = columns.T.tolist()
    plain = "\n".join(" ".join(f"{one!r}" for one in row) for row in rows)
    per_rad = "angle_turn,u_um,v_um_per_rad,a_um_per_rad2\n" + "\n".join(
        f"{row[0] / 360!r},{1e3 * row[1]!r},{1e3 * vel!r},{1e3 * acc!r}"
        for row, vel, acc in zip(rows, v.tolist(), a.tolist(), strict=True)
    )
    quintics = [
        quintics_of(parse_points(text, "a").sections[0])
        for text in (plain, per_rad, plain[: plain.rindex("\n")])
    ]
    for other in quintics[1:]:
        assert np.abs(other - quintics[0]).max() < 1e-10
    middle = quintics[0] @ 0.5 ** np.arange(6)
    exact = 0.2 * np.sin(np.radians(angle[:-1] + 15)) ** 2
    assert np.abs(middle - exact).max() < 1e-5


GOOD = [f"{i * 45};{i % 8 * (8 - i % 8) / 100:.6f}" for i in range(9)]
MOVING = [
    f"{i * 30};{0.1 * np.sin(np.radians(30 * i)) ** 2:.9f};"
    f"{0.1 * np.sin(np.radians(60 * i)) * np.pi / 180:.9f};"
    f"{0.2 * np.cos(np.radians(60 * i)) * (np.pi / 180) ** 2:.9f}"
    for i in range(13)
]
HEAD = "X_deg;Y_mm;V_mm_per_deg;A_mm_per_deg2"


def per_rad(line: str) -> str:
    """Return a line whose velocity is by radian."""
    x, y, v, a = line.split(";")
    return f"{x};{y};{float(v) * 57.3:.9f};{a}"


def accelerated(line: str) -> str:
    """Return a line whose acceleration has the wrong sign."""
    x, y, v, a = line.split(";")
    return f"{x};{y};{v};{-float(a):.9f}"


OF_A_HEIGHT = [f"{x} 5 {0.1 * np.sin(np.radians(x)):.6f}" for x in range(0, 360, 10)]

WRONG = [
    (["X_deg;Y_mm;V_mm_per_deg", *MOVING], "line 1", "no column of A"),
    (["Y_mm", "1", "2"], "line 1", "no column of X"),
    (["5;0;1", "5;30;2", "5;60;3"], "line 1", "has 3 columns and no header"),
    (OF_A_HEIGHT, "line 1", "has 3 columns and no header"),
    ([f"{row} // note" for row in OF_A_HEIGHT], "line 1", "has 3 columns and no header"),
    (["// 36 points", *(f"{x} {x % 70} 9" for x in range(0, 360, 10))], "line 2", "has 3 columns"),
    (["0", "1", "2"], "line 1", "has 1 column and no header"),
    (["X_deg;X_deg", *GOOD], "line 1", "no column of Y"),
    ([*GOOD[:3], GOOD[4], GOOD[3], *GOOD[5:]], "line 5", "angle 135 follows 180 degrees"),
    ([*GOOD[:-1], "360;0.5"], "line 9", "the turn is not closed: Y ends at 0.5, began at 0"),
    (GOOD[:4], "line 4", "4 points span 135 degrees: the turn is not closed"),
    ([*GOOD, "400;1"], "line 10", "the points span 400 degrees"),
    ([HEAD, *map(per_rad, MOVING)], "line ", "V contradicts the values"),
    ([HEAD, *map(accelerated, MOVING)], "line ", "A contradicts the velocities"),
    (
        ["Z_mm;X_deg;Y_mm", *[f"{z};{row}" for z in (5, 3) for row in GOOD]],
        "line 11",
        "3 mm follow",
    ),
    ([], "line 1", "has 0 columns and no header"),
    (["X_deg;Y_mm", "# none"], "line 1", "no points follow"),
]


@pytest.mark.parametrize(("lines", "place", "problem"), WRONG, ids=[one[2] for one in WRONG])
def test_wrong_files(lines: list[str], place: str, problem: str) -> None:
    """One line with the file, its line, what is wrong and what to do."""
    line = refused(lambda: parse_points("\n".join(lines), "points.csv"), InputError)
    assert line.startswith(f"points.csv: {place}") and problem in line and "; " in line


def test_heights_may_be_a_hundredth_apart() -> None:
    """As written, 10.01 less 10.00 is a little less than 0.01."""
    lines = ["Z_mm;X_deg;Y_mm", *[f"{z};{row}" for z in ("10.00", "10.01") for row in GOOD]]
    found = parse_points("\n".join(lines), "points.csv")
    assert found.z_mm is not None and found.z_mm.tolist() == [10.0, 10.01]


def test_wrong_sections(tmp_path: Path) -> None:
    """The part file's key and the file's line are named."""
    (tmp_path / "a.csv").write_text("\n".join([*GOOD[:3], GOOD[2], *GOOD[3:], ""]))
    (tmp_path / "b.csv").write_text("\n".join(["X_deg;Y_mm", *GOOD, ""]))
    (tmp_path / "long.csv").write_text("".join(f"{45 * i} {40 + i % 8}\n" for i in range(9)))
    half = [
        f"{i} {0.1 * np.sin(np.radians(i)):.6f}" for i in (*range(0, 81, 10), *range(250, 361, 10))
    ]
    (tmp_path / "half.csv").write_text("\n".join([*half, ""]))
    cases = {
        'csv = "a.csv"\n': "piston.section.csv: a.csv: line 4: angle 90 follows 90",
        'csv = "none.csv"\n': "piston.section.csv: none.csv: cannot be read",
        'csv = "half.csv"\n': "piston.section.csv: no points from 80 to 250 degrees, where",
        'csv = "long.csv"\n': "piston.section.csv: Y comes to 47 mm",
        "": 'piston.section.csv: shape = "points" needs either csv or',
        'csv = "b.csv"\nharmonics = 5\n': "piston.section.harmonics = 5: harmonics has no meaning",
        '[[piston.section.files]]\nz_mm = 0\ncsv = "b.csv"\n'
        '[[piston.section.files]]\nz_mm = 50\ncsv = "b.csv"\n': "do not cover the profile's",
    }
    for section, message in cases.items():
        path = imported(PERKINS, tmp_path, section)
        assert message in refused(lambda: generate(load(path).part))  # noqa: B023


def test_options_of_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Export writes beside the table; wrong options are refused before anything is written."""
    out = tmp_path / "out"
    words = [str(PERKINS), "-o", str(out)]
    for more, message in (
        (["--export-height", "3"], "--export-height: has no effect without --export"),
        (["--export", "xyva", "--export-height", "63"], "outside of the table, 0 .. 62 mm"),
        (["--export", "text", "--export-points", "3"], "--export-points 3: must be 4 .. 100000"),
        (["--export", "sew"], "--export sew: a file holds one section; give its height, --export-"),
    ):
        assert mktables([*words, *more]) == 2
        assert message in capsys.readouterr().err
        assert not out.exists()
    assert mktables([*words, "--export", "text", "--export-height", "20"]) == 0
    names = sorted(path.name for path in out.iterdir())
    assert {"perkins240_u_z20_text.txt", "perkins240_x_text.csv"} <= set(names)
    assert len(names) == 6
