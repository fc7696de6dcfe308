"""Command line of a live lathe: controller and lathe as processes, on a bus of this computer.

>>> main(["nosuch.toml"])
2
"""

from __future__ import annotations

import argparse
import json
import os
import re
import select
import shlex
import socket
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import can

from camtools.base.arguments import Option, Word, Words, command
from camtools.base.command import BAD_INPUT
from camtools.base.errors import CamtoolsError
from camtools.base.project import with_names
from camtools.base.quantities import NM_PER_MM
from camtools.base.signals import Interrupted
from camtools.cli.bus import Interface
from camtools.link.bus import open_bus
from camtools.link.controller import DBC_NODE
from camtools.link.live_lathes import Bridge, LiveLathe, announced, live_lathes, runtime_folder
from camtools.pipeline.job import DEFAULT_PART, MACHINE_HELP, write_files
from camtools.pipeline.load import Made, load, make
from camtools.sim.live import LivePair, camsim_path, died, refuses, with_home_switches
from camtools.sim.machine_file import machine_bytes

DIED = 1
_GROUP = "239.74.163.2"  # python-can's own; the port keeps live lathes apart
_MOST_SPEED_UP, _LEAST_SPEED_UP = 100.0, 0.01
_MACHINE = "machine.toml"
_START_S = 30.0
_LOOK_S = 0.1
_PEOPLE = ("waived", "present", "absent")
_EPILOG = """\
Options after -- go to both processes as to `camsim run`: --set, --rpm, --seed, ...
Type a line to cause a fault: estop, drive, bus, lost-counts:5 or another kind of camsim run
--inject; `release` ends the first three. `acknowledge:0.5` presses the button at the machine for
half a second, `key:1` turns the key switch.
Exit status: 0 ended by control-C or SIGTERM, 1 both processes died, 2 wrong usage or bad input."""


def _speed_up(text: str) -> float:
    value = float(text)
    if not _LEAST_SPEED_UP <= value <= _MOST_SPEED_UP:
        limits = f"{_LEAST_SPEED_UP:g} .. {_MOST_SPEED_UP:g}"
        raise argparse.ArgumentTypeError(f"{text}: give {limits}")
    return value


def _name(text: str) -> str:
    if not re.fullmatch(r"[A-Za-z0-9_][A-Za-z0-9_-]{0,39}", text):
        raise argparse.ArgumentTypeError(f"{text}: give letters, digits, - and _, at most 40")
    return text


_USAGE = """\
tools/live [PART.toml] [--machine M] [--speed-up F] [--operator WHO] [--name NAME]
                  [-i INTERFACE -c CHANNEL] [-- CAMSIM-OPTIONS]"""


@dataclass(frozen=True)
class Options:
    """Which lathe lives."""

    interface: Interface
    part: Annotated[Path, Word("part file (default: perkins240)", "PART.toml")] = DEFAULT_PART
    machine: Annotated[str | None, Option(MACHINE_HELP, "M")] = None
    speed_up: Annotated[
        float,
        Option(
            f"speed-up of the clock, {_LEAST_SPEED_UP:g} .. {_MOST_SPEED_UP:g} (default: 1)",
            "F",
            read=_speed_up,
        ),
    ] = 1.0
    operator: Annotated[
        str | None,
        Option(
            "operator at the machine: present presses the acknowledge button and has turned the "
            "key; absent does neither; waived: no acknowledgement is needed (default)",
            choices=_PEOPLE,
        ),
    ] = None
    name: Annotated[
        str | None,
        Option("name of this lathe, for camctl --live (default: the part's)", read=_name),
    ] = None


def _say(text: str) -> None:
    print(with_names(f"live: {text}"), flush=True)


def _bus_of(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the bus that was asked for, or frames that never leave this computer."""
    if given:
        return dict(given)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("", 0))  # to a port that nobody else on this computer has now
        port = int(free.getsockname()[1])
    return {"interface": "udp_multicast", "channel": _GROUP, "port": port, "hop_limit": 0}


def _files(made: Made, machine: str | None) -> dict[str, bytes]:
    """Return what both processes read."""
    z_last_mm = made.table.table.z_end_nm / NM_PER_MM
    own = with_home_switches(made.kind.machine(made.table.part), z_last_mm)
    text = own.encode("ascii") if machine is None else machine_bytes(machine)
    return made.files(with_plots=False) | {_MACHINE: text}


def _environment(bus: Mapping[str, Any]) -> str:
    """Return the shell command that names the bus to other programs of python-can."""
    named = {name: str(bus[name]) for name in ("interface", "channel", "bitrate") if name in bus}
    words = [f"CAN_{name.upper()}={shlex.quote(value)}" for name, value in named.items()]
    rest = {name: value for name, value in bus.items() if name not in named}
    words += [f"CAN_CONFIG={shlex.quote(json.dumps(rest))}"] if rest else []
    return " ".join(["export", *words])


class _Session:
    """The two processes on a bus, until the user ends them."""

    def __init__(self, pair: LivePair, bridge: Bridge) -> None:
        self._pair, self._bridge = pair, bridge
        self._alive = {"lathe": pair.lathe, "controller": pair.controller}
        assert pair.lathe.stdout is not None and pair.lathe.stdin is not None
        self._said, self._words = pair.lathe.stdout.fileno(), pair.lathe.stdin.fileno()
        self._heard = [self._said]
        self._rest = ""
        with suppress(OSError, ValueError):
            self._heard.append(sys.stdin.fileno())

    def wait_for_start(self) -> bool:
        """Wait for the controller's first frame; return whether it came."""
        end_s = time.monotonic() + _START_S
        while not self._bridge.spoke.wait(_LOOK_S) and time.monotonic() < end_s:
            if any(process.poll() is not None for process in self._alive.values()):
                return False  # it has said why
        return self._bridge.spoke.is_set()

    def run(self) -> None:
        """Pass on the lathe's output and what is typed, while at least one process lives."""
        last_problem = ""
        while self._alive:
            self._look_after()
            ready, _, _ = select.select(self._heard, [], [], _LOOK_S)
            for source in ready:
                self._take(source)
            if self._bridge.problem != last_problem:
                last_problem = self._bridge.problem
                _say(last_problem)

    def _look_after(self) -> None:
        for name, process in list(self._alive.items()):
            status = process.poll()
            if status is not None:
                del self._alive[name]
                after = f"; the {next(iter(self._alive))} continues" if self._alive else ""
                _say(f"the {name} (process {process.pid}) {died(status)}{after}")

    def _take(self, source: int) -> None:
        is_typed = source != self._said
        if is_typed and os.isatty(source) and os.tcgetpgrp(source) != os.getpgrp():
            time.sleep(_LOOK_S)  # in the background: what is typed is for the shell
            return
        data = os.read(source, 4096)
        if not data:
            self._heard.remove(source)
        elif is_typed:
            with suppress(OSError):
                os.write(self._words, data)
        else:
            *lines, self._rest = (self._rest + data.decode("utf-8", "replace")).split("\n")
            for line in lines:
                _say(f"lathe: {line}")


def _tell(lathe: LiveLathe, arguments: Options, where: str) -> None:
    own = arguments.machine
    machine = "a machine with the limits of the part" if own is None else f"the machine {own}"
    pace = "in" if arguments.speed_up == 1.0 else f"at {arguments.speed_up:g} times"
    _say(f"{lathe.facts['part']} on {machine}, {pace} real time")
    ids = "lathe {lathe_pid}, controller {controller_pid}".format_map(lathe.facts)
    _say(f"processes: {ids}; bus: {where}")
    others = len(live_lathes()) > 1
    _say(f"talk to it: tools/camctl {f'--live {lathe.name} ' if others else ''}status")
    _say(f"for your own programs with python-can: {_environment(lathe.bus)}")
    _say("type estop, drive, bus, lost-counts:5, .. for a fault, release to end it; control-C ends")


def _begin(
    stack: ExitStack,
    opened: tuple[can.BusABC, str],
    made: Made,
    arguments: Options,
    extra: Sequence[str],
) -> tuple[LivePair, _Session] | None:
    """Start both processes and wait until they have read their files; None: camsim refused."""
    name = made.table.table.part_name
    words = [f"{name}.camtab", "--machine", _MACHINE, *extra]
    with tempfile.TemporaryDirectory(prefix="live.", dir=runtime_folder()) as text:
        folder = Path(text)
        write_files(folder, _files(made, arguments.machine))
        if refuses(camsim_path(), folder, words):
            return None
        people = [] if arguments.operator is None else ["--operator", arguments.operator]
        pace = ["--speed-up", repr(arguments.speed_up)]
        pair = LivePair(camsim_path(), folder, [*words, *pace, *people])
        stack.callback(pair.close)
        assert pair.controller.stdin is not None and pair.controller.stdout is not None
        bridge = Bridge(*opened, pair.controller.stdin.fileno(), pair.controller.stdout.fileno())
        for end in (pair.close_pipes, bridge.close, pair.close, bridge.stop):  # the last one first
            stack.callback(end)
        session = _Session(pair, bridge)
        if not session.wait_for_start():
            raise CamtoolsError([f"{name}: the controller does not start; see the line above"])
    return pair, session


def live(options: Options, extra: Annotated[tuple[str, ...], Words(is_after_dashes=True)]) -> int:
    """Run a controller and a simulated lathe until control-C, for tools/camctl and tools/panel."""
    with ExitStack() as stack:
        made = make(load(options.part), options.part)
        bus_words = _bus_of(options.interface.words())
        bus, where = open_bus(bus_words)
        stack.callback(bus.shutdown)
        begun = _begin(stack, (bus, where), made, options, extra)
        if begun is None:
            return BAD_INPUT
        pair, session = begun
        name = made.table.table.part_name
        facts = {
            "bus": bus_words,
            "node": DBC_NODE,
            "part": name,
            "speed_up": options.speed_up,
            "lathe_pid": pair.lathe.pid,
            "controller_pid": pair.controller.pid,
        }
        own = announced(runtime_folder(), options.name or name, facts)
        _tell(stack.enter_context(own), options, where)
        with suppress(Interrupted):
            session.run()
            return DIED
    return 0


main = command("tools/live", live, usage=_USAGE, epilog=_EPILOG)

if __name__ == "__main__":
    sys.exit(main())
