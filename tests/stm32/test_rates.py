# SPDX-License-Identifier: Apache-2.0
"""The image at the least and the highest rate of the tick: BOARD_TICK_HZ of 5 and 50 kHz."""

import subprocess
from collections.abc import Iterator
from itertools import pairwise

import pytest

from tests.stm32.host import ROOT, build_with
from tests.stm32.remote import ENABLE
from tests.stm32.session import Session

pytestmark = pytest.mark.long  # it builds two images
CORE_HZ = 480_000_000
TIM5_CNT = 0x40000C24
RATES = (5_000, 50_000)
UPDATE_S = {5_000: 30e-6, 50_000: 18e-6}
HANG = b"\x30\xbf\xfd\xe7"  # sleeps for ever: wfi, and back to it
STOP_S = {5_000: (600e-6, 650e-6), 50_000: (80e-6, 138e-6)}


@pytest.fixture(scope="module", params=RATES)
def session(request: pytest.FixtureRequest) -> Session:
    """Return a session that is ready, at each of the rates."""
    image = build_with("BOARD_TICK_HZ", f"{request.param}u")
    session = Session(image=image, tick_hz=request.param)
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
    hz, board = session.board.tick_hz, session.board
    assert {b - a for a, b in pairwise(board.tick_at)} == {CORE_HZ // hz}
    begin, end = board.tick_at[0], board.tick_at[-1]
    since = {"step": set[int](), "frame": set[int]()}
    for event in board.events:
        kind = event.what.split()[0]
        if begin < event.at < end and kind in since:
            since[kind].add((event.at - begin) % (CORE_HZ // hz))
    due = round(UPDATE_S[hz] * CORE_HZ)
    assert since["step"] <= {due, due + 1}
    assert max(since["frame"]) < due
    for stepper in board.steppers.values():
        assert min(stepper.shortest.high, stepper.shortest.low) >= CORE_HZ * 500e-9
        assert stepper.shortest.setup >= CORE_HZ // hz
    assert session.chip.resets == ["power_on"]
    assert not [line for line in session.remote.lines() if "not ready" in line]


def test_a_late_tick_locks_without_a_reset(fresh: Session) -> None:
    """An overrun is a fault; the watchdog waits for the next tick on time."""
    chip, hz = fresh.chip, fresh.board.tick_hz
    chip.stall(TIM5_CNT, chip.seconds(1.2 / hz))
    chip.run(chip.seconds(0.02))
    assert chip.resets[-1] == "pin"
    assert any("a tick overran" in line for line in fresh.remote.lines())


def test_window_watchdog_ends_ticks_that_stop(fresh: Session) -> None:
    """The interrupt hangs: a reset within the time that the README states."""
    chip = fresh.chip
    fresh.remote.do(ENABLE)
    vectors = chip.nvic.v["vtor"]
    handler = int.from_bytes(chip.read_memory(vectors + 4 * (16 + 30), 4), "little") & ~1
    assert chip.run_until(lambda: not chip.nvic.active, chip.seconds(1e-3))
    instructions = chip.read_memory(handler, len(HANG))
    chip.put_instructions(handler, HANG)
    at = chip.clock.now
    least_s, most_s = STOP_S[fresh.board.tick_hz]
    assert chip.run_until(lambda: chip.resets[-1] == "window", chip.seconds(most_s))
    chip.put_instructions(handler, instructions)
    assert (chip.clock.now - at) / CORE_HZ > least_s - 2 / fresh.board.tick_hz
    assert chip.gpio.level("PE13") == 0


def test_window_watchdog_ends_ticks_at_twice_the_rate(fresh: Session) -> None:
    """The period of the tick timer is halved."""
    tim4 = fresh.chip.tim[4]
    tim4.write(0x2C, 4, tim4.read(0x2C, 4) // 2)
    assert fresh.chip.run_until(lambda: fresh.chip.resets[-1] == "window", fresh.chip.seconds(2e-3))


def test_self_test_passes(fresh: Session) -> None:
    """Ticks, window and the cycles of a tick are judged by the rate."""
    chip, hz = fresh.chip, fresh.board.tick_hz
    chip.usart3.sent.clear()
    chip.usart3.receive(b"t")
    assert chip.run_until(lambda: b"self-test: passed;" in chip.usart3.sent, chip.seconds(0.3))
    assert f" of {CORE_HZ // hz}, faults of the port 0x0" in chip.usart3.sent.decode()


@pytest.mark.parametrize("hz", [4_000, 60_000])
def test_rate_beyond_the_range_does_not_build(hz: int) -> None:
    """The compiler names the setting and its range."""
    source = ROOT / "hal" / "stm32h743" / "stm_watch.c"
    command = ["arm-none-eabi-gcc", "-fsyntax-only", f"-DBOARD_TICK_HZ={hz}u", str(source)]
    done = subprocess.run(command, check=False, capture_output=True, text=True)
    assert "BOARD_TICK_HZ: give 5000 to 50000" in done.stderr
