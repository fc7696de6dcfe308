"""IWDG1 (RM0433, section 46) on the LSI of 32 kHz; WWDG1 (section 44) on the clock of APB3."""

from collections.abc import Callable

from tests.stm32.models.bus import NEVER, Device, InsnClock, Reg, UnmodelledError
from tests.stm32.models.rcc import LSI_HZ, Rcc

KEY_START, KEY_RELOAD, KEY_ACCESS = 0xCCCC, 0xAAAA, 0x5555
WDGA, LOWEST, STEP_CLOCKS = 1 << 7, 0x40, 4096


class Iwdg(Device):
    """Counts down from the reload value, without window; at zero it calls `on_bite`."""

    def __init__(self, clock: InsnClock, rcc: Rcc, on_bite: Callable[[], None]) -> None:
        super().__init__("iwdg1", 0x58004800, clock)
        self.rcc, self.on_bite = rcc, on_bite
        self.define(
            {
                0x00: Reg("kr", 0, 0xFFFF),
                0x04: Reg("pr", 0, 7, rule="locked"),
                0x08: Reg("rlr", 0xFFF, 0xFFF, rule="locked"),
            }
        )

    def put_forward(self, cycles: int) -> None:
        """Let it bite sooner, unless somebody feeds it."""
        self.due -= cycles

    def _write_kr(self, name: str, old: int, new: int) -> None:
        if new not in (KEY_START, KEY_RELOAD, KEY_ACCESS):
            raise UnmodelledError(f"iwdg1.kr: 0x{new:x}")
        self.v["kr"] = new
        if new == KEY_START or (new == KEY_RELOAD and self.due != NEVER):
            steps = (self.v["rlr"] + 1) * (4 << min(self.v["pr"], 6))
            self.due = self.clock.now + steps * self.rcc.core_hz() // LSI_HZ

    def _write_locked(self, name: str, old: int, new: int) -> None:
        if self.v["kr"] != KEY_ACCESS:
            raise UnmodelledError(f"iwdg1.{name} written without its key")
        self.v[name] = new

    def advance(self) -> None:
        """Bite: nobody came in time."""
        self.on_bite()


class Wwdg(Device):
    """Counts down in steps; below 64, or fed before the window opens, it calls `on_bite`.

    The steps come from a prescaler that runs on when it is fed, so the first of them is shorter.
    """

    def __init__(self, clock: InsnClock, rcc: Rcc, on_bite: Callable[[], None]) -> None:
        super().__init__("wwdg1", 0x50003000, clock)
        self.rcc, self.on_bite = rcc, on_bite
        self._started_at = self._fed_at = NEVER
        self.define({0x00: Reg("cr", 0x7F, 0xFF), 0x04: Reg("cfr", 0x7F, 0x7F)})

    def reset(self) -> None:
        """Stop: only a reset can."""
        super().reset()
        self._started_at = self._fed_at = NEVER

    def _is_running(self) -> bool:
        return self._started_at != NEVER

    def _step_cycles(self) -> int:
        return STEP_CLOCKS * self.rcc.core_hz() // self.rcc.apb3_hz()

    def _steps_until(self, at: int) -> int:
        return (at - self._started_at) // self._step_cycles()

    def _left(self) -> int:
        steps = self._steps_until(self.clock.now) - self._steps_until(self._fed_at)
        return (self.v["cr"] & 0x7F) - steps

    def _read_cr(self, name: str) -> int:
        return WDGA | self._left() if self._is_running() else self.v["cr"]

    def _write_cr(self, name: str, old: int, new: int) -> None:
        if not new & WDGA or not self.rcc.v["gcr"] & 1:
            raise UnmodelledError("wwdg1.cr without WDGA, or started while WW1RSC is 0")
        is_early = self._is_running() and self._left() > self.v["cfr"]
        if not self._is_running():
            self._started_at = self.clock.now
        self.v["cr"] = new
        self._fed_at = self.clock.now
        steps = self._steps_until(self._fed_at) + (new & 0x7F) - LOWEST + 1
        self.due = self._started_at + steps * self._step_cycles()
        if is_early or not new & LOWEST:
            self.on_bite()

    def advance(self) -> None:
        """Bite: nobody came in time."""
        self.on_bite()
