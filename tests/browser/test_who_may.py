"""Command, open questions and names of strangers, as visitors meet them."""

import struct
import zlib

import pytest
from playwright.sync_api import Page, expect

from camtools.link.download import download, select_table
from camtools.pipeline.load import load, make
from tests.browser.panel_page import command, give, order
from tests.browser.panel_session import PanelSession
from tests.browser.windows import OpenWindow
from tests.tools.cases.part_cases import PERKINS

pytestmark = pytest.mark.long

HOSTILE = "<img src=x onerror=hacked=1>"


def press(page: Page, words: str) -> None:
    """Press the frame's button."""
    page.get_by_role("button", name=words).click()


def test_the_command_is_taken_over_visibly_and_free_when_its_page_goes(
    session: PanelSession, open_window: OpenWindow
) -> None:
    """The loser reads who has it; when that one leaves, nobody does."""
    first, second, viewer = (open_window().page for _ in range(3))
    for page in (first, second, viewer):
        page.goto(session.url)
    press(first, "Take command")
    expect(first.get_by_text("you command").first).to_be_visible()
    expect(viewer.get_by_text("commands", exact=False).first).to_be_visible()
    press(second, "Take over")
    second.get_by_test_id("question-yes").click()
    expect(second.get_by_text("you command").first).to_be_visible()
    expect(first.get_by_text("took over command").first).to_be_visible()
    second.close()
    for page in (first, viewer):
        expect(page.get_by_text("nobody commands").first).to_be_visible()
    while (orders := [line["order"] for line in session.logged()][-3:])[-1] == "take_over":
        viewer.wait_for_timeout(50)
    assert orders == ["take", "take_over", "lose"]


def test_command_and_an_open_question_outlive_the_page(
    session: PanelSession, open_window: OpenWindow
) -> None:
    """A connection that is lost and a page that is loaded anew; the answer then counts."""
    page = open_window().page
    command(page, session)
    give(page, session, "enable", "ready")
    order(page, "start").click()
    question = page.get_by_test_id("question-yes")
    expect(question).to_be_visible()
    page.evaluate("window.socket.io.engine.close()")
    page.wait_for_function("() => window.did_handshake && window.socket.connected")
    expect(question).to_be_visible()
    page.reload()
    expect(question).to_be_visible()
    question.click()
    session.wait_for_state("cutting")


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
        page.goto(session.url)
        expect(page.get_by_text(HOSTILE, exact=False).first).to_be_visible()
        assert page.evaluate("window.hacked === undefined")
        assert page.locator("img[src='x']").count() == 0
    finally:
        download(session.witness, image, lambda stored, seconds: None)
        select_table(session.witness)
        session.witness.rights.release()
