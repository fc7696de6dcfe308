"""Requests to the panel without a browser: those of NiceGUI's script, or of an attacker."""

import http.client
import re
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from urllib.parse import urlencode, urlsplit

from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin

from checks.patience import limit_s

SOCKET = "_nicegui_ws/socket.io/"
_CLIENT = re.compile(r"'client_id': '([0-9a-f-]{36})'")


def ask(
    origin: str, path: str, method: str = "GET", headers: dict[str, str] | None = None
) -> tuple[int, dict[str, str], str]:
    """Ask for a path as it is written, without tidying it; return status, headers and content."""
    place = urlsplit(origin)
    line = http.client.HTTPConnection(place.hostname or "", place.port, timeout=limit_s())
    try:
        line.request(method, path, headers=headers or {})
        answer = line.getresponse()
        named = {name.lower(): value for name, value in answer.getheaders()}
        return answer.status, named, answer.read().decode()
    finally:
        line.close()


@contextmanager
def open_page(url: str) -> Iterator[ClientConnection]:
    """Ask for a page and connect as its script does."""
    origin = url[: -len(urlsplit(url).path)]
    status, _, content = ask(origin, urlsplit(url).path)
    client = _CLIENT.search(content)
    assert status == 200 and client is not None, content
    query = {
        "EIO": "4",
        "transport": "websocket",
        "client_id": client[1],
        "next_message_id": "0",
        "implicit_handshake": "true",
        "document_id": str(uuid.uuid4()),
        "tab_id": str(uuid.uuid4()),
    }
    place = f"{url.replace('http://', 'ws://')}{SOCKET}?{urlencode(query)}"
    with connect(place, origin=Origin(origin), open_timeout=limit_s()) as socket:
        assert str(socket.recv(limit_s())).startswith("0")  # the handshake of Engine.IO
        socket.send("40")
        hear_until(socket, "40")
        yield socket


def hear_until(socket: ClientConnection, words: str) -> str:
    """Return the first message with some words; pings are answered."""
    while words not in (message := str(socket.recv(limit_s()))):
        if message == "2":
            socket.send("3")
    return message
