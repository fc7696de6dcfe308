"""The Linux port in operation, against a scripted machine: enable, trouble on the bus, the end."""

import os
import signal
import subprocess
import time

import pytest

from tests.linux.port_cases import (
    CUT_LINE,
    ENABLE,
    ENABLE_LINE,
    ERR_BUS,
    ERR_DRIVE,
    ERR_ESTOP,
    ESTOP_LINE,
    FAULT_LINE,
    OK,
    READY_LINE,
    RESET,
    SET,
    START,
    Start,
    enable,
    needs_kernel,
    parameter,
)
from tests.linux.port_nodes import (
    CAN,
    DISABLED,
    ENABLED,
    ENCODER,
    FAULT,
    READY,
    SPINDLE,
    TICK_S,
    Nodes,
    U,
    X,
    Z,
    level,
    pull,
    wait_until,
)  # fmt: skip

pytest_plugins = ["tests.linux.port_fixtures"]
pytestmark = needs_kernel


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
    """In the cut, then in readiness at four phases of the tick: fault, retract, quick stop."""
    controller = start()
    enable(controller, nodes)
    assert controller.command(START) == OK
    assert wait_until(lambda: level(CUT_LINE), 20.0), controller.log.read_text()
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(20))  # without timer slack
    for phase in range(5):
        time.sleep(TICK_S - time.monotonic() % TICK_S + 0.2 * phase * TICK_S)
        pull(ESTOP_LINE, False)
        latched_s = wait_until(lambda: level(FAULT_LINE), 0.1, every_s=20e-6)
        assert latched_s is not None and latched_s <= 1.05 * TICK_S
        assert wait_until(lambda: nodes.drives[SPINDLE].actual == 0, 0.01) is not None
        assert (low_s := wait_until(lambda: not level(ENABLE_LINE), 1.0))
        assert low_s <= 0.06
        assert wait_until(lambda: nodes.drives[U].status != ENABLED, 0.01) is not None
        assert 0x02 in nodes.drives[U].controls
        assert controller.reports("fault estop")
        pull(ESTOP_LINE, True)
        assert controller.command(RESET) == OK
        assert wait_until(lambda: not level(FAULT_LINE), 0.1) is not None
        nodes.drives[U].controls.clear()
        assert controller.command(ENABLE) == OK
        assert wait_until(lambda: nodes.drives[U].status == ENABLED, 0.1) is not None
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


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
        assert controller.reports(words)
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
    assert controller.reports("bus: node 1 (encoder): no measured values")
    assert controller.reports("fault bus") and not controller.says("fault drive")
    assert wait_until(lambda: not level(ENABLE_LINE), 1.0)


def test_drive_in_fault_and_emergency_message(nodes: Nodes, start: Start) -> None:
    """A drive's own fault drops enable; after the reset it is led out of it."""
    controller = start()
    enable(controller, nodes)
    nodes.extra.append((0x080 + U, bytes.fromhex("1186010000000000")))
    nodes.drives[U].status = FAULT
    seconds = wait_until(lambda: not level(ENABLE_LINE), 0.01)
    assert seconds is not None and seconds <= 0.003
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
    fault_s = wait_until(lambda: level(FAULT_LINE), 0.1, every_s=1e-4)
    assert fault_s is not None and fault_s <= 2 * TICK_S
    seconds = wait_until(lambda: not level(ENABLE_LINE), 0.1)
    assert seconds is not None and seconds + fault_s <= 0.005
    assert controller.reports("bus: the interface is down")
    subprocess.run(["ip", "link", "set", CAN, "up"], check=True)
    time.sleep(0.3)
    assert level(FAULT_LINE) and controller.command(ENABLE) != OK
    assert controller.command(RESET) == OK
    assert wait_until(lambda: controller.command(ENABLE) == OK, 1.0), controller.log.read_text()


def test_nothing_is_sent_while_it_listens(nodes: Nodes, start: Start) -> None:
    """A tenth of a second, the status included; then it starts the nodes."""
    nodes.seen.clear()
    controller = start()
    assert wait_until(lambda: controller.says("listening for another controller"), 1.0)
    assert nodes.seen == []
    assert wait_until(lambda: 0x1C0 in nodes.seen, 0.2)
    assert nodes.seen[0] in (0x080, 0x1C0, 0x202) and 0x000 in nodes.seen
    assert wait_until(lambda: controller.says("bus: all nodes are heard"), 1.0)


@pytest.mark.parametrize("by", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP])
def test_signal_ends_it_with_the_drives_let_go(
    nodes: Nodes, start: Start, by: signal.Signals
) -> None:
    """The tool leaves the work, the drives lose their voltage, the status is 0; also by SIGHUP."""
    controller = start()
    enable(controller, nodes)
    assert controller.command(START) == OK
    assert wait_until(lambda: level(CUT_LINE), 20.0)
    if by == signal.SIGHUP:
        controller.process.send_signal(by)
        time.sleep(0.005)
    assert controller.end(signal.SIGTERM if by == signal.SIGHUP else by) == 0
    time.sleep(0.005)
    assert not level(ENABLE_LINE)
    for node in (U, X, Z, SPINDLE):
        assert nodes.drives[node].controls[-2:] == [0x02, 0x00]
        assert nodes.drives[node].status == DISABLED
    assert nodes.drives[U].actual == pytest.approx(-500_000, abs=20)  # a rest of what fades


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
