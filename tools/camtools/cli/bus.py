# SPDX-License-Identifier: Apache-2.0
"""The bus on a command line: its options, and how it is opened.

>>> parser = argparse.ArgumentParser()
>>> add_bus_options(parser)
>>> parser.parse_args(["-i", "virtual", "-n", "3"]).node
3
"""

from __future__ import annotations

import argparse

import can

from camtools.base.errors import CamtoolsError
from camtools.link.controller import DBC_NODE


def _node(text: str) -> int:
    value = int(text)
    if not 1 <= value <= 127:
        raise argparse.ArgumentTypeError(f"{text}: give 1 .. 127")
    return value


def add_bus_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that name a bus and a controller on it."""
    parser.add_argument("--interface", "-i", help="of python-can: socketcan, pcan, slcan, ...")
    parser.add_argument("--channel", "-c", help="of that interface, for example can0")
    parser.add_argument("--bitrate", "-b", type=int, help="in bit/s, where the interface sets it")
    parser.add_argument(
        "--node", "-n", type=_node, default=DBC_NODE, help="of the controller, 1 .. 127; 64"
    )


def open_bus(arguments: argparse.Namespace) -> tuple[can.BusABC, str]:
    """Return the bus that the options name, and how to call it in messages.

    Raises
    ------
    CamtoolsError
        It cannot be opened.
    """
    asked = {name: getattr(arguments, name) for name in ("interface", "channel", "bitrate")}
    given = {name: value for name, value in asked.items() if value is not None}
    try:
        bus = can.Bus(**given)
    except (can.CanError, OSError, ValueError, ImportError) as error:
        place = " ".join(f"{name}={value}" for name, value in given.items()) or "no bus given"
        remedy = "give --interface and --channel, or set CAN_INTERFACE and CAN_CHANNEL"
        raise CamtoolsError([f"{place}: the bus cannot be opened: {error}; {remedy}"]) from error
    return bus, bus.channel_info
