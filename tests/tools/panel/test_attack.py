# SPDX-License-Identifier: Apache-2.0
"""Attacks on a panel that runs: by other sites, by viewers, by who speaks to its socket."""

import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack
from urllib.parse import urlsplit

import pytest
from websockets.exceptions import ConnectionClosed

from camtools.panel.access.connections import MOST_CONNECTIONS
from camtools.panel.orders.controller_service import NO_TOKEN
from checks.patience import limit_s, until
from tests.browser.panel_session import Panel, panel_alone
from tests.tools.cases.raw_page import RawPage, get


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Panel]:
    """Run a panel; no order needs a controller to be refused for the right reason."""
    with panel_alone(tmp_path_factory.mktemp("panel")) as one:
        yield one


def hello(page: RawPage, token: str) -> dict[str, object]:
    """Return what a page says when it connects."""
    return {"token": token, "sent_ms": 1.0}


def until_logged(session: Panel, order: str, n: int = 1) -> None:
    """Wait until an order is in the log."""
    until(lambda: [line["order"] for line in session.logged()].count(order) >= n, order)


def until_quiet(session: Panel) -> None:
    """Wait until nothing was logged for a second and a half."""
    n, since_s = len(session.logged()), time.monotonic()
    while time.monotonic() - since_s < 1.5:
        time.sleep(0.05)
        if n != (n := len(session.logged())):
            since_s = time.monotonic()


def button(page: RawPage, label: str) -> tuple[int, str]:
    """Return number and click listener of a button."""
    for number, event in page.listeners():
        text = page.elements[str(number)].get("props", {}).get("label")
        if text == label and event["type"] == "click":
            return number, event["listener_id"]
    raise AssertionError(label)


def test_only_pages_of_the_panel_open_its_websocket(session: Panel) -> None:
    """A page of another site cannot forge its origin; no program without one is a page."""
    page = RawPage(session.origin)
    assert page.is_let_in()
    for origin in ("http://evil.example", "null", session.origin + "0", None):
        assert not RawPage(session.origin).is_let_in(origin)


def test_a_page_that_is_known_by_its_identifier_cannot_be_stolen(session: Panel) -> None:
    """Another socket neither becomes that page nor speaks for it."""
    victim, thief = RawPage(session.origin), RawPage(session.origin)
    with victim.connected() as own, thief.connected() as other:
        own.say("panel_hello", hello(victim, session.token))
        own.hear_until("Take command")
        number, listener = button(victim, "Take command")
        before = len(session.logged())
        assert not thief.is_let_in(client_id=victim.client_id)
        other.event(number, listener, {}, client_id=victim.client_id)
        other.emit("javascript_response", {"client_id": victim.client_id, "request_id": "x"})
        other.emit("handshake", {"client_id": victim.client_id, "tab_id": thief.tab_id})
        other.event(number, listener, {}, client_id="no such page")
        own.event(number, listener, {})
        until_logged(session, "take", 1)
        lines = session.logged()[before:]
        assert [line["order"] for line in lines] == ["take"]
        own.event(number, listener, {})
        until_logged(session, "release", 1)


@pytest.mark.long
@pytest.mark.parametrize(
    "path", ["/", *(pytest.param(one, marks=pytest.mark.long) for one in ("/design", "/runs"))]
)
def test_a_viewer_who_sends_every_event_of_his_page_does_nothing(session: Panel, path: str) -> None:
    """Hidden and disabled buttons, too: rights are checked where orders are carried out."""
    page = RawPage(session.origin, path)
    before = len(session.logged())
    with page.connected() as own:
        for number, event in page.listeners():
            for args in ((), ({},), (True,), ("x",), ({"token": None, "phase": "begin"},)):
                own.event(number, event["listener_id"], *args)
        for name in ("enable", "jog", "stop"):
            own.say(name, {"press": 1, "axis": "x"})
        until_quiet(session)  # of one address a line a second is written
        own.say("panel_hello", hello(page, "wrong"))
        until_logged(session, "token")
    lines = session.logged()[before:]
    assert not any(line["is_done"] for line in lines)
    assert {line["outcome"] for line in lines} <= {NO_TOKEN, "the token is wrong"}, lines
    assert session.token not in session.log.read_text("utf-8")


def test_messages_that_are_none_end_nothing(session: Panel) -> None:
    """The panel goes on for all others, and prints no page of a stack for each."""
    page = RawPage(session.origin)
    with page.connected() as own:
        nothing: tuple[object, ...] = (None, 7, "x", [], {}, {"client_id": 7})
        for message in (*nothing, {"client_id": page.client_id}):
            for name in ("event", "ack", "log", "javascript_response", "handshake", "nosuch"):
                own.emit(name, message)
        for args in (["{"], "x", [7], None, [None], {"a": 1}):
            told = {"id": 0, "client_id": page.client_id, "listener_id": "x", "args": args}
            own.emit("event", told)
        own.say("panel_hello", None)
        own.say("panel_hello", {"token": {"a": []}, "sent_ms": "x"})
        own.say("panel_hello", {"token": "x" * 30_000, "sent_ms": 1e308})
    assert RawPage(session.origin).is_let_in()


def test_a_message_that_is_too_long_ends_its_own_connection(session: Panel) -> None:
    """Memory is bounded; a page of the panel says little."""
    page = RawPage(session.origin)
    with page.connected() as own, pytest.raises(ConnectionClosed):
        own.socket.send("42" + "x" * 300_000)
        while True:
            own.hear()
    assert RawPage(session.origin).is_let_in()


_UP = ("..", "%2e%2e", "..%2f..", "%2e%2e%2f%2e%2e", "..\\..", "%252e%252e", "....//", "..;")


@pytest.mark.parametrize(
    "base", ["/panel", "/_nicegui/3.18.0/static", "/reports", "/reports/x", ""]
)
def test_no_path_leads_out_of_its_folder(session: Panel, base: str) -> None:
    """However it is written."""
    for up in _UP:
        for depth, target in ((4, "etc/passwd"), (1, "server.py")):
            path = "/".join([base, *[up] * depth, target])
            status, content = get(session.origin, path)
            assert status in (400, 403, 404), path
            assert b"root:" not in content and b"import" not in content[:2000], path


def test_files_are_taken_from_pages_with_the_token_only(session: Panel) -> None:
    """A viewer's upload is refused, and so is one that says that it is huge."""
    page = RawPage(session.origin)
    with page.connected():
        for number in page.elements:
            path = f"/_nicegui/client/{page.client_id}/upload/{number}"
            for n in (10, 10**9):
                status, _ = get(
                    session.origin, path, "POST", b"0123456789", Origin=session.origin,
                    Content_Length=str(n),
                )  # fmt: skip
                assert status == 403


def test_what_a_proxy_would_say_is_not_believed(session: Panel) -> None:
    """Neither another address in the log nor another place of scripts."""
    status, content = get(
        session.origin, "/", X_Forwarded_For="8.8.8.8", X_Forwarded_Prefix="/evil", Forwarded="x"
    )
    assert status == 200 and b"evil" not in content
    page = RawPage(session.origin)
    with page.connected() as own:
        time.sleep(1.1)
        own.say("panel_hello", hello(page, "wrong"))
        until_logged(session, "token")
    assert {line["address"] for line in session.logged()} == {"127.0.0.1"}


def is_closed(line: socket.socket) -> bool:
    """Wait for the end of a connection; return whether it came without an answer."""
    try:
        return line.recv(1) == b""
    except ConnectionResetError:
        return True


@pytest.mark.long
def test_idle_connections_are_bounded_and_ended(session: Panel) -> None:
    """Who sends a byte at a time, or nothing, is dropped; then others are served again."""
    place = urlsplit(session.origin)
    with ExitStack() as stack:
        lines = []
        for i in range(MOST_CONNECTIONS + 20):
            line = socket.create_connection((place.hostname, place.port), timeout=limit_s())
            stack.enter_context(line)
            line.sendall(b"GET / HTTP/1.1\r\nHost: " if i % 2 else b"")
            lines.append(line)
        assert is_closed(lines[-1]), "one too many is closed at once"
        assert is_closed(lines[0]), "an idle one is closed later"
    assert get(session.origin, "/panel/panel.js")[0] == 200


@pytest.mark.long
def test_pages_that_never_connect_are_bounded(session: Panel) -> None:
    """Their number ends, the memory that they take with it; those that are open go on."""
    page = RawPage(session.origin)
    with page.connected() as own:
        statuses = [200]
        while statuses[-1] == 200 and len(statuses) < 60:
            statuses.append(get(session.origin, "/runs")[0])
        assert statuses[-1] == 503
        own.say("panel_hello", hello(page, session.token))
        own.hear_until("Take command")
