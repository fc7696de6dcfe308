# SPDX-License-Identifier: Apache-2.0
"""The Linux port against a scripted machine, on a kernel with vcan and gpio-sim.

Needs an interface RIG_CAN (default vcan0) that is up and a simulated chip RIG_GPIOCHIP with sysfs
folder RIG_GPIOSIM. Times are those of virtual time; in real time only the order is sure.
"""

from __future__ import annotations

import contextlib
import re
import signal
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from port_nodes import (
    CAN,
    CHIP,
    DISABLED,
    ENABLED,
    ENCODER,
    FAULT,
    GPIOSIM,
    INDEX_LINE,
    READY,
    SPINDLE,
    Controller,
    Nodes,
    U,
    X,
    Z,
    level,
    pack,
    pull,
    raw_socket,
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


def _missing() -> str:
    if CAN not in (name for _, name in socket.if_nameindex()):
        return f"no interface {CAN}; run in the User-Mode Linux kernel (tools/uml)"
    if not GPIOSIM.exists():
        return f"no simulated chip at {GPIOSIM}; run in the User-Mode Linux kernel (gpio-sim)"
    if not PROGRAMS:
        return "no camturn-linux; build it: cmake --workflow --preset linux"
    return ""


pytestmark = pytest.mark.skipif(bool(_missing()), reason=_missing())

Start = Callable[..., Controller]


@pytest.fixture(scope="module", params=PROGRAMS, ids=lambda path: path.parts[-4])
def program(request: pytest.FixtureRequest) -> Path:
    """Return each program that is built: with libgpiod 1 and with 2."""
    path: Path = request.param
    return path


@pytest.fixture
def nodes() -> Iterator[Nodes]:
    """Run the scripted machine, its chain closed and its lines ready."""
    for line in (ESTOP_LINE, READY_LINE):
        pull(line, True)
    pull(INDEX_LINE, False)
    machine = Nodes()
    machine.start()
    yield machine
    machine.stop()


@dataclass
class Setup:
    """What tests change of the configuration, and as whom they start the program."""

    fd: bool = False
    max_age_us: int = 3000
    index: str = "position"
    interface: str = CAN
    prefix: tuple[str, ...] = ()


def _text(table: Path, lines: dict[str, str], setup: Setup) -> str:
    names = ("estop", "ready", "index", "enable", "fault", "in_cut")
    places = {name: f"{CHIP}:{8 + i}" for i, name in enumerate(names)} | lines
    gpio = "".join(f'{name} = "{place}"\n' for name, place in places.items())
    return (
        f'[thread]\ntick_hz = 1000\n[can]\ninterface = "{setup.interface}"\nfd = {str(setup.fd).lower()}\n'
        f'[encoder]\nindex = "{setup.index}"\nmax_age_us = {setup.max_age_us}\n'
        f'[table]\nfile = "{table}"\n[gpio]\nchip = "{CHIP}"\n{gpio}'
    )


@pytest.fixture
def start(program: Path, table_of: Callable[[str], Path], tmp_path: Path) -> Iterator[Start]:
    """Start the controller; it is ended with the test."""
    running: list[Controller] = []

    def make(setup: Setup | None = None, **lines: str) -> Controller:
        setup = setup or Setup()
        table = tmp_path / "table.camtab"
        table.write_bytes(table_of("perkins240").read_bytes())
        config = tmp_path / f"machine{len(running)}.toml"
        config.write_text(_text(table, lines, setup))
        running.append(Controller([*setup.prefix, program], config, setup.interface))
        return running[-1]

    yield make
    for controller in running:
        if controller.process.poll() is None:
            controller.end(signal.SIGKILL)


def parameter(name: str) -> int:
    """Return the number of a parameter, from the header that lists them."""
    header = (ROOT / "firmware/include/cam/cam_param.h").read_text()
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


def test_drives_are_led_to_operation_enabled_step_by_step(nodes: Nodes, start: Start) -> None:
    """Shutdown, switch on, enable operation; the line follows; the SYNC comes with every tick."""
    controller = start()
    enable(controller, nodes)
    for drive in nodes.drives.values():
        assert drive.controls == [0x06, 0x07, 0x0F]
    assert level(ENABLE_LINE) and not level(FAULT_LINE)
    n_sync, begin_s = nodes.n_sync, time.monotonic()
    time.sleep(0.5)
    assert nodes.n_sync - n_sync == pytest.approx((time.monotonic() - begin_s) * 1000, abs=2)
    assert nodes.seen.count(0x300 + U) > 100  # velocity offset
    assert 0x740 in nodes.seen
    assert nodes.drives[SPINDLE].actual == 300_000
    assert nodes.drives[U].actual == -500_000  # retracted
    assert controller.end() == 0


def test_emergency_stop_retracts_then_lets_go(nodes: Nodes, start: Start) -> None:
    """From the edge to enable low: the fault within two ticks, the retract, then the quick stop."""
    controller = start()
    enable(controller, nodes)
    assert controller.command(START) == OK
    assert wait_until(lambda: level(CUT_LINE), 20.0), controller.log.read_text()
    pull(ESTOP_LINE, False)
    latched_s = wait_until(lambda: level(FAULT_LINE), 0.1)
    assert latched_s is not None and latched_s <= 0.003
    assert nodes.drives[SPINDLE].actual == 0 or wait_until(
        lambda: nodes.drives[SPINDLE].actual == 0, 0.01
    )
    assert wait_until(lambda: not level(ENABLE_LINE), 1.0)
    assert wait_until(lambda: nodes.drives[U].status != ENABLED, 0.01)
    assert 0x02 in nodes.drives[U].controls
    assert controller.tells("fault estop")
    pull(ESTOP_LINE, True)
    assert controller.command(RESET) == OK
    assert wait_until(lambda: not level(FAULT_LINE), 0.1)
    nodes.drives[U].controls.clear()
    assert controller.command(ENABLE) == OK
    assert wait_until(lambda: nodes.drives[U].status == ENABLED, 0.1)


@pytest.mark.parametrize("node", [U, X, Z])
def test_silent_drive_drops_enable_at_once(nodes: Nodes, start: Start, node: int) -> None:
    """A heartbeat that stays away is a fault; only a reset leads back."""
    controller = start()
    enable(controller, nodes)
    nodes.silent.add(node)
    seconds = wait_until(lambda: not level(ENABLE_LINE), 0.3)
    assert seconds is not None and seconds <= 0.1 + 0.003
    assert level(FAULT_LINE)
    for words in (f"bus: node {node} ", "no heartbeat", "fault bus", "fault drive"):
        assert controller.tells(words)
    nodes.silent.clear()
    time.sleep(0.2)
    assert level(FAULT_LINE), "it came back: the latch holds"
    assert controller.command(RESET) == OK
    assert wait_until(lambda: controller.command(ENABLE) == OK, 1.0)


def test_encoder_without_frames_retracts(nodes: Nodes, start: Start) -> None:
    """The encoder is lost beyond its age: the tool leaves the work while the drives still hear."""
    controller = start()
    enable(controller, nodes)
    nodes.mute.add(ENCODER)
    seconds = wait_until(lambda: level(FAULT_LINE), 0.1)
    assert seconds is not None and 0.001 <= seconds <= 0.006
    assert controller.tells("bus: node 1 (encoder): no measured values")
    assert controller.tells("fault bus") and not controller.says("fault drive")
    assert wait_until(lambda: not level(ENABLE_LINE), 1.0)


def test_drive_without_measured_values_is_not_ready(nodes: Nodes, start: Start) -> None:
    """Process data that stay away for pdo_timeout_ms are a loss of the drive."""
    controller = start()
    enable(controller, nodes)
    nodes.mute.add(Z)
    seconds = wait_until(lambda: not level(ENABLE_LINE), 0.1)
    assert seconds is not None and seconds <= 0.025
    assert wait_until(lambda: controller.says("node 4 (drive z): no measured values"), 0.1)


def test_drive_in_fault_and_emergency_message(nodes: Nodes, start: Start) -> None:
    """A drive's own fault drops enable; after the reset it is led out of it."""
    controller = start()
    enable(controller, nodes)
    nodes.extra.append((0x080 + U, bytes.fromhex("1186010000000000")))
    nodes.drives[U].status = FAULT
    assert wait_until(lambda: not level(ENABLE_LINE), 0.01)
    assert wait_until(
        lambda: controller.says("node 2 (drive u) is not ready: error code 8611h"), 0.1
    )
    time.sleep(0.1)
    assert nodes.drives[U].status == FAULT
    assert controller.command(RESET) == OK
    assert wait_until(lambda: nodes.drives[U].status in (DISABLED, READY), 1.5)
    assert wait_until(lambda: controller.command(ENABLE) == OK, 1.0)


def test_enable_is_refused_without_drives_lines_or_bus(nodes: Nodes, start: Start) -> None:
    """Each reason has its own answer."""
    controller = start()
    assert wait_until(lambda: controller.says("bus: all nodes are heard"), 2.0)
    assert controller.command(SET, parameter("spindle_mrpm"), 300_000) == OK
    pull(ESTOP_LINE, False)
    time.sleep(0.005)
    assert controller.command(ENABLE) == ERR_ESTOP
    pull(ESTOP_LINE, True)
    pull(READY_LINE, False)
    time.sleep(0.005)
    assert controller.command(ENABLE) == ERR_DRIVE
    pull(READY_LINE, True)
    nodes.mute.add(ENCODER)
    time.sleep(0.010)
    assert controller.command(ENABLE) == ERR_BUS
    nodes.mute.clear()
    time.sleep(0.010)
    assert controller.command(ENABLE) == OK


def test_interface_down_and_up_again(nodes: Nodes, start: Start) -> None:
    """Down: not ready and lost at once. Up: still in fault until the operator's reset."""
    controller = start()
    enable(controller, nodes)
    subprocess.run(["ip", "link", "set", CAN, "down"], check=True)
    seconds = wait_until(lambda: not level(ENABLE_LINE), 0.1)
    assert seconds is not None and seconds <= 0.005
    assert controller.tells("bus: the interface is down")
    subprocess.run(["ip", "link", "set", CAN, "up"], check=True)
    time.sleep(0.3)
    assert level(FAULT_LINE)
    assert controller.command(RESET) == OK
    assert wait_until(lambda: controller.command(ENABLE) == OK, 1.0), controller.log.read_text()


def test_another_controller_on_the_bus_is_noticed(nodes: Nodes, start: Start) -> None:
    """A second one keeps the first from working, and the other way round."""
    controller = start()
    enable(controller, nodes)
    other = raw_socket()
    other.send(pack((0x080, b"")))
    assert wait_until(lambda: level(FAULT_LINE), 0.01)
    assert controller.tells("another controller sends on this bus")
    other.close()


@pytest.mark.parametrize("by", [signal.SIGTERM, signal.SIGINT])
def test_signal_ends_it_with_the_drives_let_go(
    nodes: Nodes, start: Start, by: signal.Signals
) -> None:
    """The tool leaves the work, the drives stop and lose their voltage, the status is 0."""
    controller = start()
    enable(controller, nodes)
    assert controller.command(START) == OK
    assert wait_until(lambda: level(CUT_LINE), 20.0)
    assert controller.end(by) == 0
    time.sleep(0.005)
    assert not level(ENABLE_LINE)
    for node in (U, X, Z, SPINDLE):
        assert nodes.drives[node].controls[-2:] == [0x02, 0x00]
        assert nodes.drives[node].status == DISABLED
    assert nodes.drives[U].actual == -500_000


def test_second_signal_lets_go_at_once(nodes: Nodes, start: Start) -> None:
    """Whoever is in a hurry: quick stop without leaving the work first."""
    controller = start()
    enable(controller, nodes)
    assert controller.command(START) == OK
    assert wait_until(lambda: level(CUT_LINE), 20.0)
    u_nm = nodes.drives[U].actual
    controller.process.send_signal(signal.SIGINT)
    assert controller.end() == 0
    assert not level(ENABLE_LINE)
    assert nodes.drives[U].status == DISABLED
    assert abs(nodes.drives[U].actual - u_nm) < 200_000, "no retract to -500 um"


@pytest.mark.parametrize("by", [signal.SIGSEGV, signal.SIGABRT])
def test_crash_drops_enable_and_stops_the_drives(
    nodes: Nodes, start: Start, by: signal.Signals
) -> None:
    """The handler's last act; the status is still that of the crash."""
    controller = start()
    enable(controller, nodes)
    assert controller.end(by) == -by
    time.sleep(0.005)
    assert not level(ENABLE_LINE)
    for node in (U, X, Z, SPINDLE):
        assert nodes.drives[node].controls[-1] == 0x02


def test_systemd_is_told_ready_and_alive(
    nodes: Nodes, start: Start, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ready once, alive four times per watchdog interval, silent while the tick stands still."""
    manager = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    manager.bind(str(tmp_path / "notify"))
    manager.setblocking(False)
    monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
    monkeypatch.setenv("WATCHDOG_USEC", "400000")

    def heard() -> list[bytes]:
        words = []
        with contextlib.suppress(BlockingIOError):
            while True:
                words.append(manager.recv(64))
        return words

    controller = start()
    time.sleep(1.0)
    words = heard()
    assert words[0] == b"READY=1"
    assert set(words[1:]) == {b"WATCHDOG=1"} and len(words) == pytest.approx(11, abs=2)
    controller.process.send_signal(signal.SIGSTOP)
    heard()
    time.sleep(0.5)
    assert heard() == []
    controller.process.send_signal(signal.SIGCONT)
    assert controller.end() == 0
    manager.close()


def test_fd_carries_a_drive_in_one_frame(nodes: Nodes, start: Start) -> None:
    """With fd = true set-points are frames of 12 bytes, without a second one."""
    subprocess.run(["ip", "link", "set", CAN, "down"], check=True)
    subprocess.run(["ip", "link", "set", CAN, "mtu", "72", "up"], check=True)
    controller = start(Setup(fd=True))
    enable(controller, nodes)
    assert 12 in nodes.fd_lengths
    assert 0x300 + U not in nodes.seen
    assert controller.end() == 0


def test_frames_that_the_kernel_drops_are_noticed(nodes: Nodes, start: Start) -> None:
    """Stopped for a moment under a flood: the receive queue overflows, the bus is lost."""
    controller = start(Setup(max_age_us=50_000))
    enable(controller, nodes)
    controller.process.send_signal(signal.SIGSTOP)
    flood = raw_socket()
    for _ in range(2000):
        flood.send(pack((0x700 + Z, b"\x05")))
    controller.process.send_signal(signal.SIGCONT)
    flood.close()
    assert controller.tells("bus: received frames were lost")
    assert level(FAULT_LINE)


def refused(program: Path, config: Path) -> str:
    """Return what the program says that does not start; its status is 2."""
    done = subprocess.run(
        [program, "--config", config], capture_output=True, text=True, check=False, timeout=10
    )
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    return done.stderr


def test_lines_that_cannot_be_had_are_told(program: Path, tmp_path: Path, nodes: Nodes) -> None:
    """No such chip, no such line, no such offset, line in use by somebody: one line, status 2."""
    config = tmp_path / "machine.toml"

    def say(**lines: str) -> str:
        config.write_text(_text(tmp_path / "none", lines, Setup()))
        return refused(program, config)

    assert "gpio.estop: /dev/gpiochip77: no such GPIO chip" in say(estop="gpiochip77:0")
    assert f"gpio.ready: /dev/{CHIP} has no line NOBODY" in say(ready="NOBODY")
    assert f"gpio.index: /dev/{CHIP} has no line 99" in say(index=f"{CHIP}:99")
    assert "no number behind the colon" in say(fault=f"{CHIP}:x")
    user = subprocess.Popen(["gpioset", "--mode=signal", CHIP, f"{ENABLE_LINE}=0"])
    time.sleep(0.2)
    words = say()
    user.terminate()
    user.wait()
    assert f"gpio.enable: line {ENABLE_LINE} of /dev/{CHIP} is in use by gpioset" in words


def test_interfaces_that_cannot_be_had_are_told(
    program: Path, tmp_path: Path, nodes: Nodes
) -> None:
    """No such interface, one that is no CAN, one that is down."""
    config = tmp_path / "machine.toml"
    text = _text(tmp_path / "none", {}, Setup())

    def say(interface: str) -> str:
        config.write_text(text.replace(f'"{CAN}"', f'"{interface}"'))
        return refused(program, config)

    assert "nocan: no such CAN interface" in say("nocan")
    assert "lo: is no CAN interface" in say("lo")
    subprocess.run(["ip", "link", "set", CAN, "down"], check=True)
    try:
        assert f"{CAN}: bring it up" in say(CAN)
    finally:
        subprocess.run(["ip", "link", "set", CAN, "up"], check=True)


def test_index_line_gives_the_angle(nodes: Nodes, start: Start) -> None:
    """Edges of the line become an index that stays at one place, turn after turn."""
    nodes.has_index_line = True
    controller = start(Setup(index="line"))
    enable(controller, nodes)
    time.sleep(1.5)  # seven turns
    assert not level(FAULT_LINE), controller.log.read_text()
    nodes.has_index_line = False
    seconds = wait_until(lambda: level(FAULT_LINE), 0.5)
    assert seconds is not None and seconds <= 0.2 * 1.125 + 0.003
    assert controller.tells("fault index_missing")


def test_interface_that_was_removed_is_used_again(start: Start) -> None:
    """Removed and made anew: a fault, and after the reset it goes on."""
    make = "ip link add dev vcan7 type vcan && ip link set vcan7 up"
    subprocess.run(make, shell=True, check=True)
    for line in (ESTOP_LINE, READY_LINE):
        pull(line, True)
    nodes = Nodes("vcan7")
    nodes.start()
    controller = start(Setup(interface="vcan7"))
    enable(controller, nodes)
    subprocess.run(["ip", "link", "del", "vcan7"], check=True)
    assert wait_until(lambda: level(FAULT_LINE), 0.01)
    assert controller.tells("bus: the interface is down")
    nodes.stop()
    subprocess.run(make, shell=True, check=True)
    nodes = Nodes("vcan7")
    nodes.operational = {ENCODER, U, X, Z, SPINDLE}
    nodes.start()
    controller.can.close()
    controller.can = raw_socket("vcan7")
    time.sleep(1.1)  # looked for once a second
    assert wait_until(lambda: controller.command(RESET) == OK, 1.0), controller.log.read_text()
    assert wait_until(lambda: controller.command(ENABLE) == OK, 2.0), controller.log.read_text()
    assert controller.end() == 0
    nodes.stop()
    subprocess.run(["ip", "link", "del", "vcan7"], check=True)


def test_without_privileges_it_runs_and_says_what_is_lost(nodes: Nodes, start: Start) -> None:
    """Without capabilities and limits: no SCHED_FIFO, a warning, and the machine works."""
    limits = ("prlimit", "--memlock=65536", "--rtprio=0")
    rights = ("setpriv", "--bounding-set=-all", "--inh-caps=-all")
    controller = start(Setup(prefix=(*limits, *rights)))
    enable(controller, nodes)
    assert controller.says("warning: SCHED_FIFO is not permitted")
    assert controller.says("warning: memory is not locked")
    assert controller.end() == 0


CONFIGFS = Path("/sys/kernel/config/gpio-sim")


def test_chip_that_vanishes_is_an_emergency_stop(nodes: Nodes, start: Start) -> None:
    """A chip of its own is taken away in state ready: the drives are let go by the bus."""
    if not CONFIGFS.exists():
        pytest.skip(f"no {CONFIGFS}; mount configfs")
    chip = CONFIGFS / "vanishing"
    (chip / "bank0").mkdir(parents=True)
    (chip / "bank0" / "num_lines").write_text("2")
    (chip / "live").write_text("1")
    name = (chip / "bank0" / "chip_name").read_text().strip()
    device = (chip / "dev_name").read_text().strip()
    line = Path(f"/sys/devices/platform/{device}/{name}/sim_gpio0/pull")
    line.write_text("pull-up")
    controller = start(ready=f"{name}:0", enable=f"{name}:1")
    enable(controller, nodes)
    (chip / "live").write_text("0")
    assert wait_until(lambda: nodes.drives[U].status != ENABLED, 0.1)
    assert controller.tells("the line is lost")
    assert level(FAULT_LINE)
    assert controller.tells("fault estop")
    assert controller.end() == 0
    (chip / "bank0").rmdir()
    chip.rmdir()
