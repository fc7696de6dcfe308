# SPDX-License-Identifier: Apache-2.0
"""Connections to the panel are bounded: in number, and in the time that they may take to ask.

uvicorn waits for ever for a request that comes a byte at a time; here it must be whole in 10 s.

>>> HEADERS_S, MOST_CONNECTIONS
(10.0, 128)
"""

from __future__ import annotations

import asyncio

from uvicorn.protocols.http.h11_impl import H11Protocol

MOST_CONNECTIONS = 128
HEADERS_S = 10.0
MOST_HEADER_BYTES = 16 << 10


class BoundedProtocol(H11Protocol):
    """A connection that is closed when there are too many, or when no request comes."""

    _due: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin, or close at once."""
        super().connection_made(transport)
        if len(self.connections) > MOST_CONNECTIONS:
            transport.close()
            return
        self._due = self.loop.call_later(HEADERS_S, self._end_idle)

    def _end_idle(self) -> None:
        """Close while the first request is not whole; later uvicorn's own rule holds."""
        if self.cycle is None and not self.transport.is_closing():
            self.transport.close()

    def connection_lost(self, exc: Exception | None) -> None:
        """End."""
        if self._due is not None:
            self._due.cancel()
        super().connection_lost(exc)

    def handle_websocket_upgrade(self, event: object) -> None:
        """Hand over to the websocket's protocol; the time for the request is kept."""
        if self._due is not None:
            self._due.cancel()
        super().handle_websocket_upgrade(event)  # type: ignore[arg-type]
