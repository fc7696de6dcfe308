# SPDX-License-Identifier: Apache-2.0
"""The panel's pages in a window of 800 px, as on a small screen at a machine."""

import pytest
from playwright.sync_api import expect

from tests.browser.panel_page import look
from tests.browser.panel_session import PanelSession
from tests.browser.windows import OpenWindow

WIDTH_PX, HEIGHT_PX = 800, 1000
# Words, of those that can be seen, whose letters stand on more than one line.
_BROKEN = r"""() => {
    const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT), broken = [];
    while (texts.nextNode()) {
        const text = texts.currentNode;
        if (!text.parentElement.checkVisibility()) continue;
        for (const word of text.data.matchAll(/[^\s\-\/]+/g)) {
            const range = document.createRange();
            range.setStart(text, word.index);
            range.setEnd(text, word.index + word[0].length);
            const lines = new Set([...range.getClientRects()].map(one => Math.round(one.top)));
            if (lines.size > 1) broken.push(word[0]);
        }
    }
    return broken;
}"""

# Tables with columns beyond their edge.
_BEYOND = """() => [...document.querySelectorAll(".q-table__middle")]
    .filter(one => one.scrollWidth > one.clientWidth).map(one => one.textContent)"""


@pytest.mark.parametrize("path", ["", "/design", "/runs"])
def test_no_word_is_broken(session: PanelSession, open_window: OpenWindow, path: str) -> None:
    """Every word of the page stands on one line, and every column of a table is in view."""
    page = open_window().page
    page.set_viewport_size({"width": WIDTH_PX, "height": HEIGHT_PX})
    look(page, session)
    page.goto(session.origin + path)
    expect(page.get_by_role("link", name="Runs").first).to_be_visible()
    page.wait_for_timeout(1000)
    assert page.evaluate(_BROKEN) == []
    assert page.evaluate(_BEYOND) == []
