# SPDX-License-Identifier: Apache-2.0
"""Parameters are kept in flash, and the supply falls while they are.

tests/unit/stm32/test_stm_params.c interrupts the log at every operation; here the image itself
is interrupted: in the first word, in the seal, and in the erase before the log goes round.
"""

import struct
import zlib

from tests.stm32.models.flash_pwr import SECTOR_BYTES
from tests.stm32.remote import GET, PARAMS, REVERT, SAVE
from tests.stm32.session import Session

LOG, WORD = 0x081C0000, 32
MAGIC = 0x4D524150
LEAD = PARAMS.index("lead_ns")


def told(session: Session) -> str:
    """Return the newest line about the parameters."""
    return [line for line in session.remote.lines() if line.startswith("params: ")][-1]


def restart(session: Session) -> None:
    """Switch the supply off and on."""
    session.board.power_on()
    session.remote.started()


def save_until_dark(session: Session, operation: int) -> None:
    """Save until the supply falls."""
    n = len(session.chip.resets)
    session.chip.flash.left = operation
    try:
        session.remote.do(SAVE)
    except AssertionError:
        assert len(session.chip.resets) > n, "the save failed, but not for want of power"
    session.remote.started()


def record(text: bytes, number: int) -> bytes:
    """Return a record of the log: text, filled up to flash words, and its seal."""
    words = (MAGIC, number, len(text))
    seal = struct.pack("<8I", *words, *(~word & 0xFFFFFFFF for word in words), 0, 0)
    return text + b"\xff" * (-len(text) % WORD) + seal


def test_parameters_are_kept_whenever_the_supply_falls(started: Session) -> None:
    """Cut in the first word and in the seal: the old ones; whole: the new ones."""
    session = started
    assert told(session) == "params: no parameters are kept - defaults in use"
    session.remote.set("lead_ns", 61_000)
    session.remote.do(SAVE)
    text = session.chip.read_memory(LOG, SECTOR_BYTES).split(b"\ncrc32", 1)[0].decode()
    assert "\nlead_ns = 61000\n" in text
    n_words = len(record(text.encode() + b"\ncrc32 = 0123456789\n", 1)) // WORD
    for operation in (1, n_words):
        session.remote.set("lead_ns", 62_000)
        save_until_dark(session, operation)
        assert session.remote.command(GET, LEAD) == (0, 61_000)
        assert told(session).startswith("params: version 1 in use")
    session.remote.set("lead_ns", 63_000)
    session.remote.do(SAVE)
    session.remote.set("lead_ns", 64_000)
    session.remote.do(REVERT)
    assert session.remote.command(GET, LEAD) == (0, 63_000)


def test_log_goes_round_and_survives_a_cut_erase(started: Session) -> None:
    """The sector is full: the other one is erased; cut there, the newest of the full one counts."""
    session = started
    body = b"version = 9\nlead_ns = 71000\n"
    text = body + f"crc32 = {zlib.crc32(body)}\n".encode()
    one = record(text, 1)
    n = SECTOR_BYTES // len(one)
    session.chip.write_flash(LOG, b"".join(record(text, i + 1) for i in range(n)))
    session.chip.write_flash(LOG + SECTOR_BYTES, record(b"old", 0) * 3)
    restart(session)
    assert "not among those kept" in told(session)
    save_until_dark(session, 1)
    assert session.remote.command(GET, LEAD) == (0, 71_000)
    session.remote.set("lead_ns", 72_000)
    session.remote.do(SAVE)
    restart(session)
    assert session.remote.command(GET, LEAD) == (0, 72_000)
    assert b"\nlead_ns = 72000\n" in session.chip.read_memory(LOG + SECTOR_BYTES, SECTOR_BYTES)
