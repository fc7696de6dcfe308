# SPDX-License-Identifier: Apache-2.0
"""The socket of the panel, and what browsers may call it.

>>> with open_socket("127.0.0.1", 0) as sock:
...     [host.split(":")[0] for host in hosts_of(sock)]
['127.0.0.1', 'localhost']
"""

from __future__ import annotations

import socket

from camtools.base.errors import CamtoolsError

_BACKLOG = 64


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
