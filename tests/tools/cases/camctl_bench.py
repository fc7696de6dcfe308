"""The firmware with an ideal machine, over a bus within this process, for tests of camctl."""

import csv
import io
import struct
import subprocess
import threading
import time
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import can

from camtools.cli.camctl import main
from camtools.cli.camctl_control import RightsOptions
from camtools.cli.camctl_operate import follow_cut
from camtools.link.controller import PERIOD_S, Link, Status
from camtools.link.messages import COMMAND, Refused, command_bytes
from camtools.link.refusal_text import ask_done
from camtools.link.rights import SharedSession, sender_of
from checks.patience import limit_s, slowness, until
from tests.tools.cases.camsim_cases import BUILD

BENCH = BUILD / "tests" / "camctl" / "can_bench"
FRAME = struct.Struct("<IB3x64s")
CLASSIC_BYTES = 8
Act = Callable[[], object]
Refusal = Callable[..., str]
PACE = min(1.0, 3.0 / slowness())  # virtual time by the clock: signs of life must not come late
ESTOP_ID, BUTTON_ID, KEY_ID, FORCE_ID, DRIVE_ID, BUS_ID = range(0x10000, 0x10006)
FAULTS = {"estop": ESTOP_ID, "drive": DRIVE_ID, "bus": BUS_ID}


@contextmanager
def linked(bench: "Bench") -> Iterator[Link]:
    """Give a link to the controller of a bench over a bus of its own."""
    bus = can.Bus(interface="virtual", channel=bench.channel)
    try:
        yield Link(bus, f"virtual {bench.channel}", bench.node)
    finally:
        bus.shutdown()


def pass_time(link: Link, seconds: float) -> None:
    """Wait while virtual time passes, by the rows of the status."""
    end = link.status.n_rows + seconds / PERIOD_S
    assert link.wait(lambda: link.status.n_rows >= end, limit_s(seconds + 60))


def act_when(bench: "Bench", is_so: Callable[[Status], bool], act: Act) -> threading.Thread:
    """Act beside the test when the status meets a condition; return the thread."""

    def look() -> None:
        with linked(bench) as link:
            assert link.wait(lambda: is_so(link.status), limit_s())
        act()

    thread = threading.Thread(target=look)
    thread.start()
    return thread


class _Listened(io.StringIO):
    """What a command prints; words in it begin something beside the command."""

    def __init__(self, on: str, act: Act) -> None:
        super().__init__()
        self._on, self._act = on, act

    def write(self, text: str) -> int:
        if self._on and self._on in text:
            threading.Thread(target=self._act).start()
        return super().write(text)


class Bench:
    """The firmware in a process of its own, its frames on a virtual bus.

    channel: of the virtual bus; drop: tells of a frame for the controller whether it gets lost;
    node: number of the controller; the firmware knows itself as 64; is_fd: whether the bus carries
    frames of CAN FD; ended: how cuts beside the test ended that were refused; is_strict: whether
    the controller demands the button acknowledge; otherwise it is waived.
    """

    def __init__(self, channel: str, node: int = 64, *, is_strict: bool = False) -> None:
        assert BENCH.exists(), f"{BENCH} is missing: build the preset host, or let tools/test do it"
        self.channel, self.node, self.is_fd = channel, node, False
        self.drop: Callable[[can.Message], bool] = lambda frame: False
        self._bus = can.Bus(interface="virtual", channel=channel)
        self._process = subprocess.Popen(
            [str(BENCH), str(PACE), *(["strict"] if is_strict else [])],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        self._stopping, self._speaks = False, threading.Event()
        self.ended: list[Refused] = []
        self._threads = [threading.Thread(target=loop) for loop in (self._forth, self._back)]
        for thread in self._threads:
            thread.start()
        assert self._speaks.wait(limit_s()), "no frame of the firmware"

    def _write(self, identifier: int, data: bytes) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(FRAME.pack(identifier, len(data), data))
        self._process.stdin.flush()

    def _forth(self) -> None:
        while not self._stopping:
            frame = self._bus.recv(0.05)
            if frame is not None and not self.drop(frame):
                self._write(frame.arbitration_id - self.node + 64, bytes(frame.data))

    def _back(self) -> None:
        assert self._process.stdout is not None
        while len(record := self._process.stdout.read(FRAME.size)) == FRAME.size:
            self._speaks.set()
            identifier, n, data = FRAME.unpack(record)
            own = identifier - 64 + self.node
            is_fd = n > CLASSIC_BYTES
            if is_fd and not self.is_fd:
                continue  # no receiver of a classic bus takes it
            self._bus.send(
                can.Message(
                    arbitration_id=own,
                    data=data[:n],
                    is_extended_id=False,
                    is_fd=is_fd,
                    bitrate_switch=is_fd,
                )
            )

    def estop(self, is_pressed: bool) -> None:
        """Press or release the emergency stop."""
        self.fault("estop", is_there=is_pressed)

    def fault(self, name: str, *, is_there: bool) -> None:
        """Cause a fault of FAULTS, or end it."""
        self._write(FAULTS[name], bytes([is_there]))

    def press(self) -> None:
        """Press the button acknowledge, as somebody at the machine does."""
        for is_pressed in (True, False):
            self._write(BUTTON_ID, bytes([is_pressed]))
            time.sleep(0.2)

    def turn_key(self, is_on: bool) -> None:
        """Turn the key switch, which is on at the start."""
        self._write(KEY_ID, bytes([is_on]))

    def take_forces(self) -> None:
        """Give the port an output of force, for the next parameter that is set."""
        self._write(FORCE_ID, bytes(1))

    def close(self) -> None:
        """End the process and the threads."""
        self._stopping = True
        self._threads[0].join()
        assert self._process.stdin is not None and self._process.stdout is not None
        self._process.stdin.close()
        self._threads[1].join()
        self._process.wait()
        self._process.stdout.close()
        self._bus.shutdown()

    def run(self, *words: str | Path, on: str = "", act: Act = print) -> tuple[int, str]:
        """Run camctl; return its status and what it printed; act beside it when it says `on`."""
        out = _Listened(on, act)
        bus = ["--interface", "virtual", "--channel", self.channel, "--node", str(self.node)]
        return main([*bus, *map(str, words)], out), out.getvalue()

    @contextmanager
    def cutting(self, state: str = "") -> Iterator[Link]:
        """Cut a part beside the block, as camctl start does elsewhere, from a state on."""

        def follow() -> None:
            try:
                with RightsOptions().commanding(link, self.node):
                    ask_done(link, "start")
                    link.wait(lambda: False, 0.05)
                    link.status.signals.pop("state", None)
                    begun.set()
                    follow_cut(link, io.StringIO())
            except Refused as refused:
                self.ended.append(refused)
            finally:
                begun.set()

        begun, thread = threading.Event(), threading.Thread(target=follow)
        with linked(self) as link:
            thread.start()
            begun.wait()
            try:
                if state:
                    until(lambda: link.status.state == state, state)
                yield link
                if thread.is_alive():
                    self.run("stop")
            finally:
                thread.join()

    def do(self, *words: str | Path, on: str = "", act: Act = print) -> str:
        """Run camctl, which must succeed; act beside it when it says `on`."""
        status, text = self.run(*words, on=on, act=act)
        assert status == 0, text
        return text


def named(table: bytes, name: str) -> bytes:
    """Return the table with another name and a checksum that fits: TABLE_FORMAT.md."""
    body = bytearray(table)
    body[32:64] = name.encode().ljust(32, b"\0")
    struct.pack_into("<I", body, 20, zlib.crc32(body[24:]))
    return bytes(body)


def ready(bench: Bench) -> None:
    """Enable and wait for ready."""
    bench.do("enable")
    until(lambda: "ready" in bench.do("status").splitlines()[0], "ready")


@contextmanager
def keeping(link: Link) -> Iterator[None]:
    """Let a link that commands send its heartbeats beside the block, which must not use it."""
    is_over = threading.Event()

    def keep() -> None:
        while not is_over.is_set():
            link.wait(lambda: False, 0.1)

    thread = threading.Thread(target=keep)
    thread.start()
    try:
        yield
    finally:
        is_over.set()
        thread.join()


def columns(path: Path) -> dict[str, list[str]]:
    """Read a CSV file."""
    with path.open(newline="") as file:
        rows = list(csv.reader(file))
    return {name: [row[i] for row in rows[1:]] for i, name in enumerate(rows[0])}


def order(bench: Bench, command: str, session_of: Link | None = None) -> None:
    """Give a command beside the link of the test, without waiting for its answer.

    In the session of a link, or in that which camctl shares with a second one of the same user.
    """
    sender = sender_of("camctl")
    if session_of is not None:
        stamp = session_of.rights.stamp(command)
    elif session := SharedSession(f"virtual {bench.channel}", bench.node, sender).read():
        stamp = {"sender": sender, "session": session}
    else:
        stamp = {}
    data = command_bytes(command, 0, {}, **stamp)
    bus = can.Bus(interface="virtual", channel=bench.channel)
    bus.send(can.Message(arbitration_id=COMMAND.frame_id, data=data, is_extended_id=False))
    bus.shutdown()
