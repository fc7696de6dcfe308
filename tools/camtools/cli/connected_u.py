# SPDX-License-Identifier: Apache-2.0
"""U of a controller on a command line: the options that name it, and how it is opened.

>>> parser = Parser(prog="tools/identify")
>>> add_u_options(parser)
>>> parser.parse_args(["-c", "can0", "--secret", "key.txt"]).secret.name
'key.txt'
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from camtools.base.command import Parser
from camtools.cli.bus import add_bus_options, open_controller
from camtools.identify.can_drive import ConnectedU
from camtools.link.controller import Link
from camtools.link.rights import secret_of, sender_of

_OF_BUS = ("interface", "channel", "bitrate", "option", "live", "node", "secret")


def add_u_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that name a bus, a controller on it and the secret that unlocks it."""
    add_bus_options(parser)
    parser.add_argument(
        "--secret",
        type=Path,
        metavar="FILE",
        help="file of the secret that unlocks the controller for --apply",
    )


def check_u_options(parser: Parser, arguments: argparse.Namespace) -> None:
    """End with an error when options of the bus are given without --bus."""
    given = [name for name in _OF_BUS if getattr(arguments, name)]
    if given and not arguments.bus:
        remedy = "use --bus instead of --machine" if arguments.machine else "add --bus"
        parser.error(f"--{given[0]}: needs a bus: {remedy}")


@contextmanager
def connected_u(arguments: argparse.Namespace, program: str) -> Iterator[tuple[ConnectedU, int]]:
    """Open U of the controller that the options name; give it and the controller's node.

    Parameters
    ----------
    arguments : Namespace
        with the options of `add_u_options`
    program : str
        name by which it takes command, one that `link.rights` knows

    Raises
    ------
    CamtoolsError
        The bus cannot be opened, or the secret cannot be read.
    """
    bus, where, node = open_controller(arguments)
    try:
        link = Link(bus, where, node)
        link.rights.sender = sender_of(program)
        if arguments.secret is not None:
            link.rights.secret = secret_of(arguments.secret)
        yield ConnectedU(link), node
    finally:
        bus.shutdown()
