"""A whole cut by the image, tick by tick compared with the host."""

from itertools import pairwise

import pytest

from tests.stm32.board import COUNTS_PER_TURN, INDEX_AT, Outputs
from tests.stm32.host import MOST_UM_PER_S, internal_word, positions, replay, words
from tests.stm32.session import Session
from tests.stm32.tick_trace import Record

TICK_CYCLES = 24_000
STEP_CYCLES = 14_400  # 30 us
IN_CUT, FAULT, ENABLE_BIT = 4, 2, 1
CLEARED = (0, 0, 0, 0)  # /CLR of the AD5754R is low while enable is


def ticks_of(cut: Session) -> list[tuple[Record, Outputs]]:
    """Return each tick's record and what came of it; the first period has no tick before it."""
    return list(zip(cut.records, cut.board.ticks[1 : len(cut.records) + 1], strict=True))


def test_cut_is_whole(cut: Session) -> None:
    """The part is cut from first to last height at full speed, without fault or lost record."""
    states = [line[6:] for line in cut.remote.lines() if line.startswith("state ")]
    assert states == ["homing", "ready", "engaging", "cutting", "disengaging", "ready", "off"]
    assert cut.remote.newest().faults == ()
    assert sum(seen.in_cut for _, seen in ticks_of(cut)) > 2000
    assert [record["tick"] for record in cut.records] == list(range(len(cut.records)))
    in_cut = [record for record, seen in ticks_of(cut) if seen.in_cut]
    assert {seen.words[3] for _, seen in ticks_of(cut) if seen.in_cut} == {0x4000}  # 2500 of 5000
    assert min(record["out_z_nm"] for record in in_cut) < 2000
    # Set-points are rounded down to whole nanometres; the last increment of Z may end beyond 1 mm.
    assert 999_999 <= max(record["out_z_nm"] for record in in_cut) <= 1_000_010


def test_senses_are_those_of_the_machine(cut: Session) -> None:
    """Clock, encoder, index and scales come through the timers without loss."""
    for before, after in pairwise(cut.records):
        assert (after["clock"] - before["clock"]) % 2**32 == pytest.approx(12_000, abs=100)
    last = cut.records[-1]
    counts, u_counts, z_counts = cut.board.scale_counts
    start = int(0.1 * COUNTS_PER_TURN)
    turn_counts = COUNTS_PER_TURN / 24 / 20  # of one tick, at the highest speed
    assert abs(last["counts"] - (counts - start)) <= turn_counts
    assert last["index_counts"] == (last["n_index"] - 1) * COUNTS_PER_TURN + INDEX_AT - start
    assert last["n_index"] > 8
    assert last["u_nm"] == 100 * u_counts
    assert last["z_nm"] == 1000 * z_counts


def test_every_dac_word_is_the_hosts(cut: Session) -> None:
    """Same senses on the host: same set-points and words; 0 V while enable is low."""
    host = replay(cut.records, cut.changes, n_before=1)
    assert len(host) == len(cut.records)
    for (record, seen), done in zip(ticks_of(cut), host, strict=True):
        axes = tuple(record[name] for name in ("out_u_nm", "out_x_nm", "out_z_nm"))
        assert axes == done.setpoints[:3]
        assert seen.words == (words(done) if seen.enable else CLEARED), f"tick {record['tick']}"
        assert seen.internal == internal_word(done.setpoints[0])
        lines = ENABLE_BIT * seen.enable + FAULT * seen.fault + IN_CUT * seen.in_cut
        assert lines == done.outputs


def test_every_step_is_the_hosts(cut: Session) -> None:
    """X and Z follow the host's set-points in every tick, to the step."""
    host = replay(cut.records, cut.changes, n_before=1)
    enabled = [done.outputs & ENABLE_BIT for done in host]
    for i, axis in enumerate(("X", "Z")):
        wanted = positions(axis, (done.setpoints[1 + i] for done in host), enabled)
        assert [seen.steps[i] for _, seen in ticks_of(cut)] == wanted
        stepper = cut.board.steppers[axis]
        assert stepper.n_ignored == 0
        assert len(set(wanted)) > 1000


def test_start_reports_the_resolution_of_the_scales(cut: Session) -> None:
    """The lines have the numbers of board_config.h; half a step of U and of X is 0.040 um."""
    lines = cut.remote.lines()
    x = f"X 50.0 nm up to {MOST_UM_PER_S['X']} um/s"
    z = f"Z 500.0 nm up to {MOST_UM_PER_S['Z']} um/s, read to 1000.0 nm"
    assert f"scales: U 30.5 nm, read to 100.0 nm; {x}; {z}" in lines
    form = next(line for line in lines if line.startswith("form error by the steps"))
    assert 0.040 <= float(form.split()[8]) < 0.1


def test_steps_keep_the_times_of_a_drive(cut: Session) -> None:
    """High and low for 500 ns; the direction turns a tick before a step, and not close to one."""
    for axis in ("X", "Z"):
        stepper = cut.board.steppers[axis]
        assert stepper.shortest.high == 240
        assert stepper.shortest.low >= 240
        assert stepper.shortest.setup >= TICK_CYCLES
        assert stepper.shortest.hold > 240


def test_all_outputs_step_30_us_after_the_tick(cut: Session) -> None:
    """Four frames per tick, all in before /LDAC falls, always at the same time."""
    events, starts = cut.board.events, cut.board.tick_at
    steps = [event.at for event in events if event.what == "step" and event.at > starts[0]]
    delays = {step - start for start, step in zip(starts, steps, strict=False)}
    assert delays <= {STEP_CYCLES, STEP_CYCLES + 1}  # 30 us, and the edge of a counter's clock
    assert {b - a for a, b in pairwise(starts)} == {TICK_CYCLES}
    frames = [event.at for event in events if event.what.startswith("frame")]
    frames = [at for at in frames if starts[0] < at < starts[-1]]
    assert len(frames) == 4 * (len(starts) - 1)
    assert max((at - starts[0]) % TICK_CYCLES for at in frames) < STEP_CYCLES


def test_analogue_outputs_begin_at_zero(cut: Session) -> None:
    """Range and power are set before any channel shows anything, and what it shows first is 0 V."""
    frames = [event.what for event in cut.board.events if event.what.startswith("frame")]
    assert frames[:2] == ["frame 0c0004", "frame 10001f"]  # +-10 V on all, all and reference on
    assert cut.board.ticks[0].words == (0, 0, 0, 0)
    assert cut.board.ticks[0].internal == 2048
