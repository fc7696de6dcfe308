# SPDX-License-Identifier: Apache-2.0
"""USART3 (RM0433, section 48): 8N1, for each direction a data register or a FIFO of 16 bytes."""

from collections import deque

from tests.stm32.models.bus import NEVER, Device, InsnClock, Reg, UnmodelledError
from tests.stm32.models.rcc import Rcc

UE, RE, TE, FIFOEN = 1 << 0, 1 << 2, 1 << 3, 1 << 29
FIFO_BYTES = 16
RXNE, TC, TXE, TEACK, REACK, TXFE = 1 << 5, 1 << 6, 1 << 7, 1 << 21, 1 << 22, 1 << 23


class Usart(Device):
    """Collects what is sent."""

    def __init__(self, clock: InsnClock, rcc: Rcc) -> None:
        super().__init__("usart3", 0x40004800, clock)
        self.rcc = rcc
        self.sent = bytearray()  # bytes whose stop bit has passed
        self._received: deque[int] = deque()
        self._waiting: deque[int] = deque()
        self._shifting: int | None = None
        self.define(
            {
                0x00: Reg("cr1", 0, UE | RE | TE | FIFOEN),
                0x04: Reg("cr2", 0, 0),
                0x08: Reg("cr3", 0, 0),
                0x0C: Reg("brr", 0, 0xFFFF),
                0x1C: Reg("isr", 0xC0, 0),
                0x20: Reg("icr", 0, 0x00123BFF, rule="nothing"),
                0x24: Reg("rdr", 0, 0),
                0x28: Reg("tdr", 0, 0xFF, sizes=(1, 2, 4)),
                0x2C: Reg("presc", 0, 0),
            }
        )

    def reset(self) -> None:
        """Drop what is on its way."""
        super().reset()
        self._received.clear()
        self._waiting.clear()
        self._shifting = None

    def baud(self) -> float:
        """Return bits per second."""
        return self.rcc.usart3_hz() / self.v["brr"]

    def lines(self) -> list[str]:
        """Return what was sent, in lines."""
        return self.sent.decode("ascii").splitlines()

    @property
    def is_idle(self) -> bool:
        """Whether the transmitter has nothing to send."""
        return self._shifting is None

    def receive(self, text: bytes) -> None:
        """Let the terminal send; bytes without room or receiver are lost."""
        if self.v["cr1"] & (UE | RE) == UE | RE:
            self._received.extend(text[: self._room() - len(self._received)])

    def _read_rdr(self, name: str) -> int:
        if not self._received:
            raise UnmodelledError("usart3.rdr read while it is empty")
        return self._received.popleft()

    def _read_isr(self, name: str) -> int:
        cr1 = self.v["cr1"]
        if len(self._waiting) >= self._room():
            self.clock.skip_to(self.due)
        isr = TXE if len(self._waiting) < self._room() else 0
        isr |= RXNE if self._received else 0
        isr |= TC if not self._waiting and self._shifting is None else 0
        isr |= TXFE if cr1 & FIFOEN and not self._waiting else 0
        return isr | (TEACK if cr1 & TE else 0) | (REACK if cr1 & RE else 0)

    def _write_tdr(self, name: str, old: int, new: int) -> None:
        if self.v["cr1"] & (UE | TE) != UE | TE:
            raise UnmodelledError("usart3.tdr written while the transmitter is off")
        if len(self._waiting) >= self._room():
            raise UnmodelledError("usart3.tdr written while it is full: a byte is lost")
        self._waiting.append(new)
        self._start()

    def _room(self) -> int:
        return FIFO_BYTES if self.v["cr1"] & FIFOEN else 1

    def _start(self) -> None:
        if self._shifting is None and self._waiting:
            self._shifting = self._waiting.popleft()
            cycles = 10 * self.v["brr"] * self.rcc.core_hz() // self.rcc.usart3_hz()
            self.due = self.clock.now + cycles

    def advance(self) -> None:
        """End the byte on the line, begin the next one."""
        assert self._shifting is not None
        self.sent.append(self._shifting)
        self._shifting, self.due = None, NEVER
        self._start()
