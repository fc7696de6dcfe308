# SPDX-License-Identifier: Apache-2.0
"""The bus on a command line: its options, and how it is opened.

>>> parser = argparse.ArgumentParser()
>>> add_bus_options(parser)
>>> arguments = parser.parse_args(["-i", "socketcand", "--option", "port=29536"])
>>> bus_arguments(arguments)
{'interface': 'socketcand', 'port': 29536}
"""

from __future__ import annotations

import argparse
from typing import Any

import can

from camtools.base.errors import CamtoolsError
from camtools.link.bus import configured, open_bus
from camtools.link.controller import DBC_NODE
from camtools.link.live_lathes import only_lathe

_NAMED = ("interface", "channel", "bitrate")


def _node(text: str) -> int:
    value = int(text)
    if not 1 <= value <= 127:
        raise argparse.ArgumentTypeError(f"{text}: give 1 .. 127")
    return value


def _value(text: str) -> Any:  # noqa: ANN401 - of whatever type the interface wants
    """Return a number where the text is one, else the text."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return {"true": True, "false": False}.get(text.lower(), text)


def _pair(text: str) -> tuple[str, Any]:
    name, equals, value = text.partition("=")
    if not equals or not name.isidentifier():
        raise argparse.ArgumentTypeError(f"{text}: give NAME=VALUE, for example port=29536")
    return name, _value(value)


def add_interface_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that name a bus."""
    parser.add_argument("--interface", "-i", help="of python-can: socketcan, pcan, slcan, ...")
    parser.add_argument("--channel", "-c", help="of that interface, for example can0")
    parser.add_argument("--bitrate", "-b", type=int, help="in bit/s, where the interface sets it")
    parser.add_argument(
        "--option",
        type=_pair,
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="of that interface, for example host=192.168.1.7; may be given again",
    )


def add_bus_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that name a bus and a controller on it."""
    add_interface_options(parser)
    parser.add_argument("--live", metavar="NAME", help="a live lathe, where tools/live runs twice")
    parser.add_argument("--node", "-n", type=_node, help=f"of the controller, 1 .. 127; {DBC_NODE}")


def bus_arguments(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return what the options give of the arguments of can.Bus."""
    asked = {name: getattr(arguments, name) for name in _NAMED}
    return {name: value for name, value in asked.items() if value is not None} | dict(
        arguments.option
    )


def open_controller(arguments: argparse.Namespace) -> tuple[can.BusABC, str, int]:
    """Return the bus that the options name, how to call it in messages, and the controller's node.

    Where no bus is named, neither here nor by the environment, it is that of the live lathe.

    Raises
    ------
    CamtoolsError
        It cannot be opened, several live lathes run, or both a bus and a live lathe are named.
    """
    given, node = bus_arguments(arguments), arguments.node
    if arguments.live is not None and given:
        first = next(iter(given))
        raise CamtoolsError([f"--live {arguments.live}: has its own bus; leave out {first}"])
    if arguments.live is not None or "interface" not in configured(given):
        lathe = only_lathe(arguments.live)
        if lathe is not None:
            bus, where = open_bus(lathe.bus | given)
            return bus, f"live lathe {lathe.name}, {where}", node or lathe.node
    bus, where = open_bus(given)
    return bus, where, node or DBC_NODE
