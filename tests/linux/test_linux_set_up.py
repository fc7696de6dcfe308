"""The Linux port and its computer: what it asks for at the start, and what is taken from it."""

import contextlib
import re
import shlex
import signal
import socket
import subprocess
import time
from pathlib import Path

import pytest

from camtools.base.errors import CamtoolsError
from camtools.link.bus import open_bus
from tests.linux.port_cases import (
    ENABLE,
    ENABLE_LINE,
    ESTOP_LINE,
    FAULT_LINE,
    OK,
    READY_LINE,
    RESET,
    ROOT,
    Setup,
    Start,
    config_text,
    enable,
    needs_kernel,
)
from tests.linux.port_nodes import (
    CAN,
    CHIP,
    ENABLED,
    ENCODER,
    SPINDLE,
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
from tests.tools.cases.camsim_cases import camsim
from tests.tools.cases.part_cases import TableOf

pytest_plugins = ["tests.linux.port_fixtures"]
pytestmark = needs_kernel


def test_systemd_is_notified_ready_and_alive(
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
    assert controller.reports("bus: received frames were lost")
    assert level(FAULT_LINE)


def refused(program: Path, config: Path) -> str:
    """Return what the program says that does not start; its status is 2."""
    done = subprocess.run(
        [program, "--config", config], capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    return done.stderr


def test_unavailable_lines_are_reported(program: Path, tmp_path: Path, nodes: Nodes) -> None:
    """No such chip, no such line, no such offset, line in use by somebody: one line, status 2."""
    config = tmp_path / "machine.toml"

    def say(**lines: str) -> str:
        config.write_text(config_text(tmp_path / "none", lines, Setup()))
        return refused(program, config)

    assert "gpio.estop: /dev/gpiochip77: no such GPIO chip" in say(estop="gpiochip77:0")
    assert f"gpio.ready: /dev/{CHIP} has no line NOBODY" in say(ready="NOBODY")
    assert f"gpio.index: /dev/{CHIP} has no line 99" in say(index=f"{CHIP}:99")
    assert "no number after the colon" in say(fault=f"{CHIP}:x")
    user = subprocess.Popen(["gpioset", "--mode=signal", CHIP, f"{ENABLE_LINE}=0"])
    time.sleep(0.2)
    words = say()
    user.terminate()
    user.wait()
    assert f"gpio.enable: line {ENABLE_LINE} of /dev/{CHIP} is in use by gpioset" in words


def test_unavailable_interfaces_are_reported(
    program: Path, tmp_path: Path, nodes: Nodes, table_of: TableOf
) -> None:
    """No such interface, one that is no CAN, one that is down."""
    config = tmp_path / "machine.toml"
    text = config_text(tmp_path / "none", {}, Setup()).replace("tick_hz = 1000", "tick_hz = 500")

    def say(interface: str) -> str:
        config.write_text(text.replace(f'"{CAN}"', f'"{interface}"'))
        return refused(program, config)

    assert "nocan: no such CAN interface" in say("nocan")
    assert "lo: not a CAN interface" in say("lo")
    subprocess.run(["ip", "link", "set", CAN, "down"], check=True)
    try:
        assert f"{CAN}: bring the interface up: ip link set NAME up" in say(CAN)
        with pytest.raises(CamtoolsError, match=f"{CAN}: .* is down.*; bring the interface up: ip"):
            open_bus({"interface": "socketcan", "channel": CAN})
        machine = camsim("bus", table_of("perkins240"), "--can", CAN, "--gpiochip", CHIP)
        assert f"--can {CAN}: Network is down; bring the interface up" in machine.stderr
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
    assert controller.reports("fault index_missing")


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
    assert controller.reports("bus: the interface is down")
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


NAMED_ENABLE = 3  # its offset in tools/linux_kernel/machine
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
    assert controller.reports("line lost")
    assert level(FAULT_LINE)
    assert controller.reports("fault estop")
    assert controller.end() == 0
    (chip / "bank0").rmdir()
    chip.rmdir()


def test_short_queue_of_the_interface_is_reported(nodes: Nodes, start: Start) -> None:
    """Ten frames, the default of a CAN interface, are less than a tick's."""
    subprocess.run(["ip", "link", "set", CAN, "txqueuelen", "10"], check=True)
    try:
        controller = start()
        words = f"{CAN}: its queue holds 10 frames, a tick may send 14"
        assert wait_until(lambda: controller.says(words), 1.0), controller.log.read_text()
        assert controller.says(f"ip link set {CAN} txqueuelen 100")
        assert controller.end() == 0
    finally:
        subprocess.run(["ip", "link", "set", CAN, "txqueuelen", "100"], check=True)
    controller = start()
    assert wait_until(lambda: controller.says("bus: all nodes are heard"), 2.0)
    assert not controller.says("its queue holds")


def test_unit_takes_enable_down_behind_a_killed_controller(nodes: Nodes, start: Start) -> None:
    """The line is free then, and the command of the unit file can have it."""
    unit = (ROOT / "hal" / "linux" / "camturn.service").read_text()
    command = re.search(r"^ExecStopPost=-(.*)$", unit, re.MULTILINE)
    assert command
    words = shlex.split(command[1].replace("$$", "$"))
    controller = start(enable="ENABLE")
    enable(controller, nodes)
    assert level(NAMED_ENABLE)
    assert subprocess.run(words, capture_output=True, check=False).returncode != 0
    assert controller.end(signal.SIGKILL) == -signal.SIGKILL
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert not level(NAMED_ENABLE)
