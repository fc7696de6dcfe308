# SPDX-License-Identifier: Apache-2.0
"""Token, command and names of strangers, as visitors meet them in their browsers."""

import struct
import threading
import zlib
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from playwright.sync_api import Page, expect

from camtools.link.controller import Link
from camtools.link.download import download, select_table
from camtools.pipeline.load import load
from camtools.pipeline.make_table import make
from tests.browser.panel_page import press_until
from tests.browser.panel_session import PanelSession
from tests.browser.windows import OpenWindow
from tests.tools.cases.part_cases import PERKINS

GONE_MS = 30_000  # a page is gone when its connection does not come back
HOSTILE = "<img src=x onerror=hacked=1>"


def command(page: Page, words: str) -> None:
    """Press the frame's button."""
    page.get_by_role("button", name=words).click()


@contextmanager
def commanding(link: Link) -> Iterator[None]:
    """Take command over as sender 7, and keep it by heartbeats until another takes it over."""
    is_over = threading.Event()

    def keep() -> None:
        while not is_over.is_set():
            link.wait(lambda: False, 0.1)

    link.rights.sender = 7
    link.rights.take(over=True)
    thread = threading.Thread(target=keep)
    thread.start()
    try:
        yield
    finally:
        is_over.set()
        thread.join()


@pytest.fixture(autouse=True)
def off(session: PanelSession) -> None:
    """Begin in off, whatever the test before has left."""
    session.calm()


def test_the_token_leaves_the_address_and_stays_in_its_tab(
    session: PanelSession, open_window: OpenWindow
) -> None:
    """It lets in, also after a reload; it is in no other tab, no storage that lasts, no cookie."""
    page = open_window().page
    page.goto(session.url)
    expect(page.get_by_role("button", name="Take command")).to_be_visible()
    assert session.token not in page.url and session.token not in page.content()
    page.reload()
    expect(page.get_by_role("button", name="Take command")).to_be_visible()
    stored = page.evaluate("[JSON.stringify(localStorage), document.cookie]")
    assert session.token not in "".join(stored)
    other = page.context.new_page()
    other.goto(session.origin)
    expect(other.get_by_test_id("state")).to_have_text("off", ignore_case=True)  # it is alive
    other.get_by_label("token").fill("wrong")
    other.get_by_label("token").press("Enter")
    expect(other.get_by_text("the token is wrong", exact=True)).to_be_visible()
    other.get_by_label("token").fill(session.token)
    other.get_by_label("token").press("Enter")
    expect(other.get_by_role("button", name="Take command")).to_be_visible()
    assert session.token not in session.log.read_text("utf-8")


def test_the_command_is_taken_over_visibly_and_free_when_its_page_goes(
    session: PanelSession, open_window: OpenWindow
) -> None:
    """The loser reads who has it; when that one leaves, nobody does."""
    first, second, viewer = (open_window().page for _ in range(3))
    for page in (first, second):
        page.goto(session.url)
    viewer.goto(session.origin)
    command(first, "Take command")
    expect(first.get_by_text("you command").first).to_be_visible()
    expect(viewer.get_by_text("commands", exact=False).first).to_be_visible()
    command(second, "Take over")
    second.get_by_test_id("question-yes").click()
    expect(second.get_by_text("you command").first).to_be_visible()
    expect(first.get_by_text("took over command").first).to_be_visible()
    second.close()
    for page in (first, viewer):
        expect(page.get_by_text("nobody commands").first).to_be_visible(timeout=GONE_MS)
    while (orders := [line["order"] for line in session.logged()][-3:])[-1] == "take_over":
        viewer.wait_for_timeout(50)
    assert orders == ["take", "take_over", "lose"]


def test_a_jog_ends_with_its_page(session: PanelSession, open_window: OpenWindow) -> None:
    """The window is closed while the button is held: the axis stands, the log says why."""
    page = open_window().page
    page.goto(session.url)
    command(page, "Take command")
    session.wait_for_state("off")
    page.get_by_role("button", name="By hand").first.click()
    session.wait_for_state("manual")
    before = session.status().signals["x"]
    button = page.get_by_test_id("jog-xplus")
    expect(button).to_be_enabled()
    witness = session.witness
    press_until(
        page,
        button,
        lambda seconds: witness.wait(
            lambda: abs(witness.status.signals["x"] - before) > 0.05, seconds
        ),
    )
    page.close()
    last = None
    while last != (last := session.status().signals["x"]):
        session.witness.wait(lambda: False, 0.6)
    jog = [line for line in session.logged() if line["order"] == "jog_begin"][-1]
    assert jog["outcome"].endswith(
        ("the page was closed", "nothing was heard from the page for 250 ms", "released")
    )
    again = open_window().page
    again.goto(session.url)
    command(again, "Take command")
    again.get_by_role("button", name="Disable").first.click()
    session.wait_for_state("off")


def test_a_name_that_is_code_is_shown_as_text(
    session: PanelSession, open_window: OpenWindow
) -> None:
    """Of a table on every page; nothing of it becomes an element."""
    image = make(load(PERKINS), PERKINS).files(with_plots=False)["perkins240.camtab"]
    hostile = bytearray(image)
    hostile[32:64] = HOSTILE.encode().ljust(32, b"\0")
    struct.pack_into("<I", hostile, 20, zlib.crc32(hostile[24:]))
    try:
        download(session.witness, bytes(hostile), lambda stored, seconds: None)
        select_table(session.witness)
        session.witness.rights.release()
        page = open_window().page
        page.goto(session.origin)
        expect(page.get_by_text(HOSTILE, exact=False).first).to_be_visible()
        assert page.evaluate("window.hacked === undefined")
        assert page.locator("img[src='x']").count() == 0
    finally:
        download(session.witness, image, lambda stored, seconds: None)
        select_table(session.witness)
        session.witness.rights.release()


def test_another_program_that_takes_over_is_seen_and_taken_over_from(
    session: PanelSession, open_window: OpenWindow
) -> None:
    """The page tells the sender, its orders are off; after a question it commands again."""
    page = open_window().page
    page.goto(session.url)
    command(page, "Take command")
    expect(page.get_by_text("you command").first).to_be_visible()
    expect(page.get_by_test_id("do-manual")).to_be_enabled()
    with commanding(session.witness):
        news = page.get_by_text("sender 7 has taken it over", exact=False).first
        expect(news).to_be_visible()
        expect(page.get_by_text("sender 7 commands the controller").first).to_be_visible()
        expect(page.get_by_test_id("do-manual")).to_be_disabled()
        command(page, "Take over")
        page.get_by_test_id("question-yes").click()
        expect(page.get_by_text("you command").first).to_be_visible()
        expect(page.get_by_test_id("do-manual")).to_be_enabled()
