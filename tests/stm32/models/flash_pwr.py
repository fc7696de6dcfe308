"""Flash interface, supply and system configuration (RM0433, sections 4, 6 and 12).

Flash: erase and programming of the sectors that hold no code, quicker than the device (2 ms and
20 us). What a cut-off operation leaves is half done, and flash words at its edge are torn: a load
from them is an error on the bus. A bank at work must not invite the core to read ahead in it, which
would wait for the end of the operation. The supply is the LDO; its scale follows the request after
a time. Wait states and voltage are checked whenever a frequency comes into force.

Sources beyond the manual: a store that overtakes PG, embassy 1014 and 2539, stm32h7xx-hal 383; torn
words, Zephyr 33140 and 34374, PX4 27642; keys for an open bank, and ODEN read back, as in ST's HAL.
"""

from collections.abc import Callable

from tests.stm32.models.bus import NEVER, Device, InsnClock, Reg, UnmodelledError

SETTLE_CYCLES = 3000
CORE_MHZ = {0: 480, 1: 400, 3: 200}  # by voltage scale
UNWAITED_MHZ = 45  # highest AXI clock without wait states in any scale ..
AXI_MHZ = {0: 240, 1: 225, 3: 225}  # .. and with LATENCY 4 and WRHIGHFREQ 2 by voltage scale
FLASH = 0x08000000
BANK_BYTES, SECTOR_BYTES, WORD_BYTES = 1 << 20, 1 << 17, 32
CODE_SECTORS = 2  # at the start of bank 1
KEYS = [0x45670123, 0xCDEF89AB]
LOCK, PG, SER, PSIZE, START = 1 << 0, 1 << 1, 1 << 2, 3 << 4, 1 << 7
QW = 1 << 2
PGSERR, RDPERR, RDSERR, SNECCERR, DBECCERR = 1 << 18, 1 << 23, 1 << 24, 1 << 25, 1 << 26
FLAGS = 0x07EF0000  # all that FLASH_CCR clears
ERASE_CYCLES, PROGRAM_CYCLES = 960_000, 9_600
ERASED = b"\xff"
ACTVOSRDY = VOSRDY = 1 << 13


class Flash(Device):
    """Access control, and two banks that erase sectors and program flash words."""

    def __init__(self, clock: InsnClock) -> None:
        super().__init__("flash", 0x52002000, clock)
        # how a debugger reads and writes flash
        self.load: Callable[[int, int], bytes] = lambda address, size: b""
        self.save: Callable[[int, bytes], None] = lambda address, content: None
        self.left: int | None = None  # operations until the supply falls, in the middle of the last
        self.on_cut: Callable[[], None] = lambda: None  # the supply falls
        # whether the core may read ahead at an address
        self.invites: Callable[[int], bool] = lambda address: False
        self.torn: set[int] = set()  # addresses of flash words that cannot be read
        self.on_torn: Callable[[], None] = lambda: None  # called when that set has changed
        self.noise = 0  # error flags that every operation sets, though it succeeds
        self._flags = [0, 0]
        self._pg_at = [0, 0]
        self._keys: list[list[int]] = [[], []]
        self._busy_until = [0, 0]
        self.define(
            {
                0x00: Reg("acr", 0x37, 0x3F),
                0x1C: Reg("optsr_cur", 0x0316AAF0, 0),  # read-out protection: level 0
                0x38: Reg("wpsn_cur1", 0xFF, 0),  # no sector is write-protected
            }
        )
        for bank in (0, 1):
            at = 0x100 * bank
            self.define(
                {
                    at + 0x04: Reg(f"keyr{bank}", rule="key"),
                    at + 0x0C: Reg(
                        f"cr{bank}",
                        LOCK | PSIZE,
                        LOCK | PG | SER | PSIZE | START | 7 << 8,
                        rule="cr",
                    ),
                    at + 0x10: Reg(f"sr{bank}", 0, 0, rule="sr"),
                    at + 0x14: Reg(f"ccr{bank}", 0, FLAGS, rule="ccr"),
                    at + 0x60: Reg(f"ecc_fa{bank}", 0, 0),  # flash word of the bank
                }
            )

    def reset(self) -> None:
        """Lock both banks."""
        super().reset()
        self._keys, self._busy_until, self._flags = [[], []], [0, 0], [0, 0]

    def _read_sr(self, name: str) -> int:
        bank = int(name[-1])
        self.clock.skip_to(self._busy_until[bank])
        return (QW if self.clock.now < self._busy_until[bank] else 0) | self._flags[bank]

    def _write_ccr(self, name: str, old: int, new: int) -> None:
        self._flags[int(name[-1])] &= ~new

    def _require_idle(self, bank: int) -> None:
        if self.clock.now < self._busy_until[bank]:
            raise UnmodelledError(f"flash: bank {bank + 1} is busy")

    def _write_key(self, name: str, old: int, new: int) -> None:
        bank = int(name[-1])
        if not self.v[f"cr{bank}"] & LOCK:
            raise UnmodelledError(f"flash: keys for bank {bank + 1}, which is not locked")
        self._keys[bank].append(new)
        if self._keys[bank] == KEYS:
            self.v[f"cr{bank}"] &= ~LOCK
        elif self._keys[bank] != KEYS[:1]:
            raise UnmodelledError("flash: wrong key, locked until a reset")

    def _write_cr(self, name: str, old: int, new: int) -> None:
        bank = int(name[-1])
        if old & LOCK:
            raise UnmodelledError(f"flash.{name} is locked")
        self._require_idle(bank)
        if new & LOCK:
            self._keys[bank] = []
        self.v[name] = new & ~START
        self._pg_at[bank] = self.clock.now
        start = FLASH + bank * BANK_BYTES
        for address in range(start, start + BANK_BYTES, SECTOR_BYTES):
            if new & (PG | START) and self.invites(address):
                raise UnmodelledError(f"flash: bank {bank + 1} works, reads ahead at 0x{address:x}")
        if new & START:
            self._erase(bank, new)

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
        if not control & SER or control & PG or bank * 8 + sector < CODE_SECTORS:
            raise UnmodelledError(f"flash: erase with cr{bank} 0x{control:x}")
        self._flags[bank] |= self.noise
        address = FLASH + bank * BANK_BYTES + sector * SECTOR_BYTES
        if self._is_cut():
            self.save(address, ERASED * (SECTOR_BYTES // 2))
            self.tear({address, address + SECTOR_BYTES // 2})
        else:
            self.save(address, ERASED * SECTOR_BYTES)
        self._busy_until[bank] = self.clock.now + ERASE_CYCLES

    def store(self, address: int, size: int) -> None:
        """Let the image store a word into flash, the last of a flash word programs it."""
        bank, at = divmod(address - FLASH, BANK_BYTES)
        is_code = bank == 0 and at < CODE_SECTORS * SECTOR_BYTES
        if self.v[f"cr{bank}"] & (LOCK | PG | SER) != PG or is_code:
            raise UnmodelledError(f"flash: store to 0x{address:08x}")
        self._require_idle(bank)
        if self.clock.barrier_at <= self._pg_at[bank]:
            self._flags[bank] |= PGSERR  # the store is quicker than the bit
        word, left = address - address % WORD_BYTES, WORD_BYTES - address % WORD_BYTES
        if size != 4 or self.load(address, left) != ERASED * left:
            raise UnmodelledError(f"flash: 0x{address:08x} is not erased, or out of order")
        if left == 4:
            self._flags[bank] |= self.noise
            if self._is_cut():
                self.save(word + 8, ERASED * 20)
                self.tear({word})
            self._busy_until[bank] = self.clock.now + PROGRAM_CYCLES

    def tear(self, words: set[int]) -> None:
        """Make flash words unreadable, until they are erased or written by a debugger."""
        self.torn |= words
        self.on_torn()

    def heal(self, address: int, size: int) -> None:
        """Make what was written anew readable."""
        left = {word for word in self.torn if not address <= word < address + size}
        if left != self.torn:
            self.torn = left
            self.on_torn()

    def note_ecc(self, address: int, flag: int) -> None:
        """Note that a load found a word with a wrong bit (SNECCERR) or beyond correction."""
        bank, at = divmod(address - FLASH, BANK_BYTES)
        self._flags[bank] |= flag
        self.v[f"ecc_fa{bank}"] = at // WORD_BYTES

    def check(self, axi_hz: int, scale: int) -> None:
        """Raise when flash cannot be read at this clock."""
        latency, delay = self.v["acr"] & 15, self.v["acr"] >> 4 & 3
        has_waits = latency >= 4 and delay >= 2
        if axi_hz > (AXI_MHZ[scale] if has_waits else UNWAITED_MHZ) * 10**6:
            raise UnmodelledError(f"flash.acr 0x{self.v['acr']:x} at {axi_hz} Hz, scale {scale}")


class Syscfg(Device):
    """The boost for 480 MHz (ODEN) and nothing else."""

    def __init__(self, clock: InsnClock) -> None:
        super().__init__("syscfg", 0x58000400, clock)
        # a store to PWRCR that has not been read back may not have arrived
        self.is_on_its_way = False
        self.on_boost: Callable[[], None] = lambda: None  # called when ODEN has changed
        self.define({0x2C: Reg("pwrcr", 0, 1)})

    def _write_pwrcr(self, name: str, old: int, new: int) -> None:
        self.v["pwrcr"] = new
        if old != new:
            self.is_on_its_way = True
            self.on_boost()

    def _read_pwrcr(self, name: str) -> int:
        self.is_on_its_way = False
        return self.v["pwrcr"]


class Dbgmcu(Device):
    """Identity of the chip (RM0433, section 60): revision V; and what stops with the core."""

    def __init__(self, clock: InsnClock, revision: int) -> None:
        super().__init__("dbgmcu", 0x5C001000, clock)
        self.define(
            {
                0x00: Reg("idc", revision << 16 | 0x450, 0),
                0x34: Reg("apb3fz1", 0, 1 << 6),
                0x54: Reg("apb4fz1", 0, 1 << 18),
            }
        )


class Pwr(Device):
    """Power control: the LDO and its voltage scales 1, with the boost 0, and after power-on 3."""

    def __init__(self, clock: InsnClock, syscfg: Syscfg) -> None:
        super().__init__("pwr", 0x58024800, clock)
        self.syscfg = syscfg
        # called when the voltage is valid for the first time since power-on: RAM may be written
        self.on_ready: Callable[[], None] = lambda: None
        syscfg.on_boost = self._unsettle
        self._is_locked = False  # CR3 was written since power-on
        self.define(
            {
                0x04: Reg("csr1", 0x4000, 0),
                0x0C: Reg("cr3", 0x00000006, 0x7),
                0x18: Reg("d3cr", 0x4000, 0xC000, VOSRDY),
            }
        )

    def reset(self) -> None:
        """Take the values after a system reset; CR3 is kept until the power goes."""
        cr3 = self.v["cr3"]
        super().reset()
        if self._is_locked:
            self.v |= {"cr3": cr3, "csr1": ACTVOSRDY | 0x4000}

    def power_cycle(self) -> None:
        """Forget the supply configuration, which can be written once after each power-on."""
        self._is_locked = False
        self.reset()

    def scale(self) -> int:
        """Return the voltage scale in force."""
        if self.v["csr1"] & (ACTVOSRDY | 3 << 14) != ACTVOSRDY | 3 << 14:
            return 3
        return 0 if self.syscfg.v["pwrcr"] & 1 and self.due == NEVER else 1

    def check(self, core_hz: int) -> None:
        """Raise when the core is too fast for the voltage."""
        if core_hz > CORE_MHZ[self.scale()] * 10**6:
            raise UnmodelledError(f"pwr: core at {core_hz} Hz with voltage scale {self.scale()}")

    def _write_cr3(self, name: str, old: int, new: int) -> None:
        if self._is_locked and old != new:
            raise UnmodelledError("pwr.cr3: written a second time since power-on")
        if new & 3 != 2:
            raise UnmodelledError("pwr.cr3: supply other than the LDO")
        self._is_locked = True
        self.v["cr3"] = new
        self.due = min(self.due, self.clock.now + SETTLE_CYCLES)

    def _write_d3cr(self, name: str, old: int, new: int) -> None:
        if not new >> 14 & 3:
            raise UnmodelledError("pwr.d3cr: reserved value of VOS")
        if not self.v["csr1"] & ACTVOSRDY:
            raise UnmodelledError("pwr.d3cr: VOS changed before the voltage is valid")
        self.v["d3cr"] = new
        self._unsettle()

    def _unsettle(self) -> None:
        self.due = self.clock.now + SETTLE_CYCLES
        self.clock.wake()

    def _skip(self) -> None:
        if self.due != NEVER:
            self.clock.skip_to(self.due)

    def _read_csr1(self, name: str) -> int:
        self._skip()
        return self.v["csr1"]

    def _read_d3cr(self, name: str) -> int:
        if self.syscfg.is_on_its_way:
            raise UnmodelledError("pwr.d3cr: VOSRDY read before ODEN has arrived: read it back")
        self._skip()
        is_ready = self.due == NEVER and self.v["csr1"] & ACTVOSRDY
        return self.v["d3cr"] | (VOSRDY if is_ready else 0)

    def advance(self) -> None:
        """Let the voltage settle."""
        self.due = NEVER
        if not self.v["csr1"] & ACTVOSRDY:
            self.on_ready()
        self.v["csr1"] = ACTVOSRDY | (self.v["d3cr"] & 0xC000)
