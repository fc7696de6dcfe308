# SPDX-License-Identifier: Apache-2.0
r"""A proxy that answers nothing: whatever a browser wants of other computers ends here.

A browser asks for the loopback without its proxy, so what arrives was meant for elsewhere.

>>> with Trap() as trap, socket.create_connection(("127.0.0.1", trap.port)) as visitor:
...     visitor.sendall(b"GET http://example.com/ HTTP/1.1\r\n\r\n")
...     visitor.recv(1)
b''
>>> trap.caught
['GET http://example.com/ HTTP/1.1']
"""

import re
import socket
import threading
from contextlib import suppress
from typing import Self

_REQUEST_BYTES = 2000
# Chromium itself asks these, about accounts, updates and fields that are typed into, whatever
# switches it is given.
_OF_THE_BROWSER = re.compile(
    r"\w+ (https?://)?(accounts\.google|(update|content-autofill)\.googleapis)\.com[:/]"
)


class Trap:
    """A listening port of the loopback that keeps the first line of each request.

    Attributes
    ----------
    port : int
        on 127.0.0.1
    caught : list of str
        first lines of the requests, without those that the browser makes for itself
    """

    def __init__(self) -> None:
        self._server = socket.create_server(("127.0.0.1", 0))
        self.port = int(self._server.getsockname()[1])
        self.caught: list[str] = []
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def _serve(self) -> None:
        while True:
            try:
                visitor, _ = self._server.accept()
            except OSError:
                return
            with visitor, suppress(OSError):
                self._take(visitor.recv(_REQUEST_BYTES))

    def _take(self, request: bytes) -> None:
        line = request.split(b"\r\n")[0].decode("ascii", "replace")
        if line and not _OF_THE_BROWSER.match(line):
            self.caught.append(line)

    def close(self) -> None:
        """Stop listening."""
        with suppress(OSError):
            self._server.shutdown(socket.SHUT_RDWR)
        self._server.close()
        self._thread.join()

    def __enter__(self) -> Self:
        """Return this trap."""
        return self

    def __exit__(self, *_: object) -> None:
        """Stop listening."""
        self.close()
