# SPDX-License-Identifier: Apache-2.0
"""The device models by themselves: numbers of the manuals, and what they must refuse."""

from __future__ import annotations

import pytest

from tests.stm32.models.bus import InsnClock, UnmodelledError
from tests.stm32.models.fdcan import Ccu, Fdcan, Frame, MessageRam
from tests.stm32.models.flash_pwr import Flash, Pwr, Syscfg
from tests.stm32.models.gpio import Gpio
from tests.stm32.models.iwdg import Iwdg
from tests.stm32.models.pulse_timer import PulseTimer
from tests.stm32.models.rcc import Rcc
from tests.stm32.models.spi_dac import Ad5754r
from tests.stm32.models.stepper import Stepper
from tests.stm32.models.timers import Timer
from tests.stm32.models.wwdg import Wwdg

RCR, CCR1, BDTR = 0x30, 0x34, 0x44
CR1, SMCR, SR, CCMR1, CCMR2, CCER, CNT, PSC, ARR, EGR, CCR3, CCR4 = (
    0x00,
    0x08,
    0x10,
    0x18,
    0x1C,
    0x20,
    0x24,
    0x28,
    0x2C,
    0x14,
    0x3C,
    0x40,
)


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


def put(timer: Timer | PulseTimer, values: dict[int, int]) -> None:
    """Store registers in order."""
    for offset, value in values.items():
        timer.write(offset, 4, value)


def test_timer_divides_and_compares(clock: InsnClock, rcc: Rcc) -> None:
    """Prescaler 4, period 100, PWM 2 active low from 60 on: edges at 240 and 400 cycles."""
    timer = Timer(clock, rcc, "tim4", 0x40000800)
    edges: list[tuple[int, int]] = []
    timer.on_output = lambda channel, level: edges.append((clock.now, level))
    put(timer, {PSC: 3, ARR: 99, CCR3: 60, CCMR2: 0x70, EGR: 1, CCER: 0x300, CR1: 1})
    edges.clear()
    for _ in range(4):
        clock.now = timer.next_event()
        timer.advance()
    assert edges == [(240, 0), (400, 1), (640, 0), (800, 1)]
    assert timer.v["sr"] & 1
    clock.now += 42
    assert timer.read(CNT, 4) == 10


def test_timer_counts_and_captures_an_encoder(clock: InsnClock, rcc: Rcc) -> None:
    """Both senses, wrap, captures of both edges of one input, the flag of a missed one."""
    timer = Timer(clock, rcc, "tim2", 0x40000000, bits=32)
    put(timer, {CCMR1: 0x0101, CCMR2: 0x0201, CCER: 0x3100, SMCR: 3, CR1: 1})
    timer.move_encoder(-5)
    assert timer.read(CNT, 4) == 2**32 - 5
    assert timer.read(CR1, 4) == 0x11
    timer.input_edge(3, 1)
    timer.move_encoder(12)
    timer.input_edge(3, 0)
    assert (timer.read(CCR3, 4), timer.read(CCR4, 4)) == (2**32 - 5, 7)
    assert timer.read(SR, 4) & 0x18 == 0
    timer.input_edge(3, 1)
    timer.input_edge(3, 1)
    assert timer.captures_missed == 1
    assert timer.read(SR, 4) & 0x808 == 0x808
    timer.write(CCER, 4, 0x3120)  # CC2P: the other sense
    timer.move_encoder(3)
    assert timer.read(CNT, 4) == 4


@pytest.fixture
def pulses(clock: InsnClock, rcc: Rcc) -> PulseTimer:
    """Return a pulse timer whose output rests low: PWM 2, nothing counted yet."""
    timer = PulseTimer(clock, rcc, "tim16", 0x40014400)
    put(timer, {CR1: 0xC, CCR1: 0xFFFF, CCMR1: 0x70, CCER: 1, BDTR: 0x8000})
    return timer


def test_a_train_has_as_many_pulses_as_are_repeated(clock: InsnClock, pulses: PulseTimer) -> None:
    """Three periods of 100, high in the last 40 of each; then the counter rests."""
    edges: list[tuple[int, int]] = []
    pulses.on_edge = lambda at, level: edges.append((at, level))
    put(pulses, {RCR: 2, ARR: 99, CCR1: 60, EGR: 1, CR1: 0xD})
    clock.now = 130
    assert pulses.read(CR1, 4) == 0xD
    assert edges == [(60, 1), (100, 0)]
    clock.now = pulses.next_event()
    pulses.advance()
    assert edges[2:] == [(160, 1), (200, 0), (260, 1), (300, 0)]
    assert pulses.read(CR1, 4) == 0xC


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


def test_a_drive_counts_pulses_while_it_is_enabled() -> None:
    """Edges up and down, both senses, and the shortest times between them."""
    stepper = Stepper()
    stepper.turn(0, 1)
    for at in (100, 200, 300):
        stepper.step(at, 1, is_enabled=at < 300)
        stepper.step(at + 40, 0, is_enabled=True)
    stepper.turn(350, 0)
    stepper.step(500, 1, is_enabled=True)
    assert (stepper.position, stepper.n_ignored) == (1, 1)
    times = stepper.shortest
    assert (times.high, times.low, times.setup, times.hold) == (40, 60, 100, 10)


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
    pwr.clock.now = pwr.next_event()
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


def test_watchdog_bites_once_nobody_comes(clock: InsnClock, rcc: Rcc) -> None:
    """Prescaler 8 and reload 4000 on 32 kHz: a second and a quarter of a millisecond."""
    bites: list[int] = []
    iwdg = Iwdg(clock, rcc, lambda: bites.append(clock.now))
    with pytest.raises(UnmodelledError, match="without its key"):
        iwdg.write(0x08, 4, 4000)
    for offset, value in ((0, 0xCCCC), (0, 0x5555), (4, 1), (8, 4000), (0, 0xAAAA)):
        iwdg.write(offset, 4, value)
    clock.now = iwdg.next_event()
    iwdg.advance()
    assert bites == [64_000_000 * 4001 // 4000]


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
    assert wwdg.next_event() == 6 * 4096
    clock.now = 4096
    assert wwdg.read(0, 4) == 0xC4
    wwdg.write(0, 4, 0xC5)
    assert wwdg.next_event() == 7 * 4096
    clock.now = wwdg.next_event()
    wwdg.advance()
    assert bites == [7 * 4096]
    clock.now += 1
    wwdg.reset()
    wwdg.write(4, 4, 0x44)
    wwdg.write(0, 4, 0xC5)
    clock.now += 4095
    wwdg.write(0, 4, 0xC5)
    assert bites[1:] == [clock.now]


def test_pins_follow_mode_and_resistors(clock: InsnClock) -> None:
    """Analogue after reset, the board's resistor before the chip's, a driven one before both."""
    gpio = Gpio(clock)
    port, pin = gpio.pin("PE13")
    assert port.mode(pin) == 3
    port.board_pull[pin] = 1
    assert gpio.level("PE13") == 1
    port.write(0x18, 4, 1 << (16 + pin))
    port.write(0x00, 4, (0xFFFFFFFF & ~(3 << 2 * pin)) | 1 << 2 * pin)
    assert gpio.level("PE13") == 0
    port.write(0x18, 4, 1 << pin)
    assert gpio.level("PE13") == 1


def test_converter_takes_over_with_ldac() -> None:
    """Input registers wait for the falling edge; read-back comes with the next frame."""
    dac = Ad5754r()
    dac.ldac(1)
    dac.exchange(0x0C0004, 24)
    dac.exchange(0x10001F, 24)
    dac.exchange(0x02BEEF, 24)
    assert (dac.words, dac.ranges) == ([0, 0, 0, 0], [4, 4, 4, 4])
    assert all(dac.is_on(channel) for channel in range(4))
    dac.ldac(0)
    assert dac.words == [0, 0, 0xBEEF, 0]
    dac.exchange(0x820000, 24)
    assert dac.exchange(0x180000, 24) & 0xFFFF == 0xBEEF
    with pytest.raises(UnmodelledError):
        dac.exchange(0x02BEEF, 16)
    with pytest.raises(UnmodelledError):
        dac.exchange(0x0C0006, 24)  # no such range


@pytest.mark.parametrize(
    ("element", "accepted"),
    [
        (0 << 30 | 1 << 27 | 0x100 << 16 | 0x1FF, {0x100, 0x1FF}),  # range
        (1 << 30 | 1 << 27 | 0x640 << 16 | 0x000, {0x640, 0x000}),  # two identifiers
        (2 << 30 | 1 << 27 | 0x640 << 16 | 0x7F0, {0x640, 0x64F}),  # mask
        (3 << 30 | 1 << 27, set()),  # off
    ],
)
def test_bus_filters(clock: InsnClock, rcc: Rcc, element: int, accepted: set[int]) -> None:
    """The kinds of standard filters, what matches none rejected; a full FIFO loses the newest."""
    ram = MessageRam(clock)
    ccu = Ccu(clock)
    can = Fdcan(clock, rcc, ram, ccu)
    can.write(0x18, 4, 3)
    with pytest.raises(UnmodelledError, match="nobody has calibrated"):
        can.write(0x18, 4, 0)
    can.write(0x18, 4, 3)
    ccu.write(0x04, 4, 1 << 6)
    can.write(0x80, 4, 0x3F)
    can.write(0x84, 4, 1 << 16 | 0)
    can.write(0xA0, 4, 2 << 16 | 4)
    ram.write(0, 4, element)
    can.write(0x18, 4, 0)
    with pytest.raises(UnmodelledError, match="without CCE"):
        can.write(0x80, 4, 0)
    tried = (0x000, 0x0FF, 0x100, 0x1FF, 0x200, 0x640, 0x64F, 0x650)
    assert {i for i in tried if can.deliver(Frame(i, b"\1\2\3"))} == accepted
    if accepted:
        assert can.read(0xA4, 4) & 0x7F == 2
        assert not can.deliver(Frame(max(accepted), b""))
        assert can.lost == 1
        can.write(0xA8, 4, 0)
        with pytest.raises(UnmodelledError, match="is due"):
            can.write(0xA8, 4, 0)
