"""The same part with M3 and M4: every surface against a formula of the drawing, both ways round.

The formulas stand here, in the drawing's angle (PARTFILE.md, "The drawing's angle"); neither
the table nor NAME.json takes part in the judgement, except where the gauge itself is on trial.
"""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from camtools.base.quantities import Floats
from camtools.cli.mkgcode import main as mkgcode
from camtools.cli.mktables import main as mktables
from camtools.table.channel import in_sense
from camtools.table.image import pack, unpack
from tests.tools.cases.camsim_cases import ROOT, cut, form_um, plain
from tests.tools.cases.cut_cases import file_evaluated
from tests.tools.cases.lobe_tables import POLY345
from tests.tools.cases.ngc_cases import moves
from tests.tools.cases.part_cases import points_text

SENSES = (1, -1)
RADIUS_MM, LAST_MM = 45.0, 12.0
MARK_DEG, MARK_WIDTH_DEG, MARK_MM = 30.0, 9.0, 0.02
SKIRT = """\
[part]
name = "mark"
kind = "piston"
source = "Invented: an oval of 0.2 mm with a mark at 30 degrees."

[piston.profile]
height_mm = [0, {last:g}]
diameter_mm = [{diameter:g}, {diameter:g}]

[piston.section]
shape = "table"
csv = "mark.csv"
single_height = true

[process]
spindle_rpm = {rpm:g}
feed_mm = 0.5
depth_mm = 0.1
direction = {direction}
mode = "{mode}"
"""


def reduction_mm(deg: Floats, derivative: int = 0) -> Floats:
    """Return the reduction of the radius by the drawing's angle: an oval and a mark."""
    phi = np.radians(deg)
    off = (np.mod(deg - MARK_DEG + 180, 360) - 180) / MARK_WIDTH_DEG
    bell = MARK_MM * np.exp(-(off**2) / 2)
    per_rad = np.degrees(1.0) / MARK_WIDTH_DEG
    oval = (0.05 * (1 - np.cos(2 * phi)), 0.1 * np.sin(2 * phi), 0.2 * np.cos(2 * phi))
    mark = (bell, -off * bell * per_rad, (off**2 - 1) * bell * per_rad**2)
    return np.asarray(oval[derivative] + mark[derivative])


def made(folder: Path, text: str, name: str) -> Path:
    """Return the table of a part file's text, beside a scan of the marked oval."""
    deg = np.arange(0, 360, 1.5)
    scan = points_text("angle_deg,z_mm,reduction_um", deg, 0, 1e3 * reduction_mm(deg))
    (folder / "mark.csv").write_text(scan)
    (folder / f"{name}.toml").write_text(text)
    assert mktables([str(folder / f"{name}.toml"), "-o", str(folder)]) == 0
    return folder / f"{name}.camtab"


def skirt(folder: Path, direction: int, mode: str = "uniform", rpm: float = 600) -> Path:
    """Return the table of the marked skirt."""
    values = {"last": LAST_MM, "diameter": 2 * RADIUS_MM, "direction": direction}
    return made(folder, SKIRT.format(**values, mode=mode, rpm=rpm), "mark")


@pytest.mark.parametrize("direction", SENSES)
@pytest.mark.parametrize("more", [(), ("--set", "phase_udeg=25000000")])
def test_marked_skirt_is_the_drawing(tmp_path: Path, direction: int, more: tuple[str, ...]) -> None:
    """The mark lies at 30 degrees, not at 330, on a part that was turned by M3 or by M4."""
    found = cut(skirt(tmp_path, direction), "--no-learning", *more)
    turn, _, radius_mm = plain(found.surface)[:3]
    assert turn.size > 10_000
    off_um = 1e3 * (radius_mm - RADIUS_MM + reduction_mm(360 * turn))
    assert np.abs(off_um).max() < 0.3
    mirrored_um = 1e3 * (radius_mm - RADIUS_MM + reduction_mm(-360 * turn))
    assert np.abs(mirrored_um).max() > 15  # the formula tells the two apart


@pytest.mark.parametrize("direction", SENSES)
def test_eval_takes_and_gives_the_drawings_angle(tmp_path: Path, direction: int) -> None:
    """Value and both derivatives by the drawing's angle, whatever the sense of the table."""
    turn = np.random.default_rng(30).uniform(-3, 3, 2000)
    got = file_evaluated(skirt(tmp_path, direction), turn, np.full(turn.size, 7.0))
    most_nm = {"u_nm": 2.0, "u1_nm_per_rad": 40.0, "u2_nm_per_rad2": 3000.0}
    for derivative, (column, most) in enumerate(most_nm.items()):
        exact_nm = 1e6 * reduction_mm(360 * turn, derivative)
        assert np.abs(got[column] - exact_nm).max() < most


def test_gauge_sees_a_mirror_image(tmp_path: Path) -> None:
    """A table that was not mirrored for M4 is out of tolerance against the design."""
    table = skirt(tmp_path, -1)
    cut(table)
    image = unpack(table.read_bytes())
    wrong = replace(image, channels=tuple(in_sense(one, -1) for one in image.channels))
    table.write_bytes(pack(wrong))
    report = json.loads(table.with_suffix(".json").read_text())
    report["table_crc32"] = int.from_bytes(table.read_bytes()[20:24], "little")
    table.with_suffix(".json").write_text(json.dumps(report))
    assert form_um(cut(table, "--design", table.with_suffix(".json"), status=1)) > 15


def test_program_of_equal_areas_cuts_the_drawing_with_m4(tmp_path: Path) -> None:
    """C falls with M4, the point cut at C is the drawing's angle C; equal areas stay equal."""
    part = skirt(tmp_path, -1, "equal-volume", 40).with_suffix(".toml")
    program = tmp_path / "part.ngc"
    assert mkgcode([str(part), "-o", str(program), "--axes", "cxzu", "--to-mm", "2"]) == 0
    c, x, u = moves(program, "G1", "CXU").T
    assert (np.diff(c) < 0).all()
    inside = (c <= 0) & (c >= -4 * 360)
    assert np.abs((x - u - RADIUS_MM + reduction_mm(c))[inside]).max() < 1e-5
    at = c[(c <= -720) & (c >= -1080.00001)]
    deg = np.linspace(at.min(), at.max(), 100_001)
    area = np.cumsum((RADIUS_MM + 0.1) ** 2 - (RADIUS_MM - reduction_mm(deg)) ** 2)
    parts = np.diff(np.interp(np.sort(at), deg, area))
    np.testing.assert_allclose(parts, parts.mean(), rtol=2e-3)


@pytest.mark.parametrize("direction", SENSES)
def test_eval_of_a_lobe_is_that_of_the_notes(tmp_path: Path, direction: int) -> None:
    """Lift, slope and swing of a cam at 40 degrees: the swing keeps its sign with M4."""
    cam = (ROOT / "tools" / "parts" / "cam-345.toml").read_text()
    process = f"[process]\ndirection = {direction}\n"
    text = cam.replace("phase_deg = 0 ", "phase_deg = 40 ").replace("[process]\n", process)
    theta, lift, swing = np.array([line.split()[:3] for line in POLY345], float).T
    table = made(tmp_path, text, "cam-345")
    got = file_evaluated(table, (theta + 40) / 360, np.full(theta.size, 5.0))
    slope_mm = np.tan(np.radians(swing)) * (30 + lift)
    np.testing.assert_allclose(got["u_nm"], 1e6 * lift, atol=20)
    np.testing.assert_allclose(got["u1_nm_per_rad"], 1e6 * slope_mm, atol=1e3)
    np.testing.assert_allclose(got["swing_deg"], swing, atol=3e-4)


@pytest.mark.long
def test_even_volume_is_as_even_with_m4(tmp_path: Path) -> None:
    """The law of the speed is mirrored with the section: the ripple of both senses is the same."""
    found = []
    for direction in SENSES:
        table = skirt(tmp_path, direction, "equal-volume", 120)
        even = cut(table, "--no-learning", "--set", "stopped_mrpm=3000")
        found.append(even.summary["removal"]["rate_ripple"])
    assert found[1]["mean"] == pytest.approx(found[0]["mean"], rel=0.2)
    assert max(one["mean"] for one in found) < 0.02


@pytest.mark.parametrize("direction", SENSES)
def test_files_count_by_the_drawing(tmp_path: Path, direction: int) -> None:
    """Turns of trace and removal rise with M3 and fall with M4; the observer's is the true one."""
    table = skirt(tmp_path, direction)
    ticks = cut(table, "--no-learning", "--turns-limit", 4, tables=["trace"]).trace
    slices = cut(table, "--no-learning", tables=["removal"]).removal
    # two degrees: the trace has the observer's angle, the truth is sampled with the next tick
    found = (ticks["pos_q32"] > 2**32) & (ticks["z_mm"] > 0.5)
    off = ticks["turn"][found] - ticks["true_turn"][found]
    assert np.abs(off - np.round(off)).max() < 2 / 360
    assert np.sign(np.diff(ticks["turn"][found])).mean() == pytest.approx(direction)
    assert (np.sign(np.diff(slices["turn"])) == direction).all()
    even = (slices["z_mm"] > 3) & (slices["z_mm"] < 9)
    force, place = slices["chip_force_n"][even], np.mod(360 * slices["turn"][even], 360)
    near = [np.abs(place - deg) < 6 for deg in (MARK_DEG, 330)]
    at_mark, at_mirror = (force[rows].mean() for rows in near)
    depth_mm = [0.1 + reduction_mm(place[rows]).mean() for rows in near]
    assert at_mark / at_mirror == pytest.approx(depth_mm[0] / depth_mm[1], rel=0.02)
    assert depth_mm[0] / depth_mm[1] > 1.1


def test_surface_between_tracks_is_the_same_with_m4(tmp_path: Path) -> None:
    """A nose leaves the same scallops at the same angles of the drawing, whatever the sense."""
    found = []
    for direction in SENSES:
        words = ("--no-learning", "--nose-mm", 0.8, "--scallop-mm", "4:6")
        scallop = cut(skirt(tmp_path, direction), *words, tables=["scallop"]).scallop
        turn, _, proud_um = plain(scallop)
        rows = proud_um.reshape(240, -1)
        assert turn.reshape(240, -1)[1, 0] == pytest.approx(1 / 240)
        found.append(np.ptp(rows, axis=1))
        # theory: feed^2 / (8 r) = 39 um where the tool passes once per turn
        assert rows.max(axis=1).min() > 30
        assert rows.max() < 50
    np.testing.assert_allclose(found[1], found[0], rtol=0.03)
