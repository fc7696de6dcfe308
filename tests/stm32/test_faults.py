"""The image's reaction to a bad table, a late tick, a dead clock, a reset, a hang."""

from collections.abc import Callable

import pytest

from tests.stm32.board import TABLE
from tests.stm32.emulator import DTCM, DTCM_BYTES
from tests.stm32.models.core import HARD_FAULT
from tests.stm32.models.gpio import OUTPUT
from tests.stm32.models.rcc import RESET_FLAGS
from tests.stm32.remote import ENABLE, RESET, SELECT, START, errors
from tests.stm32.session import Session

ERR = errors()
TIM5_CNT = 0x40000C24
STACK_BYTES = 16 * 1024  # at the bottom of DTCM
SAFE = (0, 0, 0, 0)
PUT_S = 0.9  # by which the watchdog of a second is put forward


def outputs_since(session: Session, at: int) -> list[str]:
    """Return what the board noticed after an instant."""
    return [event.what for event in session.board.events if event.at > at]


@pytest.mark.parametrize("torn_at", [None, 0, 64])
def test_bad_table_starts_refuses_and_the_next_is_used(
    started: Session, torn_at: int | None
) -> None:
    """Erased, or with words that cannot be read: it ends the table, not the controller.

    Status, answer and line name the error. Every other kind of damage: tests/unit/firmware/table.
    """
    remote, chip, board = started.remote, started.chip, started.board
    table = chip.read_memory(TABLE, 1 << 16)
    if torn_at is None:
        board.write_table(b"\xff" * len(table))
    else:
        chip.flash.tear({TABLE + torn_at})
    chip.usart3.sent.clear()
    board.power_on()
    status = remote.started()
    assert status.state == "off"
    assert status.table < 0 if torn_at is not None else status.table == ERR["image_magic"]
    assert remote.command(ENABLE)[0] == status.table
    assert remote.status().state == "off"
    assert not any(event.what == "enable 1" for event in board.events)
    lines = [line for line in remote.lines() if line.startswith("table: ")]
    assert len(lines) == 1
    assert lines[0].endswith("home refused until a table is written")
    assert chip.resets == ["power_on"] * 2
    board.write_table(table)
    remote.do(SELECT)
    assert remote.status().table == 0


def test_tick_overrun_retracts_and_locks(ready: Session) -> None:
    """A tick that takes 60 us: fault in the next one, retract, no enable until a reset."""
    remote, chip = ready.remote, ready.chip
    chip.stall(TIM5_CNT, chip.seconds(60e-6))
    at = chip.clock.now
    chip.run(chip.seconds(200e-6))
    assert "fault 1" in outputs_since(ready, at)
    remote.wait_for("fault", 0.1)
    assert "drive" in remote.newest().faults
    ticks = ready.board.ticks
    assert chip.run_until(lambda: ticks[-1].enable == 0, chip.seconds(0.3))
    assert any("a tick overran" in line for line in remote.lines())
    remote.wait_until_retracted(0.5)
    assert remote.command(RESET)[0] == 0
    remote.wait_for("off", 0.1)
    assert remote.command(ENABLE)[0] == ERR["drive"]
    assert chip.resets == ["power_on"]

    chip.reset("pin")
    assert remote.started().reset == "pin"
    assert "start: reset pin" in remote.lines()
    assert remote.command(ENABLE, is_pressed=False)[0] == ERR["acknowledge"]


def between_ticks(session: Session) -> int:
    """Go on until the outputs have just stepped and nothing is on its way; return the time."""
    events = session.board.events
    n = len(events)
    assert session.chip.run_until(
        lambda: len(events) > n and events[-1].what == "step", session.chip.seconds(1e-3)
    )
    return session.chip.clock.now


def test_late_set_points_lock_too(ready: Session) -> None:
    """A tick that ends after the last moment for the frames, but within its period."""
    between_ticks(ready)
    ready.chip.stall(TIM5_CNT, ready.chip.seconds(25e-6))
    ready.remote.wait_for("fault", 0.1)
    assert any("came too late" in line for line in ready.remote.lines())


HALTS: dict[str, Callable[[Session], None]] = {
    "clock: the HSE oscillator failed": lambda session: session.chip.rcc.fail_hse(),
    "exception: hard fault": lambda session: session.chip.nvic.pending.add(HARD_FAULT),
}


@pytest.mark.parametrize("why", HALTS)
def test_halt_is_safe_and_names_its_reason(ready: Session, why: str) -> None:
    """Outputs at 0 V and low within 2 us, nothing else goes out; without a HSE the HSI carries."""
    chip, remote, events = ready.chip, ready.remote, ready.board.events
    at = between_ticks(ready)
    HALTS[why](ready)
    assert chip.run_until(lambda: chip.resets[-1] == "software", chip.seconds(0.01))
    assert tuple(ready.board.dac.words) == SAFE
    since = outputs_since(ready, at)
    assert set(since[: since.index("reset software")]) == {"enable 0", "fault 1"}
    assert next(event.at for event in events if event.at > at) - at < chip.seconds(2e-6)
    assert remote.started().reset == "halt"
    assert f"start: halt: {why}" in remote.lines()
    assert ready.board.ticks[-1].words == SAFE
    assert "enable 1" not in outputs_since(ready, at)
    if chip.rcc.hse_hz == 0:
        assert chip.rcc.core_hz() == 480_000_000
        assert remote.command(ENABLE)[0] == ERR["drive"]
        assert any("no HSE clock" in line for line in remote.lines())


def test_reset_in_the_cut_is_safe_and_reported(ready: Session) -> None:
    """The pins let go at once, start-up drives them low before all else, set-points return to 0.

    A brown-out, which sets a part of the flags of a power-on.
    """
    remote, chip, board = ready.remote, ready.chip, ready.board
    remote.do(START)
    remote.wait_for("engaging", 1.0)
    at = chip.clock.now
    chip.usart3.sent.clear()
    assert RESET_FLAGS["power_on"] & RESET_FLAGS["brown_out"] == RESET_FLAGS["brown_out"]
    chip.reset("brown_out")
    assert [chip.gpio.level(name) for name in ("PE13", "PE15")] == [0, 0]
    assert tuple(board.dac.words) == SAFE
    port, pin = chip.gpio.pin("PE13")
    trace, trace_pin = chip.gpio.pin("PB3")  # of the debug port, driven by a receiver of B
    assert trace.function(trace_pin) == 0
    data = (DTCM + STACK_BYTES, DTCM_BYTES - STACK_BYTES)
    memory = chip.read_memory(*data)
    assert chip.run_until(lambda: port.mode(pin) == OUTPUT, 200)
    assert chip.run_until(lambda: trace.function(trace_pin) is None, 200)
    assert chip.read_memory(*data) == memory
    status = remote.started()
    assert (status.state, status.reset, status.faults) == ("off", "brown_out", ())
    assert remote.lines()[1] == "start: brown-out reset"
    assert board.ticks[-1].words == SAFE
    assert "enable 1" not in outputs_since(ready, at)


@pytest.mark.parametrize(
    ("victim", "dog", "least_s", "most_s"),
    [("tick", "window", 100e-6, 206e-6), ("main loop", "watchdog", PUT_S + 0.05, PUT_S + 0.15)],
)
def test_watchdog_ends_a_hang(
    ready: Session, victim: str, dog: str, least_s: float, most_s: float
) -> None:
    """Tick or main loop: the outputs let go in the time of its watchdog; the reason is reported."""
    remote, chip, board = ready.remote, ready.chip, ready.board
    chip.usart3.sent.clear()
    revive = ready.hang(in_tick=victim == "tick")
    at = chip.clock.now
    if victim == "main loop":
        chip.iwdg1.put_forward(chip.seconds(PUT_S))
        at -= chip.seconds(PUT_S)
    assert chip.run_until(lambda: chip.resets[-1] == dog, chip.seconds(0.16))
    revive()
    assert least_s < (chip.clock.now - at) / 480e6 < most_s
    assert [chip.gpio.level(name) for name in ("PE13", "PE15")] == [0, 0]
    assert tuple(board.dac.words) == SAFE
    assert remote.started().reset == "watchdog"
    assert remote.lines()[1] == "start: watchdog reset"
    assert board.ticks[-1].words == SAFE


def test_window_watchdog_ends_ticks_that_come_too_fast(ready: Session) -> None:
    """One bit of the tick timer's period flips: 12 000 clocks become 3807, 16 us."""
    chip = ready.chip
    tim4 = chip.tim[4]
    tim4.write(0x2C, 4, tim4.read(0x2C, 4) & ~(1 << 13))
    assert chip.run_until(lambda: chip.resets[-1] == "window", chip.seconds(200e-6))
    assert chip.gpio.level("PE13") == 0
