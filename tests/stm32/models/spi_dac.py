# SPDX-License-Identifier: Apache-2.0
"""SPI3 as a master (RM0433, section 50), the AD5754R behind it (its data sheet), and DAC1.

The SPI shifts frames of the size set, at the kernel clock divided by MBR, out of a FIFO of 16
bytes; a frame of more than 16 bits takes four. Modelled: full duplex or transmit only, one transfer
of TSIZE frames per CSTART, hardware slave select with or without pulses. Frames come out whole, at
their end. Switched off within a clock after EOT, it cuts the last pulse off (ES0392).
"""

from collections import deque
from collections.abc import Callable

from tests.stm32.models.bus import NEVER, Device, InsnClock, Reg, UnmodelledError
from tests.stm32.models.rcc import Rcc

SPE, MASRX, CSTART, CSUSP, SSI = 1 << 0, 1 << 8, 1 << 9, 1 << 10, 1 << 12
RXP, TXP, DXP, EOT, TXTF, OVR, MODF, SUSP, TXC = (1 << i for i in (0, 1, 2, 3, 4, 6, 9, 11, 12))
MASTER, CPHA, CPOL, SSM, SSOE, SSOM = (1 << 22, 1 << 24, 1 << 25, 1 << 26, 1 << 29, 1 << 30)
FULL_DUPLEX, TRANSMIT_ONLY = 0, 1
FIFO_BYTES = 16


class Spi(Device):
    """A master."""

    def __init__(self, clock: InsnClock, rcc: Rcc, name: str, base: int) -> None:
        super().__init__(name, base, clock)
        self.rcc = rcc
        # given a frame and its number of bits, returns the frame that comes back
        self.exchange: Callable[[int, int], int] = lambda frame, bits: 0
        self._tx: deque[int] = deque()
        self._rx: deque[int] = deque()
        self._left = 0  # frames of the transfer still to come
        self._flags = 0
        self._ended_at = -NEVER  # the last transfer
        self._shifting = 0
        self.define(
            {
                0x00: Reg("cr1", 0, SPE | MASRX | CSTART | CSUSP | SSI),
                0x04: Reg("cr2", 0, 0xFFFF, rule="idle"),
                0x08: Reg("cfg1", 0x00070007, 0x701F01FF, rule="off"),
                0x0C: Reg("cfg2", 0, 0xE74600FF, rule="off"),
                0x10: Reg("ier", 0, 0),
                0x14: Reg("sr", 0x1002, 0),
                0x18: Reg("ifcr", 0, 0xFF8),
                0x20: Reg("txdr", 0, sizes=(1, 2, 4)),
                0x30: Reg("rxdr", 0, 0, sizes=(1, 2, 4)),
                0x50: Reg("i2scfgr", 0, 0),
            }
        )

    def reset(self) -> None:
        """Drop what is on its way."""
        super().reset()
        self._tx.clear()
        self._rx.clear()
        self._left, self._flags = 0, 0

    def bits(self) -> int:
        """Return the size of a frame."""
        return (self.v["cfg1"] & 31) + 1

    def bit_hz(self) -> int:
        """Return the rate of bits."""
        return self.rcc.spi3_hz() >> ((self.v["cfg1"] >> 28 & 7) + 1)

    def mode(self) -> int:
        """Return the number of the SPI mode: 2 CPOL + CPHA."""
        cfg2 = self.v["cfg2"]
        return (2 if cfg2 & CPOL else 0) + (1 if cfg2 & CPHA else 0)

    def pulses_select(self) -> bool:
        """Return whether the slave select rises between two frames."""
        return bool(self.v["cfg2"] & SSOE and self.v["cfg2"] & SSOM and self.select_high_s() > 0)

    def select_high_s(self) -> float:
        """Return how long it is high then: the time between frames but for one clock (MIDI > 1)."""
        midi = self.v["cfg2"] >> 4 & 15
        return max(0, midi - 1) / self.bit_hz()

    def _comm(self) -> int:
        return self.v["cfg2"] >> 17 & 3

    def _capacity(self) -> int:
        size = 1 if self.bits() <= 8 else 2 if self.bits() <= 16 else 4
        return FIFO_BYTES // size

    def _packet(self) -> int:
        return (self.v["cfg1"] >> 5 & 15) + 1

    def _write_cr1(self, name: str, old: int, new: int) -> None:
        self.v["cr1"] = new & ~CSTART
        if not new & SPE:
            since = self.clock.now - self._ended_at
            if old & SPE and since * self.bit_hz() < self.rcc.core_hz():
                raise UnmodelledError(f"{self.name}: switched off within a clock after EOT")
            self._tx.clear()
            self._rx.clear()
            self._left, self._flags, self.due = 0, 0, NEVER
            return
        cfg2 = self.v["cfg2"]
        if not cfg2 & MASTER or cfg2 & SSM or not cfg2 & SSOE:
            raise UnmodelledError(f"{self.name}: anything but a master with hardware slave select")
        if self._comm() not in (FULL_DUPLEX, TRANSMIT_ONLY):
            raise UnmodelledError(f"{self.name}: COMM {self._comm()}")
        if new & CSUSP:
            raise UnmodelledError(f"{self.name}: suspension")
        if new & CSTART and self._left == 0:
            self._left = self.v["cr2"] & 0xFFFF
            if self._left == 0:
                raise UnmodelledError(f"{self.name}: transfer without end (TSIZE 0)")
            self._begin_frame()

    def _write_off(self, name: str, old: int, new: int) -> None:
        if self.v["cr1"] & SPE:
            raise UnmodelledError(f"{self.name}.{name} written while the SPI is on")
        self.v[name] = new

    def _write_idle(self, name: str, old: int, new: int) -> None:
        if self.v["cr1"] & SPE and self._left:
            raise UnmodelledError(f"{self.name}.{name} written in a transfer")
        self.v[name] = new

    def _write_txdr(self, name: str, old: int, new: int) -> None:
        if not self.v["cr1"] & SPE:
            raise UnmodelledError(f"{self.name}.txdr written while the SPI is off")
        if len(self._tx) >= self._capacity():
            raise UnmodelledError(
                f"{self.name}.txdr written while the FIFO is full: a frame is lost"
            )
        self._tx.append(new & ((1 << self.bits()) - 1))
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
        sr = self._flags
        room = self._capacity() - len(self._tx)
        to_come = self._left > len(self._tx) or not self._left
        sr |= TXP if room >= self._packet() and to_come else 0
        sr |= RXP if len(self._rx) >= self._packet() else 0
        sr |= DXP if sr & TXP and sr & RXP else 0
        sr |= TXC if self._left == 0 else 0
        return sr | self._left << 16

    def _begin_frame(self) -> None:
        if self.due == NEVER and self._left and self._tx:
            self._shifting = self._tx.popleft()
            idle = (self.v["cfg2"] & 15) + (self.v["cfg2"] >> 4 & 15)
            cycles = (self.bits() + idle) * self.rcc.core_hz() // self.bit_hz()
            self.due = self.clock.now + cycles

    def advance(self) -> None:
        """End the frame on the line, begin the next one."""
        self.due = NEVER
        back = self.exchange(self._shifting, self.bits())
        if self._comm() == TRANSMIT_ONLY:
            pass
        elif len(self._rx) < self._capacity():
            self._rx.append(back)
        else:
            self._flags |= OVR
        self._left -= 1
        if self._left == 0:
            self._flags |= EOT | TXTF
            self._ended_at = self.clock.now
        self._begin_frame()


class Ad5754r:
    """Four DACs of 16 bits: input registers, DAC registers, ranges, power."""

    DAC, RANGE, POWER, CONTROL = 0, 1, 2, 3
    NOP, SETTINGS, CLEAR, LOAD = 0, 1, 4, 5
    ALL = 4

    def __init__(self) -> None:
        self.frames: list[int] = []  # every frame since power-on
        self.power_on()

    def power_on(self) -> None:
        """Take the values behind power-on: all outputs off."""
        # of A .. D: DAC registers, which the outputs show when powered, and input registers;
        # range codes: 0 .. 2 unipolar, 3 +-5 V, 4 +-10 V, 5 +-10.8 V
        self.words, self.inputs, self.ranges = [0] * 4, [0] * 4, [0] * 4
        self.power, self.settings = 0, 0
        self.is_ldac_low = self.is_clear_low = False
        self._answer = 0

    def is_on(self, channel: int) -> bool:
        """Return whether an output is powered; if not it is tied to ground."""
        return bool(self.power >> channel & 1)

    def ldac(self, level: int) -> None:
        """Move the pin /LDAC; a falling edge takes all input registers over."""
        self.is_ldac_low, was_low = not level, self.is_ldac_low
        if self.is_ldac_low and not was_low:
            self._load()

    def clear(self, level: int) -> None:
        """Move the pin /CLR; while it is low, the outputs stay at the clear code."""
        self.is_clear_low = not level
        if self.is_clear_low:
            self.inputs = [self._clear_code()] * 4
            self.words = list(self.inputs)

    def _load(self) -> None:
        """Take all input registers over, unless /CLR holds the outputs."""
        if not self.is_clear_low:
            self.words = list(self.inputs)

    def exchange(self, frame: int, bits: int) -> int:
        """Take a frame between two edges of /SYNC; return what SDO shifted out meanwhile."""
        if bits != 24 or frame >> 22 & 1:
            raise UnmodelledError(f"AD5754R: frame 0x{frame:x} of {bits} bits")
        self.frames.append(frame)
        answer, self._answer = self._answer, 0
        register, address, data = frame >> 19 & 7, frame >> 16 & 7, frame & 0xFFFF
        if frame >> 23:
            self._answer = (frame & 0xFF0000) | self._stored(register, address)
        else:
            self._write(register, address, data)
        return answer

    def _stored(self, register: int, address: int) -> int:
        if register == self.DAC:
            return self.words[address & 3]
        if register == self.RANGE:
            return self.ranges[address & 3]
        return self.power if register == self.POWER else self.settings

    def _write(self, register: int, address: int, data: int) -> None:
        channels = range(4) if address == self.ALL else (address,)
        if register == self.DAC and address <= self.ALL:
            for channel in channels:
                self.inputs[channel] = data
            if self.is_ldac_low:
                self._load()
        elif register == self.RANGE and address <= self.ALL and data <= 5:
            for channel in channels:
                self.ranges[channel] = data
        elif register == self.POWER and address == 0:
            self.power = data
        elif register == self.CONTROL:
            self._control(address, data)
        else:
            raise UnmodelledError(
                f"AD5754R: register {register}, address {address}, data 0x{data:x}"
            )

    def _control(self, address: int, data: int) -> None:
        if address == self.SETTINGS:
            self.settings = data & 15
        elif address == self.CLEAR:
            self.inputs = [self._clear_code()] * 4
            self.words = list(self.inputs)
        elif address == self.LOAD:
            self._load()
        elif address != self.NOP:
            raise UnmodelledError(f"AD5754R: control function {address}")

    def _clear_code(self) -> int:
        """Return 0 V, or with CLR select the middle (unipolar) or negative full scale."""
        return 0x8000 if self.settings >> 1 & 1 else 0


class Dac1(Device):
    """The chip's own DAC1 (RM0433, section 26): channel 1 by trigger or at once.

    Whether the output register follows a store while the channel is off, the manual leaves open:
    here it does not (embassy 1676).
    """

    TIM4_TRGO = 3
    EN, TEN, TSEL = 1 << 0, 1 << 1, 15 << 2

    def __init__(self, clock: InsnClock) -> None:
        super().__init__("dac1", 0x40007400, clock)
        # called with the code that the output shows when it changes, None when the channel is off
        self.on_output: Callable[[int | None], None] = lambda code: None
        self.define(
            {
                0x00: Reg("cr", 0, 0x3F),
                0x08: Reg("dhr12r1", 0, 0xFFF),
                0x2C: Reg("dor1", 0, 0),
                0x34: Reg("sr", 0, 0),
                0x3C: Reg("mcr", 0, 0x7),
            }
        )

    def reset(self) -> None:
        """Switch the output off."""
        was_on = self.v["cr"] & self.EN
        super().reset()
        if was_on:
            self.on_output(None)

    def _write_cr(self, name: str, old: int, new: int) -> None:
        if old & self.EN and (old ^ new) & self.TSEL:
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

    def trigger(self, source: int) -> None:
        """Let a trigger come."""
        both = self.EN | self.TEN
        if self.v["cr"] & both == both and self.v["cr"] >> 2 & 15 == source:
            self._take_over()
