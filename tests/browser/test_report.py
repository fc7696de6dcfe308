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
