"""RAM ECC monitoring of domain 1 (RM0433, section 3): flags, latched addresses, its interrupt.

A test marks words with flipped bits (`flip`); a load of such a word is an error, and a store to it
repairs it. FAR holds the number of a double word in the monitor's memory: ST's FAQ "How to
read RAMECC_MxFAR"; the DTCM is two memories, of the even and of the odd words: ST's example
RAMECC_ErrorCount.
"""

from collections.abc import Callable

from tests.stm32.models.bus import Device, InsnClock, Reg

DEIE, DEBWIE, ELEN = 1 << 3, 1 << 4, 1 << 5
SEDCF, DEDF, FLAGS = 1 << 0, 1 << 1, 7
MONITORS = AXI, ITCM, D0TCM, D1TCM = 1, 2, 3, 4


def place(address: int) -> tuple[int, int]:
    """Return the monitor of an address, and FAR after an error there."""
    if address >= 0x24000000:
        return AXI, (address - 0x24000000) // 8
    if address < 0x20000000:
        return ITCM, address // 8
    return (D1TCM if address & 4 else D0TCM), (address - 0x20000000) // 8


class Ramecc(Device):
    """The monitors."""

    def __init__(self, clock: InsnClock) -> None:
        super().__init__("ramecc1", 0x52009000, clock)
        # address of a word -> number of its wrong bits, one or two
        self.flipped: dict[int, int] = {}
        self.on_flipped: Callable[[], None] = lambda: None  # called when these have changed
        for i in MONITORS:
            at = 0x20 * i
            self.define({at: Reg(f"cr{i}", 0, DEIE | DEBWIE | ELEN), at + 8: Reg(f"far{i}", 0, 0)})
            self.define({at + 4: Reg(f"sr{i}", 0, FLAGS, rule="sr")})

    def _write_sr(self, name: str, old: int, new: int) -> None:
        self.v[name] = old & new

    def irq(self) -> bool:
        """Return whether the interrupt's line is up."""
        v, has_errors = self.v, bool(self.flipped)
        return has_errors and any(v[f"sr{i}"] & DEDF and v[f"cr{i}"] & DEIE for i in MONITORS)

    def flip(self, address: int, n_bits: int) -> None:
        """Make bits of a word wrong, until it is written."""
        self.flipped[address & ~3] = n_bits
        self.on_flipped()

    def repair(self, address: int) -> None:
        """Note that a word was written."""
        if self.flipped.pop(address & ~3, 0):
            self.on_flipped()

    def load(self, address: int) -> bool:
        """Note a load of a flipped word; return whether the error was corrected."""
        is_single = self.flipped[address & ~3] == 1
        monitor, word = place(address)
        self.v[f"sr{monitor}"] |= SEDCF if is_single else DEDF
        if self.v[f"cr{monitor}"] & ELEN:
            self.v[f"far{monitor}"] = word
        self.clock.wake()
        return is_single
