"""The server of the panel: NiceGUI behind its token, run by uvicorn on a socket that is open.

Every path begins with the token, or with the key that opens reports and nothing else. A page of
another site knows neither; if it learns the token, its Origin is refused. Starlette's
TrustedHostMiddleware refuses names that were made to point at this computer (DNS rebinding).

>>> [layer.cls.__name__ for layer in middleware(["token"], [])]
['TrustedHostMiddleware', 'KeyGate']
"""

import hmac
import socket
from collections.abc import Collection

import uvicorn
from fastapi import FastAPI
from nicegui import app, core, ui
from starlette.datastructures import Headers, MutableHeaders
from starlette.middleware import Middleware
from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.requests import Request
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from camtools.panel.context import AppContext
from camtools.panel.design_service import design_service_of
from camtools.panel.page_frame import STATIC, STATIC_FOLDER
from camtools.panel.pages import design, operate, runs
from camtools.panel.pages.runs import reports


def middleware(keys: Collection[str], proxy_hosts: Collection[str]) -> list[Middleware]:
    """Return the middleware that checks every request and websocket.

    Paths begin with a key; `proxy_hosts` are names by which browsers reach reverse proxies.
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

    'unsafe-inline' and 'unsafe-eval' remain for scripts: NiceGUI puts the elements of a page into
    an inline script that differs each time, without a nonce, and Vue compiles templates in the
    browser. Texts of strangers thus must not become elements; ui.label and props keep them texts.
    """
    return (
        "default-src 'none'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; "
        "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; font-src 'self'; "
        f"connect-src 'self' ws://{host} wss://{host}; frame-src 'self'; base-uri 'none'; "
        "form-action 'none'; frame-ancestors 'none'"
    )


# A page that is away for longer begins anew. Command is lost earlier (page_frame.py), and a jog
# ends when its heartbeats do (jog_press.py).
_RECONNECT_S = 45.0
# A page that is too busy to answer for this long is not cut off.
_PING_S, _ANSWER_S = 4.0, 8.0


async def _not_found(_request: Request, _error: Exception) -> PlainTextResponse:
    """Answer in a line. NiceGUI would keep a page of it, and log its address with the token."""
    return PlainTextResponse("no such page\n", 404)


def _ping_patiently() -> None:
    """Set what NiceGUI derives from the time for a reconnect, each time it starts."""
    core.sio.eio.ping_interval, core.sio.eio.ping_timeout = _PING_S, _ANSWER_S


def application(context: AppContext, token: str, proxy_hosts: Collection[str] = ()) -> FastAPI:
    """Return the whole application; once per process, since NiceGUI has one only.

    The address of every page begins with the token.
    """
    app.add_static_files(f"/{STATIC}", STATIC_FOLDER, follow_symlink=False)
    for page in (operate, design, runs):
        page.add(context)
    designs = design_service_of(context)
    outer = FastAPI(
        docs_url=None,
        redoc_url=None,
        openapi_url=None,
        middleware=middleware((token, designs.report_key), proxy_hosts),
    )
    outer.mount(f"/{designs.report_key}", reports(designs))
    ui.run_with(
        outer,
        mount_path=f"/{token}",
        title="camturn",
        language="en-US",
        dark=None,
        tailwind=False,
        reconnect_timeout=_RECONNECT_S,
        gzip_middleware_factory=None,
        show_welcome_message=False,
    )
    app.on_startup(_ping_patiently)
    app.add_exception_handler(404, _not_found)
    core.sio.eio.transports = app.config.socket_io_js_transports = ["websocket"]
    return outer


def serve(application: FastAPI, sock: socket.socket) -> None:
    """Serve until a signal ends it."""
    config = uvicorn.Config(
        application,
        ws="wsproto",
        proxy_headers=False,
        server_header=False,
        access_log=False,  # the address has the token
        log_level="warning",
        timeout_graceful_shutdown=1,
    )
    uvicorn.Server(config).run(sockets=[sock])
