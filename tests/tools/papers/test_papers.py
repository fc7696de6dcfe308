"""Figures and tables of the papers, and the studies that they are made of."""

import csv
import json
import tomllib
from collections.abc import Mapping
from functools import cache
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.base.text import csv_text
from camtools.cli import analyse
from camtools.cli.papers import MODULES, main
from camtools.lobe.part import LobePart
from camtools.papers import corner, helix, refit
from camtools.papers.declared import Paper, compared, filled, page
from camtools.papers.drawings import draw_points
from camtools.papers.figures import PICTURES, refit_drawers
from camtools.papers.lobe import LobeWishes
from camtools.pipeline.load import load
from tests.tools.cases.cut_cases import PARTS, geometry_of_part
from tests.tools.cases.lobe_tables import POLY345, POLY345_WHEEL
from tests.tools.cases.part_cases import ROOT, sure

PAGE = ROOT / "tools" / "docs" / "PAPERS.md"
TABLE_2_DEG = (10, 20, 30, 40, 48)

# The list of figures and tables to be reproduced, by paper.
LISTED = {
    "S0, S1": (
        *("Fig 1, Tables 2, 3", "Fig 5", "Table 1", "Fig 6", "Fig 7", "Fig 8", "Fig 9 (S1 Fig 4)"),
        *("Table 4 (S1 Table 3)", "Fig 10 (S1 Fig 5a)", "Fig 11", "Fig 12 (S1 Fig 5b)"),
        *("Fig 13 (S1 Fig 5c)", "Table 5 (S1 Table 4)", "Fig 14 (S1 Fig 8)", "Fig 15 (S1 Fig 9)"),
        "S1 Fig 6",
    ),
    "S2": (
        *("Fig 1", "Fig 2", "Fig 3", "Table 1", "Fig 4", "Fig 6", "Fig 7"),
        *("Table 2, drawing", "Table 2, before", "Table 2, measured", "Fig 8"),
    ),
    "S3": tuple(f"Fig {n}" for n in range(1, 11)),
    "S4": ("Fig 1", "Fig 2", "Fig 3"),
}


@cache
def files() -> dict[str, set[str]]:
    """Return the files of each paper; working out the names of its pictures takes a second."""
    return {one.KEY: {*one.TABLES, *PICTURES[one.KEY]()} for one in MODULES}


@cache
def all_papers() -> list[Paper]:
    """Return all papers, worked out once."""
    return [filled(one.KEY, one.quantities()) for one in MODULES]


def rows_of(text: str) -> list[dict[str, Any]]:
    """Return the rows of a CSV text."""
    return list(csv.DictReader(StringIO(text)))


@pytest.mark.long
def test_page_is_what_the_command_writes() -> None:
    """PAPERS.md is recomputed, every digit and every word; each listed item has its row."""
    text, made = PAGE.read_text(), page(all_papers())
    missing = text.split("## What is not compared")[1].split("\n## ")[0]
    assert "| axis with two linear motors | its data are not known" in missing
    assert "| flow charts | they show steps, no numbers" in missing
    begin = text.index("## S0, S1:")
    assert text[begin : begin + len(made)] == made
    for paper in all_papers():
        items = [row.item for row in paper.rows if row.item != "text"]
        assert sorted(items) == sorted(LISTED[paper.key])
        for row in paper.rows:
            assert "" not in row and set(row.files.split()) <= files()[paper.key], row.item


def test_value_beyond_its_tolerance_ends_the_page() -> None:
    """A printed value, or one of a list, that ours misses is an error that names it."""
    for ours in (1.97, np.nan):
        with pytest.raises(CamtoolsError, match=r"e_mm: .* differs from the printed 1\.96 by more"):
            compared({"e_mm": [1.96, 0.005]}, {"e_mm": ours})
    with pytest.raises(CamtoolsError, match="drawn_um"):
        compared({"drawn_um": [[-5, -20], 0.5]}, {"drawn_um": [-5.28, -20.6]})
    assert np.isnan(compared({"e_mm": [0, 0.1]}, {"e_mm": 0.05})["off"]["e_mm"])


@pytest.mark.long
def test_records_of_the_refit() -> None:
    """Each record, cut on the simulator, is its spline; a tool that swings turns the order."""
    # Of the cubic's, the peaks at the joint are narrower than the bins that hold no point.
    bounds = ((0.44, 0.3), (1.38, 0.1), (2.96, 0.1))
    for record, (largest, near) in zip(corner.records(), bounds, strict=True):
        assert record.control_um < 0.1
        assert np.abs(record.off_um).max() == pytest.approx(largest, abs=0.15)  # bins of the map
        assert record.off_um == pytest.approx(record.spline_um, abs=near)
    found = corner.quantities()
    rigid, soft, stiff = found["rigid_um"], found["soft_um"], found["stiff_um"]
    assert sorted(rigid) == rigid
    assert sorted(soft, reverse=True) == soft and sorted(stiff, reverse=True) == stiff
    assert stiff < soft
    drawn = [-175 * np.sin(np.radians(deg)) ** 2 for deg in TABLE_2_DEG]
    assert 0.5 < np.abs(np.subtract(found["before_um"], drawn)).max() < 2.5
    part = tomllib.loads((PARTS / "weichai3a_measured.toml").read_text())["process"]
    row = next(row for row in all_papers()[1].rows if row.shows == "conditions of the test")
    words = f"{part['spindle_rpm']} r/min, feed {part['feed_mm']} mm, depth {part['depth_mm']} mm, "
    assert row.ours.startswith(words)


@pytest.mark.long
def test_measured_table_and_jerk() -> None:
    """Ovality 0.35, trim 0.1 mm and (3, 3) give Table 2; the jerk is the acceleration's slope."""
    ours = corner.radius_um(refit.curve_of(corner.measured(), refit.DELETED))
    assert [f"{um:.2f}" for um in ours] == ["-5.28", "-20.47", "-43.75", "-72.31", "-99.61"]
    drawn = [-175 * np.sin(np.radians(deg)) ** 2 for deg in TABLE_2_DEG]
    assert corner.drawn_um() == pytest.approx(drawn, abs=1e-6)
    joint = corner.theory().joint
    phi, step = np.radians(np.linspace(40.05, 55.95, 3001)), 1e-7  # off the knots of the cubic
    for recipe in (refit.QUINTIC, refit.DELETED):
        curve = refit.curve_of(joint, recipe)
        slope = (curve(phi + step, 2) - curve(phi - step, 2)) / (2 * step)
        assert np.abs(slope - curve(phi, 3)).max() < 2e-3 * np.abs(curve(phi, 3)).max()
    cubic = refit.curve_of(joint, refit.CUBIC)
    jerks = np.unique(np.round(cubic(np.radians(np.arange(40.5, 56)), 3), 6))
    assert jerks.size >= 10  # constant between two points, another in each degree


@pytest.mark.long
def test_points_of_the_helix_are_those_of_the_sections() -> None:
    """Rings stand at the sections, turns join them, the radius is that of the drawn section."""
    matrix = helix.point_matrix(0.2, 4)
    assert matrix.shape == (7 * 72 + 1, 8)
    turns = matrix[:, 2] / 360
    golden_turns = [0, 1, 1.25, 1.5, 1.75, 2, 2.5, 3, 3.5, 4]
    golden_mm = [0, 0, 0.05, 0.1, 0.15, 0.2, 0.2, 0.2, 0.3, 0.4]
    for turn, z_mm in zip(golden_turns, golden_mm, strict=True):
        assert matrix[int(np.argmin(np.abs(turns - turn))), 3] == pytest.approx(z_mm, abs=1e-12)
    assert np.hypot(matrix[:, 5], matrix[:, 6]) == pytest.approx(matrix[:, 4], abs=1e-12)
    is_ring = matrix[:, 1] == 0
    assert set(matrix[is_ring, 0]) == {0, 2, 4, 6}
    short = np.abs(np.mod(matrix[:, 2], 360) - 90) < 1e-9
    low = short & is_ring & (matrix[:, 3] == 0)
    assert matrix[low, 7] == pytest.approx(0.40, abs=1e-6)  # G / 2 + trim at the lowest section
    assert helix.blend_nm() < 0.2**2 / 8 * 1.5e-4 * 1e6
    for z_mm, short_mm, joint_mm in ((20.0, 0.40, 0.31965970), (190.0, 0.53, 0.43584380)):
        diameters = helix.diameters_mm(z_mm)
        assert diameters[[70, 90]] / 2 == pytest.approx([joint_mm, short_mm], abs=1e-8)
    # Pictures: 4 rings, or all 22 at 10 mm on 210 mm, and the turns between them, of 72 points.
    for item, n_rings, is_part in (("Fig 7", 4, True), ("Fig 8", None, False)):
        shown = helix.point_matrix(10.0, n_rings)
        title = draw_points(shown, is_part=is_part).axes[0].get_title()
        assert title.startswith(f"{item}: ")
        assert title.endswith(f", {(2 * (n_rings or 22) - 1) * 72 + 1} points")
    found = helix.quantities()
    assert (found["n_rings"], found["n_helices"]) == (22 * 72 + 1, 21 * 72)


@pytest.mark.long
@pytest.mark.usefixtures("undrawn")
def test_command_makes_every_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Tables and pictures of all rows, and the page."""
    assert main(["-o", str(tmp_path / "a")]) == 0
    assert "46 figures and tables" in capsys.readouterr().out
    made = {path.name: path.read_bytes() for path in (tmp_path / "a").iterdir()}
    assert set(made) == {"papers.md"}.union(*files().values())
    assert all(data[1:4] == b"PNG" for name, data in made.items() if name.endswith(".png"))
    assert made["papers.md"].decode() == page(all_papers())


def test_wrong_words_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    """A folder is needed, and nothing else is taken."""
    for words in ([], ["perkins240.toml"], ["-o", "x", "--only", "S2"]):
        with pytest.raises(SystemExit) as stop:
            main(words)
        assert stop.value.code == 2
        assert len(capsys.readouterr().err.splitlines()) == 1


def lobe_rows(name: str, **wishes: float) -> dict[float, dict[str, float]]:
    """Return the rows of the first lobe of a part by the direction of the follower."""
    files = lobe_files(name, **wishes)[1]
    found = [{k: float(v) for k, v in row.items()} for row in rows_of(files["lobe_0.csv"].decode())]
    return {row["theta_deg"]: row for row in found}


def lobe_files(name: str, **wishes: float) -> tuple[str, dict[str, bytes]]:
    """Return text and files of the analysis of a cam of the repository."""
    part = load(PARTS / f"{name}.toml").part
    assert isinstance(part, LobePart)
    chosen = LobeWishes(**{"step_deg": 5.0, **wishes})
    return analyse.lobe_products(part, chosen, with_pictures=False)


def test_lobe_is_the_worked_table() -> None:
    """X = H and swing of the turned lobe; S, phi, ds/dphi and N_C of the ground lobe."""
    for name, lines, keys in (
        ("cam-345", POLY345, "x_mm swing_deg contact_radius_mm contact_angle_deg"),
        ("cam-345-ground", POLY345_WHEEL, "s_mm phi_deg ds_dphi_mm_rad n_c_rpm"),
    ):
        rows = lobe_rows(name)
        for line in lines:
            theta, *golden = map(float, line.split())
            for key, value in zip(keys.split(), golden, strict=False):
                bound = 6e-8 if key in ("x_mm", "contact_radius_mm", "s_mm") else 1e-6
                assert rows[theta][key] == pytest.approx(value, abs=bound), (theta, key)


def test_speeds_are_derivatives_over_time() -> None:
    """Speed and acceleration of X and of the swing are differences of x(t) and swing(t)."""
    found = list(lobe_rows("cam-345", step_deg=0.1, rpm=30.0).values())
    t = np.array([row["t_s"] for row in found])
    assert t[-1] == pytest.approx(2.0)
    for keys in (
        ("x_mm", "x_speed_mm_s", "x_acceleration_mm_s2"),
        ("swing_deg", "swing_speed_deg_s", "swing_acceleration_deg_s2"),
    ):
        value, speed, bend = (np.array([row[key] for row in found]) for key in keys)
        flank = slice(1200, 1780)  # below the nose, where no higher derivative of the law jumps
        assert np.abs(np.gradient(value, t) - speed)[flank].max() < 2e-3 * np.abs(speed).max()
        assert np.abs(np.gradient(speed, t) - bend)[flank].max() < 2e-2 * np.abs(bend).max()


@pytest.mark.usefixtures("undrawn")
def test_extremes_of_lobes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The extremes of the worked example; the command writes words, tables and pictures."""
    text, files = lobe_files("cam-345-ground")
    [lobe] = json.loads(files["analysis.json"])["lobes"]
    assert lobe["n_c_rpm"] == pytest.approx([6.7664, 104.2400], abs=1e-3)
    assert lobe["least_convex_radius_mm"] == pytest.approx(10.679909, abs=1e-5)
    assert lobe["largest_pressure_angle_deg"] == pytest.approx(19.967381, abs=1e-5)
    assert "the cam turns at 6.77 .. 104.24 r/min, before any limit of the spindle" in text
    assert analyse.main([str(PARTS / "camshaft.toml"), "-o", str(tmp_path)]) == 0
    names = ["analysis.json", *(f"lobe_{i}.csv" for i in range(3))]
    names += ["lobe_contact.png", "lobe_motion.png"]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(names)
    assert "lobe 2, height 10 .. 13 mm: lift 6 mm" in capsys.readouterr().out


def study_of(part: str, height_mm: float, spindle_rpm: float) -> refit.Study:
    """Return the refits of a part of the repository."""
    found = sure(geometry_of_part(part).corner)
    return refit.study(found.joint(height_mm), height_mm, spindle_rpm)


def refit_rows(found: refit.Study) -> Mapping[str, list[dict[str, Any]]]:
    """Return the rows of the tables of a study."""
    return {name: rows_of(csv_text(columns)) for name, columns in refit.tables(found).items()}


def test_refit_beside_the_paper() -> None:
    """Cubic agrees with the paper's plot, quintic does not; Table 1 within the stated factors."""
    found = study_of("weichai3a", 40.0, 800.0)
    rows = refit_rows(found)
    cubic, quintic, deleted, mirrored = rows["refit_comparison"]
    assert (cubic["peak_acceleration_mm_s2"], cubic["ratio_to_paper"]) == ("748205.3", "0.935")
    assert float(quintic["ratio_to_paper"]) == pytest.approx(1.255, abs=0.001)
    assert deleted["deviation_um"] == "11.01"
    assert mirrored["paper_peak_acceleration_mm_s2"] == ""
    assert float(mirrored["peak_acceleration_mm_s2"]) == pytest.approx(65789, abs=1)
    ratios = np.array([float(row["ratio_to_paper"]) for row in rows["refit_candidates"]])
    assert (ratios.min(), ratios.max()) == (0.68, 2.34)
    assert int((np.maximum(ratios, 1 / ratios) <= 1.565).sum()) == 12
    text = refit.notes(found)
    for words in ("0.68 .. 2.34", "0.980", "0.838", "[(1, 1), (2, 2), (3, 3)]", "11.01 um"):
        assert words in text


def test_other_sections_are_not_compared_with_the_paper() -> None:
    """Another part, and the paper's part at another speed, show no numbers of the paper."""
    for found in (study_of("16v240zj", 100.0, 500.0), study_of("weichai3a", 40.0, 650.0)):
        assert not found.is_papers
        assert "paper's" not in refit.notes(found).replace("the paper's construction", "")
        assert all(row["paper_jerk_mm_s3"] == "" for row in refit_rows(found)["refit_candidates"])


@pytest.mark.long
def test_pictures_show_their_columns() -> None:
    """A declared picture has a panel for each line of its declaration, with its units."""
    found = study_of("weichai3a", 40.0, 800.0)
    axes = [draw().axes for draw in refit_drawers(found).values()]
    assert [len(one) for one in axes] == [4, 3]
    assert axes[0][2].get_ylabel() == "u acceleration,\nmm/s²"
    assert [len(one.lines) for one in axes[0]] == 4 * [4]
    assert [len(one.containers) for one in axes[1]] == 3 * [2]
