"""Talks to the image over CAN, by the messages of firmware/remote/can/camturn.dbc."""

import zlib
from dataclasses import dataclass
from pathlib import Path

from cantools.database.can import Database

from tests.stm32.board import Board
from tests.stm32.models.fdcan import Frame

ROOT = Path(__file__).resolve().parents[2]
DATABASE = Database()
DATABASE.add_dbc_file(ROOT / "firmware" / "remote" / "can" / "camturn.dbc")


def _table(message: str, signal: str) -> dict[int, str]:
    choices = DATABASE.get_message_by_name(message).get_signal_by_name(signal).choices
    assert choices is not None
    return {number: str(name) for number, name in choices.items()}


def _id(message: str) -> int:
    return DATABASE.get_message_by_name(message).frame_id


_COMMANDS = {name: number for number, name in _table("Command", "command").items()}
ENABLE, DISABLE, START, STOP, RESET, SET, GET, SELECT = (
    _COMMANDS[name]
    for name in (
        *("enable", "disable", "start", "stop", "reset"),
        *("set_parameter", "get_parameter", "select_table"),
    )
)
BEGIN, END, BLOCK = (
    _COMMANDS[name] for name in ("begin_download", "end_download", "download_block")
)
SAVE, REVERT = _COMMANDS["save_parameters"], _COMMANDS["revert_parameters"]
TAKE = _COMMANDS["take_command"]
COMMAND, ANSWER, STATE, SPINDLE = (_id("Command"), _id("Answer"), _id("State"), _id("Spindle"))
DETAIL, TO_CONTROLLER, FLOW = _id("Detail"), _id("Block"), _id("BlockFlow")
PARAMS = [name for _, name in sorted(_table("Command", "parameter").items())]
ERR_BUSY = -25
ERR_ACKNOWLEDGE, ERR_NOT_COMMANDER = -120, -122
BUTTON, KEY = "PD12", "PD11"
SENDER = 5


def errors() -> dict[str, int]:
    """Return the numbers of cam_err_t by name, without their prefix."""
    return {name: number for number, name in _table("Answer", "result").items()}


@dataclass(frozen=True)
class Status:
    """The newest message State."""

    state: str
    reset: str
    table: int
    faults: tuple[str, ...]


class Remote:
    """A controller of the controller."""

    def __init__(self, board: Board) -> None:
        self.board, self.chip = board, board.chip
        self.session = 0

    def frames(self, identifier: int) -> list[Frame]:
        """Return what came with an identifier, oldest first."""
        return self.chip.fdcan1.sent[identifier]

    def status(self) -> Status:
        """Return the newest status, waiting for one that is sent from now on."""
        n = len(self.frames(STATE))
        assert self.chip.run_until(lambda: len(self.frames(STATE)) > n, self.chip.seconds(0.1)), (
            "no status comes"
        )
        return self.newest()

    def newest(self) -> Status:
        """Return the newest status that came."""
        data = self.frames(STATE)[-1].data
        said = DATABASE.get_message_by_name("State").decode_simple(data)
        faults = [name for name, bit in said.items() if name.startswith("fault_") and bit]
        return Status(
            str(said["state"]),
            str(said["reset_reason"]),
            int.from_bytes(data[2:4], "little", signed=True),
            tuple(name.removeprefix("fault_") for name in faults),
        )

    def command(
        self, command: int, index: int = 0, value: int = 0, *, is_pressed: bool = True
    ) -> tuple[int, int]:
        """Send a command as who has command; return result and value of its answer."""
        result = self.raw(command, index, value)
        if result[0] == ERR_NOT_COMMANDER:  # not taken yet, or lost while the test did other things
            done, self.session = self.raw(TAKE)
            assert done == 0, "command is not to be had"
            for level in (0, 1):  # the key is turned anew for each commander
                self.chip.gpio.drive(KEY, level)
                self.chip.run(self.chip.seconds(0.002))
            result = self.raw(command, index, value)
        if result[0] == ERR_ACKNOWLEDGE and is_pressed:
            self.press()
            result = self.raw(command, index, value)
        return result

    def press(self) -> None:
        """Press the button of the machine, hardly longer than must be."""
        for level, duration_s in ((0, 0.055), (1, 0.055), (0, 0.025)):
            self.chip.gpio.drive(BUTTON, level)
            self.chip.run(self.chip.seconds(duration_s))

    def raw(self, command: int, index: int = 0, value: int = 0) -> tuple[int, int]:
        """Send a command, whoever has it; return result and value of its answer."""
        n = len(self.frames(ANSWER))
        data = bytes([command, index, SENDER, self.session])
        data += value.to_bytes(4, "little", signed=True)
        assert self.board.send(Frame(COMMAND, data)), "the command was not received"
        assert self.chip.run_until(lambda: len(self.frames(ANSWER)) > n, self.chip.seconds(0.1)), (
            "no answer comes"
        )
        answer = self.frames(ANSWER)[-1].data
        assert answer[:2] == data[:2]
        signed = [int.from_bytes(part, "little", signed=True) for part in (answer[2:4], answer[4:])]
        return signed[0], signed[1]

    def do(self, command: int, index: int = 0, value: int = 0) -> None:
        """Send a command, again while the controller is busy; it must be accepted."""
        result = ERR_BUSY
        for _ in range(10):
            if result == ERR_BUSY:
                result, _ = self.command(command, index, value)
        assert result == 0, f"command {command} ({index}, {value}): {result}"

    def wait_until_retracted(self, seconds: float) -> None:
        """Wait until the controller reports that its axes have left the work."""

        def is_retracted() -> bool:
            newest = [f.data for f in self.frames(DETAIL) if f.data[0] == 1][-1:]
            return any(data[1] & 2 for data in newest)

        assert self.chip.run_until(is_retracted, self.chip.seconds(seconds)), "no retract ends"

    def started(self) -> Status:
        """Wait for the first status after a reset, and return it."""
        n = len(self.frames(STATE))
        assert self.chip.run_until(lambda: len(self.frames(STATE)) > n, 200_000_000), (
            f"no status comes, the image is in {self.chip.function_at(self.chip.pc)}"
        )
        return self.newest()

    # Downloads

    def _give(self, data: bytes) -> None:
        assert self.board.send(Frame(TO_CONTROLLER, data)), "a frame of a block was not received"

    def _message(self, message: bytes) -> None:
        """Send by ISO 15765-2, with the 32-bit form of the length where it is needed."""
        n = len(message)
        head = n.to_bytes(6, "big") if n > 4095 else n.to_bytes(2, "big")
        head = bytes([head[0] | 0x10]) + head[1:]
        self._give(head + message[: 8 - len(head)])
        rest = message[8 - len(head) :]
        frames = [rest[i : i + 7] for i in range(0, len(rest), 7)]
        flows = self.frames(FLOW)
        for i, part in enumerate(frames):
            if i % 8 == 0:
                assert self.chip.run_until(lambda: bool(flows), self.chip.seconds(0.1)), (
                    "no flow control comes"
                )
                assert flows.pop().data[:2] == bytes([0x30, 8])
            self._give(bytes([0x20 | (i + 1) % 16]) + part)

    def block(self, offset: int, part: bytes) -> int:
        """Send a block of a table; return the result."""
        n = len(self.frames(ANSWER))
        self._message(offset.to_bytes(4, "little") + part)
        assert self.chip.run_until(lambda: len(self.frames(ANSWER)) > n, self.chip.seconds(0.1)), (
            "no answer to a block comes"
        )
        data = self.frames(ANSWER)[-1].data
        assert data[0] == BLOCK
        return int.from_bytes(data[2:4], "little", signed=True)

    def download(self, table: bytes) -> None:
        """Download a table; all of it must be accepted."""
        self.do(BEGIN, value=len(table))
        for at in range(0, len(table), 4096):
            assert self.block(at, table[at : at + 4096]) == 0
        crc = zlib.crc32(table)
        self.do(END, value=crc - (1 << 32) if crc >> 31 else crc)

    def use(self, table: bytes) -> None:
        """Download a table and select it."""
        self.download(table)
        self.do(SELECT)

    def lines(self) -> list[str]:
        """Return the lines on the serial line, once the last one has ended."""
        usart = self.chip.usart3
        self.chip.run(self.chip.seconds(2e-3))
        assert self.chip.run_until(lambda: usart.is_idle, self.chip.seconds(0.5)), "no line ends"
        return usart.lines()

    def set(self, name: str, value: int) -> None:
        """Set a parameter."""
        self.do(SET, PARAMS.index(name), value)

    def wait_for(self, state: str, seconds: float) -> None:
        """Let time pass until the status reports a state."""
        n_seen = len(self.frames(STATE))

        def is_there() -> bool:
            nonlocal n_seen
            if len(self.frames(STATE)) == n_seen:
                return False
            n_seen = len(self.frames(STATE))
            return self.newest().state == state

        reached = self.chip.run_until(is_there, self.chip.seconds(seconds))
        assert reached, f"{state} is not reached, but {self.newest()}"
