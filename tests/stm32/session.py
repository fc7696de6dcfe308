"""A board that runs the real image, with everything recorded: what the tests start from."""

from collections.abc import Callable
from pathlib import Path

from tests.stm32.board import TICK_HZ, Board
from tests.stm32.host import IMAGE, short_table
from tests.stm32.image import Image
from tests.stm32.models.devices import IRQ_TIM4
from tests.stm32.remote import ENABLE, PARAMS, START, Remote
from tests.stm32.tick_trace import Record, Trace

HANG = b"\x30\xbf\xfd\xe7"  # sleeps for ever: wfi, and back to it
# An ideal machine: one tick of dead time, quick axes, a way into the work that X can take. It has
# nothing to be learned; what the slow side learns is no input of the replay.
SETTINGS = {
    "rehearse_turns": 0,
    "learn_harmonics": 0,
    "ripple_turns": 0,
    "engage_turns": 1,
    "x_clearance_nm": 100_000,
    "disengage_turns": 1,
    "feed_ramp_turns": 1,
    "x_acceleration_mm_per_s2": 20_000,
}


class Session:
    """One life of a board, with the short part's table or another one."""

    def __init__(
        self,
        table: bytes | None = None,
        *,
        hse_hz: int = 8_000_000,
        image: Path = IMAGE,
        tick_hz: int = TICK_HZ,
    ) -> None:
        self.board = Board(Image(image), hse_hz=hse_hz, tick_hz=tick_hz)
        self.chip = self.board.chip
        self.board.write_table(short_table().read_bytes() if table is None else table)
        self.remote = Remote(self.board)
        self.records: list[Record] = []  # the image's own of its ticks
        # new configurations in their order, as replay.c wants them
        self.changes = [f"table {short_table()}"]
        self.trace = Trace(self.chip)
        self._tick_of_board = self.chip.tim[4].on_update
        self.chip.tim[4].on_update = self._tick

    def _tick(self) -> None:
        self._tick_of_board()
        self.records += self.trace.take()

    def start(self) -> None:
        """Power on, and wait until the image says something."""
        self.board.power_on()
        self.remote.started()

    def make_ready(self, **more: int) -> None:
        """Set the parameters of the ideal machine and others, home, bring the spindle to speed."""
        values = SETTINGS | {"lead_ns": 10**9 // self.board.tick_hz} | more
        for name, value in values.items():
            self.remote.set(name, value)
            self.changes.append(f"set {PARAMS.index(name)} {value}")
        self.remote.do(ENABLE)
        self.remote.wait_for("ready", 1.0)
        self.chip.run(self.chip.seconds(0.02))

    def hang(self, *, in_tick: bool) -> Callable[[], None]:
        """Have the core sleep for ever in the interrupt or the main loop; return the way back."""
        chip = self.chip
        vectors = chip.nvic.v["vtor"]
        handler = int.from_bytes(chip.read_memory(vectors + 4 * (16 + IRQ_TIM4), 4), "little") & ~1
        assert chip.run_until(lambda: not chip.nvic.active, chip.seconds(1e-3))
        place = handler if in_tick else chip.pc
        instructions = chip.read_memory(place, len(HANG))
        chip.put_instructions(place, HANG)
        return lambda: chip.put_instructions(place, instructions)

    def cut(self) -> None:
        """Cut a whole part with a machine that is ready."""
        self.remote.do(START)
        self.remote.wait_for("cutting", 2.0)
        self.remote.wait_for("ready", 2.0)
