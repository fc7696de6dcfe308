# SPDX-License-Identifier: Apache-2.0
"""A board that runs the real image, with everything recorded: what the tests start from."""

from pathlib import Path

from tests.stm32.board import TICK_HZ, Board
from tests.stm32.host import IMAGE, short_table
from tests.stm32.image import Image
from tests.stm32.remote import ENABLE, PARAMS, START, Remote
from tests.stm32.tick_trace import Record, Trace

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
    "switch_1_per_turn": 2,
    "switch_1_on_udeg": 30_000_000,
    "switch_1_off_udeg": 60_000_000,
    "switch_8_per_turn": 1,
    "switch_8_off_udeg": 180_000_000,
    "switch_8_z_low_nm": 400_000,
    "switch_8_z_high_nm": 600_000,
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
        self.records: list[Record] = []  # what the image says of its ticks
        # new configurations in their order, as replay.c wants them
        self.changes = [f"table {short_table()}"]
        self._trace = Trace(self.chip)
        self._tick_of_board = self.chip.tim[4].on_update
        self.chip.tim[4].on_update = self._tick

    def _tick(self) -> None:
        self._tick_of_board()
        self.records += self._trace.take()

    def n_dropped(self) -> int:
        """Return ticks that left no record."""
        return self._trace.dropped()

    def set_up(self) -> None:
        """Set the parameters of the ideal machine."""
        dead_time_ns = 10**9 // self.board.tick_hz
        for name, value in {**SETTINGS, "lead_ns": dead_time_ns}.items():
            self.remote.set(name, value)
            self.changes.append(f"set {PARAMS.index(name)} {value}")

    def start(self) -> None:
        """Power on, and wait until the image says something."""
        self.board.power_on()
        self.remote.started()

    def cut(self) -> None:
        """Cut a whole part with a machine that is ready."""
        self.remote.do(START)
        self.remote.wait_for("cutting", 2.0)
        self.remote.wait_for("ready", 2.0)

    def make_ready(self) -> None:
        """Set up and home."""
        self.set_up()
        self.remote.do(ENABLE)
        self.remote.wait_for("ready", 1.0)

    def turn_spindle(self) -> None:
        """Bring the spindle of a machine that is ready to its speed."""
        self.chip.run(self.chip.seconds(0.02))
