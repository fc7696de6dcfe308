"""Timers TIM1 to TIM5 (RM0433, sections 38 and 39).

Modelled: counting up from the internal clock without prescaler and preload, encoder mode 3, input
capture from the four pins, PWM mode 2 on channel 3, update event and interrupt, OC3REF as trigger
output. The input filter delays nothing here.
"""

from collections.abc import Callable

from tests.stm32.models.bus import NEVER, WORD, Device, InsnClock, Reg, UnmodelledError
from tests.stm32.models.rcc import Rcc

CEN, URS, DIR = 1 << 0, 1 << 2, 1 << 4
UIF = UIE = 1 << 0
ENCODER_3, PWM_2, MMS_OC3REF = 3, 7 << 4, 6 << 4
CC3E, CC3P = 1 << 8, 1 << 9
SR = 0x10


class Timer(Device):
    """One timer."""

    def __init__(self, clock: InsnClock, rcc: Rcc, name: str, base: int, bits: int) -> None:
        super().__init__(name, base, clock)
        self.rcc, top = rcc, (1 << bits) - 1
        # called at a rising edge of the trigger output
        self.on_trigger: Callable[[], None] = lambda: None
        # called when the counter wraps, before the interrupt
        self.on_update: Callable[[], None] = lambda: None
        # called with the level of channel 3 when it changes
        self.on_output: Callable[[int], None] = lambda level: None
        self._since = 0  # [cycles] instant of _count and _rest
        self._count = self._rest = 0  # _rest in units of 1 / core_hz
        self._reference = self._output = 0  # of channel 3
        rcc.before_change.append(self._before_change)
        self.define(
            {
                0x00: Reg("cr1", 0, CEN | URS),
                0x04: Reg("cr2", 0, 0x70),
                0x08: Reg("smcr", 0, ENCODER_3),
                0x0C: Reg("dier", 0, UIE),
                0x10: Reg("sr", 0, 0x1E1F, WORD),
                0x14: Reg("egr", 0, 1),
                0x18: Reg("ccmr1", 0, 0xF3F3),
                0x1C: Reg("ccmr2", 0, 0xF3F3),
                0x20: Reg("ccer", 0, 0xBBBB),
                0x24: Reg("cnt", 0, 0),
                0x2C: Reg("arr", top, top),
                0x34: Reg("ccr1", 0, 0, rule="ccr"),
                0x3C: Reg("ccr3", 0, top, rule="ccr"),
                0x40: Reg("ccr4", 0, 0, rule="ccr"),
            }
        )

    def reset(self) -> None:
        """Stop."""
        super().reset()
        self._since, self._count, self._rest = self.clock.now, 0, 0
        self._reference = self._output = 0

    def irq(self) -> bool:
        """Return whether the interrupt line is raised."""
        return bool(self.v["sr"] & self.v["dier"] & UIF)

    def write(self, offset: int, size: int, value: int) -> None:
        """Do what a store does; advance() looks at its result before the next instruction."""
        self._sync()
        super().write(offset, size, value)
        if offset != SR:
            self._look()

    def _look(self) -> None:
        self.due = 0
        self.clock.wake()

    def _before_change(self) -> None:
        self._sync()
        self._look()

    # Counting

    def _is_encoder(self) -> bool:
        return self.v["smcr"] == ENCODER_3

    def _is_counting(self) -> bool:
        return bool(self.v["cr1"] & CEN) and not self._is_encoder()

    def _sync(self) -> None:
        """Count up to now; what happens at updates is advance()'s."""
        elapsed = self.clock.now - self._since
        self._since = self.clock.now
        if self._is_counting():
            total = self._rest + elapsed * self.rcc.timer_hz()
            steps, self._rest = divmod(total, self.rcc.core_hz())
            self._count += steps

    def count(self) -> int:
        """Return the counter at the clock's time."""
        self._sync()
        return self._count % (self.v["arr"] + 1)

    def put_forward(self, cycles: int) -> None:
        """Let the counter be where it will be so many cycles later."""
        self._since -= cycles

    def _is_pwm(self) -> bool:
        return self.v["ccmr2"] & 0xFF == PWM_2

    def _find_event(self) -> int:
        """Return when the counter, synchronised, reaches the next update or compare."""
        if not (self.v["dier"] & UIE or self._is_pwm()):
            return NEVER
        is_ahead = self._is_pwm() and self._count < self.v["ccr3"] <= self.v["arr"]
        mark = self.v["ccr3"] if is_ahead else self.v["arr"] + 1
        need = (mark - self._count) * self.rcc.core_hz() - self._rest
        return self._since + max(0, -(-need // self.rcc.timer_hz()))

    def advance(self) -> None:
        """Wrap, and move the output."""
        self.due = NEVER
        if self._is_counting():
            self._sync()
            if self._count > self.v["arr"]:
                self._count %= self.v["arr"] + 1
                self.v["sr"] |= UIF
                self.on_update()
            self._compare()
            self.due = self._find_event()

    def _compare(self) -> None:
        """Let channel 3 follow the counter: its reference is high from CCR3 on."""
        if not self._is_pwm():
            return
        reference = int(self.count() >= self.v["ccr3"])
        if reference and not self._reference and self.v["cr2"] == MMS_OC3REF:
            self.on_trigger()
        self._reference = reference
        self._drive()

    def _drive(self) -> None:
        is_on, is_inverted = self.v["ccer"] & CC3E, bool(self.v["ccer"] & CC3P)
        level = self._reference ^ is_inverted if is_on else 0
        if is_on and level != self._output:
            self.on_output(level)
        self._output = level

    # Encoder and capture, moved by the bench

    def move_encoder(self, counts: int) -> None:
        """Let an encoder at channels 1 and 2 pass edges, positive: A before B."""
        if counts == 0 or not self._is_encoder() or not self.v["cr1"] & CEN:
            return
        if self.v["ccmr1"] & 0x0303 != 0x0101 or self.v["ccer"] & 0x22:
            raise UnmodelledError(f"{self.name}: encoder mode without plain TI1 and TI2 as inputs")
        self.v["cr1"] = (self.v["cr1"] & ~DIR) | (DIR if counts < 0 else 0)
        self._count = (self._count + counts) % (self.v["arr"] + 1)

    def input_edge(self, pin: int, level: int, ago: int = 0) -> None:
        """Let an edge arrive at the pin of a channel 1 .. 4: level 1 rising, 0 falling.

        Parameters
        ----------
        ago : int
            counts of this timer since the edge, when the machine moves in steps
        """
        for channel in (1, 3, 4):
            word = self.v["ccmr1" if channel < 3 else "ccmr2"] >> 8 * ((channel - 1) % 2)
            source = {1: channel, 2: ((channel - 1) ^ 1) + 1}.get(word & 3)
            enable = self.v["ccer"] >> 4 * (channel - 1)
            polarity = (enable >> 1 & 1) | (enable >> 2 & 2)  # 3: both edges
            if source == pin and enable & 1 and polarity in (3, 1 - level):
                overrun = self.v["sr"] >> channel & 1
                self.v["sr"] |= 1 << channel | overrun << (8 + channel)
                self.v[f"ccr{channel}"] = (self.count() - ago) % (self.v["arr"] + 1)

    # Registers

    def _write_sr(self, name: str, old: int, new: int) -> None:
        self.v["sr"] = old & new  # cleared by writing 0

    def _write_egr(self, name: str, old: int, new: int) -> None:
        self._count = self._rest = 0
        if not self.v["cr1"] & URS:
            self.v["sr"] |= UIF
        self._compare()

    def _write_ccmr2(self, name: str, old: int, new: int) -> None:
        if not new & 3 and new & 0xFF not in (0, PWM_2):
            raise UnmodelledError(f"{self.name}.ccmr2 0x{new:x}: output mode")
        self.v["ccmr2"] = new
        self._compare()

    def _write_ccer(self, name: str, old: int, new: int) -> None:
        self.v["ccer"] = new
        if self._is_pwm():
            self._output = -1  # driven from now on
            self._drive()

    def _write_ccr(self, name: str, old: int, new: int) -> None:
        self.v[name] = new
        self._compare()

    def _read_ccr(self, name: str) -> int:
        if not self._is_pwm():  # reading a capture clears its flag
            self.v["sr"] &= ~(1 << int(name[3]))
        return self.v[name]

    def _read_cnt(self, name: str) -> int:
        return self.count()
