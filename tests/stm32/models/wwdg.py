# SPDX-License-Identifier: Apache-2.0
"""Window watchdog WWDG1 (RM0433, section 44), on the clock of APB3."""

from collections.abc import Callable

from tests.stm32.models.bus import NEVER, Device, InsnClock, Reg, UnmodelledError
from tests.stm32.models.rcc import Rcc

WDGA, LOWEST, STEP_CLOCKS = 1 << 7, 0x40, 4096


class Wwdg(Device):
    """Counts down in steps; below 64, or fed before the window opens, it calls `on_bite`.

    The steps come from a prescaler that runs on when it is fed, so the first of them is shorter.
    """

    def __init__(self, clock: InsnClock, rcc: Rcc, on_bite: Callable[[], None]) -> None:
        super().__init__("wwdg1", 0x50003000, clock)
        self.rcc, self.on_bite = rcc, on_bite
        self._started_at = self._fed_at = NEVER
        self.define(
            {0x00: Reg("cr", 0x7F, 0xFF), 0x04: Reg("cfr", 0x7F, 0x7F), 0x08: Reg("sr", 0, 0)}
        )

    def reset(self) -> None:
        """Stop: only a reset can."""
        super().reset()
        self._started_at = self._fed_at = NEVER

    @property
    def is_running(self) -> bool:
        """Whether it was started since the last reset."""
        return self._started_at != NEVER

    def _step_cycles(self) -> int:
        return STEP_CLOCKS * self.rcc.core_hz() // self.rcc.apb3_hz()

    def _steps_until(self, at: int) -> int:
        return (at - self._started_at) // self._step_cycles()

    def _left(self) -> int:
        steps = self._steps_until(self.clock.now) - self._steps_until(self._fed_at)
        return (self.v["cr"] & 0x7F) - steps

    def _read_cr(self, name: str) -> int:
        return WDGA | self._left() if self.is_running else self.v["cr"]

    def _write_cr(self, name: str, old: int, new: int) -> None:
        if not self.rcc.is_on(("apb3enr", 6)):
            raise UnmodelledError("wwdg1 written without its clock")
        if new & WDGA and not self.rcc.v["gcr"] & 1:
            raise UnmodelledError("wwdg1 started while WW1RSC is 0")
        is_early = self.is_running and self._left() > self.v["cfr"]
        if new & WDGA and not self.is_running:
            self._started_at = self.clock.now
        self.v["cr"] = new
        self._fed_at = self.clock.now
        self.due = self._bites_at() if self.is_running else NEVER
        if is_early or not new & LOWEST:
            self.on_bite()

    def _bites_at(self) -> int:
        steps = self._steps_until(self._fed_at) + (self.v["cr"] & 0x7F) - LOWEST + 1
        return self._started_at + steps * self._step_cycles()

    def advance(self) -> None:
        """Bite: nobody came in time."""
        self.on_bite()
