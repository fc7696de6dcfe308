"""A lathe is operated from the browser; what is so is asked of the controller, past the panel."""

import pytest
from playwright.sync_api import Locator, Page, expect

from checks.patience import limit_s
from tests.browser.accessible import grave_findings
from tests.browser.conftest import Keep
from tests.browser.panel_page import (
    command,
    expect_state,
    give,
    look,
    order,
    press_until,
    take_command,
)
from tests.browser.panel_session import PanelSession
from tests.browser.windows import PHONE, OpenWindow

pytestmark = pytest.mark.long

MOST_TABS = 60
# No heartbeat comes meanwhile, then the button is still held.
FREEZE = "() => { const since = performance.now(); while (performance.now() - since < 1500); }"


def test_viewer_commands_nothing(session: PanelSession, open_window: OpenWindow) -> None:
    """Without command all buttons are off, and keys do nothing."""
    page = open_window().page
    look(page, session)
    expect_state(page, "off")
    n_logged = len(session.logged())
    for name in ("enable", "start", "hold", "resume", "disable", "reset", "home", "manual"):
        expect(order(page, name)).to_be_disabled()
    expect(page.get_by_test_id("rights")).to_contain_text("take the command")
    for key in "esm":
        page.keyboard.press(key)
    expect(page.get_by_test_id("last-order")).to_contain_text("take the command")
    assert session.status().state == "off"
    assert not any(line["is_done"] for line in session.logged()[n_logged:])


def test_a_part_is_cut_and_a_fault_is_got_over(
    session: PanelSession, open_window: OpenWindow, keep: Keep
) -> None:
    """The whole story of an operator, from taking command to the second cut."""
    page = open_window().page
    n_logged = len(session.logged())
    look(page, session)
    keep(page, "Operate, viewing")
    take_command(page)
    expect(page.get_by_test_id("params-state")).to_contain_text("checksum")
    expect(page.get_by_test_id("card-drive")).to_be_hidden()  # U takes positions
    give(page, session, "enable", "ready")
    expect_state(page, "ready")
    give(page, session, "start", "cutting")
    expect_state(page, "cutting")
    keep(page, "Operate, cutting")
    z_mm = give(page, session, "hold", "holding").signals["z"]
    assert session.status().signals["z"] == pytest.approx(z_mm, abs=0.01)
    give(page, session, "resume", "cutting")
    session.wait_for(lambda status: status.signals["z"] > z_mm + 0.1)
    session.lathe.type("estop")
    session.wait_for_state("fault")
    fault = page.locator("[data-fault=estop]")
    expect(fault).to_contain_text("Cause: The emergency-stop chain is open.")
    expect(fault).to_contain_text("Remedy: Release the emergency stop")
    expect(page.get_by_test_id("missing")).to_contain_text("Release the emergency stop")
    keep(page, "Operate, fault")
    assert not grave_findings(page)
    session.lathe.type("release")
    session.wait_for(lambda status: not status.signals["is_estop"])
    expect(order(page, "reset")).to_be_enabled()
    give(page, session, "reset", "off")
    give(page, session, "enable", "ready")
    expect(order(page, "start")).to_be_enabled()
    give(page, session, "start", "cutting")
    page.get_by_test_id("stop").click()
    session.wait_for_state("disengaging", "ready")
    done = [line["order"] for line in session.logged()[n_logged:] if line["is_done"]]
    story = ["enable", "start", "hold", "resume", "reset", "enable", "start"]
    assert [name for name in done if name in story] == story


@pytest.mark.parametrize("end", ["frozen", "released", "closed"])
def test_jog_ends_with_its_heartbeats(
    session: PanelSession, open_window: OpenWindow, end: str
) -> None:
    """An axis moves while its button is held; it stops with the last order, and the log says so."""
    page = open_window().page
    command(page, session)
    give(page, session, "manual", "manual")
    button = page.get_by_test_id("jog-xplus")
    expect(button).to_be_enabled()
    witness, x_mm = session.witness, session.status().signals["x"]
    signals = witness.status.signals
    press_until(page, button, lambda s: witness.wait(lambda: signals["x"] > x_mm + 0.05, s))
    if end == "frozen":
        page.evaluate(FREEZE)
    elif end == "released":
        page.mouse.up()
    else:
        page.close()
    last = None
    while last != (last := session.status().signals["x"]):
        for _ in range(50):
            assert session.witness.next_row(limit_s())
    jog = [line for line in session.logged() if line["order"] == "jog_begin"][-1]
    assert jog["outcome"].endswith(
        ("the page was closed", "nothing was heard from the page for 250 ms", "released")
    )


def test_a_cut_by_the_keyboard_alone(session: PanelSession, open_window: OpenWindow) -> None:
    """Tab, Enter and the keys that stand on the buttons; Escape stops, whatever has the focus."""
    page = open_window().page
    look(page, session)
    take = page.get_by_role("button", name="Take command")
    expect(take).to_be_visible()
    tab_to(page, take)
    page.keyboard.press("Enter")
    states = {"enable": "ready", "start": "cutting", "hold": "holding", "stop": "ready"}
    for name, state in (states | {"disable": "off"}).items():
        if name == "stop":
            page.keyboard.press("Escape")
        else:
            expect(order(page, name)).to_be_enabled()
            page.keyboard.press(name[0])
        if name == "start":
            tab_to(page, page.get_by_test_id("question-yes"))
            page.keyboard.press("Enter")
        session.wait_for_state(state)


def tab_to(page: Page, wanted: Locator) -> None:
    """Press Tab until something has the focus, as far as the page goes round once."""
    expect(wanted).to_be_visible()
    for _ in range(MOST_TABS):
        if wanted.evaluate("element => element.contains(document.activeElement)"):
            return
        page.keyboard.press("Tab")
    raise AssertionError("Tab does not reach it")


def test_jog_by_a_finger_on_a_phone(session: PanelSession, open_window: OpenWindow) -> None:
    """An axis moves while a finger presses its button; STOP is in sight all the time."""
    page = open_window(viewport=PHONE, has_touch=True, is_mobile=True).page
    command(page, session)
    give(page, session, "manual", "manual")
    button = page.get_by_test_id("jog-zplus")
    expect(button).to_be_enabled()
    button.scroll_into_view_if_needed()
    expect(page.get_by_test_id("stop")).to_be_in_viewport()
    box = button.bounding_box()
    assert box is not None and box["width"] >= 48 and box["height"] >= 48
    finger = page.context.new_cdp_session(page)
    place = {"x": box["x"] + box["width"] / 2, "y": box["y"] + box["height"] / 2}
    witness, z_mm = session.witness, session.status().signals["z"]
    for _ in range(10):  # heartbeats that come late end a press
        finger.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": [place]})
        if witness.wait(lambda: witness.status.signals["z"] > z_mm + 0.02, 10.0):
            break
        finger.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    assert session.status().signals["z"] > z_mm
    finger.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    session.wait_for(lambda status: status.signals["hand_phase"] == 0)
    page.get_by_test_id("stop").tap()
    give(page, session, "disable", "off")
