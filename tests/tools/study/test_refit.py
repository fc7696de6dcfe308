"""The study of the refit: what it tells, beside the paper's numbers."""

import csv
from io import StringIO

import numpy as np
import pytest

from camtools.skirt.geometry.skirt_geometry import make_geometry
from camtools.study.refit import (
    PAPER_JERK_MM_S3,
    Study,
    candidates_csv,
    comparison_csv,
    notes,
    study,
)
from camtools.study.refit_plots import draw_all
from tests.tools.cases.part_cases import ROOT, load_part


def of(part: str, height_mm: float, spindle_rpm: float) -> Study:
    """Return the study of a part of the repository."""
    corner = make_geometry(load_part(ROOT / "tools" / "parts" / f"{part}.toml")).corner
    assert corner is not None
    return study(corner, height_mm, spindle_rpm)


@pytest.fixture(scope="module")
def papers() -> Study:
    """Study the section that the paper computes with."""
    return of("weichai3a", 40.0, 800.0)


def rows(text: str) -> list[dict[str, str]]:
    """Return the rows of a CSV text."""
    return list(csv.DictReader(StringIO(text)))


def test_comparison_stands_beside_the_paper(papers: Study) -> None:
    """Cubic agrees with the paper's plot, quintic does not, and the table says by how much."""
    cubic, quintic, deleted, mirrored = rows(comparison_csv(papers))
    assert (cubic["peak_acceleration_mm_s2"], cubic["ratio_to_paper"]) == ("748205.3", "0.935")
    assert float(quintic["ratio_to_paper"]) == pytest.approx(1.255, abs=0.001)
    assert deleted["deviation_um"] == "11.01"
    assert mirrored["paper_peak_acceleration_mm_s2"] == ""
    assert float(mirrored["peak_acceleration_mm_s2"]) == pytest.approx(65789, abs=1)


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


def test_pictures_are_png(papers: Study) -> None:
    """Both pictures are drawn."""
    pictures = draw_all(papers)
    assert sorted(pictures) == ["refit_deletions", "refit_motion"]
    assert all(png[1:4] == b"PNG" for png in pictures.values())
