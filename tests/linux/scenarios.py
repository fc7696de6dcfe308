# SPDX-License-Identifier: Apache-2.0
"""What happens in each scenario; test_linux.py judges it. Runs inside the kernel (inside.py)."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from tests.linux.inside import BLOCK_BYTES, ENABLE, RESET, START, Bus, Line, Session, main

POLL_S = 20e-6
TICK_NS = 1_000_000


def as_fast_as_the_tick() -> None:
    """Poll without the timer slack of ordinary processes."""
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(20))


def wait_line(line: Line, is_high: bool, limit_s: float = 5.0) -> float:
    """Return when the line got its level [s]."""
    until_s = time.monotonic() + limit_s
    while line.is_high() != is_high:
        assert time.monotonic() < until_s, "the line does not move"
        time.sleep(POLL_S)
    return time.monotonic()


def whole_cut(s: Session) -> None:
    """Cut the part from end to end."""
    s.bring_to("cutting")
    s.wait_machine()
    s.stop_controller()


def recorded(s: Session) -> None:
    """Cut while candump writes down what is on the bus."""
    s.bring_to("ready", "--stay")
    recorder = s.spawn("candump", "candump", "-L", "vcan0")
    time.sleep(0.1)
    s.command(START)
    s.wait_state("cutting")
    time.sleep(0.1)
    recorder.terminate()
    recorder.wait(5)


def cut_on(s: Session) -> None:
    """Cut until the machine has its end, whatever its words say goes wrong."""
    s.bring_to("cutting")
    s.wait_machine()
    s.seen["state"], s.seen["faults"] = s.state()
    s.stop_controller()


def estop(s: Session) -> None:
    """Open the emergency-stop chain in the cut, then in readiness at four phases of the tick."""
    chain, fault, enable = Line("ESTOP"), Line("FAULT"), Line("ENABLE")
    as_fast_as_the_tick()
    s.bring_to("cutting", "--stay")
    s.seen["reactions"] = []
    for i in range(5):
        time.sleep(0.1)
        time.sleep(1e-3 - time.monotonic() % 1e-3 + i * 0.2e-3)
        at_s = time.monotonic()
        chain.pull(False)
        fault_s = wait_line(fault, True) - at_s
        low_s = wait_line(enable, False) - at_s
        s.seen["reactions"].append({"fault_s": fault_s, "enable_low_s": low_s})
        s.wait_state("fault")
        chain.pull(True)
        time.sleep(0.05)
        s.seen["reset"] = s.command(RESET)
        s.wait_state("off")
        s.seen["enable"] = s.command(ENABLE)
        s.wait_state("ready")


def link_down(s: Session) -> None:
    """Take the interface down in the cut; up again; reset; enable."""
    s.bring_to("cutting", "--stay")
    time.sleep(0.1)
    subprocess.run(["ip", "link", "set", "vcan0", "down"], check=True)
    at_s = time.monotonic()
    s.seen["fault_s"] = wait_line(Line("FAULT"), True) - at_s
    s.seen["enable_low_s"] = wait_line(Line("ENABLE"), False) - at_s
    time.sleep(0.5)
    s.event("link up")
    subprocess.run(["ip", "link", "set", "vcan0", "up"], check=True)
    s.listen()
    time.sleep(0.5)
    s.seen["after"] = s.state()
    s.seen["refused"] = s.command(ENABLE)
    s.seen["reset"] = s.command(RESET)
    s.wait_state("off")
    time.sleep(0.3)
    s.seen["enable"] = s.command(ENABLE)
    s.wait_state("ready")


def flood(s: Session) -> None:
    """Fill the bus with foreign frames while cutting: eight of them in every millisecond."""
    bus = Bus("vcan0", 0x7FF)
    s.bring_to("cutting", "--stay")
    until_s = time.monotonic() + 0.5
    n = 0
    while time.monotonic() < until_s:
        for _ in range(8):
            bus.send(0x555, b"\xff" * 8)
            n += 1
        time.sleep(1e-3)
    s.seen["n_foreign"] = n
    s.seen["state"], s.seen["faults"] = s.state()


def lines_busy(s: Session) -> None:
    """Start a controller whose lines are held by another program."""
    holder = s.spawn("gpioset", "gpioset", "--mode=signal", "gpiochip0", "3=0")
    time.sleep(0.1)
    s.start_controller()
    assert s.controller is not None
    s.seen["controller_status"] = s.controller.wait(5)
    holder.terminate()


def two_controllers(s: Session) -> None:
    """Start a second controller, without lines, on the bus of one that cuts; the first ends."""
    s.bring_to("cutting")
    recorder = s.spawn("candump", "candump", "-L", "vcan0")
    time.sleep(0.1)
    s.event("second")
    second = s.spawn("second", s.setup["controller"], "--config", str(s.out / "second.toml"))
    time.sleep(0.5)
    s.seen["second_enable"] = s.ask_node(s.setup["second_node"], ENABLE)
    s.wait_machine()
    recorder.terminate()
    recorder.wait(5)
    recorder = s.spawn("after", "candump", "-L", "vcan0")
    time.sleep(0.1)
    s.stop_controller()
    time.sleep(0.3)
    s.seen["second_status"] = second.poll()
    recorder.terminate()
    recorder.wait(5)


def terminated(s: Session) -> None:
    """End the controller in good order while it cuts."""
    s.bring_to("cutting")
    time.sleep(0.1)
    s.stop_controller(signal.SIGTERM)
    s.wait_machine()


def killed(s: Session) -> None:
    """Kill the controller while it cuts: nothing of it is left to stop the drives."""
    s.bring_to("cutting")
    time.sleep(s.setup["killed_after_s"])
    s.stop_controller(signal.SIGKILL)
    s.wait_machine()


def canopen_drive(s: Session) -> None:
    """Cut with a U drive that is not ours."""
    s.spawn("drive", sys.executable, str(Path(__file__).with_name("canopen_drive.py")))
    time.sleep(0.5)
    s.bring_to("cutting", "--without", "u")
    s.wait_machine()
    s.stop_controller()


def download(s: Session) -> None:
    """Break a download off by a kill, at its ends and between; let camctl bring the table whole."""
    place = s.out / "table.camtab"
    before, other = place.read_bytes(), Path(s.setup["other_table"]).read_bytes()
    s.start_machine("--stay")
    n_most = -(-len(other) // BLOCK_BYTES)
    broken_off = (0, 1, n_most // 2, n_most - 1, n_most)
    for n_blocks in broken_off:
        s.start_controller()
        s.begin_download(other, n_blocks)
        s.stop_controller(signal.SIGKILL)
        assert place.read_bytes() == before, f"after {n_blocks} blocks"
    s.seen["n_broken_off"] = len(broken_off)
    s.start_controller()
    camctl = [sys.executable, "-m", "camtools.cli.camctl", "-i", "socketcan", "-c", "vcan0"]
    camctl += ["--secret", str(s.out / "secret")]
    for words in (("table", "download", s.setup["other_table"]), ("select",), ("table", "info")):
        s.seen["camctl"] = s.spawn("camctl", *camctl, *words).wait(30)
        assert s.seen["camctl"] == 0, words
    assert place.read_bytes() == other
    s.stop_controller()


def real_time(s: Session) -> None:
    """Let a thousand ticks a second run for ten seconds and note when each SYNC came."""
    syncs = Bus("vcan0", 0x080)
    s.start_machine("--stay")
    s.start_controller()
    time.sleep(1.0)
    begin_ns = time.monotonic_ns()
    time.sleep(10.0)
    end_ns = time.monotonic_ns()
    s.stop_controller()
    s.close()
    s.seen["wanted"] = (end_ns - begin_ns) // TICK_NS
    s.seen["late_ns"] = [t % TICK_NS for t in syncs.stamps_ns() if begin_ns <= t < end_ns]


SCENARIOS = {
    f.__name__: f
    for f in (
        whole_cut,
        recorded,
        cut_on,
        estop,
        link_down,
        flood,
        lines_busy,
        two_controllers,
        terminated,
        killed,
        canopen_drive,
        download,
        real_time,
    )
}

if __name__ == "__main__":
    sys.exit(main(SCENARIOS))
