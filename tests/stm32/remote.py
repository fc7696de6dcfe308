# SPDX-License-Identifier: Apache-2.0
"""Talks to the image over CAN, by the protocol in cam_remote.h."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from board import Board
from fdcan import Frame

ROOT = Path(__file__).resolve().parents[2]
HEADER = ROOT / "firmware" / "include" / "cam"
ENABLE, DISABLE, START, STOP, RESET, SET, GET, SELECT = range(1, 9)
COMMAND, ANSWER, STATE, MOTION, LOAD = 0x640, 0x5C0, 0x180, 0x280, 0x380
STATES = ("off", "homing", "ready", "engaging", "cutting", "disengaging", "fault")
RESETS = ("power_on", "pin", "software", "halt", "watchdog", "brown_out")
ERR_BUSY = -25


def _names(header: str, macro: str) -> list[str]:
    text = (HEADER / header).read_text(encoding="utf-8")
    body = text.split(f"#define {macro}(X)")[1].split("\n\n")[0]
    return re.findall(r"X\((\w+)", body)


PARAMS = _names("cam_param.h", "CAM_PARAMS")
FAULTS = _names("cam_state.h", "CAM_FAULTS")


def errors() -> dict[str, int]:
    """Return the numbers of cam_err_t by name, without their prefix."""
    text = (HEADER / "cam_err.h").read_text(encoding="utf-8")
    return {name: int(number) for name, number in re.findall(r"cam_err_(\w+) = (-?\d+)", text)}


@dataclass(frozen=True)
class Status:
    """The newest frame 0x180."""

    state: str
    reset: str
    table: int
    faults: tuple[str, ...]


class Remote:
    """A controller of the controller."""

    def __init__(self, board: Board) -> None:
        self.board, self.chip = board, board.chip

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
        mask = int.from_bytes(data[4:], "little")
        return Status(
            STATES[data[0]],
            RESETS[data[1]],
            int.from_bytes(data[2:4], "little", signed=True),
            tuple(name for i, name in enumerate(FAULTS) if mask >> i & 1),
        )

    def command(self, command: int, index: int = 0, value: int = 0) -> tuple[int, int]:
        """Send a command; return result and value of its answer."""
        n = len(self.frames(ANSWER))
        data = bytes([command, index, 0, 0]) + value.to_bytes(4, "little", signed=True)
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

    def started(self) -> Status:
        """Wait for the first status behind a reset, and return it."""
        n = len(self.frames(STATE))
        assert self.chip.run_until(lambda: len(self.frames(STATE)) > n, 200_000_000), (
            f"no status comes, the image is in {self.chip.where()}"
        )
        return self.newest()

    def lines(self) -> list[str]:
        """Return the lines on the serial line, once the last one has ended."""
        self.chip.run(self.chip.seconds(0.02))
        return self.chip.usart3.lines()

    def set(self, name: str, value: int) -> None:
        """Set a parameter."""
        self.do(SET, PARAMS.index(name), value)

    def wait_for(self, state: str, seconds: float) -> None:
        """Let time pass until the status tells a state."""
        n = len(self.frames(STATE))

        def is_there() -> bool:
            return len(self.frames(STATE)) > n and self.newest().state == state

        reached = self.chip.run_until(is_there, self.chip.seconds(seconds))
        assert reached, f"{state} is not reached, but {self.newest()}"
