# SPDX-License-Identifier: Apache-2.0
"""Timers TIM1..TIM5 (RM0433, sections 38 and 39) as far as a controller uses them.

Modelled: counting up from the internal clock with prescaler and preload, encoder mode 3, input
capture from the four pins, output compare in PWM modes 1 and 2 on channels 3 and 4, update event,
update interrupt, OC3REF as trigger output. Not modelled, hence an error: other slave modes,
counting down, one-pulse mode, DMA, break, input prescalers. The input filter delays nothing here.
"""

from collections.abc import Callable

from tests.stm32.models.bus import NEVER, WORD, Device, InsnClock, Reg, UnmodelledError
from tests.stm32.models.rcc import Rcc

CEN, UDIS, URS, DIR, ARPE = 1 << 0, 1 << 1, 1 << 2, 1 << 4, 1 << 7
UIF = 1 << 0
UIE = 1 << 0
ENCODER_3 = 3
SR = 0x10
PWM_1, PWM_2 = 6, 7


class Timer(Device):
    """One timer."""

    def __init__(
        self,
        clock: InsnClock,
        rcc: Rcc,
        name: str,
        base: int,
        *,
        bits: int = 16,
        advanced: bool = False,
    ) -> None:
        super().__init__(name, base, clock)
        self.rcc, self.top = rcc, (1 << bits) - 1
        # called at a rising edge of the trigger output
        self.on_trigger: Callable[[], None] = lambda: None
        # called when the counter wraps, before the interrupt
        self.on_update: Callable[[], None] = lambda: None
        # called with channel and level when the level of an output changes
        self.on_output: Callable[[int, int], None] = lambda channel, level: None
        self._since = 0  # [cycles] instant of _count and _rest
        self._count = 0
        self._rest = 0  # of the division by the prescaler, in units of 1 / core_hz
        self._psc = self._arr = 0
        self._compare = {3: 0, 4: 0}
        self._reference = {3: 0, 4: 0}
        self._outputs = {3: 0, 4: 0}
        rcc.before_change.append(self._before_change)
        self.define(
            {
                0x00: Reg("cr1", 0, CEN | UDIS | URS | DIR | ARPE),
                0x04: Reg("cr2", 0, 0x70),
                0x08: Reg("smcr", 0, 0x10007),
                0x0C: Reg("dier", 0, UIE),
                0x10: Reg("sr", 0, 0x1E1F, WORD),
                0x14: Reg("egr", 0, 1),
                0x18: Reg("ccmr1", 0, 0xF3F3),
                0x1C: Reg("ccmr2", 0, 0x0101FFFF),
                0x20: Reg("ccer", 0, 0xBBBB),
                0x24: Reg("cnt", 0, self.top),
                0x28: Reg("psc", 0, 0xFFFF),
                0x2C: Reg("arr", self.top, self.top),
                0x34: Reg("ccr1", 0, self.top, rule="ccr"),
                0x38: Reg("ccr2", 0, self.top, rule="ccr"),
                0x3C: Reg("ccr3", 0, self.top, rule="ccr"),
                0x40: Reg("ccr4", 0, self.top, rule="ccr"),
                0x60: Reg("af1", 0, 0),
                0x68: Reg("tisel", 0, 0),
            }
        )
        if advanced:
            self.define({0x30: Reg("rcr", 0, 0), 0x44: Reg("bdtr", 0, 0)})
        self.reset()

    def reset(self) -> None:
        """Stop."""
        super().reset()
        self._since, self._count, self._rest = self.clock.now, 0, 0
        self._psc, self._arr = 0, self.top
        self._compare = {3: 0, 4: 0}
        self._reference = {3: 0, 4: 0}
        self._outputs = {3: 0, 4: 0}

    def irq(self) -> bool:
        """Return whether the interrupt line is raised."""
        return bool(self.v["sr"] & self.v["dier"] & UIF)

    def write(self, offset: int, size: int, value: int) -> None:
        """Do what a store does."""
        super().write(offset, size, value)
        if offset != SR:
            self._look()

    def _look(self) -> None:
        """Have advance() called before the next instruction."""
        self.due = 0
        self.clock.wake()

    def _before_change(self) -> None:
        self._sync()
        self._look()

    # Counting

    def _is_encoder(self) -> bool:
        return self.v["smcr"] & 7 == ENCODER_3

    def _is_counting(self) -> bool:
        return bool(self.v["cr1"] & CEN) and not self._is_encoder()

    def _sync(self) -> None:
        """Count up to now; what happens at updates is advance()'s."""
        elapsed = self.clock.now - self._since
        self._since = self.clock.now
        if self._is_counting():
            core_hz = self.rcc.core_hz()
            total = self._rest + elapsed * self.rcc.timer_hz()
            steps, self._rest = divmod(total, core_hz * (self._psc + 1))
            self._count += steps

    def count(self) -> int:
        """Return the counter at the clock's time."""
        self._sync()
        return self._count % (self._arr + 1)

    def put_forward(self, cycles: int) -> None:
        """Let the counter be where it will be so many cycles later."""
        self._since -= cycles

    def _cycles_to(self, count: int) -> int:
        """Return when the counter, unwrapped since the last sync, reaches a number."""
        need = (count - self._count) * self.rcc.core_hz() * (self._psc + 1) - self._rest
        return self._since + max(0, -(-need // self.rcc.timer_hz()))

    def _is_on_output(self, channel: int) -> bool:
        mode = self._output_mode(channel)
        return mode is not None and bool(self.v["ccer"] >> 4 * (channel - 1) & 1)

    def _find_event(self) -> int:
        wants_update = self.v["dier"] & UIE
        channels = [c for c in (3, 4) if self._output_mode(c) in (PWM_1, PWM_2)]
        if not self._is_counting() or not (wants_update or channels):
            return NEVER
        self._sync()
        marks = [self._compare[c] for c in channels if self._count < self._compare[c] <= self._arr]
        return self._cycles_to(min([*marks, self._arr + 1]))

    def advance(self) -> None:
        """Wrap, and move the outputs."""
        if not self._is_counting():
            self.due = NEVER
            return
        self._sync()
        if self._count > self._arr:
            self._count %= self._arr + 1
            self._update()
            self.v["sr"] |= 0 if self.v["cr1"] & UDIS else UIF
            self.on_update()
        self._compare_outputs()
        self.due = self._find_event()

    def _update(self) -> None:
        """Load the shadow registers."""
        if self.v["cr1"] & UDIS:
            return
        self._psc, self._arr = self.v["psc"], self.v["arr"]
        self._compare = {c: self.v[f"ccr{c}"] for c in (3, 4)}

    # Outputs

    def _output_mode(self, channel: int) -> int | None:
        half = self.v["ccmr2"] >> 8 * (channel - 3)
        if half & 3:
            return None
        return (half >> 4 & 7) | (half >> 16 & 1) << 3

    def _compare_outputs(self) -> None:
        for channel in (3, 4):
            mode = self._output_mode(channel)
            if mode not in (None, 0, PWM_1, PWM_2):
                raise UnmodelledError(f"{self.name}: output mode {mode} on channel {channel}")
            if mode not in (PWM_1, PWM_2):
                continue
            is_below = self.count() < self._compare[channel]
            reference = int(is_below == (mode == PWM_1))
            rises = reference and not self._reference[channel]
            self._reference[channel] = reference
            if rises and channel == 3 and self.v["cr2"] >> 4 & 7 == 6:
                self.on_trigger()
            self._drive(channel)

    def _drive(self, channel: int) -> None:
        level = self._level(channel)
        if self._is_on_output(channel) and level != self._outputs[channel]:
            self.on_output(channel, level)
        self._outputs[channel] = level

    def _level(self, channel: int) -> int:
        enable = self.v["ccer"] >> 4 * (channel - 1)
        return self._reference[channel] ^ (enable >> 1 & 1) if enable & 1 else 0

    # Encoder and capture, moved by the bench

    def move_encoder(self, counts: int) -> None:
        """Let an encoder at channels 1 and 2 pass edges, positive: A before B."""
        if not self._is_encoder() or not self.v["cr1"] & CEN:
            return
        if self.v["ccmr1"] & 0x0303 != 0x0101:
            raise UnmodelledError(f"{self.name}: encoder mode without TI1 and TI2 as inputs")
        if counts == 0:
            return
        inverted = (self.v["ccer"] >> 1 ^ self.v["ccer"] >> 5) & 1
        self._sync()
        step = -counts if inverted else counts
        self.v["cr1"] = (self.v["cr1"] & ~DIR) | (DIR if step < 0 else 0)
        moved = self._count + step
        if not 0 <= moved <= self._arr:
            self.v["sr"] |= UIF
        self._count = moved % (self._arr + 1)

    def input_edge(self, pin: int, level: int, ago: int = 0) -> None:
        """Let an edge arrive at the pin of a channel 1 .. 4: level 1 rising, 0 falling.

        Parameters
        ----------
        ago : int
            counts of this timer since the edge, when the machine moves in steps
        """
        for channel in (1, 2, 3, 4):
            word = self.v["ccmr1" if channel < 3 else "ccmr2"] >> 8 * ((channel - 1) % 2)
            source = {1: channel, 2: ((channel - 1) ^ 1) + 1}.get(word & 3)
            enable = self.v["ccer"] >> 4 * (channel - 1)
            if source != pin or not enable & 1:
                continue
            if word >> 2 & 3:
                raise UnmodelledError(f"{self.name}: input prescaler")
            polarity = (enable >> 1 & 1) | (enable >> 2 & 2)
            if polarity == 3 or polarity == 1 - level:
                self._capture(channel, ago)

    def _capture(self, channel: int, ago: int) -> None:
        if self.v["sr"] >> channel & 1:
            self.v["sr"] |= 1 << (8 + channel)
        self.v[f"ccr{channel}"] = (self.count() - ago) % (self._arr + 1)
        self.v["sr"] |= 1 << channel

    # Registers

    def _write_cr1(self, name: str, old: int, new: int) -> None:
        if new & DIR:
            raise UnmodelledError(f"{self.name}: counting down")
        self._sync()
        self.v["cr1"] = new | (old & DIR)

    def _write_smcr(self, name: str, old: int, new: int) -> None:
        if new not in (0, ENCODER_3):
            raise UnmodelledError(f"{self.name}.smcr 0x{new:x}")
        self._sync()
        self.v["smcr"] = new

    def _write_dier(self, name: str, old: int, new: int) -> None:
        self.v["dier"] = new

    def _write_sr(self, name: str, old: int, new: int) -> None:
        self.v["sr"] = old & new  # cleared by writing 0

    def _write_egr(self, name: str, old: int, new: int) -> None:
        if not new & 1:
            return
        self._sync()
        self._count = self._rest = 0
        self._update()
        if not self.v["cr1"] & (UDIS | URS):
            self.v["sr"] |= UIF
        self._compare_outputs()

    def _write_ccmr2(self, name: str, old: int, new: int) -> None:
        self.v["ccmr2"] = new
        self._compare_outputs()

    def _write_ccer(self, name: str, old: int, new: int) -> None:
        self.v["ccer"] = new
        for channel in (3, 4):
            if self._is_on_output(channel):
                self._outputs[channel] = self._level(channel)
                self.on_output(channel, self._outputs[channel])

    def _write_cnt(self, name: str, old: int, new: int) -> None:
        self._sync()
        self._count, self._rest = new, 0

    def _write_arr(self, name: str, old: int, new: int) -> None:
        self._sync()
        self.v["arr"] = new
        if not self.v["cr1"] & ARPE:
            self._arr = new

    def _write_ccr(self, name: str, old: int, new: int) -> None:
        self.v[name] = new
        channel = int(name[3])
        if channel < 3:
            return
        is_preloaded = self.v["ccmr2"] >> (8 * (channel - 3) + 3) & 1
        if not is_preloaded and self._output_mode(channel) is not None:
            self._compare[channel] = new
            self._compare_outputs()

    def _read_ccr(self, name: str) -> int:
        channel = int(name[3])
        word = self.v["ccmr1" if channel < 3 else "ccmr2"] >> 8 * ((channel - 1) % 2)
        if word & 3:  # reading a capture clears its flag
            self.v["sr"] &= ~(1 << channel)
        return self.v[name] & WORD

    def _read_cnt(self, name: str) -> int:
        return self.count()
