# SPDX-License-Identifier: Apache-2.0
"""RAM ECC monitoring of domain 1 (RM0433, section 3): flags, latched addresses, its interrupt.

Which word holds flipped bits is for a test to say (`flip`); a load of it is an error, and a store
to it repairs it. FAR holds the number of a double word in the monitor's memory: ST's FAQ "How to
read RAMECC_MxFAR"; the DTCM is two memories, of the even and of the odd words: ST's example
RAMECC_ErrorCount.

>>> place(0x20000014), place(0x24000018), place(0x1000)
((4, 2), (1, 3), (2, 512))
"""

from collections.abc import Callable

from tests.stm32.models.bus import Device, InsnClock, Reg

SEIE, DEIE, ELEN = 1 << 2, 1 << 3, 1 << 5
SEDCF, DEDF = 1 << 0, 1 << 1
MONITORS = AXI, ITCM, D0TCM, D1TCM, ETM = 1, 2, 3, 4, 5


def place(address: int) -> tuple[int, int]:
    """Return the monitor of an address, and what FAR says of an error there."""
    if address >= 0x24000000:
        return AXI, (address - 0x24000000) // 8
    if address < 0x20000000:
        return ITCM, address // 8
    return (D1TCM if address & 4 else D0TCM), (address - 0x20000000) // 8


class Ramecc(Device):
    """The monitors."""

    def __init__(self, clock: InsnClock) -> None:
        super().__init__("ramecc1", 0x52009000, clock)
        # address of a word -> how many of its bits are wrong, one or two
        self.flipped: dict[int, int] = {}
        self.on_flipped: Callable[[], None] = lambda: None  # called when these have changed
        self.define({0x00: Reg("ier", 0, 0)})  # interrupts are enabled monitor by monitor
        for i in MONITORS:
            at = 0x20 * i
            self.define({at: Reg(f"cr{i}", 0, 0x3C), at + 8: Reg(f"far{i}", 0, 0)})
            self.define({at + 4: Reg(f"sr{i}", 0, 7, rule="sr")})

    def _write_sr(self, name: str, old: int, new: int) -> None:
        self.v[name] = old & new

    def irq(self) -> bool:
        """Return whether the interrupt's line is up."""
        monitors = [(self.v[f"cr{i}"], self.v[f"sr{i}"]) for i in MONITORS]
        return any((sr & SEDCF and cr & SEIE) or (sr & DEDF and cr & DEIE) for cr, sr in monitors)

    def flip(self, address: int, n_bits: int) -> None:
        """Make bits of a word wrong, until it is written."""
        self.flipped[address & ~3] = n_bits
        self.on_flipped()

    def repair(self, address: int) -> None:
        """Take note that a word was written."""
        if self.flipped.pop(address & ~3, 0):
            self.on_flipped()

    def load(self, address: int) -> bool:
        """Take note of a load of a flipped word; return whether the error was corrected."""
        is_single = self.flipped[address & ~3] == 1
        monitor, word = place(address)
        self.v[f"sr{monitor}"] |= SEDCF if is_single else DEDF
        if self.v[f"cr{monitor}"] & ELEN:
            self.v[f"far{monitor}"] = word
        self.clock.wake()
        return is_single
