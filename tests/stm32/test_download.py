# SPDX-License-Identifier: Apache-2.0
"""A table comes over the bus into the other place in flash, and the supply falls on the way."""

import struct
import zlib

import pytest

from camtools.cli.flash import FIRST_PLACE
from tests.stm32.host import short_table
from tests.stm32.models.fdcan import Frame
from tests.stm32.models.flash_pwr import SECTOR_BYTES
from tests.stm32.remote import BEGIN, COMMAND, ENABLE, SELECT, TO_CONTROLLER, errors
from tests.stm32.session import Session

OTHER, LOG, TABLE = 0x08040000, 0x080E0000, 0x08100000
MAGIC, RECORD_BYTES = 0x4C424154, 32
ERR = errors()


@pytest.fixture
def table() -> bytes:
    """Return a good table."""
    return short_table().read_bytes()


def named(table: bytes, name: str) -> bytes:
    """Return the table with another name and a checksum that fits: TABLE_FORMAT.md."""
    body = bytearray(table)
    body[32:64] = name.encode().ljust(32, b"\0")
    struct.pack_into("<I", body, 20, zlib.crc32(body[24:]))
    return bytes(body)


def record(name: int, number: int) -> bytes:
    """Return a record of the log that names a place."""
    words = (MAGIC, name, number)
    return struct.pack("<8I", *words, *(~word & 0xFFFFFFFF for word in words), 0, 0)


def told(session: Session) -> str:
    """Return the name of the table that the newest line says is in use."""
    lines = [line for line in session.remote.lines() if line.startswith("table: ")]
    return lines[-1].removeprefix("table: ").removesuffix(" in use")


def restart(session: Session) -> str:
    """Switch the supply off and on; return the name of the table that is in use then."""
    session.board.power_on()
    session.remote.started()
    return told(session)


def test_downloads_take_turns_and_are_kept(started: Session, table: bytes) -> None:
    """The new table is in use after select, and after a restart; the next one goes to place 0."""
    remote, chip = started.remote, started.chip
    old = chip.read_memory(TABLE, len(table))
    second, third = named(table, "second"), named(table, "third")
    remote.download(second)
    assert told(started) == "short skirt"
    assert chip.read_memory(OTHER, len(second)) == second
    assert chip.read_memory(LOG, RECORD_BYTES) == b"\xff" * RECORD_BYTES
    remote.do(SELECT)
    assert remote.table_name() == "second"
    assert chip.read_memory(TABLE, len(table)) == old
    assert restart(started) == "second"
    remote.download(third)
    assert chip.read_memory(TABLE, len(third)) == third
    remote.do(SELECT)
    assert restart(started) == "third"


def test_the_watchdog_is_fed_between_the_two_checks_of_a_select(
    started: Session, table: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A large signed table takes long to be checked: never two checks within one second."""
    chip, long_gaps, last = started.chip, 0, 0
    started.remote.download(named(table, "second"))
    chip.naps = 0
    write = chip.iwdg1.write

    def spy(offset: int, size: int, value: int) -> None:
        nonlocal long_gaps, last
        is_before_commit = chip.read_memory(LOG, RECORD_BYTES) == b"\xff" * RECORD_BYTES
        long_gaps += is_before_commit and chip.clock.now - last > chip.seconds(500e-6)
        last = chip.clock.now
        write(offset, size, value)

    monkeypatch.setattr(chip.iwdg1, "write", spy)
    chip.run(chip.seconds(200e-6))
    long_gaps = 0
    started.remote.do(SELECT)
    assert long_gaps == 1  # after the first check, which takes 1.1 ms; other loops up to 0.1 ms


def give_until_dark(session: Session, table: bytes) -> None:
    """Download and select until the supply falls."""
    remote, chip = session.remote, session.chip
    n = len(chip.resets)
    try:
        remote.use(table)
    except AssertionError:
        assert len(chip.resets) > n, "the download failed, but not for want of power"


@pytest.mark.parametrize("operation", [1, 100, "commit"])
def test_power_lost_on_the_way_leaves_the_old_table(
    started: Session, table: bytes, operation: int | str
) -> None:
    """In the erase, in programming, in the record itself: old table, and the next one works."""
    n_words = (len(table) + 31) // 32
    chip = started.chip
    chip.flash.left = 2 + n_words if operation == "commit" else int(operation)
    give_until_dark(started, named(table, "second"))
    assert chip.resets.count("power_on") == 2
    started.remote.started()
    assert told(started) == "short skirt"
    started.remote.use(named(table, "third"))
    assert restart(started) == "third"


def test_log_is_emptied_while_it_says_nothing(started: Session, table: bytes) -> None:
    """A log that is half full is erased when place 0 is in use, and goes on from its start."""
    chip, remote = started.chip, started.remote
    chip.write_flash(LOG, b"".join(record(1 - i % 2, i) for i in range(514)))
    assert restart(started) == "short skirt"
    remote.download(named(table, "second"))
    assert chip.read_memory(LOG, SECTOR_BYTES) == b"\xff" * SECTOR_BYTES
    remote.do(SELECT)
    assert restart(started) == "second"


def test_table_in_the_old_place_1_is_refused_with_the_remedy(
    started: Session, table: bytes
) -> None:
    """An older firmware had a download in use where code is now: no table until it comes again."""
    chip, remote = started.chip, started.remote
    chip.write_flash(LOG, record(1, 0))
    chip.usart3.sent.clear()
    started.board.power_on()
    assert remote.started().table == ERR["no_table"]
    assert "download or flash it again" in "".join(remote.lines())
    assert remote.command(ENABLE)[0] == ERR["no_table"]
    remote.use(named(table, "third"))
    assert chip.read_memory(LOG, 2 * RECORD_BYTES) == record(1, 0) + record(0, 1)
    chip.usart3.sent.clear()
    assert restart(started) == "third"
    assert "older firmware" not in "".join(remote.lines())


def test_table_of_the_old_place_0_is_in_use(started: Session, table: bytes) -> None:
    """The newest record of an older firmware names place 0, which has not moved."""
    started.board.write_table(named(table, "kept"))
    started.chip.write_flash(LOG, record(1, 0) + record(0, 1))
    assert restart(started) == "kept"


def test_table_larger_than_place_1_is_refused(started: Session) -> None:
    """Place 0 is larger, but the next download must fit place 1."""
    assert started.remote.command(BEGIN, value=LOG - OTHER + 1)[0] == ERR["download_room"]
    started.remote.do(BEGIN, value=LOG - OTHER)


def test_programmer_takes_the_place_back(started: Session, table: bytes) -> None:
    """After downloads, what tools/flash writes is in use: the table, and its record in the log."""
    started.remote.use(named(table, "second"))
    started.board.write_table(named(table, "flashed"))
    started.chip.write_flash(LOG, b"\xff" * SECTOR_BYTES)
    started.chip.write_flash(LOG, FIRST_PLACE.read_bytes())
    assert restart(started) == "flashed"
    started.remote.use(named(table, "third"))
    assert restart(started) == "third"


def test_tick_goes_on_while_flash_is_busy(started: Session, table: bytes) -> None:
    """No tick is lost or late in a download; commands are answered behind the erase."""
    chip, board = started.chip, started.board
    n, at = len(board.ticks), chip.clock.now
    started.remote.do(BEGIN, value=3 * SECTOR_BYTES)
    assert started.remote.block(0, table[:4096]) == 0
    passed = (chip.clock.now - at) * 20_000 // chip.rcc.core_hz()
    assert passed > 3 * 40
    assert abs(len(board.ticks) - n - passed) <= 1
    assert started.remote.status().faults == ()


def test_frames_of_a_block_are_no_commands(started: Session) -> None:
    """A lost first frame leaves the rest without effect."""
    for data in (b"\x21" + bytes(7), bytes(8), b"\x30\0\0"):
        assert started.board.send(Frame(TO_CONTROLLER, data))
        started.chip.run(started.chip.seconds(1e-3))
    assert COMMAND != TO_CONTROLLER
    assert started.remote.command(ENABLE, is_pressed=False)[0] == ERR["acknowledge"]
