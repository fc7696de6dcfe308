# SPDX-License-Identifier: Apache-2.0
"""Flash interface, supply and system configuration (RM0433, sections 4, 6 and 12).

Flash: erase and programming of the sectors that hold no code, quicker than the device (2 ms and
20 us); what a cut-off operation leaves is half done, but reads without an error. The supply is the
LDO; its scale follows the request after a time. What a frequency needs of wait states and voltage
is checked whenever a frequency comes into force.
"""

from __future__ import annotations

from collections.abc import Callable

from bus import NEVER, Device, InsnClock, Reg, UnmodelledError

SETTLE_CYCLES = 3000
# Voltage scale -> (highest AXI clock [MHz], wait states, programming delay WRHIGHFREQ), from the
# table "FLASH recommended number of wait states and programming delay".
WAIT_STATES = {
    0: ((70, 0, 0), (140, 1, 1), (185, 2, 1), (210, 2, 2), (225, 3, 2), (240, 4, 2)),
    1: ((70, 0, 0), (140, 1, 1), (185, 2, 1), (210, 2, 2), (225, 3, 2)),
    2: ((55, 0, 0), (110, 1, 1), (165, 2, 1), (225, 3, 2)),
    3: ((45, 0, 0), (90, 1, 1), (135, 2, 1), (180, 3, 2), (225, 4, 2)),
}
CORE_MHZ = {0: 480, 1: 400, 2: 300, 3: 200}
SCALE = {3: 1, 2: 2, 1: 3}  # of the code of VOS


FLASH = 0x08000000
BANK_BYTES, SECTOR_BYTES, WORD_BYTES = 1 << 20, 1 << 17, 32
KEYS = (0x45670123, 0xCDEF89AB)
LOCK, PG, SER, START = 1 << 0, 1 << 1, 1 << 2, 1 << 7
QW = 1 << 2
ERASE_CYCLES, PROGRAM_CYCLES = 960_000, 9_600
ERASED = b"\xff"


class Flash(Device):
    """Access control, and two banks that erase sectors and program flash words.

    Attributes
    ----------
    load, save : callable
        how a debugger reads and writes flash
    left : int or None
        operations until the supply falls, in the middle of the last
    on_cut : callable
        the supply falls
    """

    def __init__(self, clock: InsnClock) -> None:
        super().__init__("flash", 0x52002000, clock)
        self.load: Callable[[int, int], bytes] = lambda address, size: b""
        self.save: Callable[[int, bytes], None] = lambda address, content: None
        self.left: int | None = None
        self.on_cut: Callable[[], None] = lambda: None
        self._keys: list[list[int]] = [[], []]
        self._busy_until = [0, 0]
        self.define({0x00: Reg("acr", 0x37, 0x3F)})
        for bank in (0, 1):
            at = 0x100 * bank
            self.define(
                {
                    at + 0x04: Reg(f"keyr{bank}", write=self._write_key(bank)),
                    at + 0x0C: Reg(f"cr{bank}", LOCK | 3 << 4, write=self._write_cr(bank)),
                    at + 0x10: Reg(f"sr{bank}", 0, 0, read=self._read_sr(bank)),
                    at + 0x14: Reg(f"ccr{bank}", 0, 0x07EF0000),
                }
            )

    def reset(self) -> None:
        """Lock both banks."""
        super().reset()
        self._keys, self._busy_until = [[], []], [0, 0]

    def _read_sr(self, bank: int) -> Callable[[], int]:
        return lambda: QW if self.clock.now < self._busy_until[bank] else 0

    def _require_idle(self, bank: int) -> None:
        if self.clock.now < self._busy_until[bank]:
            raise UnmodelledError(f"flash: bank {bank + 1} is busy")

    def _write_key(self, bank: int) -> Callable[[int, int], None]:
        def write(old: int, new: int) -> None:
            self._keys[bank].append(new)
            if tuple(self._keys[bank]) == KEYS:
                self.v[f"cr{bank}"] &= ~LOCK
            elif self._keys[bank] != [KEYS[0]]:
                raise UnmodelledError("flash: wrong key, locked until a reset")

        return write

    def _write_cr(self, bank: int) -> Callable[[int, int], None]:
        def write(old: int, new: int) -> None:
            if old & LOCK:
                raise UnmodelledError(f"flash.cr{bank} is locked")
            self._require_idle(bank)
            if new & ~(LOCK | PG | SER | 3 << 4 | START | 7 << 8):
                raise UnmodelledError(f"flash.cr{bank} 0x{new:x}")
            if new & LOCK:
                self._keys[bank] = []
            self.v[f"cr{bank}"] = new & ~START
            if new & START:
                self._erase(bank, new)

        return write

    def _is_cut(self) -> bool:
        if self.left is None:
            return False
        self.left -= 1
        if self.left > 0:
            return False
        self.left = None
        self.on_cut()
        return True

    def _erase(self, bank: int, control: int) -> None:
        sector = control >> 8 & 7
        if not control & SER or control & PG or (bank, sector) == (0, 0):
            raise UnmodelledError(f"flash: erase with cr{bank} 0x{control:x}")
        share = 2 if self._is_cut() else 1
        address = FLASH + bank * BANK_BYTES + sector * SECTOR_BYTES
        self.save(address, ERASED * (SECTOR_BYTES // share))
        self._busy_until[bank] = self.clock.now + ERASE_CYCLES

    def store(self, address: int, size: int) -> None:
        """Let the image store a word into flash, the last of a flash word programs it."""
        bank, at = divmod(address - FLASH, BANK_BYTES)
        if self.v[f"cr{bank}"] & (LOCK | PG | SER) != PG or (bank == 0 and at < SECTOR_BYTES):
            raise UnmodelledError(f"flash: store to 0x{address:08x}")
        self._require_idle(bank)
        word, left = address - address % WORD_BYTES, WORD_BYTES - address % WORD_BYTES
        if size != 4 or self.load(address, left) != ERASED * left:
            raise UnmodelledError(f"flash: 0x{address:08x} is not erased, or out of order")
        if left == 4:
            if self._is_cut():
                self.save(word + 8, ERASED * 20)
            self._busy_until[bank] = self.clock.now + PROGRAM_CYCLES

    def next_event(self) -> int:
        """Return when an operation ends."""
        return min((at for at in self._busy_until if at > self.clock.now), default=NEVER)

    def check(self, axi_hz: int, scale: int) -> None:
        """Raise when flash cannot be read at this clock."""
        latency, delay = self.v["acr"] & 15, self.v["acr"] >> 4 & 3
        for mhz, wait_states, needed in WAIT_STATES[scale]:
            if axi_hz <= mhz * 10**6:
                if latency < wait_states or delay < needed:
                    raise UnmodelledError(f"flash.acr 0x{self.v['acr']:x} at {axi_hz} Hz")
                return
        raise UnmodelledError(f"AXI at {axi_hz} Hz with voltage scale {scale}")


class Syscfg(Device):
    """The boost for 480 MHz (ODEN) and nothing else."""

    def __init__(self, clock: InsnClock) -> None:
        super().__init__("syscfg", 0x58000400, clock)
        self.define({0x2C: Reg("pwrcr", 0, 1)})


class Dbgmcu(Device):
    """Identity of the chip (RM0433, section 60): revision V; and what stops with the core."""

    def __init__(self, clock: InsnClock, revision: int) -> None:
        super().__init__("dbgmcu", 0x5C001000, clock)
        self.define({0x00: Reg("idc", revision << 16 | 0x450, 0), 0x54: Reg("apb4fz1", 0, 1 << 18)})


class Pwr(Device):
    """Power control: LDO, voltage scaling, brown-out detector's interrupt not used."""

    def __init__(self, clock: InsnClock, syscfg: Syscfg) -> None:
        super().__init__("pwr", 0x58024800, clock)
        self.syscfg = syscfg
        self._settled_at = NEVER
        self._is_locked = False  # CR3 was written since power-on
        self.define(
            {
                0x00: Reg("cr1", 0xF000C000, 0x0007C3FF),
                0x04: Reg("csr1", 0x4000, 0),
                0x0C: Reg("cr3", 0x00000006, 0x7, write=self._write_cr3),
                0x18: Reg(
                    "d3cr",
                    0x4000,
                    0xC000,
                    1 << 13,
                    write=self._write_d3cr,
                    read=self._read_d3cr,
                ),
            }
        )

    def reset(self) -> None:
        """Take the values behind a system reset; CR3 is kept until the power goes."""
        cr3 = self.v["cr3"]
        super().reset()
        self._settled_at = NEVER
        if self._is_locked:
            self.v |= {"cr3": cr3, "csr1": 1 << 13 | 0x4000}

    def power_cycle(self) -> None:
        """Forget the supply configuration, which can be written once after each power-on."""
        self._is_locked = False
        self.reset()

    def scale(self) -> int:
        """Return the voltage scale in force, 0 (boosted) .. 3."""
        if not self.v["csr1"] >> 13 & 1:
            return 3
        scale = SCALE[self.v["csr1"] >> 14 & 3]
        return 0 if scale == 1 and self.syscfg.v["pwrcr"] & 1 else scale

    def check(self, core_hz: int) -> None:
        """Raise when the core is too fast for the voltage."""
        if core_hz > CORE_MHZ[self.scale()] * 10**6:
            raise UnmodelledError(f"pwr: core at {core_hz} Hz with voltage scale {self.scale()}")

    def _write_cr3(self, old: int, new: int) -> None:
        if self._is_locked and (old ^ new) & 7:
            raise UnmodelledError("pwr.cr3: written a second time since power-on")
        if new & 3 != 2:
            raise UnmodelledError("pwr.cr3: supply other than the LDO")
        self._is_locked = True
        self.v["cr3"] = new
        self._settled_at = min(self._settled_at, self.clock.now + SETTLE_CYCLES)

    def _write_d3cr(self, old: int, new: int) -> None:
        if not new >> 14 & 3:
            raise UnmodelledError("pwr.d3cr: reserved value of VOS")
        self.v["d3cr"] = new
        self._settled_at = self.clock.now + SETTLE_CYCLES

    def _read_d3cr(self) -> int:
        return self.v["d3cr"] | (self.v["csr1"] & 1 << 13)

    def next_event(self) -> int:
        """Return when the voltage has settled."""
        return self._settled_at

    def advance(self) -> None:
        """Let the voltage settle."""
        if self.clock.now >= self._settled_at:
            self._settled_at = NEVER
            self.v["csr1"] = 1 << 13 | (self.v["d3cr"] & 0xC000)
