# SPDX-License-Identifier: Apache-2.0
"""Figures and tables of the papers: the page cannot go stale, its numbers are the worked ones."""

import csv
import re
import tomllib
from functools import cache
from io import StringIO
from pathlib import Path

import numpy as np
import pytest

from camtools.cli.papers import chapters, main
from camtools.papers import corner, helix, helix_plots
from camtools.papers.rows import Chapter, Row, page
from tests.tools.cases.part_cases import ROOT

PAGE = ROOT / "tools" / "docs" / "PAPERS.md"

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
def all_chapters() -> list[Chapter]:
    """Return all papers, worked out once."""
    return chapters()


def rows(name: str) -> list[dict[str, float]]:
    """Return the rows of a file of the command."""
    made = next(one.files[name] for one in all_chapters() if name in one.files)()
    found = csv.DictReader(StringIO(made.decode()))
    return [{key: float(value) for key, value in row.items()} for row in found]


def row_of(key: str, item: str) -> Row:
    """Return the row of a figure, a table or a text of a paper."""
    chapter = next(one for one in all_chapters() if one.key == key)
    return next(row for row in chapter.rows if item in (row.item, row.shows))


@pytest.mark.long
def test_rows_of_the_refit() -> None:
    """Fig 8 of S2, Table 2 before the refit, and the conditions of the test."""
    row = row_of("S2", "Fig 8")
    rigid, soft, stiff = re.findall(
        r"(\d\.\d\d), (\d\.\d\d), (\d\.\d\d) um", row.ours + row.difference
    )
    assert sorted(rigid) == list(rigid)
    for swung in (soft, stiff):
        assert sorted(swung, reverse=True) == list(swung)
    assert stiff < soft
    found = [row["before_um"] for row in rows("s2_table_2.csv")]
    drawn = [-175 * np.sin(np.radians(deg)) ** 2 for deg in (10, 20, 30, 40, 48)]
    assert 0.5 < np.abs(np.subtract(found, drawn)).max() < 2.5
    assert row_of("S2", "Table 2, before").ours == ", ".join(f"{um:.2f}" for um in found) + " um"
    part = tomllib.loads((ROOT / "tools" / "parts" / "weichai3a_measured.toml").read_text())
    process, row = part["process"], row_of("S2", "conditions of the test")
    words = f"{process['spindle_rpm']} r/min, feed {process['feed_mm']} mm, depth "
    assert row.ours.startswith(f"{words}{process['depth_mm']} mm, ")
    assert "are not known here" in row.difference


@pytest.mark.long
def test_pictures_of_the_path_show_what_their_rows_state() -> None:
    """S3: 4 rings, or all 22 at 10 mm on 210 mm, and the turns between them, of 72 points."""
    for item, n_rings, is_part in (("Fig 7", 4, True), ("Fig 8", None, False)):
        matrix = helix.point_matrix(n_rings, 10.0)
        title = helix_plots.draw_points(matrix, is_part=is_part).axes[0].get_title()
        n_points = (2 * (n_rings or 22) - 1) * 72 + 1
        assert title.startswith(f"{item}: ") and title.endswith(f", {n_points} points")
        assert f"{n_points} points" in row_of("S3", item).ours
    on_rings, on_helices = re.findall(r"(\d+) on", row_of("S3", "Fig 10").ours)
    assert (int(on_rings), int(on_helices)) == (22 * 72 + 1, 21 * 72)


@pytest.mark.long
def test_page_is_what_the_command_writes() -> None:
    """The comparisons in PAPERS.md are recomputed, every digit and every word."""
    text = PAGE.read_text()
    told = page(all_chapters())
    missing = text.split("## What is not compared")[1].split("\n## ")[0]
    assert "| axis with two linear motors | its data are not known" in missing
    assert "| flow charts | they show steps, no numbers" in missing
    begin = text.index("## S0, S1:")
    assert text[begin : begin + len(told)] == told


@pytest.mark.long
def test_every_item_of_the_list_has_its_row() -> None:
    """Each figure and table of the papers stands in the page once, with files that are made."""
    for chapter in all_chapters():
        items = [row.item for row in chapter.rows if row.item != "text"]
        assert sorted(items) == sorted(LISTED[chapter.key])
        for row in chapter.rows:
            for name in re.findall(r"[\w.]+", row.file):
                assert name in chapter.files, row.item
            assert "" not in row


@pytest.mark.long
def test_measured_table_comes_out() -> None:
    """Ovality 0.35, trim 0.1 mm and (3, 3) give the paper's Table 2 within a micrometre."""
    assert [f"{um:.2f}" for um in corner.measured_um()] == [
        *("-5.28", "-20.47", "-43.75", "-72.31", "-99.61")
    ]
    drawn = [-175 * np.sin(np.radians(deg)) ** 2 for deg in (10, 20, 30, 40, 48)]
    assert corner.drawn_um() == pytest.approx(drawn, abs=1e-6)
    off = [row["difference_um"] for row in rows("s2_table_2.csv")]
    assert max(map(abs, off)) <= 0.75


@pytest.mark.long
def test_jerk_is_the_difference_of_the_acceleration() -> None:
    """The drawn jerk of Figs 2, 3 and 6 is the slope of the drawn acceleration."""
    joint = corner.theory().joint
    phi = np.radians(np.linspace(40.05, 55.95, 3001))  # off the knots of the cubic
    step = 1e-7
    for recipe in (corner.QUINTIC, corner.DELETED):
        curve = corner.curve_of(joint, recipe)
        slope = (curve(phi + step, 2) - curve(phi - step, 2)) / (2 * step)
        assert np.abs(slope - curve(phi, 3)).max() < 2e-3 * np.abs(curve(phi, 3)).max()
    cubic = corner.curve_of(joint, corner.CUBIC)
    jerks = np.unique(np.round(cubic(np.radians(np.arange(40.5, 56)), 3), 6))
    assert jerks.size >= 10  # constant between two points, another one in each degree


@pytest.mark.long
def test_points_of_the_helix_are_those_of_the_sections() -> None:
    """Rings stand at the sections, turns join them, the radius is that of the drawn section."""
    matrix = helix.point_matrix(4, 0.2)
    assert matrix.shape == (7 * helix.N_POINTS + 1, 8)
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
    for z_mm, short_mm in ((20.0, 0.40), (190.0, 0.53)):
        assert helix.diameters_mm(z_mm)[1][-1] / 2 == pytest.approx(short_mm, abs=1e-8)
        joint = {20.0: 0.31965970, 190.0: 0.43584380}[z_mm]
        assert helix.diameters_mm(z_mm)[1][70] / 2 == pytest.approx(joint, abs=1e-8)


@pytest.mark.long
def test_records_are_cut_as_calculated() -> None:
    """Each of the three records, cut on the simulator, is its spline within 0.1 um everywhere."""
    for record, largest in zip(corner.gauged(), (0.44, 1.38, 2.96), strict=True):
        assert record.control_um < 0.1
        assert np.abs(record.off_um).max() == pytest.approx(largest, abs=0.15)  # bins of the map
    for row in rows("s2_fig_8.csv"):
        assert row["after_cut_um"] == pytest.approx(row["after_spline_um"], abs=0.1)


@pytest.mark.long
@pytest.mark.usefixtures("undrawn")
def test_command_makes_every_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Tables and pictures of all rows, and the page."""
    assert main(["-o", str(tmp_path / "a")]) == 0
    assert "46 figures and tables" in capsys.readouterr().out
    made = {path.name: path.read_bytes() for path in (tmp_path / "a").iterdir()}
    wanted = {name for one in all_chapters() for name in one.files}
    assert set(made) == wanted | {"papers.md"}
    assert all(data[1:4] == b"PNG" for name, data in made.items() if name.endswith(".png"))
    assert made["papers.md"].decode() == page(all_chapters())


def test_wrong_words_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    """A folder is needed, and nothing else is taken."""
    for words in ([], ["perkins240.toml"], ["-o", "x", "--only", "S2"]):
        with pytest.raises(SystemExit) as stop:
            main(words)
        assert stop.value.code == 2
        assert len(capsys.readouterr().err.splitlines()) == 1
