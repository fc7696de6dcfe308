# SPDX-License-Identifier: Apache-2.0
"""Access to the panel: only its own pages, in browsers that have the token.

Every path begins with the token, or with the key that opens reports and nothing else. A page of
another site knows neither; if it learns the token, its Origin is refused. Starlette's
TrustedHostMiddleware refuses names that were made to point at this computer (DNS rebinding).

>>> [layer.cls.__name__ for layer in middleware(["token"], [])]
['TrustedHostMiddleware', 'KeyGate']
"""

from __future__ import annotations

import hmac
from collections.abc import Collection

from starlette.datastructures import Headers, MutableHeaders
from starlette.middleware import Middleware
from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send


def middleware(keys: Collection[str], proxy_hosts: Collection[str]) -> list[Middleware]:
    """Return the middleware that checks every request and websocket.

    Parameters
    ----------
    keys : collection of str
        a path begins with a key
    proxy_hosts : collection of str
        names by which browsers reach the panel through reverse proxies
    """
    hosts = ["127.0.0.1", "localhost", *proxy_hosts]
    return [
        Middleware(TrustedHostMiddleware, allowed_hosts=hosts, www_redirect=False),
        Middleware(KeyGate, keys=keys),
    ]


class KeyGate:
    """Refuses paths without a key, and requests from pages of other origins."""

    def __init__(self, app: ASGIApp, keys: Collection[str]) -> None:
        self._app, self._keys = app, [key.encode() for key in keys]

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request or a websocket on, or refuse it."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        headers = Headers(scope=scope)
        refusal = self._refusal(scope, headers)
        if refusal is not None:
            await refusal(scope, receive, send)
            return

        async def send_protected(message: Message) -> None:
            if message["type"] == "http.response.start":
                answer = MutableHeaders(scope=message)
                answer.setdefault("content-security-policy", _policy(headers["host"]))
                answer["referrer-policy"] = "no-referrer"  # the address has the token
                answer["x-content-type-options"] = "nosniff"
            await send(message)

        await self._app(scope, receive, send_protected)

    def _refusal(self, scope: Scope, headers: Headers) -> PlainTextResponse | None:
        first = scope["path"].removeprefix("/").partition("/")[0].encode()
        if not any(hmac.compare_digest(first, key) for key in self._keys):
            return PlainTextResponse("open the address that tools/panel has printed\n", 404)
        origin = headers.get("origin")
        if origin is None:
            is_ours = scope["type"] == "http" and scope["method"] in ("GET", "HEAD")
        else:
            is_ours = origin.partition("://")[2] == headers["host"]
        return None if is_ours else PlainTextResponse("not a page of this panel\n", 403)


def _policy(host: str) -> str:
    """Return the content security policy of a page: it loads from and sends to the panel only.

    NiceGUI puts scripts into the page and compiles templates in the browser.
    """
    return (
        "default-src 'none'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; "
        "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; font-src 'self'; "
        f"connect-src 'self' ws://{host} wss://{host}; frame-src 'self'; base-uri 'none'; "
        "form-action 'none'; frame-ancestors 'none'"
    )
