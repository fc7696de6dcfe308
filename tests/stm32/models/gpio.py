"""GPIO ports (RM0433, section 11): modes, alternate functions, levels at the pins.

A pin that nobody drives follows its pull resistor, the board's before the chip's; `pins`
are the readings of meters at them. Pins are named like "PE13".
"""

from collections.abc import Callable

from tests.stm32.models.bus import WORD, Device, InsnClock, Reg, UnmodelledError

INPUT, OUTPUT, ALTERNATE, ANALOGUE = 0, 1, 2, 3
RESET = {
    "A": {"moder": 0xABFFFFFF, "ospeedr": 0x0C000000, "pupdr": 0x64000000},
    "B": {"moder": 0xFFFFFEBF, "ospeedr": 0x000000C0, "pupdr": 0x00000100},
}


class GpioPort(Device):
    """One port of 16 pins."""

    def __init__(self, clock: InsnClock, letter: str) -> None:
        i = ord(letter) - ord("A")
        super().__init__(f"gpio{letter.lower()}", 0x58020000 + 0x400 * i, clock)
        reset = RESET.get(letter, {"moder": WORD})
        self.outside: dict[int, int] = {}  # pin number -> level that the board drives, for inputs
        self.board_pull: dict[int, int] = {}  # pin number -> level of a resistor on the board
        # pin number -> level that the peripheral of its alternate function drives
        self.alternate: dict[int, int] = {}
        # called with pin number and level when the level of a pin changes
        self.on_change: Callable[[int, int], None] = lambda pin, level: None
        self.define(
            {
                0x00: Reg("moder", reset["moder"], rule="level"),
                0x08: Reg("ospeedr", reset.get("ospeedr", 0)),
                0x0C: Reg("pupdr", reset.get("pupdr", 0), rule="level"),
                0x10: Reg("idr", 0, 0),
                0x14: Reg("odr", 0, 0),
                0x18: Reg("bsrr"),
                0x20: Reg("afrl", 0, rule="level"),
                0x24: Reg("afrh", 0, rule="level"),
            }
        )
        self.pins = 0  # levels, a bit each
        self._readable = 0  # pins that IDR shows
        self._notice()

    def reset(self) -> None:
        """Let go of all pins."""
        super().reset()
        self.alternate.clear()
        self._write_level("moder", 0, self.v["moder"])

    def mode(self, pin: int) -> int:
        """Return the two bits of MODER."""
        return self.v["moder"] >> 2 * pin & 3

    def function(self, pin: int) -> int | None:
        """Return the number of the alternate function, None when the pin has another mode."""
        word = self.v["afrl"] if pin < 8 else self.v["afrh"]
        return word >> 4 * (pin % 8) & 15 if self.mode(pin) == ALTERNATE else None

    def _driven(self, pin: int) -> int:
        """Return the level that a pin takes; an undriven one without any resistor reads 0."""
        if self.mode(pin) == OUTPUT:
            return self.v["odr"] >> pin & 1
        if self.mode(pin) == ALTERNATE and pin in self.alternate:
            return self.alternate[pin]
        pull = int(self.v["pupdr"] >> 2 * pin & 3 == 1)
        return self.outside.get(pin, self.board_pull.get(pin, pull))

    def drive(self, pin: int, level: int | None) -> None:
        """Let the board drive a pin, or cut its wire."""
        self.outside.pop(pin, None)
        self.outside |= {} if level is None else {pin: level}
        self._notice(1 << pin)

    def drive_alternate(self, pin: int, level: int) -> None:
        """Let the peripheral of a pin drive it."""
        self.alternate[pin] = level
        self._notice(1 << pin)

    def _notice(self, changed: int = 0xFFFF) -> None:
        for pin in range(changed.bit_length()):
            if changed >> pin & 1 and self._driven(pin) != self.pins >> pin & 1:
                self.pins ^= 1 << pin
                self.on_change(pin, self.pins >> pin & 1)

    def _write_level(self, name: str, old: int, new: int) -> None:
        self.v[name] = new
        self._readable = sum(1 << pin for pin in range(16) if self.mode(pin) != ANALOGUE)
        self._notice()

    def _write_bsrr(self, name: str, old: int, new: int) -> None:
        odr = (self.v["odr"] & ~(new >> 16)) | (new & 0xFFFF)
        changed, self.v["odr"] = odr ^ self.v["odr"], odr
        self._notice(changed)

    def _read_idr(self, name: str) -> int:
        return self.pins & self._readable


class Gpio:
    """All ports, and pins by name."""

    def __init__(self, clock: InsnClock) -> None:
        self.ports = {letter: GpioPort(clock, letter) for letter in "ABCDE"}

    def pin(self, name: str) -> tuple[GpioPort, int]:
        """Return port and number of a pin like "PE13"."""
        return self.ports[name[1]], int(name[2:])

    def level(self, name: str) -> int:
        """Return the level at a pin."""
        port, pin = self.pin(name)
        return port.pins >> pin & 1

    def drive(self, name: str, level: int | None) -> None:
        """Let the board drive a pin, or cut its wire."""
        port, pin = self.pin(name)
        port.drive(pin, level)

    def has_function(self, name: str, function: int) -> bool:
        """Return whether a pin is switched to an alternate function."""
        port, pin = self.pin(name)
        return port.function(pin) == function

    def require(self, name: str, function: int) -> None:
        """Raise unless a pin is switched to an alternate function."""
        if not self.has_function(name, function):
            raise UnmodelledError(f"{name} is not switched to its alternate function {function}")
