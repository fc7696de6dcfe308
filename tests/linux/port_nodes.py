"""A scripted machine on a CAN bus: an encoder, four drives and the controller's own program.

Written from hal/linux/README.md, not from the port's code, and only as much of a machine as the
port can see: drives that follow at once, an encoder that turns at a constant speed.
"""

import contextlib
import os
import signal
import socket
import struct
import subprocess
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

CAN = os.environ.get("RIG_CAN", "vcan0")
CHIP = os.environ.get("RIG_GPIOCHIP", "gpiochip0")
GPIOSIM = Path(os.environ.get("RIG_GPIOSIM", "/sys/devices/platform/gpio-sim.0/gpiochip0"))
TICK_S = 1e-3
ENCODER, U, X, Z, SPINDLE, CONTROLLER = 1, 2, 3, 4, 5, 64
NODES = (ENCODER, U, X, Z, SPINDLE)
HEARTBEAT_TICKS = 40
INDEX_LINE = 10
COUNTS_PER_TURN = 10_000
TAKE_COMMAND, HEARTBEAT, ERR_NOT_COMMANDER, SENDER = 60, 62, -122, 5

# Status words of CiA 402 with voltage enabled, quick stop not active.
DISABLED, READY, SWITCHED_ON, ENABLED, QUICK_STOP, FAULT = 0x250, 0x231, 0x233, 0x237, 0x217, 0x218

Frame = tuple[int, bytes]


def raw_socket(interface: str = CAN) -> socket.socket:
    """Return a CAN socket that takes classic and FD frames and does not wait."""
    can = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
    can.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FD_FRAMES, 1)
    can.bind((interface,))
    can.setblocking(False)
    return can


def pack(frame: Frame) -> bytes:
    """Return a classic frame as the kernel wants it."""
    identifier, data = frame
    return struct.pack("=IB3x8s", identifier, len(data), data)


def receive(can: socket.socket) -> Frame | None:
    """Take a frame; None when there is none or the interface is down."""
    try:
        raw = can.recv(72)
    except OSError:
        return None
    identifier, length = struct.unpack_from("=IB", raw)
    return identifier, raw[8 : 8 + length]


@dataclass
class Drive:
    """One CiA 402 drive: control words set its state, and it stands where it is commanded."""

    status: int = DISABLED
    actual: int = 0
    offset: int = 0
    controls: list[int] = field(default_factory=list)  # each change
    frames: list[bytes] = field(default_factory=list)  # of the last SYNC
    emcy: int = 0

    def take(self, control: int, target: int) -> None:
        """Take a control word and a target; both act at once."""
        if not self.controls or self.controls[-1] != control:
            self.controls.append(control)
        if self.status == FAULT:
            self.status = DISABLED if control & 0x80 else FAULT
        elif not control & 2:
            self.status = DISABLED
        elif not control & 4:
            self.status = QUICK_STOP if self.status == ENABLED else DISABLED
        elif self.status in (DISABLED, QUICK_STOP):
            self.status = READY if control & 0xF == 6 and self.status == DISABLED else DISABLED
        elif control & 0xF == 6:
            self.status = READY
        elif control & 0xF == 7:
            self.status = SWITCHED_ON
        elif control & 0xF == 0xF and self.status in (SWITCHED_ON, ENABLED):
            self.status = ENABLED
        if self.status == ENABLED:
            self.actual = target


class Nodes(threading.Thread):
    """All nodes, half a tick before the controller's ticks."""

    def __init__(self, interface: str = CAN, rpm: float = 300.0) -> None:
        super().__init__(daemon=True)
        self.can = raw_socket(interface)
        self.drives = {node: Drive() for node in (U, X, Z, SPINDLE)}
        self.counts_per_tick = rpm / 60.0 * COUNTS_PER_TURN * TICK_S
        self.position = 0.0
        self.has_index_line = False
        self.silent: set[int] = set()  # no heartbeat
        self.mute: set[int] = set()  # no process data
        self.seen: list[int] = []  # identifiers of everything that others sent
        self.n_sync = 0
        self.fd_lengths: set[int] = set()
        self.operational: set[int] = set()
        self.extra: list[Frame] = []  # sent once, then forgotten
        self.is_over = threading.Event()
        self.n_steps = 0

    def run(self) -> None:
        """Step at absolute times until `is_over` is set."""
        due_s = (time.monotonic() // TICK_S + 1.5) * TICK_S
        while not self.is_over.is_set():
            time.sleep(max(0.0, due_s - time.monotonic()))
            self.step()
            due_s += TICK_S

    def stop(self) -> None:
        """End the thread."""
        self.is_over.set()
        self.join()
        self.can.close()

    def step(self) -> None:
        """Take what came, answer the SYNC, send the encoder's position."""
        has_sync = False
        while (frame := receive(self.can)) is not None:
            has_sync |= self.take(*frame)
        turns = self.position // COUNTS_PER_TURN
        self.position += self.counts_per_tick
        if self.has_index_line:
            pull(INDEX_LINE, self.position // COUNTS_PER_TURN != turns)  # one tick long
        if ENCODER not in self.mute and ENCODER in self.operational:
            self.send(0x180 + ENCODER, struct.pack("<I", int(self.position) % 2**32))
        for node, drive in self.drives.items():
            if has_sync and node not in self.mute and node in self.operational:
                self.send(0x180 + node, struct.pack("<Hi", drive.status, drive.actual))
        for node in NODES:
            if node not in self.silent and self.n_steps % HEARTBEAT_TICKS == 0:
                self.send(0x700 + node, bytes([5 if node in self.operational else 127]))
        while self.extra:
            self.send(*self.extra.pop(0))
        self.n_steps += 1

    def send(self, identifier: int, data: bytes) -> None:
        """Send a frame; an interface that is down swallows it."""
        with contextlib.suppress(OSError):
            self.can.send(pack((identifier, data)))

    def take(self, identifier: int, data: bytes) -> bool:
        """Take a frame; return whether it was the SYNC."""
        self.seen.append(identifier)
        node = identifier & 0x7F
        if identifier == 0 and data[0] == 1:
            self.operational |= set(NODES) if data[1] == 0 else {data[1]}
        elif identifier == 0x200 + node and node in self.drives:
            control, target = struct.unpack_from("<Hi", data)
            self.drives[node].take(control, target)
            self.fd_lengths.add(len(data))
        elif identifier == 0x300 + node and node in self.drives:
            self.drives[node].offset = struct.unpack("<i", data)[0]
        self.n_sync += identifier == 0x080
        return identifier == 0x080


def pull(offset: int, is_high: bool) -> None:
    """Drive an input line of the simulated chip."""
    (GPIOSIM / f"sim_gpio{offset}" / "pull").write_text("pull-up" if is_high else "pull-down")


def level(offset: int) -> bool:
    """Return what an output line of the simulated chip shows."""
    return (GPIOSIM / f"sim_gpio{offset}" / "value").read_text().strip() == "1"


def wait_until(
    condition: Callable[[], bool], seconds: float, every_s: float = 0.0005
) -> float | None:
    """Return the seconds until it holds, or None; in virtual time."""
    start_s = time.monotonic()
    while time.monotonic() - start_s < seconds:
        if condition():
            return time.monotonic() - start_s
        time.sleep(every_s)
    return None


class Controller:
    """The program under test, its configuration and what it says."""

    def __init__(self, program: list[str | Path], config: Path, interface: str = CAN) -> None:
        self.log = config.with_suffix(".log")
        with self.log.open("w") as log:
            self.process = subprocess.Popen([*program, "--config", config], stderr=log)
        self.can = raw_socket(interface)
        self.session = 0
        self.is_over = threading.Event()
        threading.Thread(target=self._keep_command, args=(interface,), daemon=True).start()

    def _keep_command(self, interface: str) -> None:
        """Send the heartbeats of who has command."""
        can = raw_socket(interface)
        while not self.is_over.wait(0.2):
            if self.session:
                data = struct.pack("<BBBBi", HEARTBEAT, 0, SENDER, self.session, 0)
                with contextlib.suppress(OSError):  # the test takes the interface down
                    can.send(pack((0x600 + CONTROLLER, data)))
        can.close()

    def says(self, words: str) -> bool:
        """Return whether the log contains the words."""
        return words in self.log.read_text()

    def reports(self, words: str) -> bool:
        """Return whether it says that within a tenth of a second: a line comes after the fact."""
        return wait_until(lambda: self.says(words), 0.1) is not None

    def command(self, number: int, parameter: int = 0, value: int = 0) -> int | None:
        """Send a command as who has command; return its result, None without an answer."""
        result = self.raw(number, parameter, value)
        if result is not None and result[0] == ERR_NOT_COMMANDER:  # not taken, or lost
            taken = self.raw(TAKE_COMMAND)
            assert taken is not None and taken[0] == 0
            self.session = taken[1]
            result = self.raw(number, parameter, value)
        return None if result is None else result[0]

    def raw(self, number: int, parameter: int = 0, value: int = 0) -> tuple[int, int] | None:
        """Send a command, whoever has it; return result and value, None without an answer."""
        while receive(self.can) is not None:
            pass
        data = struct.pack("<BBBBi", number, parameter, SENDER, self.session, value)
        self.can.send(pack((0x600 + CONTROLLER, data)))
        answers: list[tuple[int, int]] = []

        def is_answered() -> bool:
            while (frame := receive(self.can)) is not None:
                if frame[0] == 0x580 + CONTROLLER and frame[1][0] == number:
                    answers.append(struct.unpack_from("<hi", frame[1], 2))
            return bool(answers)

        wait_until(is_answered, 0.5)
        return answers[0] if answers else None

    def end(self, by: signal.Signals = signal.SIGTERM) -> int:
        """End it by a signal; return its exit status."""
        self.is_over.set()
        if self.process.poll() is None:
            self.process.send_signal(by)
        status = self.process.wait()
        self.can.close()
        return status
