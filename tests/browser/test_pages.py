# SPDX-License-Identifier: Apache-2.0
"""Every page of the panel, as it looks and as it can be used by all."""

import pytest

from tests.browser.accessible import grave_findings
from tests.browser.gallery import Gallery
from tests.browser.panel_session import PanelSession
from tests.browser.windows import DESK, PHONE, OpenWindow

PAGES = {"operate": "/", "design": "/design", "runs": "/runs"}


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", PAGES)
def test_page_has_no_grave_finding(
    session: PanelSession, open_window: OpenWindow, gallery: Gallery, name: str, scheme: str
) -> None:
    """Axe finds nothing serious, at a desk and on a phone, where nothing is beyond the edge."""
    page = open_window(color_scheme=scheme).page
    page.goto(session.origin + PAGES[name], wait_until="networkidle")
    for place, size in {"desk": DESK, "phone": PHONE}.items():
        page.set_viewport_size(size)
        gallery.keep(page, f"{name}, {place}, {scheme}", is_whole=True)
        assert not grave_findings(page)
        assert page.evaluate("document.documentElement.scrollWidth") <= size["width"]
