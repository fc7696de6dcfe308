"""The command line of the analysis: files, figures, and everything that must be refused."""

import csv
import json
import re
from itertools import pairwise
from pathlib import Path

import pytest

from camtools.cli.analyse import main, skirt_products
from camtools.papers.section import AnalysisWishes, make_analysis, notes, summary
from camtools.skirt.part.part_file import SkirtPart
from tests.tools.cases.maths_tables import TABLE_1, TABLE_4
from tests.tools.cases.part_cases import PERKINS, ROOT, Capture, load_part

WEICHAI = ROOT / "tools" / "parts" / "weichai3a.toml"


@pytest.fixture(scope="module")
def files(perkins: SkirtPart) -> dict[str, bytes]:
    """Analyse the Perkins skirt as the papers do."""
    return skirt_products(perkins, AnalysisWishes(rpm=1667.27), with_pictures=False)[1]


def rows(data: bytes) -> list[dict[str, str]]:
    """Return the rows of a CSV file."""
    return list(csv.DictReader(data.decode().splitlines()))


def test_tables_are_those_of_the_papers(files: dict[str, bytes]) -> None:
    """Table 1 and Table 4 of the part's own section at height 20 mm, six digits."""
    for row, printed in zip(rows(files["depth_and_area.csv"]), TABLE_1, strict=True):
        assert f"{float(row['area_mm2']):.6f}" == printed.split()[3]
        assert f"{float(row['depth_mm']):.6f}" == printed.split()[1]
    for row, printed in zip(rows(files["equal_parts.csv"]), TABLE_4, strict=True):
        assert row["angle_deg"][:-2] == printed.split()[1][:-2]
        assert row["speed_ratio"] == printed.split()[5]


def test_axes_follow_the_angle_not_the_time(files: dict[str, bytes]) -> None:
    """Table 5: equal times, Z from C, X the profile at Z, U the section there; 120 slices."""
    uniform, even = rows(files["axes_uniform.csv"]), rows(files["axes_equal_volume.csv"])
    assert len(uniform) == len(even) == 121
    for one in (uniform, even):
        steps = {round(float(b["t_s"]) - float(a["t_s"]), 8) for a, b in pairwise(one)}
        assert len(steps) <= 2
        for row in one:
            assert float(row["z_mm"]) == pytest.approx(20 + float(row["c_deg"]) / 3600, abs=1e-6)
    assert float(even[30]["c_deg"]) == pytest.approx(90, abs=1e-6)
    assert float(even[1]["c_deg"]) == pytest.approx(4.489177, abs=2e-6)
    assert float(even[30]["u_mm"]) == pytest.approx(0.1, abs=1e-4)
    assert float(uniform[-1]["t_s"]) == pytest.approx(60 / 1667.27, abs=1e-8)


def test_figures_and_notes(files: dict[str, bytes]) -> None:
    """The figures of MATHS.md (25) and (29), and the honest sentences."""
    told = json.loads(files["analysis.json"])
    assert told["parts"] == {
        "n": 30,
        "area_mm2": pytest.approx(0.36154495, abs=1e-7),
        "least": 28,
        "most": 179,
        "largest_depth_change_in_part": 9,
    }
    assert told["removal"]["rate_mm3_s"] == pytest.approx(120.5586, abs=1e-3)
    assert told["speed"]["highest_mean_rpm"] == pytest.approx(207.745, abs=1e-2)
    text = files["notes.md"].decode()
    for sentence in ("1 : 2.000", "number of the slice", "28 .. 179"):
        assert sentence in text


def test_notes_keep_to_the_section() -> None:
    """The papers' own numbers are spoken of beside their section, and nowhere else."""
    for name in ("weichai3a", "perkins240_x30"):
        text = notes(make_analysis(load_part(PERKINS.with_name(f"{name}.toml")), AnalysisWishes()))
        assert "near 8 degrees" not in text
        assert "32 205" not in text
        assert "a part must not" in text


def test_corner_is_studied_too() -> None:
    """A part with a corner gets the study of its refit beside the paper."""
    _, found = skirt_products(load_part(WEICHAI), AnalysisWishes(), with_pictures=False)
    assert b"Beside the paper" in found["refit_notes.md"]
    assert len(rows(found["refit_candidates.csv"])) == 16


@pytest.mark.usefixtures("undrawn")
def test_pictures_are_written(tmp_path: Path, capsys: Capture) -> None:
    """The command writes tables and pictures and tells the essentials."""
    assert main([str(PERKINS), "-o", str(tmp_path / "out")]) == 0
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"area.png", "parts.png", "speed.png", "motion.png", "forces.png"} <= names
    assert {"paths.csv", "path_unrolled.png", "path_scallop.png"} <= names
    assert "not constant: the force of the chip" in capsys.readouterr().out


def told_of(part: SkirtPart, wishes: AnalysisWishes) -> str:
    """Return what the command prints of a part."""
    return summary(make_analysis(part, wishes))


def test_uniform_part_is_not_judged_by_equal_parts(perkins: SkirtPart) -> None:
    """Equal parts are judged only where they are turned or asked for; nothing is shouted."""
    for name in ("weichai3a", "16v240zj", "scan90", "double_ellipse", "perkins240_x30"):
        text = told_of(load_part(PERKINS.with_name(f"{name}.toml")), AnalysisWishes())
        assert "the part is turned uniformly; equal volume would need" in text
        assert not re.search(r"not possible|NOT", text)
    assert "30 equal parts are possible; the range is 28 (volume" in told_of(
        perkins, AnalysisWishes(parts=30)
    )
    even = load_part(PERKINS.with_name("perkins240_equal_volume.toml"))
    assert "30 equal parts are possible" in told_of(even, AnalysisWishes())
    asked = told_of(perkins, AnalysisWishes(parts=500))
    assert "500 equal parts are not possible; give 28 (volume of a part) .. 120" in asked
    assert "by --parts or process.parts" in asked
    none = told_of(even, AnalysisWishes(slice_volume_mm3=1e-6))
    assert "30 equal parts: no number of parts is possible" in none


def test_part_without_depth_is_refused(tmp_path: Path, capsys: Capture) -> None:
    """At depth 0 nothing is cut at the long axis."""
    path = tmp_path / "p.toml"
    path.write_text(PERKINS.read_text().replace("depth_mm = 0.1", "depth_mm = 0"))
    assert main([str(path), "-o", str(tmp_path / "out")]) == 2
    assert "process.depth_mm: nothing is cut" in capsys.readouterr().err
