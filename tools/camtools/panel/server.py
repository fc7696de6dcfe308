# SPDX-License-Identifier: Apache-2.0
"""The server of the panel: NiceGUI below the token, run by uvicorn on a socket that is open.

>>> application.__name__
'application'
"""

from __future__ import annotations

import socket
from collections.abc import Collection

import uvicorn
from fastapi import FastAPI
from nicegui import app, core, ui
from starlette.requests import Request
from starlette.responses import PlainTextResponse

from camtools.panel.access import middleware
from camtools.panel.context import AppContext
from camtools.panel.design_service import design_service_of
from camtools.panel.page_frame import STATIC, STATIC_FOLDER
from camtools.panel.pages import design, operate, runs
from camtools.panel.pages.reports import reports

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

    Parameters
    ----------
    token : str
        with which the address of every page begins
    proxy_hosts : collection of str
        names by which browsers reach the panel through reverse proxies
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
