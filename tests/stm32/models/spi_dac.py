"""SPI3 as a master (RM0433, section 50), the AD5754R at it (its data sheet), and DAC1.

The SPI shifts frames of 24 bits, at the kernel clock divided by MBR, out of a FIFO that takes four.
Modelled: full duplex or transmit only, one transfer of TSIZE frames per CSTART, hardware slave
select with pulses. Frames come out whole, at their end. Switched off within a clock after EOT, it
cuts the last pulse off (ES0392).
"""

from collections import deque
from collections.abc import Callable

from tests.stm32.models.bus import NEVER, Device, InsnClock, Reg, UnmodelledError
from tests.stm32.models.rcc import Rcc

SPE, CSTART = 1 << 0, 1 << 9
EOT, TXTF = 1 << 3, 1 << 4
BITS = 24
# Master, clock idle low and data on its rising edge, slave select by hardware with pulses.
CFG2 = 1 << 22 | 1 << 24 | 1 << 29 | 1 << 30 | 1 << 31
TRANSMIT_ONLY, MIDI, MSSI = 1 << 17, 15 << 4, 15
FIFO_FRAMES = 4


class Spi(Device):
    """A master."""

    def __init__(self, clock: InsnClock, rcc: Rcc, name: str, base: int) -> None:
        super().__init__(name, base, clock)
        self.rcc = rcc
        # given a frame, returns the frame that comes back
        self.exchange: Callable[[int], int] = lambda frame: 0
        self._tx: deque[int] = deque()
        self._rx: deque[int] = deque()
        self._left = 0  # frames of the transfer still to come
        self._flags = 0
        self._ended_at = -NEVER  # the last transfer
        self._shifting = 0
        self.define(
            {
                0x00: Reg("cr1", 0, SPE | CSTART),
                0x04: Reg("cr2", 0, 0xFFFF),
                0x08: Reg("cfg1", 0x00070007, 0x70000000 | 31, rule="off"),
                0x0C: Reg("cfg2", 0, CFG2 | TRANSMIT_ONLY | MIDI | MSSI, rule="off"),
                0x14: Reg("sr", 0, 0),
                0x18: Reg("ifcr", 0, EOT | TXTF),
                0x20: Reg("txdr"),
                0x30: Reg("rxdr", 0, 0),
            }
        )

    def reset(self) -> None:
        """Drop what is on its way."""
        super().reset()
        self._drop()

    def _drop(self) -> None:
        self._tx.clear()
        self._rx.clear()
        self._left, self._flags, self.due = 0, 0, NEVER

    def bit_hz(self) -> int:
        """Return the rate of bits."""
        return self.rcc.pll1_hz("q") >> ((self.v["cfg1"] >> 28 & 7) + 1)

    def select_high_s(self) -> float:
        """Return the time of a high slave select: that between frames but for one clock."""
        return max(0, (self.v["cfg2"] >> 4 & 15) - 1) / self.bit_hz()

    def _write_cr1(self, name: str, old: int, new: int) -> None:
        self.v["cr1"] = new & ~CSTART
        if not new & SPE:
            since = self.clock.now - self._ended_at
            if old & SPE and since * self.bit_hz() < self.rcc.core_hz():
                raise UnmodelledError(f"{self.name}: switched off within a clock after EOT")
            self._drop()
            return
        is_bits = self.v["cfg1"] & 31 == BITS - 1
        if self.v["cfg2"] & CFG2 != CFG2 or not is_bits or not self.v["cr2"]:
            raise UnmodelledError(f"{self.name}: anything but a master with hardware slave select")
        if new & CSTART and self._left == 0:
            self._left = self.v["cr2"]
            self._begin_frame()

    def _write_off(self, name: str, old: int, new: int) -> None:
        if self.v["cr1"] & SPE:
            raise UnmodelledError(f"{self.name}.{name} written while the SPI is on")
        self.v[name] = new

    def _write_cr2(self, name: str, old: int, new: int) -> None:
        self._write_off(name, old, new)

    def _write_txdr(self, name: str, old: int, new: int) -> None:
        if not self.v["cr1"] & SPE or len(self._tx) >= FIFO_FRAMES:
            raise UnmodelledError(f"{self.name}.txdr written while off or full: a frame is lost")
        self._tx.append(new & ((1 << BITS) - 1))
        self._begin_frame()

    def _read_rxdr(self, name: str) -> int:
        if not self._rx:
            raise UnmodelledError(f"{self.name}.rxdr read while it is empty")
        return self._rx.popleft()

    def _write_ifcr(self, name: str, old: int, new: int) -> None:
        self._flags &= ~new

    def _read_sr(self, name: str) -> int:
        if self._left and not self._tx:  # the last frame is on the line
            self.clock.skip_to(self.due)
        return self._flags

    def _begin_frame(self) -> None:
        if self.due == NEVER and self._left and self._tx:
            self._shifting = self._tx.popleft()
            idle = (self.v["cfg2"] & 15) + (self.v["cfg2"] >> 4 & 15)
            self.due = self.clock.now + (BITS + idle) * self.rcc.core_hz() // self.bit_hz()

    def advance(self) -> None:
        """End the frame on the line, begin the next one."""
        self.due = NEVER
        back = self.exchange(self._shifting)
        if not self.v["cfg2"] & TRANSMIT_ONLY:
            self._rx.append(back)
        self._left -= 1
        if self._left == 0:
            self._flags |= EOT | TXTF
            self._ended_at = self.clock.now
        self._begin_frame()


class Ad5754r:
    """Four DACs of 16 bits: input registers, DAC registers, range, power."""

    DAC, RANGE, POWER, CONTROL, READ = 0, 1, 2, 3, 16
    NOP, SETTINGS, LOAD = 0, 1, 5
    ALL, RANGE_10V = 4, 4

    def __init__(self) -> None:
        self.power_on()

    def power_on(self) -> None:
        """Take the values after power-on: all outputs off."""
        # of A .. D: DAC registers, which the outputs show when powered, and input registers
        self.words, self.inputs = [0] * 4, [0] * 4
        self.power = self.range = 0
        self.is_ldac_low = self.is_clear_low = False
        self._answer = 0

    def volts(self, channel: int) -> float:
        """Return the voltage of an output; one that is not powered is tied to ground."""
        if not self.power >> channel & 1:
            return 0.0
        if self.range != self.RANGE_10V:
            raise UnmodelledError(f"AD5754R: range {self.range}")
        return signed16(self.words[channel]) * 10 / 32768

    def ldac(self, level: int) -> None:
        """Move the pin /LDAC; a falling edge takes all input registers over."""
        self.is_ldac_low, was_low = not level, self.is_ldac_low
        if self.is_ldac_low and not was_low:
            self._load()

    def clear(self, level: int) -> None:
        """Move the pin /CLR; while it is low, the outputs stay at 0 V."""
        self.is_clear_low = not level
        if self.is_clear_low:
            self.words, self.inputs = [0] * 4, [0] * 4

    def _load(self) -> None:
        """Take all input registers over, unless /CLR holds the outputs."""
        if not self.is_clear_low:
            self.words = list(self.inputs)

    def exchange(self, frame: int) -> int:
        """Take a frame between two edges of /SYNC; return what SDO shifted out meanwhile."""
        answer, self._answer = self._answer, 0
        register, address, data = frame >> 19, frame >> 16 & 7, frame & 0xFFFF
        if register == self.READ | self.POWER:
            self._answer = (frame & 0xFF0000) | self.power
        elif register == self.DAC and address < self.ALL:
            self.inputs[address] = data
            if self.is_ldac_low:
                self._load()
        elif register == self.RANGE and address == self.ALL:
            self.range = data
        elif register == self.POWER and address == 0:
            self.power = data
        elif (register, address) == (self.CONTROL, self.LOAD):
            self._load()
        elif register != self.CONTROL or address > self.SETTINGS or data & 2:  # CLR select
            raise UnmodelledError(f"AD5754R: frame 0x{frame:06x}")
        return answer


def signed16(word: int) -> int:
    """Return the number of a two's complement word."""
    return word - 0x10000 if word & 0x8000 else word


class Dac1(Device):
    """The chip's own DAC1 (RM0433, section 26): channel 1 by the trigger of TIM4 or at once.

    Whether the output register follows a store while the channel is off, the manual leaves open:
    here it does not (embassy 1676).
    """

    EN, TEN, TSEL_TIM4 = 1 << 0, 1 << 1, 3 << 2

    def __init__(self, clock: InsnClock) -> None:
        super().__init__("dac1", 0x40007400, clock)
        # called with the code that the output shows when it changes, None when the channel is off
        self.on_output: Callable[[int | None], None] = lambda code: None
        self.define(
            {
                0x00: Reg("cr", 0, self.EN | self.TEN | self.TSEL_TIM4),
                0x08: Reg("dhr12r1", 0, 0xFFF),
                0x2C: Reg("dor1", 0, 0),
            }
        )

    def reset(self) -> None:
        """Switch the output off."""
        was_on = self.v["cr"] & self.EN
        super().reset()
        if was_on:
            self.on_output(None)

    def _write_cr(self, name: str, old: int, new: int) -> None:
        if old & self.EN and (old ^ new) & self.TSEL_TIM4:
            raise UnmodelledError("dac1.cr: trigger selected while the channel is on")
        self.v["cr"] = new
        if (old ^ new) & self.EN:
            self.on_output(self.v["dor1"] if new & self.EN else None)

    def _write_dhr12r1(self, name: str, old: int, new: int) -> None:
        self.v["dhr12r1"] = new
        if self.v["cr"] & (self.EN | self.TEN) == self.EN:
            self._take_over()

    def _take_over(self) -> None:
        self.v["dor1"] = self.v["dhr12r1"]
        self.on_output(self.v["dor1"])

    def trigger(self) -> None:
        """Let the trigger of TIM4 come."""
        if self.v["cr"] == self.EN | self.TEN | self.TSEL_TIM4:
            self._take_over()
