"""Images built with other settings: the highest tick rate, U by steps or force."""

import subprocess
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise

import pytest

from tests.stm32.board import FORCE_MN, LIMITS
from tests.stm32.host import ROOT, build_with, positions, replay
from tests.stm32.models.spi_dac import signed16
from tests.stm32.remote import ENABLE
from tests.stm32.session import Session

pytestmark = pytest.mark.long  # each builds an image
CORE_HZ = 480_000_000
TIM1_CNT, TIM5_CNT = 0x24, 0x40000C24
TICK_HZ = 50_000
UPDATE_S = 18e-6
STOP_S = 80e-6, 138e-6
HIGH_CYCLES = 240  # 500 ns
TICK_CYCLES = 24_000
LATENCY_US = 2.5  # BOARD_FORCE_NS
FORCE_DELAY_NS = 27_500  # and half a tick of hold
LIMIT_LOW, LIMIT_HIGH = 0x800, 0x1000  # hal.h
OF_FORCE = {
    "u_acceleration_mm_per_s2": 200_000,
    "servo_force_limit_mn": 340_000,
    "servo_force_delay_ns": FORCE_DELAY_NS,
    "servo_crossover_hz": 400,
    "lead_ns": 50_000 + FORCE_DELAY_NS,
}


@pytest.fixture(scope="module")
def session() -> Session:
    """Return a session that is ready, at 50 kHz."""
    image = build_with("BOARD_TICK_HZ", f"{TICK_HZ}u")
    session = Session(image=image, tick_hz=TICK_HZ)
    session.start()
    session.make_ready()
    return session


@pytest.fixture
def fresh(session: Session) -> Iterator[Session]:
    """Return the session, started anew by the test and after it."""
    session.chip.reset("pin")
    session.remote.started()
    yield session


def test_ticks_come_at_the_rate_and_outputs_step_in_them(session: Session) -> None:
    """Periods are exact; all frames arrive before the outputs step, always at the same time."""
    board = session.board
    assert {b - a for a, b in pairwise(board.tick_at)} == {CORE_HZ // TICK_HZ}
    begin, end = board.tick_at[0], board.tick_at[-1]
    since = {"step": set[int](), "frame": set[int]()}
    for event in board.events:
        kind = event.what.split()[0]
        if begin < event.at < end and kind in since:
            since[kind].add((event.at - begin) % (CORE_HZ // TICK_HZ))
    due = round(UPDATE_S * CORE_HZ)
    assert since["step"] <= {due, due + 1}
    assert max(since["frame"]) < due
    for stepper in board.steppers.values():
        assert min(stepper.shortest.high, stepper.shortest.low) >= HIGH_CYCLES
        assert stepper.shortest.setup >= CORE_HZ // TICK_HZ
    assert session.chip.resets == ["power_on"]
    assert not [line for line in session.remote.lines() if "not ready" in line]


def test_a_late_tick_locks_without_a_reset(fresh: Session) -> None:
    """An overrun is a fault; the watchdog waits for the next tick on time."""
    chip = fresh.chip
    chip.stall(TIM5_CNT, chip.seconds(1.2 / TICK_HZ))
    chip.run(chip.seconds(0.02))
    assert chip.resets[-1] == "pin"
    assert any("a tick overran" in line for line in fresh.remote.lines())


def test_window_watchdog_ends_ticks_that_stop(fresh: Session) -> None:
    """The interrupt hangs: a reset within the time that the README states."""
    chip = fresh.chip
    fresh.remote.do(ENABLE)
    revive = fresh.hang(in_tick=True)
    at = chip.clock.now
    least_s, most_s = STOP_S
    assert chip.run_until(lambda: chip.resets[-1] == "window", chip.seconds(most_s))
    revive()
    assert (chip.clock.now - at) / CORE_HZ > least_s - 2 / TICK_HZ
    assert chip.gpio.level("PE13") == 0


def test_window_watchdog_ends_ticks_at_twice_the_rate(fresh: Session) -> None:
    """The period of the tick timer is halved."""
    tim4 = fresh.chip.tim[4]
    tim4.write(0x2C, 4, tim4.read(0x2C, 4) // 2)
    assert fresh.chip.run_until(lambda: fresh.chip.resets[-1] == "window", fresh.chip.seconds(2e-3))


def test_self_test_passes(fresh: Session) -> None:
    """Ticks, window and the cycles of a tick are judged by the rate."""
    chip = fresh.chip
    chip.naps = 0  # it counts ticks by the main loop
    chip.usart3.sent.clear()
    chip.usart3.receive(b"t")
    assert chip.run_until(lambda: b"self-test: passed;" in chip.usart3.sent, chip.seconds(0.3))
    assert f" of {CORE_HZ // TICK_HZ}, faults of the port 0x0" in chip.usart3.sent.decode()


@pytest.mark.parametrize("hz", [4_000, 60_000])
def test_rate_beyond_the_range_does_not_build(hz: int) -> None:
    """The compiler names the setting and its range."""
    source = ROOT / "hal" / "stm32h743" / "stm_watch.c"
    command = ["arm-none-eabi-gcc", "-fsyntax-only", f"-DBOARD_TICK_HZ={hz}u", str(source)]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    assert "BOARD_TICK_HZ: give 5000 to 50000" in done.stderr


def test_u_by_steps_follows_the_hosts_set_points() -> None:
    """Every tick of a whole cut, to the step, with no step missed."""
    cut = Session(image=build_with("BOARD_U_STEP_PM", "100000"))
    cut.board.has_u_steps = True
    cut.start()
    cut.make_ready()
    cut.cut()
    host = replay(cut.records, cut.changes, n_before=1)
    wanted = positions("U", (done.setpoints[0] for done in host), (d.outputs & 1 for d in host))
    assert [outputs.steps[2] for outputs in cut.board.ticks[1 : len(host) + 1]] == wanted
    assert len(set(wanted)) > 1000
    assert cut.remote.newest().faults == ()
    stepper = cut.board.steppers["U"]
    assert stepper.n_ignored == 0
    assert stepper.shortest.high == HIGH_CYCLES
    assert stepper.shortest.low >= HIGH_CYCLES
    assert stepper.shortest.setup >= TICK_CYCLES
    # 36 steps in a tick are over 39 mm/s.
    line = next(line for line in cut.remote.lines() if line.startswith("scales: "))
    assert line.startswith("scales: U 100.0 nm up to 72000 um/s, read to 100.0 nm; ")


@dataclass
class Meter:
    """Instants [cycles] of each tick's latch of U's scale and of the converter's frames."""

    latched: int = 0
    delays: list[int] = field(default_factory=list)
    order: list[list[int]] = field(default_factory=list)

    def connect(self, session: Session) -> None:
        """Watch the counter of U's scale and the AD5754R."""
        chip, dac, timer = session.chip, session.board.dac, session.chip.tim[1]
        read, exchange = timer.read, dac.exchange

        def latch(offset: int, size: int) -> int:
            if offset == TIM1_CNT:
                self.latched = chip.clock.now
                self.order.append([])
            return read(offset, size)

        def take(frame: int) -> int:
            back = exchange(frame)
            channel = frame >> 16
            if self.order:
                self.order[-1].append(channel)
            if channel == 0:
                self.delays.append(chip.clock.now - self.latched)
                assert not session.chip.gpio.level("PE13") or dac.words[0] == frame & 0xFFFF
            return back

        timer.read = latch  # type: ignore[method-assign]
        dac.exchange = take  # type: ignore[method-assign]


def test_u_by_force_closes_its_loop_through_the_port() -> None:
    """A mass that the image's forces move follows the table; the force leaves first and soon.

    Its frame acts alone, within the stated time of the scale's latch; the voltage is the nearest
    code of 345 N at +10 V, and 0 V while enable is low. A limit switch ends it at once.
    """
    session = Session(image=build_with("BOARD_U_FORCE_MN", str(FORCE_MN)))
    board, meter = session.board, Meter()
    board.has_u_force = True
    session.start()
    session.make_ready(**OF_FORCE)
    meter.connect(session)
    session.cut()
    assert session.remote.newest().faults == ()
    ticks = list(zip(session.records, board.ticks[1:], strict=False))
    in_cut = [record for record, seen in ticks if seen.in_cut]
    assert len(in_cut) > 1000
    assert max(abs(record["u_nm"]) for record in in_cut) > 50_000
    after = zip(in_cut, in_cut[2:], strict=False)
    assert max(abs(late["u_nm"] - early["out_u_nm"]) for early, late in after) < 1000
    assert max(abs(record["force_q6"]) for record in in_cut) > 64 * 10_000
    for record, seen in ticks:
        mn = signed16(seen.words[0]) * FORCE_MN / 32768
        wanted_mn = record["force_q6"] / 64 if seen.enable else 0.0
        assert mn == pytest.approx(wanted_mn, abs=0.51 * FORCE_MN / 32768)
    assert {tuple(channels) for channels in meter.order[1:-1]} == {(0, 1, 2, 3)}
    assert max(meter.delays) < LATENCY_US * CORE_HZ / 1e6
    assert min(meter.delays) > LATENCY_US * CORE_HZ / 1e6 / 2
    assert board.ticks[-1].enable == 1
    for pin, bit in zip(LIMITS, (LIMIT_LOW, LIMIT_HIGH), strict=True):
        assert not session.records[-1]["inputs"] & bit
        session.chip.gpio.drive(pin, 0)
        session.chip.run(session.chip.seconds(101e-6))
        assert session.records[-1]["inputs"] & bit
        assert board.ticks[-1].fault == 1
    assert "u_travel" in session.remote.status().faults
