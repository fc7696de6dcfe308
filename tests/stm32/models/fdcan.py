"""FDCAN1 with its message RAM (RM0433, section 56) and a bus with one listener, the bench.

Modelled: initialisation, clock calibration unit (bypassed), bit timing, receive FIFO 0 in blocking
mode for every standard identifier, transmit FIFO and its time on the bus, acknowledge always given,
bus-off on request of the bench, internal loop-back (LBCK with MON), in which no frame reaches the
bus.
"""

from collections import defaultdict, deque
from collections.abc import Callable
from dataclasses import dataclass

from tests.stm32.models.bus import NEVER, Device, InsnClock, Reg, UnmodelledError
from tests.stm32.models.rcc import Rcc

RAM_BASE = 0x4000AC00
RAM_BYTES = 10 * 1024
INIT, CCE, FDOE, BRSE = 1 << 0, 1 << 1, 1 << 8, 1 << 9
MON, TEST, LBCK = 1 << 5, 1 << 7, 1 << 4
BUS_OFF = 1 << 7
BYPASS = 1 << 6
ELEMENT_WORDS, OF_64_BYTES = 18, 7  # codes of RXESC and TXESC
# Frames that are remote or extended are rejected, all others go to FIFO 0.
GFC = 1 << 0 | 1 << 1 | 2 << 2
DLC_BYTES = (*range(9), 12, 16, 20, 24, 32, 48, 64)


@dataclass(frozen=True)
class Frame:
    """A frame on the bus; `at` is when it ended, in cycles."""

    id: int
    data: bytes
    is_fd: bool = False
    at: int = 0


class MessageRam(Device):
    """Words that FDCAN and software share; undefined until written."""

    def __init__(self, clock: InsnClock) -> None:
        super().__init__("fdcan message ram", RAM_BASE, clock, RAM_BYTES)
        self.words = [0xDEADBEEF] * (RAM_BYTES // 4)

    def reset(self) -> None:
        """Nothing: RAM keeps its content."""

    def read(self, offset: int, size: int) -> int:
        """Load a word."""
        self._require_word(offset, size)
        return self.words[offset // 4]

    def write(self, offset: int, size: int, value: int) -> None:
        """Store a word."""
        self._require_word(offset, size)
        self.words[offset // 4] = value

    def _require_word(self, offset: int, size: int) -> None:
        if size != 4 or offset % 4:
            raise UnmodelledError(f"fdcan message ram: {size} bytes at 0x{offset:x}")


class Ccu(Device):
    """The clock calibration unit before both nodes; bypassed, it passes the kernel clock on.

    Unless bypassed, nothing gets through: RM0433 56.4; Zephyr and ST's HAL set BCC.
    """

    def __init__(self, clock: InsnClock) -> None:
        super().__init__("fdcan ccu", 0x4000A800, clock)
        # whether FDCAN1 has INIT and CCE set
        self.can_configure: Callable[[], bool] = lambda: False
        self.define({0x04: Reg("ccfg", 0, BYPASS)})

    def _write_ccfg(self, name: str, old: int, new: int) -> None:
        if not self.can_configure():
            raise UnmodelledError("fdcan ccu.ccfg written without INIT and CCE of FDCAN1")
        self.v["ccfg"] = new


class Fdcan(Device):
    """One node, and the bench at the other end."""

    def __init__(self, clock: InsnClock, rcc: Rcc, ram: MessageRam, ccu: Ccu) -> None:
        super().__init__("fdcan1", 0x4000A000, clock)
        self.rcc, self.ram, self.ccu = rcc, ram, ccu
        ccu.can_configure = self._can_configure
        self.sent: defaultdict[int, list[Frame]] = defaultdict(list)  # what came out, by identifier
        self.lost = 0  # frames that found receive FIFO 0 full
        self._queue: deque[int] = deque()
        self._done_at = self._back_at = self.due = NEVER
        self._rx_put = self._rx_get = self._rx_fill = self._tx_put = 0
        self.define(
            {
                0x0C: Reg("dbtp", 0x00000A33, 0x009F1FFF),
                0x10: Reg("test", 0, LBCK),
                0x18: Reg("cccr", INIT, INIT | CCE | MON | TEST | FDOE | BRSE),
                0x1C: Reg("nbtp", 0x06000A03, 0xFFFFFF7F),
                0x44: Reg("psr", 0x707, 0),
                0x48: Reg("tdcr", 0, 0x7F7F),
                0x80: Reg("gfc", 0, GFC),
                0x84: Reg("sidfc", 0, 0),
                0x88: Reg("xidfc", 0, 0),
                0xA0: Reg("rxf0c", 0, 0x007FFFFC),
                0xA4: Reg("rxf0s", 0, 0),
                0xA8: Reg("rxf0a", 0, 0x3F),
                0xBC: Reg("rxesc", 0, OF_64_BYTES),
                0xC0: Reg("txbc", 0, 0x3F00FFFC),
                0xC4: Reg("txfqs", 0, 0),
                0xC8: Reg("txesc", 0, OF_64_BYTES),
                0xD0: Reg("txbar", 0),
            }
        )

    def reset(self) -> None:
        """Leave the bus."""
        super().reset()
        self._back_at = NEVER
        self._leave()

    def _leave(self) -> None:
        self._queue.clear()
        self._done_at, self.due = NEVER, self._back_at
        self._rx_put = self._rx_get = self._rx_fill = self._tx_put = 0

    def write(self, offset: int, size: int, value: int) -> None:
        """Do what a store does; the configuration is locked unless CCE and INIT are set."""
        reg = self._reg(offset, size)
        if reg.name not in ("cccr", "rxf0a", "txbar") and not self._can_configure():
            raise UnmodelledError(f"fdcan1.{reg.name} written without CCE")
        super().write(offset, size, value)

    def _can_configure(self) -> bool:
        return self.v["cccr"] & (INIT | CCE) == INIT | CCE

    # Timing

    def bit_hz(self) -> float:
        """Return the rate of the arbitration phase."""
        nbtp = self.v["nbtp"]
        quanta = 1 + (nbtp >> 8 & 0xFF) + 1 + (nbtp & 0x7F) + 1
        return self.rcc.fdcan_hz() / ((nbtp >> 16 & 0x1FF) + 1) / quanta

    def data_bit_hz(self) -> float:
        """Return the rate of the data phase."""
        dbtp = self.v["dbtp"]
        quanta = 1 + (dbtp >> 8 & 31) + 1 + (dbtp >> 4 & 15) + 1
        return self.rcc.fdcan_hz() / ((dbtp >> 16 & 31) + 1) / quanta

    def sample_point(self) -> float:
        """Return where the arbitration phase is sampled, as a part of the bit."""
        nbtp = self.v["nbtp"]
        before = 1 + (nbtp >> 8 & 0xFF) + 1
        return before / (before + (nbtp & 0x7F) + 1)

    def _cycles(self, n_bytes: int) -> int:
        """Return a frame's time: 47 bits around its data, stuffing not counted."""
        return int((47 + 8 * n_bytes) * self.rcc.core_hz() / self.bit_hz())

    # Registers

    def _write_cccr(self, name: str, old: int, new: int) -> None:
        if new & CCE and not (old & INIT and new & INIT):
            new &= ~CCE  # CCE needs INIT to have been read back as set
        if new & INIT:
            self._leave()
        elif not self._is_set_up():
            raise UnmodelledError("fdcan1 joins the bus before its clock and memory are set up")
        if old & INIT and not new & INIT and self.v["psr"] & BUS_OFF:
            idle_bits = 129 * 11
            cycles = int(idle_bits * self.rcc.core_hz() / self.bit_hz())
            self._back_at = self.clock.now + cycles
            self.due = min(self._done_at, self._back_at)
        if not new & TEST:
            self.v["test"] = 0
        if not new & INIT and bool(new & MON) != self._is_looped():
            raise UnmodelledError("fdcan1: MON without LBCK, or LBCK without MON")
        self.v["cccr"] = new

    def _is_set_up(self) -> bool:
        is_large = self.v["rxesc"] == self.v["txesc"] == OF_64_BYTES
        return is_large and self.ccu.v["ccfg"] == BYPASS and self.v["gfc"] == GFC

    def _write_test(self, name: str, old: int, new: int) -> None:
        if not self.v["cccr"] & TEST:
            raise UnmodelledError("fdcan1.test written while TEST is 0")
        self.v["test"] = new

    def _is_looped(self) -> bool:
        return bool(self.v["test"] & LBCK)

    def _is_on_bus(self) -> bool:
        return not (self.v["cccr"] & INIT or self.v["psr"] & BUS_OFF)

    # Reception

    def _rx_elements(self) -> tuple[int, int]:
        """Return the first word of FIFO 0 and the number of its elements."""
        return (self.v["rxf0c"] & 0xFFFC) // 4, self.v["rxf0c"] >> 16

    def _read_rxf0s(self, name: str) -> int:
        return self._rx_fill | self._rx_get << 8 | self._rx_put << 16

    def _write_rxf0a(self, name: str, old: int, new: int) -> None:
        if not self._rx_fill or new != self._rx_get:
            raise UnmodelledError(
                f"fdcan1.rxf0a: element {new} acknowledged, {self._rx_get} is due"
            )
        self._rx_get = (self._rx_get + 1) % self._rx_elements()[1]
        self._rx_fill -= 1

    def deliver(self, frame: Frame) -> bool:
        """Let the bench send a frame; return whether it went into receive FIFO 0."""
        return not self._is_looped() and self._receive(frame)

    def _receive(self, frame: Frame) -> bool:
        first, n = self._rx_elements()
        if not self._is_on_bus() or self._rx_fill >= n:
            self.lost += 1
            return False
        at = first + ELEMENT_WORDS * self._rx_put
        padded = frame.data.ljust(DLC_BYTES[_dlc(frame.data)], b"\0")
        self.ram.words[at] = frame.id << 18
        self.ram.words[at + 1] = _dlc(frame.data) << 16 | frame.is_fd << 21 | 1 << 31
        for i in range(0, len(padded), 4):
            self.ram.words[at + 2 + i // 4] = int.from_bytes(padded[i : i + 4], "little")
        self._rx_put = (self._rx_put + 1) % n
        self._rx_fill += 1
        return True

    # Transmission

    def _tx_elements(self) -> tuple[int, int]:
        return (self.v["txbc"] & 0xFFFC) // 4, self.v["txbc"] >> 24

    def _read_txfqs(self, name: str) -> int:
        free = self._tx_elements()[1] - len(self._queue)
        return free | self._tx_put << 16 | (free == 0) << 21

    def _write_txbar(self, name: str, old: int, new: int) -> None:
        if not self._is_on_bus():
            return
        n = self._tx_elements()[1]
        if len(self._queue) == n or new != 1 << self._tx_put:
            raise UnmodelledError(f"fdcan1.txbar 0x{new:x}, put index is {self._tx_put}")
        self._queue.append(self._tx_put)
        self._tx_put = (self._tx_put + 1) % n
        self._begin()

    def _begin(self) -> None:
        if self._queue and self._done_at == NEVER:
            self._done_at = self.clock.now + self._cycles(len(self._frame(self._queue[0]).data))
            self.due = min(self._done_at, self._back_at)

    def _frame(self, element: int) -> Frame:
        at = self._tx_elements()[0] + ELEMENT_WORDS * element
        t0, t1, *data = self.ram.words[at : at + ELEMENT_WORDS]
        is_fd = bool(t1 >> 21 & 1)
        if t0 >> 29 & 3 or (is_fd and not self.v["cccr"] & FDOE):
            raise UnmodelledError(f"fdcan1: transmit element 0x{t0:08x} 0x{t1:08x}")
        n = min(DLC_BYTES[t1 >> 16 & 15], 64 if is_fd else 8)
        content = b"".join(word.to_bytes(4, "little") for word in data)
        return Frame(t0 >> 18 & 0x7FF, content[:n], is_fd, self.clock.now)

    def advance(self) -> None:
        """End the frame on the bus, begin the next one; come back from bus-off."""
        if self.clock.now >= self._back_at:
            self._back_at = NEVER
            self.v["psr"] &= ~BUS_OFF
        if self.clock.now >= self._done_at:
            self._done_at = NEVER
            frame = self._frame(self._queue.popleft())
            if self._is_looped():
                self._receive(frame)
            else:
                self.sent[frame.id].append(frame)
            self._begin()
        self.due = min(self._done_at, self._back_at)

    def go_bus_off(self) -> None:
        """Let the bus fail until the image clears INIT again and 129 times 11 bits have passed."""
        self.v["psr"] |= BUS_OFF
        self.v["cccr"] |= INIT
        self._queue.clear()
        self._done_at = self._back_at = self.due = NEVER


def _dlc(data: bytes) -> int:
    return next(code for code, n in enumerate(DLC_BYTES) if n >= len(data))
