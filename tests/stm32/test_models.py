# SPDX-License-Identifier: Apache-2.0
"""The device models: what they must refuse, by themselves and in a chip."""

import pytest

from tests.stm32.emulator import Chip
from tests.stm32.host import IMAGE
from tests.stm32.image import Image
from tests.stm32.models.bus import InsnClock, UnmodelledError
from tests.stm32.models.flash_pwr import Flash, Pwr, Syscfg
from tests.stm32.models.pulse_timer import PulseTimer
from tests.stm32.models.rcc import Rcc
from tests.stm32.models.wwdg import Wwdg

RCR, CCR1, BDTR = 0x30, 0x34, 0x44
CR1, CCMR1, CCER, ARR, EGR = 0x00, 0x18, 0x20, 0x2C, 0x14


@pytest.fixture
def clock() -> InsnClock:
    """Return a clock at 0."""
    return InsnClock(0, 0, None)


@pytest.fixture
def rcc(clock: InsnClock) -> Rcc:
    """Return a clock tree behind power-on: everything at 64 MHz."""
    rcc = Rcc(clock, 8_000_000)
    rcc.restart("power_on")
    return rcc


def put(timer: PulseTimer, values: dict[int, int]) -> None:
    """Store registers in order."""
    for offset, value in values.items():
        timer.write(offset, 4, value)


@pytest.fixture
def pulses(clock: InsnClock, rcc: Rcc) -> PulseTimer:
    """Return a pulse timer whose output rests low: PWM 2, nothing counted yet."""
    timer = PulseTimer(clock, rcc, "tim16", 0x40014400)
    put(timer, {CR1: 0xC, CCR1: 0xFFFF, CCMR1: 0x70, CCER: 1, BDTR: 0x8000})
    return timer


def test_a_train_is_not_made_otherwise(clock: InsnClock, rcc: Rcc, pulses: PulseTimer) -> None:
    """Repetitions count from UG on, a resting output may be high, and trains are not changed."""
    edges: list[tuple[int, int]] = []
    pulses.on_edge = lambda at, level: edges.append((at, level))
    put(pulses, {ARR: 99, CCR1: 60, EGR: 1, RCR: 2, CR1: 0xD})
    with pytest.raises(UnmodelledError, match="ccr1 written in a train"):
        pulses.write(CCR1, 4, 50)
    clock.now = 1000
    pulses.advance()
    assert len(edges) == 2  # RCR came behind UG
    with pytest.raises(UnmodelledError, match="pulses without end"):
        pulses.write(CR1, 4, 5)
    bare = PulseTimer(clock, rcc, "tim17", 0x40014800)
    bare.on_edge = lambda at, level: edges.append((at, level))
    put(bare, {CR1: 0xC, CCMR1: 0x70, CCER: 1, BDTR: 0x8000})
    assert edges[2:] == [(1000, 1)]  # CCR1 is 0


def test_clock_tree_refuses_what_the_manual_forbids(rcc: Rcc) -> None:
    """A switch to a clock that is off, an unknown bit, a PLL changed while it runs."""
    with pytest.raises(UnmodelledError, match="not ready"):
        rcc.write(0x10, 4, 3)
    with pytest.raises(UnmodelledError, match="nobody models bits"):
        rcc.write(0x10, 4, 1 << 22)
    rcc.write(0x28, 4, 0x0202_0080)  # HSI / 8
    rcc.write(0x00, 4, rcc.read(0x00, 4) | 1 << 24)
    with pytest.raises(UnmodelledError, match="while PLL1 is on"):
        rcc.write(0x30, 4, 119)


def settle(pwr: Pwr) -> None:
    """Let the voltage settle."""
    pwr.clock.now = pwr.due
    pwr.advance()


def test_supply_and_flash_limit_the_clock(clock: InsnClock) -> None:
    """480 MHz needs the boost, 240 MHz at the flash four wait states."""
    syscfg, flash = Syscfg(clock), Flash(clock)
    pwr = Pwr(clock, syscfg)
    pwr.write(0x0C, 4, 2)
    with pytest.raises(UnmodelledError, match="before the voltage is valid"):
        pwr.write(0x18, 4, 3 << 14)
    settle(pwr)
    pwr.write(0x18, 4, 3 << 14)
    assert not pwr.read(0x18, 4) >> 13 & 1
    settle(pwr)
    assert pwr.read(0x18, 4) >> 13 & 1
    with pytest.raises(UnmodelledError, match="voltage scale 1"):
        pwr.check(480_000_000)
    syscfg.write(0x2C, 4, 1)
    with pytest.raises(UnmodelledError, match="read it back"):
        pwr.read(0x18, 4)
    assert syscfg.read(0x2C, 4) == 1
    with pytest.raises(UnmodelledError, match="voltage scale 1"):
        pwr.check(480_000_000)
    settle(pwr)
    pwr.check(480_000_000)
    flash.write(0x00, 4, 0x23)
    with pytest.raises(UnmodelledError, match=r"acr 0x23"):
        flash.check(240_000_000, pwr.scale())
    flash.write(0x00, 4, 0x24)
    flash.check(240_000_000, pwr.scale())


def test_window_watchdog_bites_late_and_early(clock: InsnClock, rcc: Rcc) -> None:
    """Six steps of 4096 clocks of APB3; fed within the first of them, at once."""
    bites: list[int] = []
    wwdg = Wwdg(clock, rcc, lambda: bites.append(clock.now))
    with pytest.raises(UnmodelledError, match="without its clock"):
        wwdg.write(0, 4, 0xC5)
    rcc.write(0xE4, 4, 1 << 6)
    with pytest.raises(UnmodelledError, match="WW1RSC"):
        wwdg.write(0, 4, 0xC5)
    rcc.write(0xA0, 4, 1)
    wwdg.write(4, 4, 0x44)
    wwdg.write(0, 4, 0xC5)
    assert wwdg.due == 6 * 4096
    clock.now = 4096
    assert wwdg.read(0, 4) == 0xC4
    wwdg.write(0, 4, 0xC5)
    assert wwdg.due == 7 * 4096
    clock.now = wwdg.due
    wwdg.advance()
    assert bites == [7 * 4096]
    clock.now += 1
    wwdg.reset()
    wwdg.write(4, 4, 0x44)
    wwdg.write(0, 4, 0xC5)
    clock.now += 4095
    wwdg.write(0, 4, 0xC5)
    assert bites[1:] == [clock.now]


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
def test_unknown_addresses_end_the_run(address: int, why: str) -> None:
    """What no model knows fails with the address and the place in the code."""
    chip = Chip(Image(IMAGE), hse_hz=8_000_000)
    chip.power_on()
    load = b"\x00\x48\x00\x68"  # ldr r0, [pc]; ldr r0, [r0]; the word after them is loaded first
    chip.put_instructions(
        chip.pc, b"\x00\xbf" * (chip.pc // 2 % 2) + load + address.to_bytes(4, "little")
    )
    with pytest.raises(UnmodelledError, match=f"{why}.*0x{address:08x}.*stm_reset"):
        chip.run(10)
