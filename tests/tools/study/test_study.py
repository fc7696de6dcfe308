# SPDX-License-Identifier: Apache-2.0
"""Studies of cams and of the refit: worked numbers of MATHS.md, figures beside the paper's."""

import csv
import json
from io import StringIO
from pathlib import Path

import numpy as np
import pytest

from camtools.cli.analyse import lobe_products, main
from camtools.lobe.part import LobePart
from camtools.pipeline.load import load
from camtools.study.lobe import LobeWishes
from camtools.study.refit import (
    PAPER_JERK_MM_S3,
    Study,
    candidates_csv,
    comparison_csv,
    notes,
    study,
)
from camtools.study.refit_plots import draw_all
from tests.tools.cases.cut_cases import PARTS, geometry_of_part
from tests.tools.cases.lobe_tables import POLY345, POLY345_WHEEL


def products(name: str, wishes: LobeWishes | None = None) -> tuple[str, dict[str, bytes]]:
    """Return what the command makes of a part of the repository."""
    part = load(PARTS / f"{name}.toml").part
    assert isinstance(part, LobePart)
    return lobe_products(part, wishes or LobeWishes(step_deg=5.0), with_pictures=False)


def rows_of(files: dict[str, bytes], number: int = 0) -> dict[float, dict[str, float]]:
    """Return the rows_of of a lobe by the direction of the follower."""
    text = files[f"lobe_{number}.csv"].decode()
    found = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(StringIO(text))]
    return {row["theta_deg"]: row for row in found}


def test_lobe_is_the_worked_table() -> None:
    """X = H and swing of the turned lobe; S, phi, ds/dphi and N_C of the ground one."""
    turned, ground = rows_of(products("cam-345")[1]), rows_of(products("cam-345-ground")[1])
    for line in POLY345:
        theta, lift, swing, radius, alpha = map(float, line.split()[:5])
        row = turned[theta]
        assert row["x_mm"] == pytest.approx(lift, abs=6e-8)
        assert row["swing_deg"] == pytest.approx(swing, abs=1e-6)
        assert row["contact_radius_mm"] == pytest.approx(radius, abs=6e-8)
        assert row["contact_angle_deg"] == pytest.approx(alpha, abs=1e-6)
    for line in POLY345_WHEEL:
        theta, s, phi, travel, speed = map(float, line.split())
        row = ground[theta]
        assert row["s_mm"] == pytest.approx(s, abs=6e-8)
        assert row["phi_deg"] == pytest.approx(phi, abs=1e-6)
        assert row["ds_dphi_mm_rad"] == pytest.approx(travel, abs=1e-6)
        assert row["n_c_rpm"] == pytest.approx(speed, abs=1e-6)


def test_speeds_are_derivatives_over_time() -> None:
    """Speed and acceleration of X and of the swing are differences of x(t) and swing(t)."""
    found = list(rows_of(products("cam-345", LobeWishes(step_deg=0.1, rpm=30.0))[1]).values())
    t = np.array([row["t_s"] for row in found])
    assert t[-1] == pytest.approx(2.0)
    for value, speed, bend in (
        ("x_mm", "x_speed_mm_s", "x_acceleration_mm_s2"),
        ("swing_deg", "swing_speed_deg_s", "swing_acceleration_deg_s2"),
    ):
        one, two, three = (np.array([row[key] for row in found]) for key in (value, speed, bend))
        flank = slice(1200, 1780)  # below the nose, where no higher derivative of the law jumps
        measured = np.gradient(one, t)
        assert np.abs(measured - two)[flank].max() < 2e-3 * np.abs(two).max()
        assert np.abs(np.gradient(two, t) - three)[flank].max() < 2e-2 * np.abs(three).max()


def test_figures_and_words() -> None:
    """The extremes of the worked example, and what a user reads."""
    told, files = products("cam-345-ground")
    [lobe] = json.loads(files["analysis.json"])["lobes"]
    assert lobe["n_c_rpm"] == pytest.approx([6.7664, 104.2400], abs=1e-3)
    assert lobe["least_convex_radius_mm"] == pytest.approx(10.679909, abs=1e-5)
    assert lobe["largest_pressure_angle_deg"] == pytest.approx(19.967381, abs=1e-5)
    assert "the cam turns at 6.77 .. 104.24 r/min, before any limit of the spindle" in told
    names = ["analysis.json", *(f"lobe_{i}.csv" for i in range(3))]
    assert sorted(products("camshaft")[1]) == names


@pytest.mark.usefixtures("undrawn")
def test_command_writes_tables_and_pictures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Both pictures of three lobes, the tables, the words."""
    assert main([str(PARTS / "camshaft.toml"), "-o", str(tmp_path)]) == 0
    assert {"lobe_motion.png", "lobe_contact.png"} <= {path.name for path in tmp_path.iterdir()}
    assert "lobe 2, height 10 .. 13 mm: lift 6 mm" in capsys.readouterr().out


def of(part: str, height_mm: float, spindle_rpm: float) -> Study:
    """Return the study of a part of the repository."""
    corner = geometry_of_part(part).corner
    assert corner is not None
    return study(corner, height_mm, spindle_rpm)


@pytest.fixture(scope="module")
def papers() -> Study:
    """Study the section that the paper computes with."""
    return of("weichai3a", 40.0, 800.0)


def rows(text: str) -> list[dict[str, str]]:
    """Return the rows of a CSV text."""
    return list(csv.DictReader(StringIO(text)))


@pytest.mark.long
def test_comparison_stands_beside_the_paper(papers: Study) -> None:
    """Cubic agrees with the paper's plot, quintic does not; both pictures are drawn."""
    cubic, quintic, deleted, mirrored = rows(comparison_csv(papers))
    assert (cubic["peak_acceleration_mm_s2"], cubic["ratio_to_paper"]) == ("748205.3", "0.935")
    assert float(quintic["ratio_to_paper"]) == pytest.approx(1.255, abs=0.001)
    assert deleted["deviation_um"] == "11.01"
    assert mirrored["paper_peak_acceleration_mm_s2"] == ""
    assert float(mirrored["peak_acceleration_mm_s2"]) == pytest.approx(65789, abs=1)
    pictures = draw_all(papers)
    assert sorted(pictures) == ["refit_deletions", "refit_motion"]
    assert all(png[1:4] == b"PNG" for png in pictures.values())


def test_table_1_is_met_within_the_factors_told(papers: Study) -> None:
    """All 16 within 0.68 .. 2.34, 12 of them within 1.56; correlation of logarithms 0.980."""
    ratios = np.array([float(row["ratio_to_paper"]) for row in rows(candidates_csv(papers))])
    assert (ratios.min(), ratios.max()) == (0.68, 2.34)
    assert int((np.maximum(ratios, 1 / ratios) <= 1.565).sum()) == 12
    ours = [one.tail_jerk_mm_s3 for one in papers.as_paper]
    correlation = np.corrcoef(np.log10(ours), np.log10(PAPER_JERK_MM_S3))[0, 1]
    assert f"{correlation:.3f}" == "0.980"
    text = notes(papers)
    for told in ("0.68 .. 2.34", "0.980", "0.838", "[(1, 1), (2, 2), (3, 3)]", "11.01 um"):
        assert told in text


def test_other_sections_are_not_compared_with_the_paper() -> None:
    """Another part, and the paper's part at another speed, show no numbers of the paper."""
    for found in (of("16v240zj", 100.0, 500.0), of("weichai3a", 40.0, 650.0)):
        assert not found.is_papers
        assert "paper's" not in notes(found).replace("the paper's construction", "")
        assert all(row["paper_jerk_mm_s3"] == "" for row in rows(candidates_csv(found)))
