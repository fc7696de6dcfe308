# SPDX-License-Identifier: Apache-2.0
"""What the image does with a bad table, a late tick, a dead clock, a fall of the supply, a hang."""

from collections.abc import Callable

import pytest

from camtools.base.project_paths import VERSION
from tests.stm32.board import READY
from tests.stm32.emulator import DTCM, DTCM_BYTES
from tests.stm32.host import short_table
from tests.stm32.models.core import HARD_FAULT
from tests.stm32.models.gpio import OUTPUT
from tests.stm32.models.rcc import RESET_FLAGS
from tests.stm32.remote import ENABLE, KEY, PARAMS, RESET, SELECT, SET, START, TAKE, errors
from tests.stm32.session import Session

ERR = errors()
TIM5_CNT = 0x40000C24
STACK_BYTES = 16 * 1024  # at the bottom of DTCM
SAFE = (0, 0, 0, 0)
PUT_S = 0.9  # by which the watchdog of a second is put forward
HANG = b"\x30\xbf\xfd\xe7"  # sleeps for ever: wfi, and back to it


# Every kind of damage is tried in tests/unit/firmware/table.
BAD_TABLES: dict[str, tuple[Callable[[bytes], bytes], str]] = {
    "erased": (lambda table: b"", "image_magic"),
    "one bit": (lambda table: table[:-1] + bytes([table[-1] ^ 1]), "image_crc"),
}


def outputs_since(session: Session, at: int) -> list[str]:
    """Return what the board noticed behind an instant."""
    return [event.what for event in session.board.events if event.at > at]


@pytest.mark.parametrize("case", BAD_TABLES)
def test_bad_table_starts_refuses_and_says_why(case: str) -> None:
    """Status, answer and line name the error; a good table then needs no new start."""
    spoil, name = BAD_TABLES[case]
    table = short_table().read_bytes()
    session = Session(spoil(table))
    remote = session.remote
    session.board.power_on()
    status = remote.started()
    assert (status.state, status.table) == ("off", ERR[name])
    assert remote.command(ENABLE) == (ERR[name], 0)
    assert remote.status().state == "off"
    assert not any(event.what == "enable 1" for event in session.board.events)
    told = [line for line in remote.lines() if line.startswith("table: ")]
    assert len(told) == 1
    assert told[0].endswith("home refused until a table is written")

    session.board.write_table(table)
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


def test_late_set_points_lock_too(ready: Session) -> None:
    """A tick that ends behind the last moment for the frames, but within its period."""
    between_ticks(ready)
    ready.chip.stall(TIM5_CNT, ready.chip.seconds(25e-6))
    ready.remote.wait_for("fault", 0.1)
    assert any("came too late" in line for line in ready.remote.lines())


def between_ticks(session: Session) -> int:
    """Go on until the outputs have just stepped and nothing is on its way; return the time."""
    events = session.board.events
    n = len(events)
    assert session.chip.run_until(
        lambda: len(events) > n and events[-1].what == "step", session.chip.seconds(1e-3)
    )
    return session.chip.clock.now


def expect_safe_halt(session: Session, at: int, why: str) -> None:
    """Expect outputs at 0 V and low first, nothing else to go out, and the reason at the start."""
    chip, remote, events = session.chip, session.remote, session.board.events
    assert chip.run_until(lambda: chip.resets[-1] == "software", chip.seconds(0.01))
    assert tuple(session.board.dac.words) == SAFE
    behind = outputs_since(session, at)
    assert set(behind[: behind.index("reset software")]) == {"enable 0", "fault 1"}
    assert next(event.at for event in events if event.at > at) - at < chip.seconds(2e-6)
    assert remote.started().reset == "halt"
    assert f"start: halt: {why}" in remote.lines()
    assert session.board.ticks[-1].words == SAFE
    assert "enable 1" not in outputs_since(session, at)


def test_lost_clock_halts_and_runs_on_without(ready: Session) -> None:
    """The HSE dies: NMI, safe, reset; then the HSI carries it, and nothing can be enabled."""
    at = between_ticks(ready)
    ready.chip.rcc.fail_hse()
    expect_safe_halt(ready, at, "clock: the HSE oscillator failed")
    assert ready.chip.rcc.core_hz() == 480_000_000
    assert ready.remote.command(ENABLE)[0] == ERR["drive"]
    assert any("no HSE clock" in line for line in ready.remote.lines())


def test_exception_halts(ready: Session) -> None:
    """A hard fault: safe, reset, its name told."""
    at = between_ticks(ready)
    ready.chip.nvic.pending.add(HARD_FAULT)
    expect_safe_halt(ready, at, "exception: hard fault")


@pytest.mark.parametrize(
    ("reason", "text"),
    [("brown_out", "brown-out reset"), ("pin", "reset pin"), ("power_on", "power on")],
)
def test_reset_in_the_cut_is_safe_and_told(ready: Session, reason: str, text: str) -> None:
    """The pins let go at once, start-up drives them low before all else, set-points return to 0."""
    remote, chip, board = ready.remote, ready.chip, ready.board
    remote.do(START)
    remote.wait_for("engaging", 1.0)
    at = chip.clock.now
    chip.usart3.sent.clear()
    if reason == "power_on":
        board.power_on()
    else:
        chip.reset(reason)
    assert [chip.gpio.level(name) for name in ("PE13", "PE15")] == [0, 0]
    assert tuple(board.dac.words) == SAFE
    port, pin = chip.gpio.pin("PE13")
    data = (DTCM + STACK_BYTES, DTCM_BYTES - STACK_BYTES)
    memory = chip.read_memory(*data)
    assert chip.run_until(lambda: port.mode(pin) == OUTPUT, 200)
    assert chip.read_memory(*data) == memory
    status = remote.started()
    assert (status.state, status.reset, status.faults) == ("off", reason, ())
    assert remote.lines()[:2] == [f"camturn {VERSION}", f"start: {text}"]
    assert board.ticks[-1].words == SAFE
    assert "enable 1" not in outputs_since(ready, at)


PROTECTION = (  # RDP, WPSN; level, firmware protected, brown-out level
    *((0xAA, 0xFF, 0, 0, 0), (0xBB, 0xFC, 1, 1, 3), (0x00, 0xFE, 1, 0, 1), (0xCC, 0xFC, 2, 1, 2)),
)


def test_protection_of_the_chip_is_reported_at_the_start(started: Session) -> None:
    """By the option bytes: any RDP but two is level 1, a bit of 0 protects one of two sectors."""
    chip = started.chip
    for rdp, wpsn, level, is_protected, brown_out in PROTECTION:
        started.board.power_on()
        chip.usart3.sent.clear()
        options = 0x031600F0 | rdp << 8 | brown_out << 2
        chip.flash.v |= {"optsr_cur": options, "wpsn_cur1": wpsn}
        line = f"port: read-out protection level {level}, write protection of the firmware "
        line += f"{is_protected}, brown-out level {brown_out} (UPDATE.md)"
        started.remote.started()
        assert line in started.remote.lines()


@pytest.mark.parametrize(
    ("victim", "dog", "least_s", "most_s"),
    [("tick", "window", 100e-6, 206e-6), ("main loop", "watchdog", PUT_S + 0.05, PUT_S + 0.15)],
)
def test_watchdog_ends_a_hang(
    ready: Session, victim: str, dog: str, least_s: float, most_s: float
) -> None:
    """Whoever hangs, the outputs let go in the time of its watchdog, and the reason is told."""
    remote, chip, board = ready.remote, ready.chip, ready.board
    chip.usart3.sent.clear()
    vectors = chip.nvic.v["vtor"]
    handler = int.from_bytes(chip.read_memory(vectors + 4 * (16 + 30), 4), "little") & ~1
    assert chip.run_until(lambda: not chip.nvic.active, chip.seconds(1e-3))
    place = handler if victim == "tick" else chip.pc
    instructions = chip.read_memory(place, len(HANG))
    chip.put_instructions(place, HANG)
    at = chip.clock.now
    if victim == "main loop":
        chip.iwdg1.put_forward(chip.seconds(PUT_S))
        at -= chip.seconds(PUT_S)
    assert chip.run_until(lambda: chip.resets[-1] == dog, chip.seconds(0.16))
    chip.put_instructions(place, instructions)  # or it would hang again
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


def test_cut_wire_reads_as_not_ready(started: Session) -> None:
    """Nobody drives the pins of the chains: their pull-down resistors say no."""
    for name in (READY, "PE10"):
        port, pin = started.chip.gpio.pin(name)
        del port.outside[pin]
    started.chip.run(started.chip.seconds(1e-3))
    assert started.remote.command(ENABLE)[0] == ERR["estop"]
    started.chip.gpio.drive("PE10", 1)
    started.chip.run(started.chip.seconds(1e-3))
    assert started.remote.command(ENABLE)[0] == ERR["drive"]


def test_power_on_is_told_from_brown_out_and_flags_are_cleared(started: Session) -> None:
    """Power-on sets the flag of a brown-out too; what is reported is cleared for the next time."""
    assert RESET_FLAGS["power_on"] & RESET_FLAGS["brown_out"] == RESET_FLAGS["brown_out"]
    assert started.remote.newest().reset == "power_on"
    assert started.chip.rcc.v["rsr"] == 0


def test_enable_wants_the_button_and_limits_want_the_key(started: Session) -> None:
    """Without a wire at their pins nothing is enabled, and no limit changes."""
    remote, gpio = started.remote, started.chip.gpio
    remote.session = remote.raw(TAKE)[1]
    stroke = PARAMS.index("u_stroke_nm")
    assert remote.raw(SET, stroke, 1_300_000)[0] == ERR["locked"]
    assert remote.raw(ENABLE)[0] == ERR["acknowledge"]
    gpio.drive(KEY, 1)
    started.chip.run(started.chip.seconds(2e-3))
    assert remote.raw(SET, stroke, 1_300_000)[0] == 0
