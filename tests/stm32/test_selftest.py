"""The self-test that the letter t on the serial line starts, on good boards and on bad ones."""

import re

import pytest
from unicorn import UC_HOOK_MEM_READ

from camtools.base.project import VERSION
from tests.stm32.board import TABLE
from tests.stm32.emulator import AXI, DTCM, DTCM_BYTES
from tests.stm32.remote import ENABLE, errors
from tests.stm32.session import Session

PARTS = ("clocks", "RAM", "flash", "timers", "AD5754R", "FDCAN1", "window watchdog", "tick")
RECORDER = AXI + (1 << 18)  # a word of its memory
REPORT_S = 0.5
END = re.compile(rb"self-test: (passed;|FAILED).*\n")


def report_of(session: Session) -> list[str]:
    """Ask for the self-test, which counts ticks by the main loop; return its lines."""
    chip = session.chip
    chip.naps = 0
    chip.usart3.sent.clear()
    chip.usart3.receive(b"t")
    assert chip.run_until(lambda: END.search(chip.usart3.sent) is not None, chip.seconds(REPORT_S))
    return chip.usart3.lines()


def verdicts_of(lines: list[str]) -> dict[str, str]:
    """Return the verdict on each part."""
    found = (re.match(r"(.+): (ok|FAILED), ", line) for line in lines)
    return {match[1]: match[2] for match in found if match}


def bad_in(lines: list[str]) -> set[str]:
    """Return the parts that a report fails."""
    return {part for part, verdict in verdicts_of(lines).items() if verdict == "FAILED"}


def test_good_board_passes_and_the_report_names_it(started: Session) -> None:
    """Every part is ok; device, revision, version, sizes and times are those of the models.

    The memory that is written has its old content afterwards; the end is the watchdog's reset.
    """
    chip = started.chip
    content = bytes(range(256)) * 16
    chip.write_memory(RECORDER, content)
    lines = report_of(started)
    assert chip.read_memory(RECORDER, len(content)) == content
    text = "\n".join(lines)
    assert lines[0].startswith(f"self-test: camturn {VERSION}, device 0x20030450, revision V")
    assert verdicts_of(lines) == dict.fromkeys(PARTS, "ok")
    cycles = re.search(r"HSE, (\d+) core cycles in 1 ms", text)
    assert cycles is not None
    assert int(cycles[1]) == pytest.approx(480_000, rel=0.01)
    assert "393216 written, 0 wrong words, 0 corrected errors" in text
    assert "1835008 of 1835008 bytes readable" in text
    assert re.search(r"timers: ok, (399|400|401) ticks in 20 ms", text)
    assert "answer by SDO 0x90001F" in text
    tick = re.search(r"tick: ok, (\d+) cycles, longest (\d+) of 24000, .* 0x0$", text, re.MULTILINE)
    assert tick is not None
    assert 500 < int(tick[1]) <= int(tick[2]) < 24_000
    assert "self-test: passed" in text
    chip.iwdg1.put_forward(chip.seconds(0.9))
    assert chip.run_until(lambda: chip.resets[-1] == "watchdog", chip.seconds(0.2))
    started.remote.started()
    lines = started.remote.lines()
    assert lines[lines.index(f"camturn {VERSION}") + 1] == "start: watchdog reset"


def test_drives_enabled_refuse_it(ready: Session) -> None:
    """One line names the remedy, and the machine stays ready."""
    ready.chip.usart3.receive(b"xt")
    ready.chip.run(ready.chip.seconds(0.05))
    assert "self-test: refused while the drives are enabled: disable them" in ready.remote.lines()
    assert ready.chip.resets == ["power_on"]
    assert ready.remote.status().state == "ready"


def test_flash_being_written_refuses_it(started: Session) -> None:
    """A bank at work cannot be read."""
    flash = started.chip.flash
    read = flash.read
    flash.read = lambda offset, size: read(offset, size) | (4 if offset == 0x10 else 0)  # type: ignore[method-assign]
    started.chip.usart3.receive(b"t")
    started.chip.run(started.chip.seconds(0.01))
    assert "self-test: refused while flash is written: ask again" in started.remote.lines()


@pytest.mark.long
def test_bad_parts_are_named(started: Session) -> None:
    """All but clocks, timers and tick.

    A cell of the recorder's memory that a disturbance changes after each store, a torn word of
    flash, a converter in overload, a loop-back without an echo, a window watchdog that stands.
    """
    chip = started.chip
    exchange = chip.spi3.exchange
    chip.spi3.exchange = lambda frame: exchange(frame) | 1 << 7
    chip.reset("pin")
    started.remote.started()
    chip.ramecc.flip(DTCM + DTCM_BYTES - 512, 1)
    spoilt = (RECORDER, RECORDER + 3)
    chip.uc.hook_add(
        UC_HOOK_MEM_READ, lambda uc, *_: uc.mem_write(RECORDER, b"\x55" * 4), None, *spoilt
    )
    chip.flash.tear({TABLE + (1 << 19)})
    chip.fdcan1._receive = lambda frame: False  # type: ignore[method-assign]
    chip.wwdg1._left = lambda: 68  # type: ignore[method-assign]
    lines = report_of(started)
    assert bad_in(lines) == {"RAM", "flash", "AD5754R", "FDCAN1", "window watchdog"}
    assert "1 wrong words, 1 corrected errors" in "\n".join(lines)
    assert "self-test: FAILED" in "\n".join(lines)


@pytest.mark.long
def test_bare_board_without_its_oscillator_fails_the_clocks() -> None:
    """Without 8 MHz at OSC_IN the report names it; the fault of the port fails the tick.

    It runs from the HSI at the same frequencies, and enables nothing. A bare board has no AD5754R,
    whose silence at SDO is no failure.
    """
    session = Session(hse_hz=0)
    exchange = session.chip.spi3.exchange
    session.chip.spi3.exchange = lambda frame: exchange(frame) & 0
    session.start()
    assert session.remote.newest().state == "off"
    assert session.chip.rcc.core_hz() == 480_000_000
    assert session.remote.command(ENABLE)[0] == errors()["drive"]
    lines = report_of(session)
    assert bad_in(lines) == {"clocks", "tick"}
    assert "OSC_IN has no 8 MHz" in "\n".join(lines)
    assert "AD5754R: no answer by SDO: not wired to PC11, or no supply" in lines


@pytest.mark.long
def test_dead_watchdog_is_reported_after_a_halt(started: Session) -> None:
    """No reset within 2 s: the self-test halts, and the next start names the reason."""
    chip = started.chip
    chip.iwdg1.on_bite = chip.iwdg1.reset
    report_of(started)
    chip.iwdg1.put_forward(chip.seconds(1.0))
    chip.tim[5].put_forward(chip.seconds(1.9))
    assert chip.run_until(lambda: chip.resets[-1] == "software", chip.seconds(0.2))
    started.remote.started()
    why = "start: halt: self-test: the independent watchdog did not reset within 2 s"
    assert why in started.remote.lines()
