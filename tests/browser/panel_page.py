"""A visitor's actions on the operator's page."""

import re
from collections.abc import Callable

from playwright.sync_api import Locator, Page, expect

from camtools.link.controller import Status
from checks.patience import until
from tests.browser.panel_session import PanelSession

_PRESSES = 10
_PRESS_S = 10.0
_WORK_S = 300.0  # of a processor, for the longest order
_ASKED = ("start", "measure_loop", "apply_loop")


def look(page: Page, session: PanelSession) -> None:
    """Open the operator's page, and wait until it is alive."""
    page.goto(session.url)
    expect(page.get_by_test_id("state")).not_to_have_text("no connection", ignore_case=True)
    expect(page.get_by_test_id("rights")).to_contain_text("take the command")


def take_command(page: Page) -> None:
    """Take command, over from a page that is not given up yet."""
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
    take_command(page)


def order(page: Page, name: str) -> Locator:
    """Return the button of an order."""
    return page.get_by_test_id(f"do-{name}")


def give(page: Page, session: PanelSession, name: str, *states: str) -> Status:
    """Press the button of an order until it is done, as a person would do it on a slow computer.

    Returns the first status in one of some states.
    """
    last = page.get_by_test_id("last-order")
    for _ in range(_PRESSES):
        if _outcome(page, session, name):
            expect(last).to_contain_text(": done")
            return session.wait_for_state(*states)
    raise AssertionError(last.inner_text())


def _outcome(page: Page, session: PanelSession, name: str) -> bool:
    """Press the button of an order once; return whether the order was done."""
    last = page.get_by_test_id("last-order")
    take = page.get_by_role("button", name="Take command")
    is_on = order(page, name).and_(page.locator(":enabled"))
    expect(is_on.or_(take).first).to_be_visible()
    if take.is_visible():  # the page was away for longer than command lasts
        take.click()
        expect(is_on).to_be_visible()
    before, n_before = last.inner_text(), len(session.logged())

    def outcomes() -> list[bool]:
        return [line["is_done"] for line in session.logged()[n_before:] if line["order"] == name]

    order(page, name).click()
    if name in _ASKED:
        page.get_by_test_id("question-yes").click()
    until(
        lambda: outcomes() or ": not done" in last.inner_text().replace(before, ""),
        f"an outcome of {name}",
        _WORK_S,
    )
    return any(outcomes())


def press_until(page: Page, button: Locator, moves: Callable[[float], bool]) -> None:
    """Hold the button of a jog until the axis moves; it stays held.

    A press whose heartbeats came late ends by itself, and is made again, as a person would do it.
    `moves` waits for the motion for some seconds, and returns whether it came.
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
