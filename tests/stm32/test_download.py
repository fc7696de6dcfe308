# SPDX-License-Identifier: Apache-2.0
"""Tables and parameters come over the bus into flash, and the supply falls on the way.

A table goes into the place that is not in use. tests/unit/stm32/test_stm_params.c interrupts the
log of the parameters at every operation; here the image itself is interrupted: in the first word,
in the seal, and in the erase before the log goes round.
"""

import struct
import zlib
from collections.abc import Callable

import pytest

from camtools.cli.flash import FIRST_PLACE
from tests.stm32.host import IMAGE, short_table
from tests.stm32.image import Image
from tests.stm32.models.fdcan import Frame
from tests.stm32.models.flash_pwr import (
    LOCK,
    RDPERR,
    RDSERR,
    SECTOR_BYTES,
    SNECCERR,
    SYSTEM_MEMORY,
)
from tests.stm32.remote import (
    BEGIN,
    COMMAND,
    ENABLE,
    GET,
    PARAMS,
    REVERT,
    SAVE,
    SELECT,
    TO_CONTROLLER,
    errors,
)
from tests.stm32.session import Session

OTHER, LOG, TABLE = 0x08040000, 0x080E0000, 0x08100000
PARAMS_LOG = 0x081C0000
MAGIC, PARAMS_MAGIC, RECORD_BYTES = 0x4C424154, 0x4D524150, 32
LEAD = PARAMS.index("lead_ns")
MOST_BOOT_BYTES = 512
BOOT = {"stm_reset", "stm_boot_fill", "on_boot_fault"}
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


def record(name: int, number: int, magic: int = MAGIC) -> bytes:
    """Return a record of the log that names a place."""
    words = (magic, name, number)
    return struct.pack("<8I", *words, *(~word & 0xFFFFFFFF for word in words), 0, 0)


def params_record(text: bytes, number: int) -> bytes:
    """Return a record of the log of parameters: text, filled up to flash words, and its seal."""
    return text + b"\xff" * (-len(text) % RECORD_BYTES) + record(number, len(text), PARAMS_MAGIC)


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


def until_dark(session: Session, operation: int, act: Callable[[], None]) -> None:
    """Act until the supply falls in an operation of the flash, and wait for the next start."""
    n = len(session.chip.resets)
    session.chip.flash.left = operation
    try:
        act()
    except AssertionError:
        assert len(session.chip.resets) > n, "refused, but not for want of power"
    session.remote.started()


@pytest.mark.parametrize("operation", [1, 100, "commit"])
def test_power_lost_on_the_way_leaves_the_old_table(
    started: Session, table: bytes, operation: int | str
) -> None:
    """In the erase, in programming, in the record itself: old table, and the next one works."""
    n_words = (len(table) + 31) // 32
    chip = started.chip
    at = 2 + n_words if operation == "commit" else int(operation)
    until_dark(started, at, lambda: started.remote.use(named(table, "second")))
    assert chip.resets.count("power_on") == 2
    assert table_in_use(started) == "short skirt"
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


def test_parameters_are_kept_whenever_the_supply_falls(started: Session) -> None:
    """Cut in the first word and in the seal: the old ones; whole: the new ones."""
    assert newest(started, "params") == "no parameters are kept - defaults in use"
    started.remote.set("lead_ns", 61_000)
    started.remote.do(SAVE)
    text = started.chip.read_memory(PARAMS_LOG, SECTOR_BYTES).split(b"\ncrc32", 1)[0].decode()
    assert "\nlead_ns = 61000\n" in text
    n_words = len(params_record(text.encode() + b"\ncrc32 = 0123456789\n", 1)) // RECORD_BYTES
    for operation in (1, n_words):
        started.remote.set("lead_ns", 62_000)
        until_dark(started, operation, lambda: started.remote.do(SAVE))
        assert started.remote.command(GET, LEAD) == (0, 61_000)
        assert newest(started, "params").startswith("version 1 in use")
    started.remote.set("lead_ns", 63_000)
    started.remote.do(SAVE)
    started.remote.set("lead_ns", 64_000)
    started.remote.do(REVERT)
    assert started.remote.command(GET, LEAD) == (0, 63_000)


def test_log_goes_round_and_survives_a_cut_erase(started: Session) -> None:
    """The sector is full: the other one is erased; cut there, the newest of the full one counts."""
    body = b"version = 9\nlead_ns = 71000\n"
    text = body + f"crc32 = {zlib.crc32(body)}\n".encode()
    one = params_record(text, 1)
    n = SECTOR_BYTES // len(one)
    started.chip.write_flash(PARAMS_LOG, b"".join(params_record(text, i + 1) for i in range(n)))
    started.chip.write_flash(PARAMS_LOG + SECTOR_BYTES, params_record(b"old", 0) * 3)
    restart(started)
    assert "not among those kept" in newest(started, "params")
    until_dark(started, 1, lambda: started.remote.do(SAVE))
    assert started.remote.command(GET, LEAD) == (0, 71_000)
    started.remote.set("lead_ns", 72_000)
    started.remote.do(SAVE)
    restart(started)
    assert started.remote.command(GET, LEAD) == (0, 72_000)
    assert b"\nlead_ns = 72000\n" in started.chip.read_memory(
        PARAMS_LOG + SECTOR_BYTES, SECTOR_BYTES
    )


def test_core_reads_ahead_neither_in_system_memory_nor_in_the_code_in_flash(
    started: Session,
) -> None:
    """The protection unit forbids both; tables are read ahead, which is what the cache is for."""
    mpu = started.chip.nvic.mpu
    forbidden = [SYSTEM_MEMORY + i for i in range(0, 1 << 20, 1 << 16)]
    forbidden += [0x08000000 + i for i in range(0, 2 << 17, 1 << 14)]
    assert mpu.invites(0x08000000 + (2 << 17))
    assert not any(mpu.invites(address) for address in forbidden)
    assert mpu.invites(TABLE)


def test_download_outlives_flags_that_are_no_errors_of_its_own(started: Session) -> None:
    """A read of system memory and a corrected bit set flags; flash is written all the same."""
    started.chip.flash.noise = RDPERR | RDSERR | SNECCERR
    started.remote.use(short_table().read_bytes())


def test_keys_are_given_to_a_locked_bank_only(started: Session) -> None:
    """A bank that is open already, as a debugger leaves it, is used as it is."""
    started.chip.flash.v["cr0"] &= ~LOCK
    started.remote.do(BEGIN, value=4096)


@pytest.mark.parametrize("torn_at", [0, 64, 4096])
def test_torn_table_is_refused_and_the_next_is_used(started: Session, torn_at: int) -> None:
    """A programmer was interrupted: words that cannot be read end the table, not the controller."""
    started.chip.flash.tear({TABLE + torn_at})
    started.board.power_on()
    status = started.remote.started()
    assert status.state == "off"
    assert status.table < 0
    assert started.remote.command(ENABLE)[0] == status.table
    assert started.chip.resets == ["power_on"] * 2
    if torn_at == 64:
        started.remote.use(short_table().read_bytes())
        assert started.remote.status().table == 0


def test_only_the_start_up_lies_in_flash() -> None:
    """Neither main() nor the main loop: flash may be erased while they run."""
    image = Image(IMAGE)
    assert image.functions[".boot"] == BOOT
    assert image.sizes[".boot"] <= MOST_BOOT_BYTES
