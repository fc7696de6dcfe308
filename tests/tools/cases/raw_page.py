# SPDX-License-Identifier: Apache-2.0
"""A page of the panel without a browser: what NiceGUI's script says, or what an attacker would."""

import http.client
import json
import re
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any
from urllib.parse import urlencode, urlsplit

from websockets.exceptions import ConnectionClosed, InvalidHandshake
from websockets.sync.client import ClientConnection, connect

from checks.patience import limit_s

_ELEMENTS = re.compile(r"parseElements\(String\.raw`(.*?)`\)", re.DOTALL)
_CLIENT = re.compile(r"'client_id': '([0-9a-f-]{36})'")
_ESCAPES = {"&#36;": "$", "&#96;": "`", "&gt;": ">", "&lt;": "<", "&amp;": "&"}


def get(
    origin: str, path: str, method: str = "GET", body: bytes | None = None, **headers: str
) -> tuple[int, bytes]:
    """Ask for a path as it is written, without tidying it; return status and content."""
    place = urlsplit(origin)
    line = http.client.HTTPConnection(place.hostname or "", place.port, timeout=limit_s())
    try:
        more = {name.replace("_", "-"): value for name, value in headers.items()}
        line.request(method, path, body, more)
        answer = line.getresponse()
        return answer.status, answer.read()
    finally:
        line.close()


class RawPage:
    """A page that was asked for, with what its elements listen to.

    Attributes
    ----------
    client_id, tab_id : str
        by which the server knows page and tab
    elements : dict
        of the page by their numbers, as the browser gets them
    """

    def __init__(self, origin: str, path: str = "/") -> None:
        self.origin = origin
        status, content = get(origin, path)
        assert status == 200, content
        text = content.decode("utf-8")
        found, client = _ELEMENTS.search(text), _CLIENT.search(text)
        assert found is not None and client is not None
        raw = found[1]
        for escape, character in _ESCAPES.items():
            raw = raw.replace(escape, character)
        self.elements: dict[str, Any] = json.loads(raw)
        self.client_id, self.tab_id = client[1], str(uuid.uuid4())

    def query(self, **more: str) -> str:
        """Return what the page's script says of itself when it connects."""
        own = {
            "EIO": "4",
            "transport": "websocket",
            "client_id": self.client_id,
            "next_message_id": "0",
            "implicit_handshake": "true",
            "document_id": str(uuid.uuid4()),
            "tab_id": self.tab_id,
        }
        return urlencode(own | more)

    @contextmanager
    def connected(self, origin: str | None = "", **more: str) -> Iterator["RawSocket"]:
        """Connect as the page does; origin None: without one, "": the page's own."""
        place = self.origin.replace("http://", "ws://")
        url = f"{place}/_nicegui_ws/socket.io/?{self.query(**more)}"
        said = self.origin if origin == "" else origin
        with connect(url, origin=said, open_timeout=limit_s()) as socket:  # type: ignore[arg-type]
            one = RawSocket(self, socket)
            one.begin()
            yield one

    def is_let_in(self, origin: str | None = "", **more: str) -> bool:
        """Return whether a websocket is accepted."""
        try:
            with self.connected(origin, **more):
                return True
        except (InvalidHandshake, ConnectionClosed, AssertionError):
            return False

    def listeners(self) -> Iterator[tuple[int, dict[str, Any]]]:
        """Yield the number of each element and what it listens to."""
        for number, element in self.elements.items():
            for event in element.get("events", []):
                yield int(number), event


class RawSocket:
    """The websocket of a page."""

    def __init__(self, page: RawPage, socket: ClientConnection) -> None:
        self.page, self.socket = page, socket

    def hear(self) -> str:
        """Return the next message; pings are answered."""
        while (message := str(self.socket.recv(limit_s()))) == "2":
            self.socket.send("3")
        return message

    def begin(self) -> None:
        """Do what socket.io does first; fails where the server refuses."""
        assert self.hear().startswith("0")
        self.socket.send("40")
        assert self.hear().startswith("40")

    def emit(self, name: str, message: object) -> None:
        """Send an event of socket.io."""
        self.socket.send(f"42{json.dumps([name, message])}")

    def event(self, element: int, listener: str, *args: object, client_id: str = "") -> None:
        """Send an event of an element, of this page or another."""
        told = {
            "id": element,
            "client_id": client_id or self.page.client_id,
            "listener_id": listener,
            "args": [json.dumps(one) for one in args],
        }
        self.emit("event", told)

    def say(self, name: str, *args: object) -> None:
        """Send an event of the page itself, as emitEvent() does."""
        for element, event in self.page.listeners():
            if element == 0 and event["type"] == name:
                self.event(0, event["listener_id"], *args)

    def hear_until(self, words: str) -> str:
        """Return the first message with some words."""
        while words not in (message := self.hear()):
            pass
        return message
