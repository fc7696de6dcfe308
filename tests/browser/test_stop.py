# SPDX-License-Identifier: Apache-2.0
"""The machine's STOP is at hand on the pages that are not the operator's."""

import socket
from contextlib import ExitStack
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import expect

from tests.browser.panel_session import PanelSession
from tests.browser.windows import OpenWindow


@pytest.mark.parametrize("path", ["/design", "/runs"])
def test_stop_is_on_every_page(session: PanelSession, open_window: OpenWindow, path: str) -> None:
    """By its button, and for who commands by Escape; the page tells what came of it."""
    page = open_window().page
    page.goto(f"{session.origin}{path}#token={session.token}")
    expect(page.get_by_role("button", name="Take command")).to_be_visible()
    expect(page.get_by_test_id("machine")).to_have_text("machine: off")
    n_before = len(session.logged())
    page.get_by_test_id("stop").click()
    expect(page.get_by_text("STOP of the machine").first).to_be_visible()
    page.keyboard.press("Escape")  # he does not command, and may only have closed a menu
    page.get_by_role("button", name="Take command").click()
    expect(page.get_by_role("button", name="Give command back")).to_be_visible()
    assert [line["order"] for line in session.logged()[n_before:]] == ["stop", "take"]
    page.keyboard.press("Escape")
    expect(page.locator(".q-notification__badge")).to_have_text("2")  # the same words once more
    assert [line["order"] for line in session.logged()[n_before:]] == ["stop", "take", "stop"]


def test_stop_gets_past_connections_that_say_nothing(
    session: PanelSession, open_window: OpenWindow
) -> None:
    """128 of them keep new ones out for a while; the page that is open has its own."""
    page = open_window().page
    page.goto(f"{session.origin}/design#token={session.token}")
    expect(page.get_by_test_id("machine")).to_have_text("machine: off")
    n_before, place = len(session.logged()), urlsplit(session.origin)
    assert place.hostname is not None
    assert place.port is not None
    with ExitStack() as mute:
        for _ in range(128):
            mute.enter_context(socket.create_connection((place.hostname, place.port)))
        page.get_by_test_id("stop").click()
        expect(page.get_by_text("STOP of the machine").first).to_be_visible()
    assert [line["order"] for line in session.logged()[n_before:]] == ["stop"]


def test_runs_say_what_to_do_and_end_no_machine(
    session: PanelSession, open_window: OpenWindow
) -> None:
    """What ends a simulation is not called as the machine's STOP."""
    page = open_window().page
    page.goto(f"{session.origin}/runs#token={session.token}")
    expect(page.get_by_test_id("stop-run")).to_contain_text("End the simulation")
    expect(page.get_by_role("button", name="stop")).to_have_count(1)
