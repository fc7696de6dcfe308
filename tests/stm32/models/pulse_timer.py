# SPDX-License-Identifier: Apache-2.0
"""Timers TIM16, TIM17 and TIM8 (RM0433, sections 41 and 38) making trains of pulses.

Modelled: one-pulse mode with the repetition counter, PWM modes 1 and 2 on one channel, main output
enable. A train has RCR + 1 periods; the repetition counter is loaded by an update event, so by UG.
Not modelled, hence an error: preload of ARR and CCRx, counting without end, and everything that
changes a train while it runs.

The edges of a train are known when it starts. They are told at its end, or before anything happens
that depends on them, each with its own time.
"""

from collections.abc import Callable

from tests.stm32.models.bus import NEVER, Device, InsnClock, Reg, UnmodelledError
from tests.stm32.models.rcc import Rcc

CEN, UDIS, URS, OPM = 1 << 0, 1 << 1, 1 << 2, 1 << 3
UIF, UG, CC1E, CC1P, MOE = 1, 1, 1, 2, 1 << 15
PWM_1, PWM_2 = 6, 7
TOP = 0xFFFF


class PulseTimer(Device):
    """One timer."""

    def __init__(
        self, clock: InsnClock, rcc: Rcc, name: str, base: int, *, channel: int = 1
    ) -> None:
        super().__init__(name, base, clock)
        self._ccmr, self._ccr = f"ccmr{(channel + 1) // 2}", f"ccr{channel}"
        self._at = 4 * (channel - 1)  # of the channel's bits in CCER
        self.rcc = rcc
        # called with time [cycles] and level of every edge of the channel, 1 or 3
        self.on_edge: Callable[[int, int], None] = lambda at, level: None
        self._edges: list[tuple[int, int]] = []  # of the train that runs, not yet told
        self._repetitions = 0
        self._level: int | None = None  # None: not driven
        rcc.before_change.append(self._refuse_change)
        self.define(
            {
                0x00: Reg("cr1", 0, CEN | URS | OPM),
                0x10: Reg("sr", 0, UIF),
                0x14: Reg("egr", 0, UG),
                0x16 + 2 * channel: Reg(self._ccmr, 0, 0x10070, rule="idle"),
                0x20: Reg("ccer", 0, (CC1E | CC1P) << self._at, rule="idle"),
                0x28: Reg("psc", 0, 0),
                0x2C: Reg("arr", TOP, TOP, rule="idle"),
                0x30: Reg("rcr", 0, 0xFF),
                0x30 + 4 * channel: Reg(self._ccr, 0, TOP, rule="idle"),
                0x44: Reg("bdtr", 0, MOE, rule="idle"),
            }
        )

    def reset(self) -> None:
        """Stop and let go of the pin."""
        super().reset()
        self._edges, self._repetitions, self._level = [], 0, None

    def is_running(self) -> bool:
        """Return whether a train is on its way."""
        self.catch_up()
        return self.due != NEVER

    def catch_up(self) -> None:
        """Tell the edges that have come until now."""
        while self._edges and self._edges[0][0] <= self.clock.now:
            at, self._level = self._edges.pop(0)
            self.on_edge(at, self._level)
        if self.due <= self.clock.now:
            self.due = NEVER
            self.v["cr1"] &= ~CEN
            self.v["sr"] |= UIF
            self._repetitions = self.v["rcr"]

    def advance(self) -> None:
        """End the train."""
        self.catch_up()

    def _output(self, count: int) -> int:
        """Return the level of the pin while the counter is at a number."""
        ccmr = self.v[self._ccmr]
        mode = (ccmr >> 4 & 7) | (ccmr >> 13 & 8)
        if mode not in (PWM_1, PWM_2):
            raise UnmodelledError(f"{self.name}: output mode {mode}")
        is_active = (count < self.v[self._ccr]) == (mode == PWM_1)
        return int(is_active) ^ (self.v["ccer"] >> self._at >> 1 & 1)

    def _is_driven(self) -> bool:
        return bool(self.v["ccer"] >> self._at & CC1E and self.v["bdtr"] & MOE)

    def _show(self) -> None:
        """Drive the pin as the resting counter, 0, wants it."""
        level = self._output(0) if self._is_driven() else None
        if level is not None and level != self._level:
            self.on_edge(self.clock.now, level)
        self._level = level

    def _start(self) -> None:
        ratio = self.rcc.core_hz() / self.rcc.timer_hz()
        period, compare = self.v["arr"] + 1, self.v[self._ccr]
        if not 0 < compare < period:
            raise UnmodelledError(f"{self.name}: no pulse, CCRx is {compare} of {period}")
        active, rest = self._output(compare), self._output(0)
        for i in range(self._repetitions + 1):
            begin = self.clock.now + i * period * ratio
            self._edges.append((round(begin + compare * ratio), active))
            self._edges.append((round(begin + period * ratio), rest))
        self.due = self._edges[-1][0]
        if not self._is_driven():
            self._edges = []

    # Registers

    def _refuse_change(self) -> None:
        if self.is_running():
            raise UnmodelledError(f"{self.name}: the clock changes in a train")

    def _write_idle(self, name: str, old: int, new: int) -> None:
        if self.is_running():
            raise UnmodelledError(f"{self.name}.{name} written in a train")
        self.v[name] = new
        self._show()

    def _read_cr1(self, name: str) -> int:
        self.catch_up()
        return self.v["cr1"]

    def _write_cr1(self, name: str, old: int, new: int) -> None:
        if self.is_running():
            raise UnmodelledError(f"{self.name}.cr1 written in a train")
        self.v["cr1"] = new
        if new & CEN:
            if not new & OPM:
                raise UnmodelledError(f"{self.name}: pulses without end")
            self._start()

    def _write_sr(self, name: str, old: int, new: int) -> None:
        self.v["sr"] = old & new

    def _write_egr(self, name: str, old: int, new: int) -> None:
        if self.is_running():
            raise UnmodelledError(f"{self.name}: UG ends the train")
        self._repetitions = self.v["rcr"]
        if not self.v["cr1"] & URS:
            self.v["sr"] |= UIF
