# SPDX-License-Identifier: Apache-2.0
"""What a visitor does on the operator's page, and what is read from it there."""

import re
from collections.abc import Callable

from playwright.sync_api import Locator, Page, expect

from camtools.link.controller import Status
from tests.browser.overheard import Overheard
from tests.browser.panel_session import PanelSession

_POINTS = """element => getElement(Number(element.id.slice(1))).chart.getOption().series
    .filter(series => series.id.startsWith("turns-")).flatMap(series => series.data)"""
Point = tuple[float, float]
_PRESSES = 5
_PRESS_S = 10.0
_WORDS = {"manual": "by hand"}


def look(page: Page, session: PanelSession) -> None:
    """Open the operator's page without the token, and wait until it is alive."""
    page.goto(session.origin)
    expect(page.get_by_test_id("state")).not_to_have_text("no connection", ignore_case=True)
    expect(page.get_by_test_id("rights")).to_contain_text("viewing only")


def take_command(page: Page, session: PanelSession) -> None:
    """Type the token, and take the command, over from a page that is not given up yet."""
    page.get_by_label("token").fill(session.token)
    page.get_by_label("token").press("Enter")
    page.get_by_role("button", name=re.compile("^Take (command|over)$")).click()
    has_it = page.get_by_role("button", name="Give command back")
    question = page.get_by_test_id("question-yes")
    expect(has_it.or_(question).first).to_be_visible()
    if question.is_visible():
        question.click()
    expect(has_it).to_be_visible()


def command(page: Page, session: PanelSession) -> None:
    """Open the operator's page, with the right to command."""
    look(page, session)
    take_command(page, session)


def order(page: Page, name: str) -> Locator:
    """Return the button of an order."""
    return page.get_by_test_id(f"do-{name}")


def give(page: Page, overheard: Overheard, name: str, *states: str) -> Status:
    """Press the button of an order, and wait until the controller is in one of some states.

    Where the page says that its connection was lost meanwhile, it is pressed again, as a person
    would do it.
    """
    last = page.get_by_test_id("last-order")
    said = re.compile(f"^{_WORDS.get(name, name)}: (not )?done")
    for _ in range(_PRESSES):
        order(page, name).click()
        if name == "start":
            page.get_by_test_id("question-yes").click()
        expect(last).to_have_text(said)
        if "press again" not in last.inner_text():
            break
    return overheard.wait_for_state(*states)


def press_until(page: Page, button: Locator, moves: Callable[[float], bool]) -> None:
    """Hold the button of a jog until the axis moves; it stays held.

    A press whose heartbeats came late ends by itself, and is made again, as a person would do it.

    Parameters
    ----------
    moves : function
        waits for the motion for some seconds, and returns whether it came
    """
    for _ in range(_PRESSES):
        button.hover()
        page.mouse.down()
        if moves(_PRESS_S):
            return
        page.mouse.up()
    raise AssertionError(f"the axis stands: {page.get_by_test_id('last-order').inner_text()}")


def expect_state(page: Page, state: str) -> None:
    """Wait until the page shows a state."""
    expect(page.get_by_test_id("state")).to_have_text(state, ignore_case=True)


def points(page: Page) -> set[Point]:
    """Return angle [degrees] and following error [um] of the points of the unrolled chart."""
    chart = page.get_by_test_id("error-unrolled")
    return {(angle, error) for angle, error in chart.evaluate(_POINTS)}
