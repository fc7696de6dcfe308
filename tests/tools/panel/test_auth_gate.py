# SPDX-License-Identifier: Apache-2.0
"""What passes the gate and what does not; after it every request is served."""

import asyncio
from typing import Any

import pytest

from camtools.panel.access.auth_gate import MOST_UPLOAD_BYTES, REPORTS, AuthGate

HOST = "127.0.0.1:8417"
ORIGIN = f"http://{HOST}"
CLIENT = "0f0e0d0c-0b0a-4908-8706-050403020100"
UPLOAD = f"/_nicegui/client/{CLIENT}/upload/7"
SOCKET = "/_nicegui_ws/socket.io/"


async def _everything(scope: Any, receive: Any, send: Any) -> None:  # noqa: ANN401
    """Take what comes, and answer 200."""
    if scope["type"] == "websocket":
        await send({"type": "websocket.accept"})
        return
    while (await receive()).get("more_body"):
        pass
    headers = [(b"content-type", b"text/html"), (b"x-frame-options", b"ALLOWALL")]
    await send({"type": "http.response.start", "status": 200, "headers": headers})
    await send({"type": "http.response.body", "body": b"in"})


class Visit:
    """One request or websocket through the gate.

    Attributes
    ----------
    status : int
        of the answer; of a websocket 101 when it was accepted, 403 when not
    headers : dict
        of the answer
    """

    def __init__(
        self,
        path: str,
        headers: dict[str, str],
        method: str = "GET",
        body: tuple[bytes, ...] = (b"",),
        *,
        is_full: bool = False,
    ) -> None:
        self.status, self.headers = 0, dict[str, str]()
        kind = "websocket" if method == "WS" else "http"
        raw = [(name.encode(), value.encode("latin-1")) for name, value in headers.items()]
        scope = {"type": kind, "method": method, "path": path, "headers": raw}
        messages = [
            {"type": "http.request", "body": part, "more_body": i + 1 < len(body)}
            for i, part in enumerate(body)
        ]

        async def receive() -> Any:  # noqa: ANN401
            return messages.pop(0) if kind == "http" else {"type": "websocket.connect"}

        async def send(message: Any) -> None:  # noqa: ANN401
            if message["type"] == "http.response.start":
                self.status = message["status"]
                self.headers = {a.decode(): b.decode() for a, b in message["headers"]}
            elif message["type"].startswith("websocket."):
                self.status = 101 if message["type"] == "websocket.accept" else 403

        door = AuthGate(_everything, {HOST}, lambda client: client == CLIENT, lambda: is_full)
        asyncio.run(door(scope, receive, send))


def status(path: str, method: str = "GET", **headers: str) -> int:
    """Return the status of a request with our Host and some more headers."""
    more = {name.replace("_", "-"): value for name, value in headers.items()}
    return Visit(path, {"host": HOST} | more, method).status


@pytest.mark.parametrize("method", ["GET", "HEAD", "WS", "POST"])
@pytest.mark.parametrize(
    "host",
    ["evil.example", "evil.example:8417", "127.0.0.1", "127.0.0.1:80", "localhost.evil:8417"],
)
def test_a_name_that_was_made_to_point_here_is_refused(method: str, host: str) -> None:
    """DNS rebinding: the page of a stranger has the stranger's name, wherever it leads."""
    path = {"WS": SOCKET, "POST": UPLOAD}.get(method, "/")
    assert Visit(path, {"host": host, "origin": f"http://{host}"}, method).status == 403
    assert Visit(path, {}, method).status == 403


@pytest.mark.parametrize(
    "origin",
    [
        "http://evil.example",
        "null",
        "https://127.0.0.1:8417",
        "http://127.0.0.1:8418",
        "",
        "file://",
    ],
)
@pytest.mark.parametrize("method", ["GET", "WS", "POST"])
def test_what_comes_from_another_origin_is_refused(method: str, origin: str) -> None:
    """Also a page of another port of this computer is another site."""
    path = {"WS": SOCKET, "POST": UPLOAD}.get(method, "/")
    assert status(path, method, origin=origin, content_length="0") == 403


def test_a_websocket_needs_our_origin_and_its_own_path() -> None:
    """Browsers always send it; what has none is no page."""
    assert status(SOCKET, "WS", origin=ORIGIN) == 101
    assert status(SOCKET, "WS") == 403
    assert status("/", "WS", origin=ORIGIN) == 403


def test_a_header_that_comes_twice_is_not_believed() -> None:
    """Whoever looks at the first one and whoever looks at the last one would disagree."""

    async def visit() -> int:
        found = []

        async def send(message: Any) -> None:  # noqa: ANN401
            found.append(message.get("status"))

        headers = [(b"host", HOST.encode()), (b"host", b"evil.example")]
        scope = {"type": "http", "method": "GET", "path": "/", "headers": headers}
        await AuthGate(_everything, {HOST})(scope, send, send)  # type: ignore[arg-type]
        return int(found[0])

    assert asyncio.run(visit()) == 403


@pytest.mark.parametrize("method", ["PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "CONNECT"])
def test_no_method_that_changes_anything(method: str) -> None:
    """With our origin, too."""
    assert status("/", method, origin=ORIGIN) == 405


@pytest.mark.parametrize(
    "path", ["/", "/design", SOCKET, f"{UPLOAD}/../8", "/_nicegui/client/x/upload/7"]
)
def test_nothing_is_posted_but_uploads(path: str) -> None:
    """The polling of socket.io would be a POST that carries orders: it does not exist here."""
    assert status(path, "POST", origin=ORIGIN, content_length="0") == 403


def test_socket_io_is_not_polled() -> None:
    """Nor read by GET."""
    assert status(SOCKET) == 403


def test_an_upload_needs_origin_token_and_a_fair_size() -> None:
    """The token: of the page whose identifier is in the path."""
    fair = {"origin": ORIGIN, "content_length": "10"}
    assert status(UPLOAD, "POST", **fair) == 200
    assert status(UPLOAD, "POST", content_length="10") == 403
    other = UPLOAD.replace(CLIENT, CLIENT[::-1].replace("-", "0")[:36])
    assert status(other, "POST", **fair) == 403
    for length in (str(MOST_UPLOAD_BYTES + 1), "-1", "x", "", "9" * 5000, "\u00b2"):
        assert status(UPLOAD, "POST", origin=ORIGIN, content_length=length) == 413


def test_an_upload_that_lies_about_its_size_is_broken_off() -> None:
    """What comes is counted, whatever was announced."""
    headers = {"host": HOST, "origin": ORIGIN, "content-length": "10"}
    body = (b"x" * (MOST_UPLOAD_BYTES // 2 + 1),) * 2
    assert Visit(UPLOAD, headers, "POST", body).status == 413


@pytest.mark.parametrize("site", ["cross-site", "same-site"])
def test_other_sites_may_link_here_and_nothing_else(site: str) -> None:
    """No picture, script, frame or fetch of another site gets an answer, so none fills memory."""
    link = {"sec_fetch_site": site, "sec_fetch_mode": "navigate", "sec_fetch_dest": "document"}
    assert status("/", **link) == 200
    assert status("/", **link | {"sec_fetch_dest": "iframe"}) == 403
    assert status("/", **link | {"sec_fetch_mode": "no-cors", "sec_fetch_dest": "image"}) == 403
    assert status("/", sec_fetch_site="same-origin", sec_fetch_mode="cors") == 200


def test_when_too_many_pages_are_open_no_more_are_made() -> None:
    """What the open ones need is still served."""
    assert Visit("/", {"host": HOST}, is_full=True).status == 503
    assert Visit("/_nicegui/x.js", {"host": HOST}, is_full=True).status == 200


def test_answers_keep_pages_to_themselves() -> None:
    """No frame, no guess of types, no referrer; scripts from here or with the nonce only."""
    first, second = (Visit("/", {"host": HOST}).headers for _ in range(2))
    assert first["x-frame-options"] == "DENY"
    assert first["x-content-type-options"] == "nosniff"
    assert first["referrer-policy"] == "no-referrer"
    own = first["content-security-policy"]
    assert own != second["content-security-policy"], "the nonce is new each time"
    scripts = own.split("; ")[1]
    assert scripts.startswith("script-src 'self' 'nonce-") and "unsafe-inline" not in scripts
    for part in ("default-src 'none'", "base-uri 'none'", "form-action 'none'"):
        assert part in own.split("; ")
    assert "frame-ancestors 'none'" in own


def test_a_report_runs_its_scripts_in_a_room_of_their_own() -> None:
    """Its origin is nobody's, it reaches no network, and only our pages frame it."""
    headers = Visit(f"{REPORTS}1/page.html", {"host": HOST}).headers
    own = headers["content-security-policy"]
    assert "sandbox allow-scripts" in own and "allow-same-origin" not in own
    assert "default-src 'none'" in own and "connect-src" not in own
    assert headers["x-frame-options"] == "SAMEORIGIN" and "frame-ancestors 'self'" in own
