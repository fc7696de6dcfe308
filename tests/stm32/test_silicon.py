# SPDX-License-Identifier: Apache-2.0
"""What silicon does beside the sequence of a manual: reads ahead, stores on their way, torn words.

A start or a download shows some of it as an error of a model; the rest is told apart here.
"""

import pytest

from tests.stm32.board import TABLE
from tests.stm32.host import IMAGE, short_table
from tests.stm32.image import Image
from tests.stm32.models.flash_pwr import LOCK, RDPERR, RDSERR, SNECCERR, SYSTEM_MEMORY
from tests.stm32.remote import BEGIN, ENABLE
from tests.stm32.session import Session

MIDDLE = 2048  # of the internal DAC: U = 0
MOST_BOOT_BYTES = 512
BOOT = {"stm_reset", "stm_boot_fill", "on_boot_fault"}


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


def test_u_of_the_internal_converter_begins_in_the_middle(started: Session) -> None:
    """PA4 floats until it shows the middle: 0 V would be full negative U."""
    codes = [code for _, code in started.board.at_pa4]
    assert MIDDLE in codes
    shown = started.board.at_pa4[: codes.index(MIDDLE) + 1]
    first = next(at for at, code in shown if code is not None)
    assert shown[-1][0] - first < started.chip.seconds(1e-6)
    assert set(codes[codes.index(MIDDLE) :]) == {MIDDLE}


def test_select_of_the_converter_is_high_long_enough(started: Session) -> None:
    """Seven clocks of 50 ns between two frames, where its data sheet asks for 100 ns."""
    assert started.chip.spi3.select_high_s() == pytest.approx(350e-9)


def test_trace_output_is_let_go_at_once(started: Session) -> None:
    """PB3 is the trace's output after a reset; a receiver of the spindle's B drives it."""
    started.board.power_on()
    port, pin = started.chip.gpio.pin("PB3")
    assert port.function(pin) == 0
    assert started.chip.run_until(lambda: port.function(pin) is None, 200)


def test_only_the_start_up_lies_in_flash() -> None:
    """Neither main() nor the main loop: flash may be erased while they run."""
    image = Image(IMAGE)
    assert image.functions[".boot"] == BOOT
    assert image.sizes[".boot"] <= MOST_BOOT_BYTES
