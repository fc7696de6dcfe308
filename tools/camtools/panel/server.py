# SPDX-License-Identifier: Apache-2.0
"""The server of the panel: NiceGUI, protected by the gate, run by uvicorn on a socket that is open.

>>> MOST_PAGES
48
"""

from __future__ import annotations

import socket
from collections.abc import Collection
from http import HTTPStatus

import uvicorn
from fastapi import FastAPI, Request
from fastapi.responses import PlainTextResponse
from nicegui import Client, app, core, ui

from camtools.panel.access.auth_gate import AuthGate
from camtools.panel.access.connections import MOST_HEADER_BYTES, BoundedProtocol
from camtools.panel.access.nonce_template import use_nonces
from camtools.panel.access.socket_events import MOST_MESSAGE_BYTES, guard_socket
from camtools.panel.context import AppContext
from camtools.panel.log_limit import keep_traces_few
from camtools.panel.page_frame import STATIC, STATIC_FOLDER, may_upload
from camtools.panel.pages import design, operate, runs

MOST_PAGES = 48
# A page that is away for longer begins anew. Command is lost earlier (page_frame.py), and a jog
# ends when its heartbeats do (jog_press.py).
_RECONNECT_S = 45.0
# A page that is too busy to answer for this long is not cut off.
_PING_S, _ANSWER_S = 4.0, 8.0


async def _not_found(_request: Request, _error: Exception) -> PlainTextResponse:
    """Answer in a line; NiceGUI would make a page of it, which stays in memory for a minute."""
    return PlainTextResponse("no such page; / is the operator's page\n", HTTPStatus.NOT_FOUND)


def _ping_patiently() -> None:
    """Set what NiceGUI derives from the time for a reconnect, each time it starts."""
    core.sio.eio.ping_interval, core.sio.eio.ping_timeout = _PING_S, _ANSWER_S


def application(context: AppContext, hosts: Collection[str]) -> AuthGate:
    """Return the whole application; once per process, since NiceGUI has one only."""
    outer = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
    app.add_static_files(STATIC, STATIC_FOLDER, follow_symlink=False)
    for page in (operate, design, runs):
        page.add(context)
    ui.run_with(
        outer,
        title="camturn",
        language="en-US",
        dark=None,
        tailwind=False,
        reconnect_timeout=_RECONNECT_S,
        gzip_middleware_factory=None,
        show_welcome_message=False,
    )
    app.on_startup(_ping_patiently)
    app.add_exception_handler(HTTPStatus.NOT_FOUND, _not_found)
    use_nonces()
    keep_traces_few()
    guard_socket([f"http://{host}" for host in hosts])
    return AuthGate(outer, hosts, may_upload, lambda: len(Client.instances) >= MOST_PAGES)


def serve(application: AuthGate, sock: socket.socket) -> None:
    """Serve until a signal ends it."""
    config = uvicorn.Config(
        application,
        http=BoundedProtocol,
        ws="wsproto",
        ws_max_size=MOST_MESSAGE_BYTES,
        h11_max_incomplete_event_size=MOST_HEADER_BYTES,
        proxy_headers=False,
        server_header=False,
        access_log=False,
        log_level="warning",
        timeout_graceful_shutdown=1,
    )
    uvicorn.Server(config).run(sockets=[sock])
