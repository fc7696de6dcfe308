"""Command line of the browser panel.

>>> Options().port
8417
"""

from __future__ import annotations

import argparse
import os
import re
import secrets
import socket
import sys
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from camtools.base.arguments import Option, command, whole_within
from camtools.base.errors import CamtoolsError
from camtools.base.files import read_private
from camtools.base.project import RESULTS
from camtools.base.signals import Interrupted
from camtools.cli.bus import BusOptions
from camtools.link.bus import configured
from camtools.link.controller import Link
from camtools.link.live_lathes import live_lathes, only_lathe
from camtools.panel.context import AppContext
from camtools.panel.orders.commander import Commander, CommandLog
from camtools.panel.orders.controller_service import ControllerService

_LOOPBACK, _PORT = "127.0.0.1", 8417
_HOST = re.compile(r"[A-Za-z0-9.-]+")
_TOKEN_BYTES = 24
_TOKEN = re.compile(r"[A-Za-z0-9_-]{16,200}")
_EPILOG = """\
The panel serves this computer only, and only those who have the printed address: it begins with the
token. Without options for the bus, the panel uses the live lathe of tools/live. While there is no
controller, the page says how to start one.
From another computer: ssh -L 8417:127.0.0.1:8417 THIS-COMPUTER, then open the address as printed.
Exit status: 0 ended by control-C or SIGTERM, 2 wrong usage or bad input."""


_KEPT = RESULTS / "panel"


def _host(text: str) -> str:
    if not _HOST.fullmatch(text):
        raise argparse.ArgumentTypeError(f"{text}: give a name such as lathe.example, without port")
    return text.lower()


@dataclass(frozen=True)
class Options(BusOptions):
    """Which controller is shown, to whom."""

    port: Annotated[
        int,
        Option(
            f"TCP port, 0 for any free one (default: {_PORT})", read=whole_within(0, (1 << 16) - 1)
        ),
    ] = _PORT
    proxy_host: Annotated[
        tuple[str, ...],
        Option(
            "name by which browsers reach a reverse proxy on this computer; may be repeated",
            "NAME",
            read=_host,
        ),
    ] = ()
    token_file: Annotated[
        Path | None, Option("file with the token (default: a new token)", "FILE")
    ] = None
    log: Annotated[
        Path, Option("log of all commands (default: build/panel/commands.jsonl)", "FILE")
    ] = _KEPT / "commands.jsonl"
    keep: Annotated[Path, Option("folder for parts and runs (default: build/panel)", "DIR")] = _KEPT


def token_of(path: Path | None) -> str:
    """Return the token of a file that only its owner can read, or a new one."""
    if path is None:
        return secrets.token_urlsafe(_TOKEN_BYTES)
    try:
        token = read_private(path, "--token-file").decode("ascii").strip()
    except UnicodeDecodeError as error:
        raise CamtoolsError([f"--token-file {path}: not ASCII; give letters and digits"]) from error
    if not _TOKEN.fullmatch(token):
        raise CamtoolsError([f"--token-file {path}: give 16 .. 200 letters, digits, - and _"])
    return token


def _open_socket(port: int) -> socket.socket:
    try:
        return socket.create_server((_LOOPBACK, port))
    except OSError as error:
        reason = os.strerror(error.errno or 0)  # create_server() adds the address to strerror
        problem = f"{_LOOPBACK} port {port}: {reason}; give another --port"
        raise CamtoolsError([problem]) from error


def _check_bus(options: Options) -> None:
    """Raise when the bus that is named cannot be opened; a live lathe may still come."""
    given, named = options.words(), options.live
    is_there = named is not None and any(lathe.name == named for lathe in live_lathes())
    if "interface" in configured(given) or (given and named is not None) or is_there:
        options.opened()[0].shutdown()
    elif named is None:
        only_lathe(None)


def panel(options: Options) -> int:
    """Show and command a controller in the browser; one visitor at a time commands."""
    token = token_of(options.token_file)
    _check_bus(options)
    with ExitStack() as stack:
        sock = stack.enter_context(_open_socket(options.port))
        log = CommandLog(options.log)
        stack.callback(log.close)
        from camtools.panel.server import application, serve  # it takes a second

        commander = Commander(log)
        service = ControllerService(lambda: Link(*options.opened()), commander, log)
        stack.callback(service.close)
        own = options.keep / "parts", options.keep / "runs"
        app = application(AppContext(service, commander, log, *own), token, options.proxy_host)
        print(f"panel: http://{_LOOPBACK}:{sock.getsockname()[1]}/{token}/")
        print("panel: control-C ends", flush=True)
        with suppress(Interrupted):
            serve(app, sock)
    return 0


main = command("tools/panel", panel, epilog=_EPILOG)

if __name__ == "__main__":
    sys.exit(main())
