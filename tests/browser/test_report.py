# SPDX-License-Identifier: Apache-2.0
"""The report of a cut in a browser."""

from __future__ import annotations

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
