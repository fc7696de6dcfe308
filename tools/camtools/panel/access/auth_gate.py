# SPDX-License-Identifier: Apache-2.0
"""The doorway: every request and every websocket passes it before anything else sees them.

- The header Host must be one of ours: a name of a stranger that was made to point at this computer
  (DNS rebinding) is refused.
- A websocket must say that a page of ours opens it (Origin), and so must an upload. Pages of other
  sites cannot forge that. What names no origin, or another one, is refused.
- There are GET and HEAD, and POST for the upload of a file into an open page that has the token.
  No request changes anything else: orders travel over the websocket of a page only.
- Other sites may link here; they may not embed what is here, nor make it part of their pages.
- Answers say what a page may load and who may frame it.

>>> policy("abc", "127.0.0.1:8417").split("; ")[0:2]
["default-src 'none'", "script-src 'self' 'nonce-abc' 'unsafe-eval'"]
"""

from __future__ import annotations

import re
import secrets
from collections.abc import Callable, Collection

from starlette.types import ASGIApp, Message, Receive, Scope, Send

REPORTS = "/reports/"  # reports are served below; they run scripts, but in a room of their own
NONCE = "camturn.nonce"  # key in the scope of a request
MOST_UPLOAD_BYTES = 17 << 20
_UPLOAD = re.compile(r"/_nicegui/client/([0-9a-f-]{36})/upload/\d+")
_LENGTH = re.compile(r"[0-9]{1,9}")
_SOCKET = "/_nicegui_ws/"
_NONCE_BYTES = 16
_REPORT_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'self'; sandbox allow-scripts"
)
_ALWAYS = {
    b"x-content-type-options": b"nosniff",
    b"referrer-policy": b"no-referrer",
    b"cross-origin-opener-policy": b"same-origin",
    b"cross-origin-resource-policy": b"same-origin",
    b"permissions-policy": b"camera=(), microphone=(), geolocation=(), usb=(), serial=()",
}


def policy(nonce: str, host: str) -> str:
    """Return the content security policy of a page.

    NiceGUI compiles templates and handlers in the browser, hence unsafe-eval; Quasar and Vue set
    styles, hence unsafe-inline for those. Scripts come from here, or carry the nonce of the answer.
    """
    return "; ".join(
        (
            "default-src 'none'",
            f"script-src 'self' 'nonce-{nonce}' 'unsafe-eval'",
            "style-src 'self' 'unsafe-inline'",
            "img-src 'self' data: blob:",
            "font-src 'self'",
            f"connect-src 'self' ws://{host}",
            "frame-src 'self'",
            "base-uri 'none'",
            "form-action 'none'",
            "frame-ancestors 'none'",
        )
    )


class _TooLarge(Exception):  # noqa: N818 - it ends a request, it is no error of the program
    """A body is larger than it may be."""


class AuthGate:
    """Middleware around the whole application.

    Parameters
    ----------
    app : ASGI application
        behind the door
    hosts : collection of str
        what the header Host may be, in lower case: name and port
    may_upload : callable
        tells whether the page with an identifier may upload a file
    is_full : callable
        tells whether so many pages are open that no more may be
    """

    def __init__(
        self,
        app: ASGIApp,
        hosts: Collection[str],
        may_upload: Callable[[str], bool] = lambda client: False,
        is_full: Callable[[], bool] = lambda: False,
    ) -> None:
        self._app, self._hosts = app, frozenset(hosts)
        self._origins = frozenset(f"http://{host}" for host in hosts)
        self._may_upload, self._is_full = may_upload, is_full

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a request or a websocket pass, or refuse it."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        headers = _headers(scope)
        refusal = self._refusal(scope, headers)
        if refusal is not None:
            await _refuse(scope, receive, send, *refusal)
            return
        # What a proxy would say is not believed: there is none.
        scope["headers"] = [one for one in scope["headers"] if not one[0].startswith(b"x-f")]
        if scope["type"] == "websocket":
            await self._app(scope, receive, send)
            return
        nonce = secrets.token_urlsafe(_NONCE_BYTES)
        scope[NONCE] = nonce
        sending = _Sending(send, scope["path"], policy(nonce, headers["host"]))
        try:
            await self._app(scope, _bounded(receive), sending)
        except _TooLarge:
            if not sending.is_begun:
                await _refuse(scope, receive, send, 413, "the file is too large")

    def _refusal(self, scope: Scope, headers: dict[str, str]) -> tuple[int, str] | None:
        """Return status and reason, or nothing where all is well."""
        if headers.get("host", "").lower() not in self._hosts:
            return 403, "this is not the host that you asked for"
        origin = headers.get("origin")
        if origin is not None and origin.lower() not in self._origins:
            return 403, "pages of other sites have nothing to do here"
        if scope["type"] == "websocket":
            is_ours = origin is not None and scope["path"].startswith(_SOCKET)
            return None if is_ours else (403, "only pages of this panel open a websocket")
        return self._refusal_of_http(scope, headers, origin)

    def _refusal_of_http(
        self, scope: Scope, headers: dict[str, str], origin: str | None
    ) -> tuple[int, str] | None:
        path: str = scope["path"]
        if path.startswith(_SOCKET):
            return 403, "only websockets lead there"
        if scope["method"] == "POST":
            upload = _UPLOAD.fullmatch(path)
            if upload is None or origin is None or not self._may_upload(upload[1]):
                return 403, "files are taken from open pages with the token only"
            length = headers.get("content-length", "")
            is_fair = _LENGTH.fullmatch(length) and int(length) <= MOST_UPLOAD_BYTES
            return None if is_fair else (413, f"at most {MOST_UPLOAD_BYTES} bytes")
        if scope["method"] not in ("GET", "HEAD"):
            return 405, "this method does not exist here"
        if headers.get("sec-fetch-site") in ("cross-site", "same-site"):
            is_link = headers.get("sec-fetch-dest") == "document"
            if headers.get("sec-fetch-mode") != "navigate" or not is_link:
                return 403, "pages of other sites have nothing to do here"
        if not path.startswith("/_nicegui/") and self._is_full():
            return 503, "too many pages are open; close some"
        return None


def _headers(scope: Scope) -> dict[str, str]:
    """Return the headers; of one that comes twice nothing that would be believed."""
    found: dict[str, str] = {}
    for raw_name, raw_value in scope["headers"]:
        name = raw_name.decode("latin-1").lower()
        found[name] = "twice" if name in found else raw_value.decode("latin-1")
    return found


class _Sending:
    """Sends an answer with the headers of the door."""

    def __init__(self, send: Send, path: str, page_policy: str) -> None:
        self._send, self._is_report = send, path.startswith(REPORTS)
        self._policy = _REPORT_POLICY if self._is_report else page_policy
        self.is_begun = False

    async def __call__(self, message: Message) -> None:
        if message["type"] == "http.response.start":
            self.is_begun = True
            own = _ALWAYS | {
                b"content-security-policy": self._policy.encode("latin-1"),
                b"x-frame-options": b"SAMEORIGIN" if self._is_report else b"DENY",
            }
            rest = [one for one in message["headers"] if one[0].lower() not in own]
            message["headers"] = [*rest, *own.items()]
        await self._send(message)


def _bounded(receive: Receive) -> Receive:
    """Return a receiver that ends a body which is larger than it may be."""
    n = 0

    async def bounded() -> Message:
        nonlocal n
        message = await receive()
        n += len(message.get("body", b""))
        if n > MOST_UPLOAD_BYTES:
            raise _TooLarge
        return message

    return bounded


async def _refuse(scope: Scope, receive: Receive, send: Send, status: int, reason: str) -> None:
    if scope["type"] == "websocket":
        await receive()
        await send({"type": "websocket.close", "code": 1008, "reason": reason})
        return
    body = f"{reason}\n".encode()
    headers = [
        (b"content-type", b"text/plain; charset=utf-8"),
        (b"content-length", str(len(body)).encode()),
        (b"content-security-policy", b"default-src 'none'; frame-ancestors 'none'"),
        (b"connection", b"close"),
        *_ALWAYS.items(),
    ]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": body})
