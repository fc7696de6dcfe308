"""Every page of the panel: it works, can be read by all, and has STOP at hand."""

import pytest
from playwright.sync_api import ViewportSize, expect

from tests.browser.accessible import grave_findings
from tests.browser.conftest import Keep
from tests.browser.panel_page import command, give, look
from tests.browser.panel_session import PanelSession
from tests.browser.windows import DESK, PHONE, OpenWindow

PAGES = {"operate": "", "design": "design", "runs": "runs"}
SMALL: ViewportSize = {"width": 800, "height": 1000}
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


def test_operate_works(session: PanelSession, open_window: OpenWindow) -> None:
    """The page comes alive, takes command and enables the drives."""
    page = open_window().page
    command(page, session)
    give(page, session, "enable", "ready")


def test_design_works(session: PanelSession, open_window: OpenWindow) -> None:
    """The preview of the part comes, and the part can be cut."""
    page = open_window().page
    page.goto(session.url + "design")
    expect(page.get_by_test_id("preview-state")).to_have_text("preview of this text")
    expect(page.get_by_test_id("cut")).to_be_enabled()


def test_runs_work_and_end_no_machine(session: PanelSession, open_window: OpenWindow) -> None:
    """The button that ends a simulation is not called as the machine's STOP."""
    page = open_window().page
    page.goto(session.url + "runs")
    expect(page.get_by_test_id("machine")).to_have_text("machine: off")
    expect(page.get_by_test_id("stop-run")).to_contain_text("End the simulation")
    expect(page.get_by_role("button", name="stop")).to_have_count(1)


@pytest.mark.long
@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", PAGES)
def test_page_has_no_grave_finding(
    session: PanelSession, open_window: OpenWindow, keep: Keep, name: str, scheme: str
) -> None:
    """Axe finds nothing serious at a desk and on a phone, and nothing is beyond the edge.

    On a small screen every word is on one line, and every column of a table is in view.
    """
    page = open_window(color_scheme=scheme).page
    look(page, session)
    page.goto(session.url + PAGES[name], wait_until="networkidle")
    for place, size in {"desk": DESK, "phone": PHONE}.items():
        page.set_viewport_size(size)
        keep(page, f"{name}, {place}, {scheme}", is_whole=True)
        assert not grave_findings(page)
        assert page.evaluate("document.documentElement.scrollWidth") <= size["width"]
    page.set_viewport_size(SMALL)
    page.wait_for_function(f"() => ({_BROKEN})().length + ({_BEYOND})().length === 0")


@pytest.mark.long
@pytest.mark.parametrize("path", ["design", "runs"])
def test_stop_is_on_every_page(session: PanelSession, open_window: OpenWindow, path: str) -> None:
    """By its button, and for the commander also by Escape."""
    page = open_window().page
    page.goto(session.url + path)
    expect(page.get_by_test_id("machine")).to_have_text("machine: off")
    n_before = len(session.logged())
    page.get_by_test_id("stop").click()
    expect(page.get_by_text("STOP of the machine").first).to_be_visible()
    page.keyboard.press("Escape")  # a visitor without command may only have closed a menu
    page.get_by_role("button", name="Take command").click()
    expect(page.get_by_role("button", name="Give command back")).to_be_visible()
    assert [line["order"] for line in session.logged()[n_before:]] == ["stop", "take"]
    page.keyboard.press("Escape")
    expect(page.locator(".q-notification__badge")).to_have_text("2")  # the same words once more
    assert [line["order"] for line in session.logged()[n_before:]] == ["stop", "take", "stop"]
