# SPDX-License-Identifier: Apache-2.0
"""Command line of the browser panel.

>>> _parser().parse_args([]).port
8417
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from camtools.base.command import Parser, run_command
from camtools.base.places import ROOT
from camtools.cli.bus import add_bus_options, open_controller
from camtools.link.controller import Link
from camtools.panel.command_log import CommandLog
from camtools.panel.commander import Commander
from camtools.panel.context import AppContext
from camtools.panel.desk import Desk
from camtools.panel.token import TokenGuard, new_token

_PORT = 8417


def _parser() -> argparse.ArgumentParser:
    parser = Parser(
        prog="tools/panel",
        description="Show a controller in the browser, and let one visitor command it.",
        allow_abbrev=False,
    )
    add_bus_options(parser)
    parser.add_argument("--port", type=int, default=_PORT, help=f"of TCP; {_PORT}; 0: a free one")
    parser.add_argument("--listen", default="127.0.0.1", metavar="ADDRESS", help="127.0.0.1")
    parser.add_argument("--token-file", type=Path, metavar="FILE", help="its first line")
    parser.add_argument(
        "--log", type=Path, default=ROOT / "build" / "panel" / "commands.jsonl", metavar="FILE"
    )
    return parser


def _run(arguments: argparse.Namespace) -> int:
    from camtools.panel.server import application, open_socket, serve

    def open_link() -> Link:
        return Link(*open_controller(arguments))

    sock = open_socket(arguments.listen, arguments.port)
    log, token = CommandLog(arguments.log), new_token()
    commander = Commander(log)
    desk = Desk(open_link, commander, log)
    try:
        address, port = sock.getsockname()[:2]
        sys.stdout.write(f"panel: http://{address}:{port}/#token={token}\n")
        sys.stdout.flush()
        serve(application(AppContext(desk, commander, log, TokenGuard(token))), sock)
    finally:
        desk.close()
        sock.close()
    return 0


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; 0 ended by the user, 2 wrong usage or bad input."""
    arguments = _parser().parse_args(argv)
    return run_command("panel", lambda: _run(arguments))


if __name__ == "__main__":
    sys.exit(main())
