# SPDX-License-Identifier: Apache-2.0
"""What a browser may say over its websocket: events of its own page, and nothing else.

NiceGUI takes an event for the page whose identifier it names, from whatever socket it comes. Here
the socket must have been accepted for that page. A message that is none is dropped in silence, and
nothing that a browser wants logged is.

>>> [_page_of("a socket", message) for message in (None, "x", {}, {"client_id": 7})]
[None, None, None, None]
"""

from __future__ import annotations

from collections.abc import Collection
from contextlib import suppress
from typing import Any

from nicegui import Client, core

_MALFORMED = (ValueError, KeyError, TypeError, AttributeError)
MOST_MESSAGE_BYTES = 1 << 18


def _page_of(sid: str, message: object) -> Client | None:
    """Return the page that a socket speaks for, when the message names the same one."""
    if not isinstance(message, dict):
        return None
    named = message.get("client_id")
    if not isinstance(named, str) or named not in core.sio.rooms(sid):
        return None
    page = Client.instances.get(named)
    return page if page is not None and page.has_socket_connection else None


def _on_event(sid: str, message: Any) -> None:  # noqa: ANN401 - whatever a browser sends
    page = _page_of(sid, message)
    if page is not None:
        with suppress(*_MALFORMED):
            page.handle_event(message)


def _on_javascript_response(sid: str, message: Any) -> None:  # noqa: ANN401
    page = _page_of(sid, message)
    if page is not None:
        with suppress(*_MALFORMED):
            page.handle_javascript_response(message)


def _on_ack(sid: str, message: Any) -> None:  # noqa: ANN401
    page = _page_of(sid, message)
    if page is not None:
        with suppress(*_MALFORMED):
            page.outbox.prune_history(int(message["next_message_id"]))


def _on_log(_sid: str, _message: Any) -> None:  # noqa: ANN401
    return


def guard_socket(origins: Collection[str]) -> None:
    """Put the guarded handlers in the place of NiceGUI's; websockets only, from our pages only."""
    core.sio.on("event", _on_event)
    core.sio.on("javascript_response", _on_javascript_response)
    core.sio.on("ack", _on_ack)
    core.sio.on("log", _on_log)
    core.sio.eio.transports = ["websocket"]
    core.sio.eio.cors_allowed_origins = list(origins)
    core.sio.eio.max_http_buffer_size = MOST_MESSAGE_BYTES
    core.app.config.socket_io_js_transports = ["websocket"]
