"""What test_linux_port.py and test_linux_set_up.py share: the machine, the program, an operator.

They need an interface RIG_CAN (default vcan0) that is up and a simulated chip RIG_GPIOCHIP with
sysfs folder RIG_GPIOSIM. Times are those of virtual time; in real time only the order is sure.
"""

import re
import socket
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.linux.port_nodes import (
    CAN,
    CHIP,
    ENABLED,
    GPIOSIM,
    Controller,
    Nodes,
    wait_until,
)  # fmt: skip

ROOT = Path(__file__).resolve().parents[2]
ESTOP_LINE, READY_LINE, _, ENABLE_LINE, FAULT_LINE, CUT_LINE = range(8, 14)
ENABLE, DISABLE, START, STOP, RESET, SET = 1, 2, 3, 4, 5, 6
OK, ERR_ESTOP, ERR_DRIVE, ERR_BUS = 0, -27, -28, -37
PROGRAMS = [
    path
    for preset in ("linux", "linux-gpiod2")
    if (path := ROOT / "build" / preset / "hal" / "linux" / "camturn-linux").exists()
]


def missing() -> str:
    """Return why the tests cannot run here, "" when they can."""
    if CAN not in (name for _, name in socket.if_nameindex()):
        return f"no interface {CAN}; run in the User-Mode Linux kernel (tools/uml)"
    if not GPIOSIM.exists():
        return f"no simulated chip at {GPIOSIM}; run in the User-Mode Linux kernel (gpio-sim)"
    if not PROGRAMS:
        return "no camturn-linux; build it: cmake --workflow --preset linux"
    return ""


needs_kernel = pytest.mark.skipif(bool(missing()), reason=missing())

Start = Callable[..., Controller]


@dataclass
class Setup:
    """What tests change of the configuration, and as whom they start the program."""

    fd: bool = False
    max_age_us: int = 3000
    index: str = "position"
    interface: str = CAN
    prefix: tuple[str, ...] = ()


def config_text(table: Path, lines: dict[str, str], setup: Setup) -> str:
    """Return a configuration file; lines that are not given are those of the simulated chip."""
    names = ("estop", "ready", "index", "enable", "fault", "in_cut")
    places = {name: f"{CHIP}:{8 + i}" for i, name in enumerate(names)} | lines
    gpio = "".join(f'{name} = "{place}"\n' for name, place in places.items())
    return (
        f'[thread]\ntick_hz = 1000\n[can]\ninterface = "{setup.interface}"\n'
        f"fd = {str(setup.fd).lower()}\n"
        f'[encoder]\nindex = "{setup.index}"\nmax_age_us = {setup.max_age_us}\n'
        f'[operator]\nacknowledge = "waived"\n'
        f'[table]\nfile = "{table}"\n[parameters]\nfile = "{table}.toml"\n'
        f'[gpio]\nchip = "{CHIP}"\n{gpio}'
    )


def parameter(name: str) -> int:
    """Return the number of a parameter, from the header that lists them."""
    header = (ROOT / "firmware/param/cam_param.h").read_text()
    return re.findall(r"X\((\w+), +-?\d", header).index(name)


def enable(controller: Controller, nodes: Nodes) -> None:
    """Bring it to state ready at 300 r/min."""
    assert wait_until(lambda: controller.says("bus: all nodes are heard"), 2.0), (
        controller.log.read_text()
    )
    assert controller.command(SET, parameter("spindle_mrpm"), 300_000) == OK
    assert controller.command(ENABLE) == OK
    assert wait_until(lambda: controller.says("state ready"), 2.0), controller.log.read_text()
    assert {drive.status for drive in nodes.drives.values()} == {ENABLED}
