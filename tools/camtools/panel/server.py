# SPDX-License-Identifier: Apache-2.0
"""The server of the panel: NiceGUI behind the doorway, run by uvicorn on a socket that is open."""

from __future__ import annotations

import socket
from collections.abc import Collection

import uvicorn
from fastapi import FastAPI
from nicegui import Client, app, ui

from camtools.base.errors import CamtoolsError
from camtools.panel.connections import MOST_HEADER_BYTES, BoundedProtocol
from camtools.panel.context import AppContext
from camtools.panel.doorway import Doorway
from camtools.panel.frame import STATIC, STATIC_FOLDER, may_upload
from camtools.panel.nonce_template import use_nonces
from camtools.panel.pages import design, operate, runs
from camtools.panel.socket_events import MOST_MESSAGE_BYTES, guard_socket

MOST_PAGES = 48
_BACKLOG = 64
_RECONNECT_S = 3.0


def open_socket(address: str, port: int) -> socket.socket:
    """Return a socket that is bound to an address and port; port 0: a free one.

    Raises
    ------
    CamtoolsError
        The address is none of this computer, or the port is in use.
    """
    family = socket.AF_INET6 if ":" in address else socket.AF_INET
    sock = socket.socket(family, socket.SOCK_STREAM)
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        sock.bind((address, port))
        sock.listen(_BACKLOG)
    except OSError as error:
        sock.close()
        problem = f"{address} port {port}: {error.strerror}"
        raise CamtoolsError([f"{problem}; give another --port or --listen"]) from error
    return sock


def hosts_of(sock: socket.socket) -> list[str]:
    """Return what a browser may call this server: name and port, that to be told first."""
    address, port = sock.getsockname()[:2]
    named = f"[{address}]" if ":" in address else address
    is_loopback = address in ("127.0.0.1", "::1")
    return [f"{named}:{port}", *([f"localhost:{port}"] if is_loopback else [])]


def application(context: AppContext, hosts: Collection[str]) -> Doorway:
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
    use_nonces()
    guard_socket([f"http://{host}" for host in hosts])
    return Doorway(outer, hosts, may_upload, lambda: len(Client.instances) >= MOST_PAGES)


def serve(application: Doorway, sock: socket.socket) -> None:
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
