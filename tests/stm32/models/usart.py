"""USART3 (RM0433, section 48): 8N1, with a FIFO of 16 bytes for each direction."""

from collections import deque

from tests.stm32.models.bus import NEVER, Device, InsnClock, Reg, UnmodelledError
from tests.stm32.models.rcc import Rcc

ON = 1 << 0 | 1 << 2 | 1 << 3 | 1 << 29  # UE, RE, TE, FIFOEN
FIFO_BYTES = 16
RXFNE, TXFNF = 1 << 5, 1 << 7


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
                0x00: Reg("cr1", 0, ON),
                0x0C: Reg("brr", 0, 0xFFFF),
                0x1C: Reg("isr", 0, 0),
                0x24: Reg("rdr", 0, 0),
                0x28: Reg("tdr", 0, 0xFF),
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
        return self.rcc.apb1_hz() / self.v["brr"]

    def lines(self) -> list[str]:
        """Return what was sent, in lines."""
        return self.sent.decode("ascii").splitlines()

    @property
    def is_idle(self) -> bool:
        """Whether the transmitter has nothing to send."""
        return self._shifting is None

    def receive(self, text: bytes) -> None:
        """Let the terminal send; bytes without room or receiver are lost."""
        if self.v["cr1"] == ON:
            self._received.extend(text[: FIFO_BYTES - len(self._received)])

    def _read_rdr(self, name: str) -> int:
        if not self._received:
            raise UnmodelledError("usart3.rdr read while it is empty")
        return self._received.popleft()

    def _read_isr(self, name: str) -> int:
        if len(self._waiting) >= FIFO_BYTES:
            self.clock.skip_to(self.due)
        isr = TXFNF if len(self._waiting) < FIFO_BYTES else 0
        return isr | (RXFNE if self._received else 0)

    def _write_tdr(self, name: str, old: int, new: int) -> None:
        if self.v["cr1"] != ON or len(self._waiting) >= FIFO_BYTES:
            raise UnmodelledError("usart3.tdr written while it is off or full: a byte is lost")
        self._waiting.append(new)
        self._start()

    def _start(self) -> None:
        if self._shifting is None and self._waiting:
            self._shifting = self._waiting.popleft()
            cycles = 10 * self.v["brr"] * self.rcc.core_hz() // self.rcc.apb1_hz()
            self.due = self.clock.now + cycles

    def advance(self) -> None:
        """End the byte on the line, begin the next one."""
        assert self._shifting is not None
        self.sent.append(self._shifting)
        self._shifting, self.due = None, NEVER
        self._start()
