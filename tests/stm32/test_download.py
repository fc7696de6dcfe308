"""Tables and parameters come over the bus into flash, and the supply falls on the way.

A table goes into the place that is not in use. tests/campaign/power_stm.c and
tests/unit/stm32/test_stm_params.c interrupt both logs at every operation; here the image itself is
interrupted, in the record of a table and in the seal of the parameters.
"""

import struct
import zlib
from collections.abc import Callable

import pytest

from camtools.cli.flash import FIRST_PLACE
from tests.stm32.board import TABLE
from tests.stm32.host import short_table
from tests.stm32.models.flash_pwr import LOCK, RDPERR, RDSERR, SECTOR_BYTES, SNECCERR
from tests.stm32.remote import BEGIN, ENABLE, GET, PARAMS, REVERT, SAVE, SELECT, errors
from tests.stm32.session import Session

OTHER, LOG, PARAMS_LOG = 0x08040000, 0x080E0000, 0x081C0000
MAGIC, RECORD_BYTES = 0x4C424154, 32
LEAD = PARAMS.index("lead_ns")
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


def newest(session: Session, subject: str) -> str:
    """Return what the newest line about a subject reports."""
    lines = [line for line in session.remote.lines() if line.startswith(subject)]
    return lines[-1].removeprefix(f"{subject}: ")


def table_in_use(session: Session) -> str:
    """Return the name of the table that is in use by the newest line."""
    return newest(session, "table").removesuffix(" in use")


def restart(session: Session) -> str:
    """Switch the supply off and on; return the name of the table that is in use then."""
    session.board.power_on()
    session.remote.started()
    return table_in_use(session)


def test_downloads_take_turns_and_are_kept(started: Session, table: bytes) -> None:
    """The new table is in use after select, and after a restart; the next one goes to place 0."""
    remote, chip = started.remote, started.chip
    old = chip.read_memory(TABLE, len(table))
    second, third = named(table, "second"), named(table, "third")
    remote.download(second)
    assert table_in_use(started) == "short skirt"
    assert chip.read_memory(OTHER, len(second)) == second
    assert chip.read_memory(LOG, RECORD_BYTES) == b"\xff" * RECORD_BYTES
    remote.do(SELECT)
    assert table_in_use(started) == "second"
    assert chip.read_memory(TABLE, len(table)) == old
    assert restart(started) == "second"
    remote.download(third)
    assert chip.read_memory(TABLE, len(third)) == third
    remote.do(SELECT)
    assert restart(started) == "third"


def until_dark(session: Session, operation: int, act: Callable[[], None]) -> None:
    """Act until the supply falls in an operation of the flash, and wait for the next start."""
    n = len(session.chip.resets)
    session.chip.flash.left = operation
    try:
        act()
    except AssertionError:
        assert len(session.chip.resets) > n, "refused, but not for want of power"
    session.remote.started()


@pytest.mark.long
def test_power_lost_in_the_record_leaves_the_old_table(started: Session, table: bytes) -> None:
    """The old table, and the next download works, by flags and locks that are no errors of it.

    A read of system memory and a corrected bit set flags; a debugger leaves a bank open.
    """
    n_words = (len(table) + 31) // 32
    chip = started.chip
    chip.flash.noise = RDPERR | RDSERR | SNECCERR
    until_dark(started, 2 + n_words, lambda: started.remote.use(named(table, "second")))
    assert chip.resets.count("power_on") == 2
    assert table_in_use(started) == "short skirt"
    chip.flash.v["cr0"] &= ~LOCK
    started.remote.use(named(table, "third"))
    assert restart(started) == "third"


@pytest.mark.long
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


@pytest.mark.long
def test_programmer_takes_the_place_back(started: Session, table: bytes) -> None:
    """After downloads, what tools/flash writes is in use: the table, and its record in the log."""
    started.remote.use(named(table, "second"))
    started.board.write_table(named(table, "flashed"))
    started.chip.write_flash(LOG, b"\xff" * SECTOR_BYTES)
    started.chip.write_flash(LOG, FIRST_PLACE.read_bytes())
    assert restart(started) == "flashed"


def test_tick_goes_on_while_flash_is_busy(started: Session, table: bytes) -> None:
    """No tick is lost or late in a download; commands are answered after the erase.

    A table that does not fit the smaller place is refused before.
    """
    chip, board = started.chip, started.board
    assert started.remote.command(BEGIN, value=LOG - OTHER + 1)[0] == ERR["download_room"]
    n, at = len(board.ticks), chip.clock.now
    started.remote.do(BEGIN, value=LOG - OTHER)
    assert started.remote.block(0, table[:4096]) == 0
    passed = (chip.clock.now - at) * 20_000 // chip.rcc.core_hz()
    assert passed > 3 * 40
    assert abs(len(board.ticks) - n - passed) <= 1
    assert started.remote.status().faults == ()


def test_parameters_are_kept_when_the_supply_falls(started: Session) -> None:
    """Cut in the seal: the old ones; whole: the new ones, also by revert."""
    assert newest(started, "params") == "no parameters are kept - defaults in use"
    started.remote.set("lead_ns", 61_000)
    started.remote.do(SAVE)
    kept = started.chip.read_memory(PARAMS_LOG, SECTOR_BYTES)
    assert b"\nlead_ns = 61000\n" in kept
    n_words = len(kept.rstrip(b"\xff")) // RECORD_BYTES  # the seal is the last of them
    started.remote.set("lead_ns", 62_000)
    until_dark(started, n_words, lambda: started.remote.do(SAVE))
    assert started.remote.command(GET, LEAD) == (0, 61_000)
    assert newest(started, "params").startswith("version 1 in use")
    started.remote.set("lead_ns", 63_000)
    started.remote.do(SAVE)
    started.remote.set("lead_ns", 64_000)
    started.remote.do(REVERT)
    assert started.remote.command(GET, LEAD) == (0, 63_000)
