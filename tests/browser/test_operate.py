# SPDX-License-Identifier: Apache-2.0
"""A lathe is operated from the browser; what is so is asked of the controller, past the panel."""

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.browser.accessible import grave_findings
from tests.browser.gallery import Gallery
from tests.browser.overheard import Overheard
from tests.browser.panel_page import (
    command,
    expect_state,
    give,
    look,
    order,
    points,
    press_until,
    take_command,
)
from tests.browser.panel_session import PanelSession
from tests.browser.windows import PHONE, OpenWindow

JOG_TIMEOUT_ROWS = 25  # 250 ms of the controller's own time: a status comes every 10 ms
ROUND_ROWS = 24  # the phase of a jog and the place of X come in turn with other pages
NEW_POINTS = 100
MOST_TABS = 60
# No heartbeat comes meanwhile, then the button is still held.
FREEZE = "() => { const since = performance.now(); while (performance.now() - since < 1500); }"


def expect_curve_of_the_controller(overheard: Overheard, page: Page) -> None:
    """Wait until the chart has new points, all of which the controller said on the bus."""
    before = points(page)
    while len(new := points(page) - before) < NEW_POINTS:
        overheard.status()
    heard, n_lost = overheard.points()
    strange = {point for point in new if point not in heard}
    assert len(strange) <= min(n_lost, NEW_POINTS / 10), (sorted(strange)[:5], n_lost)
    assert len({angle for angle, _ in new}) > NEW_POINTS / 2, "from all around"


def test_viewer_commands_nothing(
    session: PanelSession, overheard: Overheard, open_window: OpenWindow
) -> None:
    """Without the token all buttons are off, keys do nothing, and taking is not offered."""
    page = open_window().page
    look(page, session)
    expect_state(page, "off")
    n_logged = len(session.logged())
    for name in ("enable", "start", "hold", "resume", "disable", "reset", "home", "manual"):
        expect(order(page, name)).to_be_disabled()
    expect(page.get_by_test_id("rights")).to_contain_text("token")
    expect(page.get_by_role("button", name="Take command")).to_be_hidden()
    for key in "esm":
        page.keyboard.press(key)
    expect(page.get_by_test_id("last-order")).to_contain_text("token")
    assert overheard.status().state == "off"
    assert not any(line["is_done"] for line in session.logged()[n_logged:])


def test_a_part_is_cut_and_a_fault_is_got_over(
    session: PanelSession, overheard: Overheard, open_window: OpenWindow, gallery: Gallery
) -> None:
    """The whole story of an operator, from the token to the second cut."""
    page = open_window().page
    look(page, session)
    gallery.keep(page, "Operate, viewing")
    take_command(page, session)
    give(page, overheard, "enable", "ready")
    expect_state(page, "ready")
    give(page, overheard, "start", "cutting")
    expect_state(page, "cutting")
    expect_curve_of_the_controller(overheard, page)
    gallery.keep(page, "Operate, cutting")
    z_mm = give(page, overheard, "hold", "holding").signals["z"]
    gallery.keep(page, "Operate, holding")
    assert overheard.status().signals["z"] == pytest.approx(z_mm, abs=0.01)
    give(page, overheard, "resume", "cutting")
    overheard.wait_for(lambda status: status.signals["z"] > z_mm + 0.1)
    session.lathe.type("estop")
    overheard.wait_for_state("fault")
    fault = page.locator("[data-fault=estop]")
    expect(fault).to_contain_text("Cause: The emergency-stop chain is open.")
    expect(fault).to_contain_text("Remedy: Release the emergency stop")
    expect(page.get_by_test_id("missing")).to_contain_text("Release the emergency stop")
    gallery.keep(page, "Operate, fault")
    assert not grave_findings(page)
    session.lathe.type("release")
    overheard.wait_for(lambda status: not status.signals["is_estop"])
    expect(order(page, "reset")).to_be_enabled()
    give(page, overheard, "reset", "off")
    give(page, overheard, "enable", "ready")
    expect(order(page, "start")).to_be_enabled()
    give(page, overheard, "start", "cutting")
    page.get_by_test_id("stop").click()
    overheard.wait_for_state("disengaging", "ready")
    done = [line["order"] for line in session.logged() if line["is_done"]]
    assert [name for name in done if name in ("enable", "start", "hold", "resume", "reset")] == [
        *("enable", "start", "hold", "resume", "reset", "enable", "start")
    ]


@pytest.mark.parametrize("way", ["frozen", "let go"])
def test_jog_ends_with_its_heartbeats(
    session: PanelSession, overheard: Overheard, open_window: OpenWindow, way: str
) -> None:
    """An axis moves while its button is held; 250 ms behind the last order it stands."""
    window = open_window()
    page = window.page
    command(page, session)
    give(page, overheard, "manual", "manual")
    button = page.get_by_test_id("jog-xplus")
    expect(button).to_be_enabled()
    x_mm = overheard.status().signals["x"]
    press_until(
        page,
        button,
        lambda seconds: overheard.comes(
            lambda status: status.signals["x"] > x_mm + 0.02 and status.signals["hand_phase"] != 0,
            seconds,
        ),
    )
    if way == "frozen":
        page.evaluate(FREEZE)
    else:
        page.mouse.up()
    overheard.wait_for(lambda status: status.signals["hand_phase"] == 0)
    assert 0 <= overheard.rest_row - overheard.jog_row <= JOG_TIMEOUT_ROWS + ROUND_ROWS
    jog_row, seen_row = overheard.jog_row, overheard.rest_row + ROUND_ROWS
    status = overheard.wait_for(lambda status: status.n_rows > seen_row)
    stands_mm, until_row = status.signals["x"], seen_row + 2 * JOG_TIMEOUT_ROWS
    later = overheard.wait_for(lambda status: status.n_rows > until_row)
    assert later.signals["x"] == stands_mm and overheard.jog_row == jog_row
    page.mouse.up()


def test_a_cut_by_the_keyboard_alone(
    session: PanelSession, overheard: Overheard, open_window: OpenWindow
) -> None:
    """Tab, Enter and the keys that stand on the buttons; Escape stops, whatever has the focus."""
    page = open_window().page
    look(page, session)
    expect(page.get_by_label("token")).to_be_visible()
    tab_to(page, page.get_by_label("token"))
    page.keyboard.type(session.token)
    page.keyboard.press("Enter")
    take = page.get_by_role("button", name="Take command")
    expect(take).to_be_visible()
    tab_to(page, take)
    page.keyboard.press("Enter")
    expect(order(page, "enable")).to_be_enabled()
    page.keyboard.press("e")
    overheard.wait_for_state("ready")
    expect(order(page, "start")).to_be_enabled()
    page.keyboard.press("s")
    tab_to(page, page.get_by_test_id("question-yes"))
    page.keyboard.press("Enter")
    overheard.wait_for_state("cutting")
    expect(order(page, "hold")).to_be_enabled()
    page.keyboard.press("h")
    overheard.wait_for_state("holding")
    page.keyboard.press("Escape")
    overheard.wait_for_state("ready")
    expect(order(page, "disable")).to_be_enabled()
    page.keyboard.press("d")
    overheard.wait_for_state("off")


def tab_to(page: Page, wanted: Locator) -> None:
    """Press Tab until something has the focus, as far as the page goes round once."""
    expect(wanted).to_be_visible()
    for _ in range(MOST_TABS):
        if wanted.evaluate("element => element.contains(document.activeElement)"):
            return
        page.keyboard.press("Tab")
    raise AssertionError("Tab does not lead there")


def test_jog_by_a_finger_on_a_phone(
    session: PanelSession, overheard: Overheard, open_window: OpenWindow
) -> None:
    """An axis moves while a finger lies on its button; STOP is in sight all the time."""
    page = open_window(viewport=PHONE, has_touch=True, is_mobile=True).page
    command(page, session)
    give(page, overheard, "manual", "manual")
    button = page.get_by_test_id("jog-zplus")
    expect(button).to_be_enabled()
    button.scroll_into_view_if_needed()
    expect(page.get_by_test_id("stop")).to_be_in_viewport()
    box = button.bounding_box()
    assert box is not None and box["width"] >= 48 and box["height"] >= 48
    finger = page.context.new_cdp_session(page)
    place = {"x": box["x"] + box["width"] / 2, "y": box["y"] + box["height"] / 2}
    z_mm = overheard.status().signals["z"]
    finger.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": [place]})
    overheard.wait_for(lambda status: status.signals["z"] > z_mm + 0.02)
    finger.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    overheard.wait_for(lambda status: status.signals["hand_phase"] == 0)
    page.get_by_test_id("stop").tap()
    give(page, overheard, "disable", "off")
