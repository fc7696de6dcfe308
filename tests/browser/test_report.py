# SPDX-License-Identifier: Apache-2.0
"""The report of a cut in a browser."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from accessible import grave_findings
from gallery import Gallery
from windows import OpenWindow


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_report_has_no_grave_finding(
    report_folder: Path, open_window: OpenWindow, gallery: Gallery, scheme: str
) -> None:
    """Axe finds nothing serious."""
    page = open_window(color_scheme=scheme).page
    page.goto((report_folder / "report.html").as_uri())
    gallery.keep(page, f"Report, {scheme}", is_whole=True)
    assert not grave_findings(page)


def test_report_fits_paper(report_folder: Path, open_window: OpenWindow) -> None:
    """On A4 less its margins nothing is wider than the page, and pictures stand for the charts."""
    page = open_window().page
    page.set_viewport_size({"width": 688, "height": 1000})  # 182 mm of 1/96 inch
    page.goto((report_folder / "report.html").as_uri())
    page.wait_for_selector(".has-board", state="attached")
    page.emulate_media(media="print")
    assert page.evaluate("document.documentElement.scrollWidth") <= 688
    assert not page.locator("#board").is_visible()
    assert page.locator("#picture-map img").is_visible()


def test_sheet_reads_as_its_data(report_folder: Path, open_window: OpenWindow) -> None:
    """Every feature of every sheet stands on the page with the digits of sheets.json."""
    data = json.loads((report_folder / "sheets.json").read_text())
    page = open_window().page
    page.goto((report_folder / "report.html").as_uri())
    assert len(data["sections"]) > 2
    for number, section in enumerate(data["sections"], 1):
        rows = page.locator(f"#sheet-{number} table").first.locator("tr").all_inner_texts()[1:]
        cells = [row.split("\t") for row in rows]
        assert [row[0] for row in cells] == [one["name"] for one in section["features"]]
        assert [row[6] for row in cells] == [one["verdict"] for one in section["features"]]
        for row, one in zip(cells, section["features"], strict=True):
            assert float(row[3].replace(" ", "")) == pytest.approx(one["actual"], abs=5.1e-5)
