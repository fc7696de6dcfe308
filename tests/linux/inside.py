"""What runs beside the controller inside the kernel: machine, operator, troublemakers.

    inside.py SCENARIO < setup.json

One scenario of scenarios.py is played: the machine (camsim bus) and the controller
(camturn-linux) are started, an operator gives commands by CAN, something goes wrong. What was seen
goes into result.json of the folder that the setup names. Standard library only, one process: a
program start costs a fifth of a second in User-Mode Linux.
"""

import json
import os
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

COMMAND, ANSWER, STATE = 0x640, 0x5C0, 0x1C0
BLOCK, BLOCK_FLOW = 0x6C0, 0x540
ENABLE, START, SET = 1, 3, 6
BEGIN_DOWNLOAD = 16
TAKE_COMMAND, HEARTBEAT = 60, 62
ERR_NOT_COMMANDER, ERR_LOCKED, SENDER = -122, -123, 5
KEY_LINE = "sim_gpio6"  # in tools/linux_kernel/machine
STATES = (
    *("off", "homing", "ready", "engaging", "cutting", "disengaging", "fault"),
    *("rehearsing", "identifying", "manual", "holding"),
)
BUSY = -3
FRAME = struct.Struct("<IB3x8s")
BLOCK_BYTES = 4096
SO_RCVBUFFORCE = 33  # asm-generic/socket.h; Python has no name for it


class Bus:
    """A raw CAN socket."""

    def __init__(self, interface: str, *ids: int) -> None:
        self.socket = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        filters = b"".join(struct.pack("=II", i, 0x7FF) for i in ids)
        if ids:
            self.socket.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, filters)
        # Room for ten thousand frames and more; root may take it.
        self.socket.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, 1 << 25)
        self.socket.bind((interface,))

    def send(self, can_id: int, data: bytes) -> None:
        """Send a classic frame."""
        self.socket.send(FRAME.pack(can_id, len(data), data.ljust(8, b"\0")))

    def receive(self, timeout_s: float) -> tuple[int, bytes] | None:
        """Return identifier and data of the next frame, None when there is none in time."""
        self.socket.settimeout(max(timeout_s, 1e-6))
        try:
            can_id, n, data = FRAME.unpack(self.socket.recv(16))
        except TimeoutError:
            return None
        return can_id, data[:n]


class Session:
    """The processes and what was seen."""

    def __init__(self, setup: dict[str, Any]) -> None:
        self.setup = setup
        self.out = Path(setup["out"])
        self.seen: dict[str, Any] = {}
        self.operator = Bus("vcan0", ANSWER)
        self.listener = Bus("vcan0", STATE)
        self.children: list[subprocess.Popen[bytes]] = []
        self.machine: subprocess.Popen[bytes] | None = None
        self.controller: subprocess.Popen[bytes] | None = None
        self.number = 0  # session of who has command
        self.is_over = threading.Event()
        threading.Thread(target=self.keep_command, daemon=True).start()

    # Processes

    def spawn(self, name: str, *words: str) -> subprocess.Popen[bytes]:
        """Start a program; what it says goes to NAME.log."""
        log = (self.out / f"{name}.log").open("ab")
        child = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=log, stderr=log)
        self.children.append(child)
        return child

    def start_machine(self, *words: str) -> None:
        """Start camsim bus; it leaves surface, summary and trace in the folder."""
        outputs = [f"--{what}={self.out}/{what}" for what in ("surface", "summary", "trace")]
        self.machine = self.spawn(
            "machine", self.setup["camsim"], "bus", self.setup["table"], "--can", "vcan0",
            "--gpiochip", os.environ["CAMTURN_GPIOCHIP"], "--machine", self.setup["machine"],
            *outputs, *self.setup["machine_words"], *words,
        )  # fmt: skip
        time.sleep(0.1)

    def start_controller(self) -> None:
        """Start the firmware."""
        config = str(self.out / "camturn.toml")
        self.controller = self.spawn("controller", self.setup["controller"], "--config", config)
        time.sleep(0.2)

    def wait_said(self, name: str, words: str, limit_s: float = 20.0) -> None:
        """Wait until a program has printed some words."""
        until_s = time.monotonic() + limit_s
        while words not in (self.out / f"{name}.log").read_text():
            assert time.monotonic() < until_s, f"{name}: no {words}"
            time.sleep(0.05)

    def wait_machine(self, limit_s: float = 60.0) -> None:
        """Wait for the end of camsim bus."""
        assert self.machine is not None
        self.seen["machine_status"] = self.machine.wait(limit_s)

    def stop_controller(self, number: signal.Signals = signal.SIGTERM) -> None:
        """Send the controller a signal and wait for its end."""
        assert self.controller is not None
        self.controller.send_signal(number)
        self.seen["controller_status"] = self.controller.wait(10)

    def close(self) -> None:
        """End what still runs; the machine writes its results."""
        self.is_over.set()
        for child in self.children:
            if child.poll() is None:
                child.terminate()
                child.wait(20)

    # Operator

    def command(self, what: int, parameter: int = 0, value: int = 0) -> int:
        """Give a command as who has command; return the result, after waiting out `busy`."""
        while True:
            result, _ = self.raw(what, parameter, value)
            if result == ERR_NOT_COMMANDER:  # not taken yet, or lost while the session did others
                taken, self.number = self.raw(TAKE_COMMAND)
                assert taken == 0, "command is not to be had"
            elif result == ERR_LOCKED:
                self.turn_key()
            elif result != self.setup["busy"]:
                return result
            else:
                time.sleep(0.002)

    def keep_command(self) -> None:
        """Send the heartbeats of who has command, until the session is over."""
        bus = Bus("vcan0", 0)
        while not self.is_over.wait(0.3):
            if self.number:
                data = struct.pack("<BBBBI", HEARTBEAT, 0, SENDER, self.number, 0)
                bus.send(COMMAND, data)

    def turn_key(self) -> None:
        """Turn the key switch off and on."""
        for pull in ("pull-down", "pull-up"):
            Path(os.environ["CAMTURN_GPIOSIM"], KEY_LINE, "pull").write_text(pull)
            time.sleep(0.01)

    def raw(self, what: int, parameter: int = 0, value: int = 0) -> tuple[int, int]:
        """Give a command, whoever has it; return result and value."""
        data = struct.pack("<BBBBI", what, parameter, SENDER, self.number, value & 0xFFFFFFFF)
        self.operator.send(COMMAND, data)
        answer = self.operator.receive(1.0)
        while answer is not None and answer[1][0] == HEARTBEAT:
            answer = self.operator.receive(1.0)
        assert answer is not None, f"no answer to command {what}"
        result, returned = struct.unpack_from("<hi", answer[1], 2)
        return int(result), int(returned)

    def begin_download(self, image: bytes, n_blocks: int) -> None:
        """Begin a download and send some blocks, by the kernel's own ISO-TP."""
        transport = socket.socket(socket.AF_CAN, socket.SOCK_DGRAM, socket.CAN_ISOTP)
        transport.bind(("vcan0", BLOCK_FLOW, BLOCK))
        assert self.command(BEGIN_DOWNLOAD, 0, len(image)) == 0
        for at in range(0, n_blocks * BLOCK_BYTES, BLOCK_BYTES):
            transport.send(struct.pack("<I", at) + image[at : at + BLOCK_BYTES])
            answer = self.operator.receive(1.0)
            while answer is not None and answer[1][0] == HEARTBEAT:
                answer = self.operator.receive(1.0)
            assert answer is not None and answer[1][2:4] == b"\0\0", f"block at {at}: {answer}"

    def state(self) -> tuple[str, int]:
        """Return state and faults as of the next status."""
        self.listener.socket.settimeout(0)
        try:
            while True:
                self.listener.socket.recv(16)
        except BlockingIOError:
            pass
        frame = self.listener.receive(1.0)
        assert frame is not None, "the controller sends no state"
        return STATES[frame[1][0]], int(struct.unpack_from("<I", frame[1], 4)[0])

    def wait_state(self, wanted: str, limit_s: float = 20.0) -> None:
        """Wait until the controller reports a state; limits are of virtual time."""
        until_s = time.monotonic() + limit_s
        while True:
            state, faults = self.state()
            if state == wanted:
                return
            assert state != "fault", f"fault {faults:#x} instead of {wanted}"
            assert time.monotonic() < until_s, f"state {state} instead of {wanted}"

    def set_parameters(self) -> None:
        """Give the controller the parameters that fit the machine."""
        for index, value in enumerate(self.setup["parameters"]):
            result = self.command(SET, index, value)
            assert result == 0, f"parameter {index} = {value}: refused: {result}"

    def start_cut(self, *machine_words: str) -> None:
        """Start everything until the controller cuts."""
        self.start_machine(*machine_words)
        self.start_controller()
        self.set_parameters()
        for command, wanted in ((ENABLE, "ready"), (START, "cutting")):
            result = self.command(command)
            assert result == 0, f"command {command}: refused: {result}"
            self.wait_state(wanted)


@contextmanager
def session(setup: dict[str, Any]) -> Iterator[Session]:
    """Run a session; whatever happens, result.json is written and nothing is left running."""
    s = Session(setup)
    try:
        yield s
    except (AssertionError, OSError, subprocess.SubprocessError) as err:
        s.seen["error"] = f"{type(err).__name__}: {err}"
    finally:
        s.close()
        (s.out / "result.json").write_text(json.dumps(s.seen, indent=1) + "\n")


def main(scenarios: Mapping[str, Callable[[Session], None]]) -> int:
    """Play the scenario named on the command line; return the exit status."""
    setup = json.loads(Path(sys.argv[2]).read_text())
    with session(setup) as s:
        scenarios[sys.argv[1]](s)
    return 1 if "error" in s.seen else 0
