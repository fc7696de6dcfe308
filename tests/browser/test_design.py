"""A part is edited, cut and compared in the browser; its numbers are read where a person does."""

import json
import re
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.browser.accessible import grave_findings, told_um
from tests.browser.conftest import Keep
from tests.browser.panel_session import PanelSession
from tests.browser.windows import NO_3D, OpenWindow

pytestmark = pytest.mark.long

FEED_MM = 0.5  # coarse, so that a cut is short
_SECTION = """element => getElement(Number(element.id.slice(1))).chart.getOption().series
    .map(series => JSON.stringify(series.data)).join()"""


def open_design(page: Page, session: PanelSession) -> None:
    """Open the page, and wait for the preview of its part."""
    page.goto(session.url + "design")
    expect(page.get_by_test_id("cut")).to_be_enabled()
    settled(page)


def settled(page: Page) -> None:
    """Wait until the preview is that of the text."""
    expect(page.get_by_test_id("preview-state")).to_have_text("preview of this text")


def type_field(page: Page, name: str, text: str) -> None:
    """Change a field of the form."""
    field = page.get_by_test_id(f"field-{name}").first
    field.click()
    page.keyboard.press("Control+A")
    page.keyboard.type(text)
    page.keyboard.press("Tab")


def cut(page: Page, folder: Path, n_runs: int) -> dict[str, Any]:
    """Cut the part; return the summary of the run, which is the n-th."""
    page.get_by_test_id("cut").click()
    expect(page.get_by_test_id("cut-state")).to_have_text(re.compile(f"-{n_runs:03}: .*tolerance"))
    runs = sorted((folder / "runs").glob("*/summary.json"))
    assert len(runs) == n_runs
    summary: dict[str, Any] = json.loads(runs[-1].read_text("utf-8"))
    return summary


def test_part_is_edited_cut_and_compared(
    session: PanelSession, open_window: OpenWindow, keep: Keep
) -> None:
    """From a wrong value to two runs side by side."""
    page = open_window(viewport={"width": 1400, "height": 1180}).page
    page.add_init_script(NO_3D)
    open_design(page, session)
    page.get_by_test_id("tab-form").click()
    chart = page.get_by_test_id("section-chart")
    before = chart.evaluate(_SECTION)
    speed = "machine.limits.u_speed_mm_s"
    type_field(page, speed, "-1")
    alert = page.get_by_role("alert").filter(has_text=speed)
    expect(alert).to_contain_text("give at least 0.001")
    keep(page, "Design, a wrong value")
    type_field(page, speed, "20")
    expect(page.get_by_test_id("verdict")).to_have_text("not feasible")
    settled(page)
    type_field(page, speed, "400")
    expect(page.get_by_test_id("verdict")).to_have_text("feasible")
    settled(page)
    page.get_by_test_id("height").click(position={"x": 60, "y": 10})
    there = chart.element_handle()
    page.wait_for_function(f"([one, old]) => ({_SECTION})(one) !== old", arg=[there, before])
    page.get_by_test_id("cut-feed").fill(str(FEED_MM))
    summary = cut(page, session.log.parent, 1)
    report = page.get_by_test_id("cut-report").content_frame
    line = report.locator("#summary tr", has_text="form error").inner_text()
    assert told_um(line) == pytest.approx(summary["form_error_um"]["max"], rel=0.01)
    assert summary["cut"]["feed_mm"] == FEED_MM
    keep(page, "Design, the report below the cut")
    page.get_by_test_id("cut-machine").click()
    page.locator(".q-menu .q-item").get_by_text("real", exact=True).click()
    other = cut(page, session.log.parent, 2)
    page.goto(session.url + "runs")
    rows = page.locator("[data-testid=runs-table] tbody tr")
    own = rows.filter(has_text=re.compile(r"-00\d"))  # tools/run may have left others in build/run
    boxes = own.locator("[role=checkbox]")
    expect(boxes).to_have_count(2)
    boxes.nth(0).click()
    boxes.nth(1).click()
    page.get_by_test_id("compare").click()
    row = page.get_by_test_id("figures").locator("tr", has_text="form error").first
    expect(row).to_be_visible()
    found = [float(one) for one in re.findall(r"\d+\.\d+", row.inner_text())]
    for one in (summary, other):
        assert any(x == pytest.approx(one["form_error_um"]["max"], rel=0.02) for x in found), found
    check_reports(page)
    keep(page, "Runs, two machines compared", is_whole=True)
    assert not grave_findings(page)


def check_reports(page: Page) -> None:
    """Look at the reports one after the other: never more than the chosen one is loaded."""
    asked: list[str] = []
    page.on("request", lambda one: asked.append(one.url))
    frame, loaded = page.get_by_test_id("report"), page.locator("iframe[src*='/own/']")
    expect(frame).to_be_hidden()
    expect(loaded).to_have_count(0)
    for i, button in enumerate(page.get_by_test_id("reports").get_by_role("button").all()):
        button.click()
        expect(frame).to_have_attribute("src", re.compile(rf"/own/.*-00{i + 1}/"))
        expect(frame.content_frame.locator("#error-map .main-svg").first).to_be_visible()
        expect(loaded).to_have_count(1)
    assert len([url for url in asked if "/own/" in url]) == 2
