r"""Step an image through the emulator and write down what it executes.

>>> parse_listing("    3bd4:\t4801      \tldr\tr0, [pc, #4]\t@ (3bdc)")
{15316: Step(address=15316, size=2, name='ldr', operands='r0, [pc, #4]')}
"""

from __future__ import annotations

import re
import socket
import subprocess
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from camtools.base.errors import CamtoolsError

_LINE = re.compile(  # address, code, name, operands without comment
    r"^ *([0-9a-f]+):\t((?:[0-9a-f]{4} ?)+) *\t([^\s.][^\s]*)(?:\t([^@;\n]*))?", re.MULTILINE
)
_TIMEOUT_S = 60.0
_MAX_STEPS = 100_000
_CALL = 2  # instructions of a call that the counter may see or not
_R0, _R1, _R2, _LR, _PC = 0, 1, 2, 14, 15


@dataclass(frozen=True)
class Step:
    """One line of a disassembly.

    Attributes
    ----------
    address, size : int
        Bytes.
    name, operands : str
        As objdump writes them, without its comment.
    """

    address: int
    size: int
    name: str
    operands: str


@dataclass(frozen=True)
class InstructionTrace:
    """One call of a function, instruction by instruction.

    Attributes
    ----------
    name : str
        Name that the image gives it.
    counted : int
        Instructions that the image's own counter found, one or two of the call among them.
    addresses : tuple of int
        Of every instruction that was executed, in order.
    """

    name: str
    counted: int
    addresses: tuple[int, ...]


def run_tool(command: Sequence[str | Path], text: str = "") -> str:
    """Run a tool of the tool chain; return its output."""
    words = [str(word) for word in command]
    try:
        done = subprocess.run(
            words, input=text, capture_output=True, text=True, timeout=_TIMEOUT_S, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise CamtoolsError([f"{words[0]} cannot be run: {error}"]) from error
    if done.returncode != 0:
        raise CamtoolsError([f"{words[0]} failed: {done.stderr.strip()[:200]}"])
    return done.stdout


def parse_listing(text: str) -> dict[int, Step]:
    """Return the instructions of `objdump -d` by address."""
    found = {}
    for address, code, name, operands in _LINE.findall(text):
        size = len(code.replace(" ", "")) // 2
        at = int(address, 16)
        found[at] = Step(at, size, name, operands.strip())
    return found


def parse_symbols(text: str) -> dict[str, tuple[int, int]]:
    """Return address and size of the functions of `nm -S` by name."""
    words = [line.split() for line in text.splitlines()]
    return {
        w[3]: (int(w[0], 16) & ~1, int(w[1], 16)) for w in words if len(w) == 4 and w[2] in "tTwW"
    }


class _Debugger:
    """The remote protocol of gdb, as much of it as stepping needs."""

    def __init__(self, link: socket.socket) -> None:
        self._link = link
        self._stream = link.makefile("rb")
        self.ask("qXfer:features:read:target.xml:0,fff")  # before it, "p" is not served

    def ask(self, text: str) -> str:
        checksum = sum(text.encode()) & 0xFF
        self._link.sendall(f"${text}#{checksum:02x}".encode())
        while (byte := self._stream.read(1)) != b"$":
            if not byte:
                raise CamtoolsError(["the emulator ended while it was being stepped"])
        answer = bytearray()
        while (byte := self._stream.read(1)) != b"#":
            answer += byte
        self._stream.read(2)
        with suppress(BrokenPipeError):  # the image may have ended
            self._link.sendall(b"+")
        return answer.decode()

    def register(self, number: int) -> int:
        return int.from_bytes(bytes.fromhex(self.ask(f"p{number:x}")), "little")

    def text(self, address: int, size: int = 32) -> str:
        return bytes.fromhex(self.ask(f"m{address:x},{size:x}")).split(b"\0")[0].decode()

    def run_to(self, address: int) -> bool:
        """Continue to an address; return False when the image ends before."""
        self.ask(f"Z1,{address:x},2")
        answer = self.ask("c")
        if answer[0] in "WX":
            if answer[:3] != "W00":
                raise CamtoolsError([f"the image ended with an error (gdb says {answer})"])
            return False
        self.ask(f"z1,{address:x},2")
        return True

    def steps_to(self, end: int) -> Iterator[int]:
        for _ in range(_MAX_STEPS):
            at = self.register(_PC)
            if at == end:
                return
            yield at
            self.ask("s")
        raise CamtoolsError([f"a call does not return within {_MAX_STEPS} instructions"])


@contextmanager
def _emulator(image: Path, machine: str) -> Iterator[_Debugger]:
    with tempfile.TemporaryDirectory() as folder, socket.socket(socket.AF_UNIX) as server:
        path = f"{folder}/gdb"
        server.bind(path)
        server.listen(1)
        server.settimeout(_TIMEOUT_S)
        command = ["qemu-system-arm", "-M", machine, "-nographic", "-monitor", "none"]
        command += ["-serial", "none", "-semihosting-config", "enable=on,target=native"]
        command += ["-icount", "shift=8", "-kernel", str(image), "-S"]
        command += ["-chardev", f"socket,id=gdb,path={path}", "-gdb", "chardev:gdb"]
        try:
            process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        except OSError as error:
            raise CamtoolsError([f"{command[0]} cannot be run: {error}"]) from error
        try:
            link, _ = server.accept()
            link.settimeout(_TIMEOUT_S)
            with link:
                yield _Debugger(link)
        except TimeoutError as error:
            raise CamtoolsError([f"{command[0]} does not answer"]) from error
        finally:
            process.kill()
            process.wait()


def trace_calls(
    image: Path, machine: str, symbols: Mapping[str, tuple[int, int]]
) -> list[InstructionTrace]:
    """Step through the calls that an image announces by budget_trace().

    Parameters
    ----------
    image : Path
        One of tests/budget; it must end without an error.
    machine : str
        The emulator's name of the board.
    symbols : mapping
        Functions of the image, from `parse_symbols`.

    Raises
    ------
    CamtoolsError
        The emulator or the image fails, or stepping and the image's own counter disagree.
    """
    traces = []
    with _emulator(image, machine) as debugger:
        while debugger.run_to(symbols["budget_trace"][0]):
            name = debugger.text(debugger.register(_R0))
            counted = debugger.register(_R1)
            debugger.run_to(debugger.register(_R2) & ~1)
            steps = tuple(debugger.steps_to(debugger.register(_LR) & ~1))
            if abs(len(steps) - counted) > _CALL:
                msg = f"{name}: {len(steps)} instructions stepped, {counted} counted"
                raise CamtoolsError([msg])
            traces.append(InstructionTrace(name, counted, steps))
    return traces
