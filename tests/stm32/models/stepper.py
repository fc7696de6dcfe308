"""A drive's input for step and direction: it counts edges and measures times between them."""

from dataclasses import dataclass, field

FAR = 10**12  # [cycles] longer than any test


@dataclass
class Times:
    """The shortest times that were seen, in cycles of the core."""

    high: int = FAR
    low: int = FAR
    setup: int = FAR  # from a change of direction to the next rising edge
    hold: int = FAR  # from a falling edge to a change of direction


@dataclass
class Stepper:
    """One axis."""

    position: int = 0  # [steps] sum of all pulses that came while the drive was enabled
    n_ignored: int = 0  # pulses that came while it was not
    direction: int = 0
    shortest: Times = field(default_factory=Times)  # of all signals since power-on
    _level: int = 0
    _rose_at: int = -FAR
    _fell_at: int = -FAR
    _turned_at: int = -FAR

    def step(self, at: int, level: int, *, is_enabled: bool) -> None:
        """Take an edge of the step line."""
        if level == self._level:
            return
        self._level = level
        if not level:
            self.shortest.high = min(self.shortest.high, at - self._rose_at)
            self._fell_at = at
            return
        self.shortest.low = min(self.shortest.low, at - self._fell_at)
        self.shortest.setup = min(self.shortest.setup, at - self._turned_at)
        self._rose_at = at
        if is_enabled:
            self.position += 1 if self.direction else -1
        else:
            self.n_ignored += 1

    def turn(self, at: int, level: int) -> None:
        """Take an edge of the direction line."""
        assert not self._level, f"the direction turns at {at} while the step is high"
        self.direction, self._turned_at = level, at
        self.shortest.hold = min(self.shortest.hold, at - self._fell_at)
