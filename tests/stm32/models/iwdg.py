# SPDX-License-Identifier: Apache-2.0
"""Independent watchdog IWDG1 (RM0433, section 46), without window, on the LSI of 32 kHz."""

from collections.abc import Callable

from tests.stm32.models.bus import NEVER, Device, InsnClock, Reg, UnmodelledError
from tests.stm32.models.rcc import LSI_HZ, Rcc

KEY_START, KEY_RELOAD, KEY_ACCESS = 0xCCCC, 0xAAAA, 0x5555


class Iwdg(Device):
    """Counts down from the reload value; at zero it calls `on_bite`."""

    def __init__(self, clock: InsnClock, rcc: Rcc, on_bite: Callable[[], None]) -> None:
        super().__init__("iwdg1", 0x58004800, clock)
        self.rcc, self.on_bite = rcc, on_bite
        self._can_write = False
        self.define(
            {
                0x00: Reg("kr", 0, 0xFFFF),
                0x04: Reg("pr", 0, 7, rule="locked"),
                0x08: Reg("rlr", 0xFFF, 0xFFF, rule="locked"),
                0x0C: Reg("sr", 0, 0),  # updates take effect at once here
                0x10: Reg("winr", 0xFFF, 0),
            }
        )

    def reset(self) -> None:
        """Stop: only a reset can."""
        super().reset()
        self._can_write = False

    @property
    def is_running(self) -> bool:
        """Whether it was started since the last reset."""
        return self.due != NEVER

    def put_forward(self, cycles: int) -> None:
        """Let it bite sooner, unless somebody feeds it."""
        self.due -= cycles

    def _write_kr(self, name: str, old: int, new: int) -> None:
        if new not in (KEY_START, KEY_RELOAD, KEY_ACCESS):
            raise UnmodelledError(f"iwdg1.kr: 0x{new:x}")
        self._can_write = new == KEY_ACCESS
        if new == KEY_START or (new == KEY_RELOAD and self.is_running):
            steps = (self.v["rlr"] + 1) * (4 << min(self.v["pr"], 6))
            self.due = self.clock.now + steps * self.rcc.core_hz() // LSI_HZ

    def _write_locked(self, name: str, old: int, new: int) -> None:
        if not self._can_write:
            raise UnmodelledError(f"iwdg1.{name} written without its key")
        self.v[name] = new

    def advance(self) -> None:
        """Bite: nobody came in time."""
        self.on_bite()
