# SPDX-License-Identifier: Apache-2.0
"""What a visitor does on the operator's page, and what is read from it there."""

from __future__ import annotations

from playwright.sync_api import Locator, Page, expect

from panel_session import PanelSession

_POINTS = """element => getElement(Number(element.id.slice(1))).chart.getOption().series
    .filter(series => series.id.startsWith("turns-")).flatMap(series => series.data)"""
Point = tuple[float, float]


def look(page: Page, session: PanelSession, path: str = "/") -> None:
    """Open a page without the token, and wait until it is alive."""
    page.goto(session.origin + path)
    expect(page.get_by_text("commands", exact=False).first).to_be_visible()


def take_command(page: Page, session: PanelSession) -> None:
    """Type the token, and take the command, when nobody has it any more."""
    page.get_by_label("token").fill(session.token)
    page.get_by_label("token").press("Enter")
    page.get_by_role("button", name="Take command").click()
    expect(page.get_by_text("you command").first).to_be_visible()


def command(page: Page, session: PanelSession) -> None:
    """Open the operator's page, with the right to command."""
    look(page, session)
    take_command(page, session)


def order(page: Page, name: str) -> Locator:
    """Return the button of an order."""
    return page.get_by_test_id(f"do-{name}")


def start(page: Page) -> None:
    """Start a cut, and agree to it."""
    order(page, "start").click()
    page.get_by_test_id("question-yes").click()


def expect_state(page: Page, state: str) -> None:
    """Wait until the page shows a state."""
    expect(page.get_by_test_id("state")).to_have_text(state, ignore_case=True)


def points(page: Page) -> set[Point]:
    """Return angle [degrees] and following error [um] of the points of the unrolled chart."""
    chart = page.get_by_test_id("error-unrolled")
    return {(angle, error) for angle, error in chart.evaluate(_POINTS)}
