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


PLACES = {"GET": "/", "HEAD": "/", "WS": SOCKET, "POST": UPLOAD}
FAIR = {"origin": ORIGIN, "content-length": "10"}
LINK = {"sec-fetch-mode": "navigate", "sec-fetch-dest": "document"}
OTHER_UPLOAD = UPLOAD.replace(CLIENT, CLIENT[::-1].replace("-", "0")[:36])
# DNS rebinding: the page of a stranger has the stranger's name, wherever it leads.
STRANGERS = (
    "evil.example",
    "evil.example:8417",
    "127.0.0.1",
    "127.0.0.1:80",
    "localhost.evil:8417",
)
# A page of another port of this computer is another site, too.
ORIGINS = ("http://evil.example", "null", "https://127.0.0.1:8417", "http://127.0.0.1:8418", "")
# Method, path, headers beside our Host, and the status of the answer.
VISITS: list[tuple[str, str, dict[str, str], int]] = [
    *(
        (method, path, {"host": host, "origin": f"http://{host}"}, 403)
        for method, path in PLACES.items()
        for host in STRANGERS
    ),
    *(
        (method, PLACES[method], {"origin": origin, "content-length": "0"}, 403)
        for method in ("GET", "WS", "POST")
        for origin in (*ORIGINS, "file://")
    ),
    # Browsers send our origin to a websocket; what has none is no page.
    ("WS", SOCKET, {"origin": ORIGIN}, 101),
    ("WS", SOCKET, {}, 403),
    ("WS", "/", {"origin": ORIGIN}, 403),
    # No method that changes anything; nothing is posted but uploads, and socket.io is not polled.
    *(
        (method, "/", {"origin": ORIGIN}, 405)
        for method in ("PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "CONNECT")
    ),
    *(
        ("POST", path, {"origin": ORIGIN, "content-length": "0"}, 403)
        for path in ("/", "/design", SOCKET, f"{UPLOAD}/../8", "/_nicegui/client/x/upload/7")
    ),
    ("GET", SOCKET, {}, 403),
    # An upload needs our origin, the token of the page in its path, and a fair size.
    ("POST", UPLOAD, FAIR, 200),
    ("POST", UPLOAD, {"content-length": "10"}, 403),
    ("POST", OTHER_UPLOAD, FAIR, 403),
    *(
        ("POST", UPLOAD, FAIR | {"content-length": length}, 413)
        for length in (str(MOST_UPLOAD_BYTES + 1), "-1", "x", "", "9" * 5000, "\u00b2")
    ),
    # Other sites may link here; no picture, script, frame or fetch of theirs gets an answer.
    *(
        ("GET", "/", LINK | {"sec-fetch-site": site} | more, wanted)
        for site in ("cross-site", "same-site")
        for more, wanted in (
            ({}, 200),
            ({"sec-fetch-dest": "iframe"}, 403),
            ({"sec-fetch-mode": "no-cors", "sec-fetch-dest": "image"}, 403),
        )
    ),
    ("GET", "/", {"sec-fetch-site": "same-origin", "sec-fetch-mode": "cors"}, 200),
]


@pytest.mark.parametrize(("method", "path", "headers", "wanted"), VISITS)
def test_only_our_own_pages_are_served(
    method: str, path: str, headers: dict[str, str], wanted: int
) -> None:
    """Each visit has its answer."""
    assert Visit(path, {"host": HOST} | headers, method).status == wanted


@pytest.mark.parametrize(("method", "path"), PLACES.items())
def test_a_visit_without_a_host_is_refused(method: str, path: str) -> None:
    """Whatever it asks for."""
    assert Visit(path, {}, method).status == 403


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


def test_an_upload_that_lies_about_its_size_is_broken_off() -> None:
    """What comes is counted, whatever was announced."""
    headers = {"host": HOST, "origin": ORIGIN, "content-length": "10"}
    body = (b"x" * (MOST_UPLOAD_BYTES // 2 + 1),) * 2
    assert Visit(UPLOAD, headers, "POST", body).status == 413


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
