"""The bus on a command line: its options, and how it is opened.

>>> Interface("socketcand", option=(("port", 29536),)).words()
{'interface': 'socketcand', 'port': 29536}
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from typing import Annotated, Any

import can

from camtools.base.arguments import Option, whole_within
from camtools.base.errors import CamtoolsError
from camtools.link.bus import configured, open_bus
from camtools.link.controller import DBC_NODE
from camtools.link.live_lathes import only_lathe

_NAMED = ("interface", "channel", "bitrate")


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


@dataclass(frozen=True)
class Interface:
    """The options that name a bus."""

    interface: Annotated[
        str | None, Option("CAN interface of python-can: socketcan, pcan, slcan, ...", short="-i")
    ] = None
    channel: Annotated[
        str | None, Option("channel of the CAN interface, for example can0", short="-c")
    ] = None
    bitrate: Annotated[
        int | None, Option("bit rate in bit/s (default: the interface's)", short="-b")
    ] = None
    option: Annotated[
        tuple[tuple[str, Any], ...],
        Option(
            "further setting of the CAN interface, for example host=192.168.1.7; repeatable",
            "NAME=VALUE",
            read=_pair,
        ),
    ] = ()

    def words(self) -> dict[str, Any]:
        """Return what the options give of the arguments of can.Bus."""
        asked = {name: getattr(self, name) for name in _NAMED}
        asked |= self.option
        return {name: value for name, value in asked.items() if value is not None}


@dataclass(frozen=True)
class BusOptions(Interface):
    """The options that name a bus and a controller on it."""

    live: Annotated[
        str | None, Option("name of the live lathe (default: the only one running)", "NAME")
    ] = None
    node: Annotated[
        int | None,
        Option(
            f"node of the controller, 1 .. 127 (default: the live lathe's, else {DBC_NODE})",
            short="-n",
            read=whole_within(1, 127),
        ),
    ] = None

    def opened(self) -> tuple[can.BusABC, str, int]:
        """Return the bus, its name for messages, and the controller's node.

        Where no bus is named, neither here nor by the environment, it is that of the live lathe.
        Raises CamtoolsError: it cannot be opened, several live lathes run, or both a bus and a live
        lathe are named.
        """
        given = self.words()
        if self.live is not None and given:
            first = next(iter(given))
            raise CamtoolsError([f"--live {self.live}: has its own bus; leave out {first}"])
        if self.live is not None or "interface" not in configured(given):
            lathe = only_lathe(self.live)
            if lathe is not None:
                bus, where = open_bus(lathe.bus | given)
                return bus, f"live lathe {lathe.name}, {where}", self.node or lathe.node
        bus, where = open_bus(given)
        return bus, where, self.node or DBC_NODE
