# SPDX-License-Identifier: Apache-2.0
"""The server of the panel: NiceGUI behind the doorway, run by uvicorn on a socket that is open."""

from __future__ import annotations

import socket

import uvicorn
from fastapi import FastAPI
from nicegui import ui

from camtools.base.errors import CamtoolsError
from camtools.panel.context import AppContext
from camtools.panel.doorway import Doorway
from camtools.panel.pages import design, operate, runs


def open_socket(address: str, port: int) -> socket.socket:
    """Return a socket that listens.

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
    except OSError as error:
        sock.close()
        problem = f"{address} port {port}: {error.strerror}"
        raise CamtoolsError([f"{problem}; give another --port or --listen"]) from error
    return sock


def application(context: AppContext) -> FastAPI:
    """Return the whole application; once per process, since NiceGUI has one only."""
    app = FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
    for page in (operate, design, runs):
        page.add(context)
    ui.run_with(
        app,
        title="camturn",
        language="en-US",
        dark=None,
        tailwind=False,
        gzip_middleware_factory=None,
        show_welcome_message=False,
    )
    return app


def serve(app: FastAPI, sock: socket.socket) -> None:
    """Serve until a signal ends it."""
    address, port = sock.getsockname()[:2]
    config = uvicorn.Config(
        Doorway(app, {f"{address}:{port}"}), log_level="warning", timeout_graceful_shutdown=1
    )
    uvicorn.Server(config).run(sockets=[sock])
