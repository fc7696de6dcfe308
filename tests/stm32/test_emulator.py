# SPDX-License-Identifier: Apache-2.0
"""The emulator itself: its core and clock by little images, its models register by register."""

from pathlib import Path

import pytest

from tests.stm32.emulator import Chip
from tests.stm32.image import Image
from tests.stm32.image_build import build_image
from tests.stm32.models.bus import UnmodelledError
from tests.stm32.models.rcc import RESET_FLAGS


def chip_of(name: str, folder: Path, *, hse_hz: int = 8_000_000) -> Chip:
    """Return a chip with a little image, switched on."""
    chip = Chip(Image(build_image(name, folder)), hse_hz=hse_hz)
    chip.power_on()
    return chip


def answers(chip: Chip) -> list[int]:
    """Return what the image has to say."""
    raw = chip.read_memory(chip.image.symbols["answer"], 64)
    return [int.from_bytes(raw[i : i + 4], "little") for i in range(0, 64, 4)]


def test_interrupted_sums_are_right(tmp_path: Path) -> None:
    """Interrupts between any two instructions spoil neither flags, conditions nor floats."""
    chip = chip_of("image_interrupts", tmp_path)
    chip.run(1_000_000)
    rounds, _, n_interrupts, number, wrong, *_ = answers(chip)
    assert rounds > 50
    assert n_interrupts == pytest.approx(1_000_000 / 98, rel=0.02)
    assert number == 16 + 30
    assert wrong == 0


def test_reset_keeps_memory_and_flags(tmp_path: Path) -> None:
    """A reset by software keeps RAM, and adds its flag to those of power-on."""
    chip = chip_of("image_reset", tmp_path)
    chip.run(2000)
    assert chip.resets == ["power_on", "software"]
    assert answers(chip)[:2] == [RESET_FLAGS["power_on"] | RESET_FLAGS["software"], 0x600DC0DE]
    chip.run(50_000)
    chip.reset("brown_out")
    chip.run(2000)
    assert answers(chip)[:2] == [RESET_FLAGS["brown_out"], 0x600DC0DE]
    chip.power_on()  # memory is lost, so the image begins as at first
    chip.run(2000)
    assert chip.resets[-3:] == ["brown_out", "power_on", "software"]


def test_masked_interrupts_wait_and_sleep_ends(tmp_path: Path) -> None:
    """PRIMASK holds the tick back; afterwards each tick ends one sleep."""
    chip = chip_of("image_reset", tmp_path)
    chip.run(200_000)
    before = answers(chip)
    assert before[4] == 0
    chip.run(100_000)
    after = answers(chip)
    assert after[3] - before[3] == 100
    assert after[5] - before[5] == 100


def test_lost_oscillator_raises_the_nmi(tmp_path: Path) -> None:
    """The clock security system reports once."""
    chip = chip_of("image_reset", tmp_path)
    chip.run(100_000)
    chip.rcc.fail_hse()
    chip.run(1000)
    assert answers(chip)[2] == 1
    assert chip.rcc.core_hz() == 64_000_000


@pytest.mark.parametrize(
    ("address", "why"),
    [
        (0x40001000, "no device"),  # TIM6
        (0x58024404, "no register"),  # RCC_HSICFGR
        (0x40000800, "without its clock"),  # TIM4
        (0x30000000, "no memory"),  # SRAM1
        (0x00000010, "null pointer"),
    ],
)
def test_unknown_addresses_end_the_run(tmp_path: Path, address: int, why: str) -> None:
    """What no model knows fails with the address and the place in the code."""
    chip = chip_of("image_peek", tmp_path)
    chip.write_memory(chip.image.symbols["peek_at"], address.to_bytes(4, "little"))
    with pytest.raises(UnmodelledError, match=f"{why}.*0x{address:08x}.*image_main"):
        chip.run(2000)
