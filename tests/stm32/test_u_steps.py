# SPDX-License-Identifier: Apache-2.0
"""U by step and direction: an image built with BOARD_U_STEP_PM, in a whole cut."""

from itertools import pairwise

import pytest

from tests.stm32.host import build_with, positions, replay, steps
from tests.stm32.session import Session

pytestmark = pytest.mark.long  # it builds an image
ENABLE_BIT = 1
HIGH_CYCLES = 240  # 500 ns
TICK_CYCLES = 24_000


@pytest.fixture(scope="module")
def cut() -> Session:
    """Return a session from power-on through a cut, its U driven by steps of 100 nm."""
    session = Session(image=build_with("BOARD_U_STEP_PM", "100000"))
    session.board.has_u_steps = True
    session.start()
    session.make_ready()
    session.turn_spindle()
    session.cut()
    return session


def test_u_stands_where_the_hosts_set_points_lead(cut: Session) -> None:
    """Every tick, to the step; the cut ends without a fault, the drive missed no step."""
    host = replay(cut.records, cut.changes, n_before=1)
    enabled = [done.outputs & ENABLE_BIT for done in host]
    wanted = positions("U", (done.setpoints[0] for done in host), enabled)
    seen = [outputs.steps[2] for outputs in cut.board.ticks[1 : len(host) + 1]]
    assert seen == wanted
    assert len(set(wanted)) > 1000
    assert cut.remote.newest().faults == ()
    stepper = cut.board.steppers["U"]
    assert stepper.n_ignored == 0
    assert stepper.shortest.high == HIGH_CYCLES
    assert stepper.shortest.low >= HIGH_CYCLES
    assert stepper.shortest.setup >= TICK_CYCLES


def test_u_is_late_only_where_it_turns(cut: Session) -> None:
    """A tick that turns the direction sends no steps; the next one has caught up."""
    in_cut = [
        (record, outputs)
        for record, outputs in zip(cut.records, cut.board.ticks[1:], strict=False)
        if outputs.in_cut
    ]
    off = [outputs.steps[2] - steps("U", record["out_u_nm"]) for record, outputs in in_cut]
    rest = off[0] if off[0] == off[1] else off[2]
    late = [one != rest for one in off]
    assert sum(late) < len(off) / 50
    assert not any(a and b for a, b in pairwise(late))


def test_start_names_step_and_speed(cut: Session) -> None:
    """The line of the scales has U's step and the speed of 36 steps in a tick: over 39 mm/s."""
    line = next(line for line in cut.remote.lines() if line.startswith("scales: "))
    assert line.startswith("scales: U 100.0 nm up to 72000 um/s, read to 100.0 nm; ")
