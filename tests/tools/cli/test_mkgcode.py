"""The command line tools/mkgcode: programs read back, files whole or absent, refusals."""

import re
import subprocess
import tracemalloc
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from camtools.ngc.gcode_words import CLEARANCE_MM, ENGAGE_TURNS
from camtools.skirt.geometry.skirt_geometry import Geometry, make_geometry, section_cut
from camtools.skirt.tool.turning import path_of
from tests.tools.cases.background import python
from tests.tools.cases.command_cases import command
from tests.tools.cases.linuxcnc import AXES, Interpreter
from tests.tools.cases.ngc_cases import changed, moves
from tests.tools.cases.part_cases import PERKINS, environment, load_part, sure

MKGCODE = "camtools.cli.mkgcode"
EVEN = PERKINS.with_name("perkins240_equal_volume.toml")
mkgcode = partial(command, MKGCODE)


def made(folder: Path, part: Path, *words: str) -> Path:
    """Return a program of a part."""
    path = folder / "part.ngc"
    done = mkgcode(part, "-o", path, *words)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    return path


@pytest.mark.parametrize("chord_um", [0.01, 0.1, 5.0])
def test_segments_keep_the_chord_error(tmp_path: Path, geometry: Geometry, chord_um: float) -> None:
    """Points lie on the profile, the polygon within the stated error, with no point too many."""
    program = made(tmp_path, PERKINS, "--chord-um", str(chord_um))
    x, z, lead = moves(program, "G33", "XZK").T
    z, x = np.append(0.0, z), np.append(float(geometry.radius_mm(0.0)), x)
    assert z[-1] == 62
    assert np.abs(x - geometry.radius_mm(z)).max() <= 0.51e-6
    dense = np.linspace(0, 62, 100_001)
    off_um = np.abs(np.interp(dense, z, x) - geometry.radius_mm(dense)).max() * 1000
    assert off_um <= chord_um
    stated = sure(re.search(r"; (\d+) segments, chord error ([0-9.]+) um", program.read_text()))
    assert int(stated[1]) == z.size - 1
    assert float(stated[2]) == pytest.approx(off_um, abs=2e-4)
    longest = np.sqrt(8 * chord_um / 1000 / np.abs(geometry.radius_mm(dense, 2)).min())
    assert z.size - 1 >= 62 / longest
    # Z is fed by the feed: K is measured along the segment.
    along = np.hypot(np.diff(x), np.diff(z))
    np.testing.assert_allclose(lead * np.diff(z) / along, 0.1, rtol=1e-8)


def test_profile_program_engages_and_retracts(tmp_path: Path) -> None:
    """Tool off the blank before and after; camturn is asked to start and stop, and waited for."""
    lines = made(tmp_path, PERKINS).read_text().splitlines()
    program = [line for line in lines if not line.startswith(";")]
    clear = f"G0 X{46.1 + CLEARANCE_MM:.6f}"
    assert program[2].startswith("M65 P0")
    assert program[3:7] == ["S2500 M3", clear, "G0 Z0.000000", "G95 G1 X45.970000 F0.100000"]
    first = next(i for i, line in enumerate(program) if line.startswith("G33"))
    assert program[7].startswith("M64 P0")
    assert program[8].startswith("M66 P0 L3")
    assert [line.strip()[:5] for line in program[9:first][1:3]] == ["(MSG,", clear[:5]]
    assert program[-5] == clear
    assert [line[:6] for line in program[-4:-2]] == ["M65 P0", "M66 P0"]
    assert program[-1] == "M2"


def test_opposite_rotation_and_diameters(tmp_path: Path) -> None:
    """Direction -1 turns by M4 and falling C; G7 doubles X and nothing else."""
    part = changed(tmp_path, PERKINS, direction="-1")
    assert "S2500 M4\n" in made(tmp_path, part).read_text()
    radius = moves(made(tmp_path, part, "--axes", "cxzu", "--to-mm", "1"), "G1", "CXZU")
    program = made(tmp_path, part, "--axes", "cxzu", "--to-mm", "1", "--diameter")
    diameter = moves(program, "G1", "CXZU")
    assert " G7\n" in program.read_text()
    assert np.diff(radius[:, 0]).max() < 0
    np.testing.assert_allclose(diameter, radius * [1, 2, 1, 1], atol=1.01e-6)


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("perkins240", {}),
        ("perkins240", {"path": '"ring-helix"', "feed_mm": "0.2"}),
        ("perkins240", {"path": '"stepped"', "feed_mm": "0.2", "spindle_rpm": "500"}),
        ("perkins240_equal_volume", {"spindle_rpm": "200"}),
        ("perkins240_equal_volume", {"spindle_rpm": "200", "path": '"stepped"'}),
        pytest.param("16v240zj", {}, marks=pytest.mark.long),
        ("scan90", {}),
        ("scan90", {"direction": "-1"}),
        ("perkins240_equal_volume", {"spindle_rpm": "200", "direction": "-1"}),
    ],
)
def test_full_program_is_the_geometry(tmp_path: Path, name: str, changes: dict[str, str]) -> None:
    """X - U at each C and Z is the radius of the part; Z is the path; times are equal."""
    source = PERKINS.with_name(f"{name}.toml")
    part_file = changed(tmp_path, source, **changes)
    if name == "scan90":
        (tmp_path / "scan90.csv").write_bytes(source.with_name("scan90.csv").read_bytes())
    part = load_part(part_file)
    geometry = make_geometry(part)
    first, last = geometry.z_first_mm + 3, geometry.z_first_mm + 7
    words = ("--axes", "cxzu", "--from-mm", f"{first}", "--to-mm", f"{last}")
    program = made(tmp_path, part_file, *words)
    c, x, z, u, f = moves(program, "G1", "CXZUF").T
    modulated = part.process.mode == "equal-volume"
    path = path_of(part, first, last, 2.0 if modulated else 1.0)
    if path.kind == "stepped":  # the step's share of a turn depends on the fastest spindle: as told
        told = sure(re.search(r"steps of ([0-9.]+) turns", program.read_text()))
        assert path.step * (0.6 if modulated else 1) - 1e-8 <= float(told[1]) <= path.step + 1e-8
        per_s = part.process.spindle_rpm * 4 * part.process.parts / 60
        v_mm_s = np.sqrt(part.process.feed_mm * part.machine.limits.z_acceleration_mm_s2)
        assert np.abs(np.diff(z)).max() * per_s <= v_mm_s * (1 + 1e-3)
        path = replace(path, step=float(told[1]))
    turns = part.process.direction * c / 360
    n = 4 * part.process.parts
    assert turns.size % n == 0
    np.testing.assert_allclose(z, path.height_mm(turns), atol=1e-6)
    np.testing.assert_allclose(f, part.process.spindle_rpm * n, rtol=1e-9)
    cut = (turns >= 0) & (turns <= path.turns)
    rho = geometry.radius_mm(z[cut]) - geometry.delta(np.radians(c[cut]), z[cut]).delta
    assert np.abs(x[cut] - u[cut] - rho).max() < 3e-6
    clear = x.max()
    assert (x[-1], u[-1]) == (clear, 0)
    assert (x[cut] < clear - CLEARANCE_MM).all()
    outside = geometry.radius_mm(z) - geometry.delta(np.radians(c), z).delta
    assert (x - u >= outside - 3e-6).all()  # never a gouge


def test_equal_volume_blocks_cut_equal_areas(tmp_path: Path) -> None:
    """At every height the 120 blocks of a turn cut the same area of its section, to 1e-6."""
    part_file = changed(tmp_path, EVEN, spindle_rpm="200")
    part = load_part(part_file)
    geometry = make_geometry(part)
    words = ("--axes", "cxzu", "--from-mm", "18", "--to-mm", "24")
    c = moves(made(tmp_path, part_file, *words), "G1", "C")[:, 0] / 360
    for turn in (0, 13, 21, 37, 59):
        cut = section_cut(geometry, 0.1, 18 + 0.1 * (turn + 0.5))
        row = (turn + ENGAGE_TURNS) * 120 + np.arange(30)
        angles = np.append(0.0, 2 * np.pi * (c[row] - turn))
        areas = np.diff(cut.area_mm2(np.minimum(angles, np.pi / 2)))
        np.testing.assert_allclose(areas, cut.total_mm2 / 30, rtol=1e-5)


@pytest.mark.long
def test_profile_program_by_linuxcnc(tmp_path: Path, linuxcnc: Interpreter) -> None:
    """LinuxCNC's interpreter accepts the X/Z program and goes where our reading goes."""
    program = made(tmp_path, PERKINS)
    done = linuxcnc.rs274(program)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("START_SPEED_FEED_SYNC(") == 27
    message, points = linuxcnc.points(program)
    assert message == ""
    feeds = points[points[:, 0] == 1][1:]  # behind the infeed
    np.testing.assert_allclose(feeds[:, [1, 3]], moves(program, "G33", "XZ"), atol=1e-9)


@pytest.mark.parametrize("diameter", [(), ("--diameter",)])
def test_full_program_by_linuxcnc(
    tmp_path: Path, linuxcnc: Interpreter, geometry: Geometry, diameter: tuple[str, ...]
) -> None:
    """The points that LinuxCNC's interpreter understands lie on the part, to 3 nm."""
    words = ("--axes", "cxzu", "--from-mm", "30", "--to-mm", "33", *diameter)
    message, points = linuxcnc.points(made(tmp_path, PERKINS, *words))
    assert message == ""
    is_feed = points[:, 0] == 1
    at = dict(zip(AXES, points[is_feed][:, 1:].T, strict=True))
    cut = (at["C"] >= 0) & (at["C"] <= 30 * 360)
    assert cut.sum() == 30 * 120 + 1
    z, u = at["Z"][cut], at["U"][cut]
    delta = geometry.delta(np.radians(at["C"][cut]), z).delta
    assert np.abs(at["X"][cut] - u - geometry.radius_mm(z) + delta).max() < 3e-6


@pytest.mark.long
def test_two_runs_give_the_same_bytes(tmp_path: Path) -> None:
    """A program is the same from process to process, whatever the order of sets."""
    words = ("--axes", "cxzu", "--to-mm", "1")
    first = made(tmp_path, PERKINS, *words).read_bytes()
    again = tmp_path / "again.ngc"
    subprocess.run(python(MKGCODE, PERKINS, *words, "-o", again), env=environment(), check=True)
    assert again.read_bytes() == first


def test_memory_does_not_grow_with_the_program(tmp_path: Path) -> None:
    """Eight times the blocks take at most 100 kB more."""
    peaks_bytes = []
    for to_mm in ("1", "8"):
        tracemalloc.start()
        words = ("--axes", "cxzu", "--to-mm", to_mm)
        assert mkgcode(PERKINS, "-o", tmp_path / "p.ngc", *words).returncode == 0
        peaks_bytes.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks_bytes[1] - peaks_bytes[0] < 100_000


@pytest.mark.parametrize(
    ("name", "changes", "axes", "told"),
    [
        ("perkins240", {"path": '"ring-helix"'}, "xz", r"process\.path: .*G33; give --axes cxzu"),
        (
            "perkins240",
            {"path": '"ring-helix"', "feed_mm": "1"},
            "cxzu",
            r"needs at least 6944\.4\d+ mm/s2 of Z, .* turn at 1341\.6 r/min at most",
        ),
        (
            "perkins240_equal_volume",
            {},
            "cxzu",
            r"spindle_acceleration_rad_s2 = 500 rad/s2: the part needs .* at most 202\.5 r/min",
        ),
        (
            "perkins240",
            {"u_acceleration_mm_s2": "1000"},
            "cxzu",
            r"u_acceleration_mm_s2 = 1000 mm/s2: the part needs 20\d+\.\d+ .* at most 549\.9 r/min",
        ),
        *(
            (
                "perkins240",
                {"height_mm": "[0, 1, 2, 3, 4, 6, 8]", "feed_mm": "8.000001"},
                axes,
                r"process\.feed_mm = 8\.000001: must be at most 8, the height of the part; give mm",
            )
            for axes in ("xz", "cxzu")
        ),
        ("weichai3a_plain", {}, "cxzu", r"piston\.section\.refit: is missing"),
    ],
)
def test_impossible_parts_are_refused(
    tmp_path: Path, name: str, changes: dict[str, str], axes: str, told: str
) -> None:
    """The line tells the field, the numbers and the highest speed that would do."""
    part = changed(tmp_path, PERKINS.with_name(f"{name.removesuffix('_plain')}.toml"), **changes)
    if name.endswith("_plain"):
        text = part.read_text()
        part.write_text(re.sub(r"\[piston\.section\.refit\][^\[]*", "", text))
    done = mkgcode(part, "-o", tmp_path / "p.ngc", "--axes", axes)
    assert done.returncode == 2
    assert re.fullmatch(rf"mkgcode: .*part\.toml: .*{told}.*\n", done.stderr)
    assert not (tmp_path / "p.ngc").exists()
