"""Reset and clock control (RM0433, section 8): oscillators, PLL1, dividers, gates, reset flags.

Oscillators and PLL1 are ready a fixed time after they are switched on. What the manual forbids is
an error: a PLL changed while it runs, a switch to a clock that is not ready, frequencies beyond the
supply's range. The system clock is the HSI or PLL1.
"""

from collections.abc import Callable

from tests.stm32.models.bus import NEVER, Device, InsnClock, Reg, UnmodelledError

HSI_HZ = 64_000_000
LSI_HZ = 32_000
READY_CYCLES = 5000
HSI_READY = 1 << 0 | 1 << 2 | 1 << 5  # on and ready, undivided
HSEON, HSERDY, HSEBYP, CSSON, PLL1ON, PLL1RDY = (1 << i for i in (16, 17, 18, 19, 24, 25))
HSECSSF = 1 << 10
RMVF = 1 << 16
SW_HSI, SW_PLL1 = 0, 3

# Reset flags in RCC_RSR by the reason of a reset (table "Reset source identification").
CPU, D1, D2, BOR, PIN, POR, SFT, IWDG1, WWDG1 = (
    1 << bit for bit in (17, 19, 20, 21, 22, 23, 24, 26, 28)
)
RESET_FLAGS = {
    "power_on": CPU | D1 | D2 | BOR | PIN | POR,
    "pin": CPU | PIN,
    "brown_out": CPU | PIN | BOR,
    "software": CPU | PIN | SFT,
    "watchdog": CPU | PIN | IWDG1,
    "window": CPU | PIN | WWDG1,
}
GATES = {
    "ahb4enr": 0xE0,
    "apb3enr": 0xE4,
    "apb1lenr": 0xE8,
    "apb1henr": 0xEC,
    "apb2enr": 0xF0,
    "apb4enr": 0xF4,
}


def ahb_divisor(code: int) -> int:
    """Return the divisor of a 4-bit HPRE or D1CPRE field."""
    return 1 if code < 8 else (2, 4, 8, 16, 64, 128, 256, 512)[code - 8]


def apb_divisor(code: int) -> int:
    """Return the divisor of a 3-bit APB prescaler field."""
    return 1 if code < 4 else 2 << (code - 4)


class Rcc(Device):
    """RCC; every other model asks it for its clock."""

    def __init__(self, clock: InsnClock, hse_hz: int) -> None:
        super().__init__("rcc", 0x58024400, clock)
        self.hse_hz = hse_hz  # frequency at the pin OSC_IN; 0: dead
        # called before a frequency changes, so that counters count up to now at the old one
        self.before_change: list[Callable[[], None]] = []
        # called when the clock security system has found the HSE dead: the NMI
        self.on_css: Callable[[], None] = lambda: None
        # given the frequencies of core and AXI in Hz before they come into force; raises
        self.check_supply: Callable[[int, int], None] = lambda core_hz, axi_hz: None
        self._hz: dict[str, int] = {}  # frequencies computed since the last store
        self.reachable: dict[int, Device] = {}  # devices by kilobyte, found on since then
        self.define(
            {
                0x00: Reg("cr", HSI_READY, HSEON | HSEBYP | CSSON | PLL1ON),
                0x10: Reg("cfgr", 0, 7),
                0x18: Reg("d1cfgr", 0, 0x0F7F, rule="divisor"),
                0x1C: Reg("d2cfgr", 0, 0x0770, rule="divisor"),
                0x20: Reg("d3cfgr", 0, 0x0070, rule="divisor"),
                0x28: Reg("pllckselr", 0x02020200, 0x03F3F3F3, rule="pll"),
                0x2C: Reg("pllcfgr", 0x01FF0000, 0x01FF0FFF, rule="pll"),
                0x30: Reg("pll1divr", 0x01010280, 0x7F7FFFFF, rule="pll"),
                0x50: Reg("d2ccip1r", 0, 1 << 28),  # SPI1..3: PLL1Q; FDCAN: HSE or PLL1Q
                0x64: Reg("cifr", 0, 0),
                0x68: Reg("cicr", 0, 0x7FF),
                0xA0: Reg("gcr", 0, 1),
                0xD0: Reg("rsr", 0, RMVF),
            }
            | {offset: Reg(name) for name, offset in GATES.items()}
        )

    def restart(self, reason: str) -> None:
        """Reset everything but the flags of earlier resets, and add those of this one."""
        flags = self.v["rsr"] if reason != "power_on" else 0
        self.reset()
        self._forget()
        self.v["rsr"] = flags | RESET_FLAGS[reason]

    def write(self, offset: int, size: int, value: int) -> None:
        """Do what a store does; any of them may change a frequency."""
        self._forget()
        super().write(offset, size, value)
        self._forget()

    def _forget(self) -> None:
        self._hz.clear()
        self.reachable.clear()

    # Frequencies

    def _reference_hz(self) -> int:
        source_hz = {0: HSI_HZ, 2: self.hse_hz}.get(self.v["pllckselr"] & 3, 0)
        return source_hz // max(1, self.v["pllckselr"] >> 4 & 63)

    def _vco_hz(self) -> int:
        return self._reference_hz() * ((self.v["pll1divr"] & 0x1FF) + 1)

    def pll1_hz(self, output: str) -> int:
        """Return the frequency of an output of PLL1, "p" or "q"; 0 when it is off."""
        if output not in self._hz:
            i = "pq".index(output)
            is_running = self.v["cr"] & PLL1RDY and self.v["pllcfgr"] >> (16 + i) & 1
            divider = (self.v["pll1divr"] >> (9, 16)[i] & 0x7F) + 1
            self._hz[output] = self._vco_hz() // divider if is_running else 0
        return self._hz[output]

    def system_hz(self) -> int:
        """Return the frequency of sys_ck."""
        return self.pll1_hz("p") if self.v["cfgr"] >> 3 & 7 == SW_PLL1 else HSI_HZ

    def core_hz(self) -> int:
        """Return the frequency of the core."""
        if "core" not in self._hz:
            self._hz["core"] = self.system_hz() // ahb_divisor(self.v["d1cfgr"] >> 8 & 15)
        return self._hz["core"]

    def ahb_hz(self) -> int:
        """Return the frequency of AXI and all AHB."""
        return self.core_hz() // ahb_divisor(self.v["d1cfgr"] & 15)

    def apb1_hz(self) -> int:
        """Return the frequency of APB1."""
        return self.ahb_hz() // apb_divisor(self.v["d2cfgr"] >> 4 & 7)

    def apb3_hz(self) -> int:
        """Return the frequency of APB3."""
        return self.ahb_hz() // apb_divisor(self.v["d1cfgr"] >> 4 & 7)

    def timer_hz(self) -> int:
        """Return the frequency of the timers on APB1 and APB2, which must be equal here."""
        if "timer" not in self._hz:
            codes = {self.v["d2cfgr"] >> 4 & 7, self.v["d2cfgr"] >> 8 & 7}
            if len(codes) > 1:
                raise UnmodelledError("rcc: APB1 and APB2 with different prescalers")
            divisor = apb_divisor(codes.pop())
            self._hz["timer"] = self.ahb_hz() // divisor * (1 if divisor == 1 else 2)
        return self._hz["timer"]

    def fdcan_hz(self) -> int:
        """Return the kernel clock of the FDCANs."""
        return self.pll1_hz("q") if self.v["d2ccip1r"] >> 28 & 1 else self.hse_hz

    # Registers

    def _change(self) -> None:
        for prepare in self.before_change:
            prepare()

    def _check(self) -> None:
        self._hz.clear()
        if self.system_hz() == 0:
            raise UnmodelledError("rcc: the system clock stands still")
        if max(self.apb1_hz(), self.ahb_hz() // apb_divisor(self.v["d2cfgr"] >> 8 & 7)) > 120e6:
            raise UnmodelledError("rcc: APB1 or APB2 above 120 MHz")
        self.check_supply(self.core_hz(), self.ahb_hz())

    def _write_cr(self, name: str, old: int, new: int) -> None:
        if old & HSEON and (old ^ new) & HSEBYP:
            raise UnmodelledError("rcc.cr: HSEBYP changed while the HSE is on")
        for on, ready in ((HSEON, HSERDY), (PLL1ON, PLL1RDY)):
            if not new & on:
                new &= ~ready
        self.v["cr"] = new | old & CSSON  # set by software only
        self._check()
        if self._awaited():
            self.due = self.clock.now + READY_CYCLES

    def _read_cr(self, name: str) -> int:
        if self.due != NEVER:
            self.clock.skip_to(self.due)
        return self.v["cr"]

    def _awaited(self) -> int:
        cr = self.v["cr"]
        bits = HSERDY if cr & HSEON and not cr & HSERDY and self.hse_hz else 0
        return bits | (PLL1RDY if cr & PLL1ON and not cr & PLL1RDY and self._vco_hz() else 0)

    def advance(self) -> None:
        """Report oscillators ready."""
        self.due = NEVER
        self._hz.clear()
        if self._awaited() & PLL1RDY:
            self._check_pll()
        self.v["cr"] |= self._awaited()
        if self.v["cr"] & CSSON and self.v["cr"] & HSEON and not self.hse_hz:
            self._lose_hse()

    def _check_pll(self) -> None:
        low, high = ((1, 2), (2, 4), (4, 8), (8, 16))[self.v["pllcfgr"] >> 2 & 3]
        if not low * 10**6 <= self._reference_hz() <= high * 10**6:
            raise UnmodelledError(f"rcc: PLL1RGE does not fit {self._reference_hz()} Hz")
        wide = not self.v["pllcfgr"] >> 1 & 1
        low, high = (192, 960) if wide else (150, 420)
        if not low * 10**6 <= self._vco_hz() <= high * 10**6:
            raise UnmodelledError(f"rcc: PLL1's VCO at {self._vco_hz()} Hz")
        p_code = self.v["pll1divr"] >> 9 & 0x7F
        if p_code and not p_code & 1:
            raise UnmodelledError("rcc: DIVP1 odd")

    def _write_pll(self, name: str, old: int, new: int) -> None:
        if self.v["cr"] & PLL1ON and old != new:
            raise UnmodelledError(f"rcc.{name} changed while PLL1 is on")
        self.v[name] = new

    def _write_cfgr(self, name: str, old: int, new: int) -> None:
        code = new & 7
        if code not in (SW_HSI, SW_PLL1) or (code == SW_PLL1 and not self.v["cr"] & PLL1RDY):
            raise UnmodelledError(f"rcc.cfgr: switch to clock {code}, which is not ready")
        self._change()
        self.v["cfgr"] = (new & ~0x38) | code << 3
        self._check()

    def _write_divisor(self, name: str, old: int, new: int) -> None:
        self._change()
        self.v[name] = new
        self._check()

    def _write_cicr(self, name: str, old: int, new: int) -> None:
        self.v["cifr"] &= ~new

    def _write_rsr(self, name: str, old: int, new: int) -> None:
        if new & RMVF:
            self.v["rsr"] = 0

    # The board

    def fail_hse(self) -> None:
        """Let the HSE stop; with the security system on, take the HSI and raise the NMI."""
        self._change()
        was_watched = self.v["cr"] & HSERDY and self.v["cr"] & CSSON
        self.hse_hz = 0
        if not was_watched:
            raise UnmodelledError("rcc: the HSE died and nobody watches it")
        self._lose_hse()

    def _lose_hse(self) -> None:
        self.v["cr"] &= ~(HSEON | HSERDY)
        if self.v["pllckselr"] & 3 == 2:
            self.v["cr"] &= ~(PLL1ON | PLL1RDY)
        self.v["cfgr"] &= ~0x3F  # HSI
        self.v["cifr"] |= HSECSSF
        self._hz.clear()
        self.on_css()
        self.clock.wake()
