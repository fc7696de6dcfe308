"""The machine around the chip, wired as hal/stm32h743/README.md says.

An ideal machine: the spindle follows the voltage of channel D on a ramp, U takes the position of
channel A at the start of every tick, or is a mass that its force moves, X and Z follow their steps;
everything stands still while the enable line is low. Signals reach the chip only through pins that
are switched to the right function.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

from tests.stm32.emulator import Chip
from tests.stm32.image import Image
from tests.stm32.models.bus import UnmodelledError
from tests.stm32.models.fdcan import Frame
from tests.stm32.models.spi_dac import Ad5754r
from tests.stm32.models.stepper import Stepper

HSE_HZ = 8_000_000
TABLE = 0x08100000
COUNTS_PER_TURN = 10_000
INDEX_AT = 1234  # [counts] the index pulse begins in the middle of this count ..
INDEX_WIDTH = 3  # .. and ends so many counts later
TICK_HZ = 20_000
TIMER_HZ = 240_000_000
TICK_CLOCKS = TIMER_HZ // TICK_HZ  # of TIM5
RAMP_COUNTS = 0.4  # change of the spindle's counts from tick to tick, within the guard's window
OUTPUTS = {"PE13": "enable", "PE14": "fault", "PE15": "in cut"}
STEPS = {  # timer, steps with their alternate function, direction
    "X": (16, "PB8", 1, "PB6"),
    "Z": (17, "PB9", 1, "PB7"),
    "U": (8, "PC8", 3, "PC9"),
}
CLEAR = "PE13"  # enable is also /CLR of the AD5754R
ESTOP, READY = "PE10", "PE12"
LIMITS = ("PD13", "PD15")  # 1: contact closed

# Values at +10 V of channels A .. D and counts of the scales: board_config.h.
FULL = (1_000_000, 200_000_000, 500_000_000, 5_000_000)
U_COUNT_NM, Z_COUNT_NM = 100, 1000
STEP_PM = {"X": 50_000, "Z": 500_000, "U": 100_000}  # U: if it is built with steps
FORCE_MN = 345_000  # at +10 V of channel A, if it is built with forces
MASS_KG = 1.5
SYNC_HIGH_S = 100e-9  # data sheet of the AD5754R, timing characteristics: /SYNC high in writes
ANALOGUE = 3  # mode of a pin


@dataclass(frozen=True)
class Outputs:
    """The outputs of the chip during one tick, after /LDAC."""

    words: tuple[int, ...]
    internal: int
    enable: int
    fault: int
    in_cut: int
    steps: tuple[int, int, int]  # positions of X, Z and U


@dataclass(frozen=True)
class Event:
    """A change that a meter on the board notices."""

    at: int
    what: str


class Board:
    """Chip, converters, machine, and what happened."""

    def __init__(self, image: Image, *, hse_hz: int = HSE_HZ, tick_hz: int = TICK_HZ) -> None:
        self.tick_hz = tick_hz  # rate at which the image was built to run
        self.dac = Ad5754r()
        self.ticks: list[Outputs] = []  # per tick of TIM4, taken at the start of the next
        self.tick_at: list[int] = []  # [cycles] when the tick of each of them started
        # levels of the outputs when they change, frames to the AD5754R, resets
        self.events: list[Event] = []
        self.steppers = {name: Stepper() for name in STEPS}  # step inputs of the drives X, Z and U
        self.rpm = 0.0  # of the spindle
        self.is_held = False  # the spindle keeps its speed whatever the command
        self.is_stamped = True  # A and B are wired to TIM5 as well
        self.has_u_steps = False  # the drive of U follows its steps, not its voltage
        # channel A is the force of U, a mass that its brake holds while it is not enabled
        self.has_u_force = False
        # instant [cycles] and code of each change of the internal DAC's output; None: it is off
        self.at_pa4: list[tuple[int, int | None]] = []
        self._turns = 0.1  # angle
        self._u_counts = self._z_counts = 0
        self._u_nm = self._u_nm_per_tick = 0.0
        self.chip = Chip(image, hse_hz=hse_hz)
        self._wire()

    def _wire(self) -> None:
        chip = self.chip
        chip.spi3.exchange = self._exchange
        chip.dac1.on_output = self._show_pa4
        chip.tim[4].on_output = self._drive_ldac
        chip.tim[4].on_update = self._tick
        chip.on_reset = lambda reason: self._note(f"reset {reason}")
        for name, (timer, *_) in STEPS.items():
            chip.pulses[timer].on_edge = self._step_of(name)
        for port in chip.gpio.ports.values():
            port.on_change = self._change_of(port.name[-1].upper())
        for name, resistor in (("PE13", 0), ("PE14", 0), ("PE15", 0), ("PD14", 1)):
            port, pin = chip.gpio.pin(name)
            port.board_pull[pin] = resistor
        chip.gpio.drive(ESTOP, 1)
        for name in (READY, *LIMITS):
            chip.gpio.drive(name, 1)

    def _note(self, what: str) -> None:
        self.events.append(Event(self.chip.clock.now, what))

    def power_on(self) -> None:
        """Switch on chip and converters."""
        self.dac.power_on()
        self.chip.power_on()
        self.dac.clear(self.chip.gpio.level(CLEAR))

    # Signals out of the chip

    def _change_of(self, letter: str) -> Callable[[int, int], None]:
        def change(pin: int, level: int) -> None:
            name = f"P{letter}{pin}"
            if name == CLEAR:
                self.dac.clear(level)
            if name in OUTPUTS:
                self._note(f"{OUTPUTS[name]} {level}")
            elif name == "PD14":
                self.dac.ldac(level)
                if level == 0:
                    self._note("step")
            else:
                self._turn_direction(name, level)

        return change

    def _step_of(self, axis: str) -> Callable[[int, int], None]:
        _, pin, function, _ = STEPS[axis]

        def step(at: int, level: int) -> None:
            if self.chip.gpio.has_function(pin, function):
                is_enabled = bool(self.chip.gpio.level("PE13"))
                self.steppers[axis].step(at, level, is_enabled=is_enabled)

        return step

    def _turn_direction(self, pin: str, level: int) -> None:
        """Let the drive see the steps that came before the direction turned, then the turn."""
        for axis, (timer, _, _, direction) in STEPS.items():
            if pin == direction:
                self.chip.pulses[timer].catch_up()
                self.steppers[axis].turn(self.chip.clock.now, level)

    def _drive_ldac(self, level: int) -> None:
        if self.chip.gpio.has_function("PD14", 2):
            port, pin = self.chip.gpio.pin("PD14")
            port.drive_alternate(pin, level)

    def _show_pa4(self, code: int | None) -> None:
        port, pin = self.chip.gpio.pin("PA4")
        is_seen = port.mode(pin) == ANALOGUE
        self.at_pa4.append((self.chip.clock.now, code if is_seen else None))

    def _exchange(self, frame: int) -> int:
        spi, gpio = self.chip.spi3, self.chip.gpio
        for name in ("PC10", "PC12", "PA15"):
            gpio.require(name, 6)
        if spi.bit_hz() > 30e6 or spi.select_high_s() < SYNC_HIGH_S:
            raise UnmodelledError("the AD5754R does not understand this SPI")
        self._note(f"frame {frame:06x}")
        return self.dac.exchange(frame)

    def wanted(self, channel: int) -> float:
        """Return the command of a drive by its voltage: [nm] or [r/min / 1000]."""
        return self.dac.volts(channel) / 10 * FULL[channel]

    # The machine

    def _tick(self) -> None:
        gpio = self.chip.gpio
        self.tick_at.append(self.chip.clock.now)
        pins = gpio.ports["E"].pins
        enable, fault, in_cut = pins >> 13 & 1, pins >> 14 & 1, pins >> 15
        for timer in self.chip.pulses.values():
            timer.catch_up()
        x, z, u = (self.steppers[name].position for name in STEPS)
        words, dor1 = tuple(self.dac.words), self.chip.dac1.v["dor1"]
        self.ticks.append(Outputs(words, dor1, enable, fault, in_cut, (x, z, u)))
        self._turn_spindle(enable)
        if enable:
            self._move_axes()
        else:
            self._u_nm_per_tick = 0.0

    def _turn_spindle(self, enable: int) -> None:
        if not self.is_held:
            left = (self.wanted(3) / 1000 if enable else 0.0) - self.rpm
            ramp_rpm = RAMP_COUNTS / COUNTS_PER_TURN * 60 * self.tick_hz
            self.rpm += max(-ramp_rpm, min(ramp_rpm, left))
        self._turn(self.rpm / 60 / self.tick_hz)

    def _turn(self, turns: float) -> None:
        """Pass counts and index edges in the order of their angles."""
        begin, self._turns = self._turns, self._turns + turns
        low, high = sorted((begin, self._turns))
        edges = []
        for turn in range(math.floor(low) - 1, math.floor(high) + 2):
            for offset, level in ((0, 1), (INDEX_WIDTH, 0)):
                at = turn + (INDEX_AT + offset + 0.5) / COUNTS_PER_TURN
                if low < at <= high:
                    edges.append((at, level if turns > 0 else 1 - level))
        counted = begin
        for at, level in sorted(edges, reverse=turns < 0):
            self._count(counted, at)
            counted = at
            if self.chip.gpio.has_function("PB10", 1):
                self.chip.tim[2].input_edge(3, level)
        self._count(counted, self._turns)
        self._stamp(begin, self._turns)

    def _stamp(self, begin: float, end: float) -> None:
        """Let TIM5 see the last edges of A, at even counts, and of B, at odd ones, in time."""
        low, high = sorted((begin * COUNTS_PER_TURN, end * COUNTS_PER_TURN))
        passed = range(math.floor(low) + 1, math.floor(high) + 1)
        late = passed[-4:] if end > begin else passed[:4][::-1]
        for at in late:
            pin, channel = ("PA0", 1) if at % 2 == 0 else ("PA3", 4)
            share = (end * COUNTS_PER_TURN - at) / ((end - begin) * COUNTS_PER_TURN)
            level = at // 2 % 2 ^ int(end < begin)
            if self.is_stamped and self.chip.gpio.has_function(pin, 2):
                self.chip.tim[5].input_edge(channel, level, round(share * TIMER_HZ / self.tick_hz))

    def _count(self, begin: float, end: float) -> None:
        gpio = self.chip.gpio
        if gpio.has_function("PA5", 1) and gpio.has_function("PB3", 1):
            counts = math.floor(end * COUNTS_PER_TURN) - math.floor(begin * COUNTS_PER_TURN)
            self.chip.tim[2].move_encoder(counts)

    def _push(self) -> float:
        """Let the force act for a tick; return where U stands then."""
        newton = self.dac.volts(0) / 10 * FORCE_MN / 1000
        self._u_nm_per_tick += newton / MASS_KG * 1e9 / self.tick_hz**2
        self._u_nm += self._u_nm_per_tick
        return self._u_nm

    def _move_axes(self) -> None:
        gpio, tim = self.chip.gpio, self.chip.tim
        u_nm = self._push() if self.has_u_force else self.wanted(0)
        if self.has_u_steps:
            u_nm = self.steppers["U"].position * STEP_PM["U"] / 1000
        u_counts = round(u_nm / U_COUNT_NM)
        z_counts = round(self.steppers["Z"].position * STEP_PM["Z"] / 1000 / Z_COUNT_NM)
        if gpio.has_function("PE9", 1) and gpio.has_function("PE11", 1):
            tim[1].move_encoder(u_counts - self._u_counts)
        if gpio.has_function("PC6", 2) and gpio.has_function("PC7", 2):
            tim[3].move_encoder(z_counts - self._z_counts)
        self._u_counts, self._z_counts = u_counts, z_counts

    @property
    def scale_counts(self) -> tuple[int, int, int]:
        """Where spindle, U and Z stand, in counts since the board exists."""
        return math.floor(self._turns * COUNTS_PER_TURN), self._u_counts, self._z_counts

    # The bus and the table

    def send(self, frame: Frame) -> bool:
        """Send a frame to the chip; return whether it took it."""
        self.chip.gpio.require("PD0", 9)
        self.chip.gpio.require("PD1", 9)
        if round(self.chip.fdcan1.bit_hz()) != 500_000:
            raise UnmodelledError(f"CAN at {self.chip.fdcan1.bit_hz()} bit/s")
        return self.chip.fdcan1.deliver(frame)

    def write_table(self, content: bytes) -> None:
        """Write the table's place, as tools/flash would."""
        self.chip.write_flash(TABLE, content)
