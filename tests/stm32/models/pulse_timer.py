"""Timers TIM16, TIM17 and TIM8 (RM0433, sections 41 and 38) making trains of pulses.

Modelled: one-pulse mode with the repetition counter, PWM mode 2 on one channel, main output enable.
A train has RCR + 1 periods; the repetition counter is loaded by an update event, so by UG. Counting
without end, and every change of a train while it runs, is an error.

The edges of a train are known when it starts. They are reported at its end, or before anything
happens that depends on them, each with its own time.
"""

from collections.abc import Callable

from tests.stm32.models.bus import NEVER, Device, InsnClock, Reg, UnmodelledError
from tests.stm32.models.rcc import Rcc

CEN, URS, OPM = 1 << 0, 1 << 2, 1 << 3
UG, MOE = 1, 1 << 15
PWM_2 = 7 << 4
TOP = 0xFFFF


class PulseTimer(Device):
    """One timer, with its channel 1 or 3."""

    def __init__(
        self, clock: InsnClock, rcc: Rcc, name: str, base: int, *, channel: int = 1
    ) -> None:
        super().__init__(name, base, clock)
        self.rcc = rcc
        # called with time [cycles] and level of every edge of the channel
        self.on_edge: Callable[[int, int], None] = lambda at, level: None
        self._edges: list[tuple[int, int]] = []  # of the train that runs, not yet reported
        self._repetitions = 0
        self._level: int | None = None  # None: not driven
        self._enable = 1 << 4 * (channel - 1)
        rcc.before_change.append(self._require_idle)
        self.define(
            {
                0x00: Reg("cr1", 0, CEN | URS | OPM),
                0x14: Reg("egr", 0, UG),
                0x16 + 2 * channel: Reg("ccmr", 0, PWM_2, rule="idle"),
                0x20: Reg("ccer", 0, self._enable, rule="idle"),
                0x2C: Reg("arr", TOP, TOP, rule="idle"),
                0x30: Reg("rcr", 0, 0xFF),
                0x30 + 4 * channel: Reg("ccr", 0, TOP, rule="idle"),
                0x44: Reg("bdtr", 0, MOE, rule="idle"),
            }
        )

    def reset(self) -> None:
        """Stop and let go of the pin."""
        super().reset()
        self._edges, self._repetitions, self._level = [], 0, None

    def catch_up(self) -> None:
        """Report the edges that have come until now."""
        while self._edges and self._edges[0][0] <= self.clock.now:
            at, self._level = self._edges.pop(0)
            self.on_edge(at, self._level)
        if self.due <= self.clock.now:
            self.due = NEVER
            self.v["cr1"] &= ~CEN
            self._repetitions = self.v["rcr"]

    def advance(self) -> None:
        """End the train."""
        self.catch_up()

    def _is_driven(self) -> bool:
        return bool(self.v["ccer"] and self.v["bdtr"])

    def _require_idle(self) -> None:
        self.catch_up()
        if self.due != NEVER:
            raise UnmodelledError(f"{self.name} is written, or its clock changes, in a train")

    def _write_idle(self, name: str, old: int, new: int) -> None:
        """Store, and drive the pin by the resting counter, 0: low if CCRx is above it."""
        self._require_idle()
        self.v[name] = new
        if self.v["ccmr"] not in (0, PWM_2):
            raise UnmodelledError(f"{self.name}: output mode 0x{self.v['ccmr']:x}")
        level = int(self.v["ccr"] == 0) if self._is_driven() else None
        if level is not None and level != self._level:
            self.on_edge(self.clock.now, level)
        self._level = level

    def _read_cr1(self, name: str) -> int:
        self.catch_up()
        return self.v["cr1"]

    def _write_cr1(self, name: str, old: int, new: int) -> None:
        self._require_idle()
        self.v["cr1"] = new
        if not new & CEN:
            return
        ratio = self.rcc.core_hz() / self.rcc.timer_hz()
        period, compare = self.v["arr"] + 1, self.v["ccr"]
        if not new & OPM or not 0 < compare < period or self.v["ccmr"] != PWM_2:
            raise UnmodelledError(f"{self.name}: no pulses, or pulses without end")
        for i in range(self._repetitions + 1):
            begin = self.clock.now + i * period * ratio
            self._edges.append((round(begin + compare * ratio), 1))
            self._edges.append((round(begin + period * ratio), 0))
        self.due = self._edges[-1][0]
        if not self._is_driven():
            self._edges = []

    def _write_egr(self, name: str, old: int, new: int) -> None:
        self._require_idle()
        self._repetitions = self.v["rcr"]
