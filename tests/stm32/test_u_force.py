# SPDX-License-Identifier: Apache-2.0
"""U by force: an image built with BOARD_U_FORCE_MN, its loop closed around a mass, in a cut."""

from dataclasses import dataclass, field

import pytest

from tests.stm32.board import FORCE_MN, LIMITS, signed16
from tests.stm32.host import build_with
from tests.stm32.remote import ENABLE
from tests.stm32.session import Session

pytestmark = pytest.mark.long  # it builds an image
CYCLES_PER_US = 480
TIM1_CNT = 0x24
LATENCY_US = 2.5  # BOARD_FORCE_NS
FORCE_DELAY_NS = 27_500  # and half a tick of hold
LIMIT_LOW, LIMIT_HIGH = 0x800, 0x1000  # hal.h
PARAMETERS = {
    "u_acceleration_mm_per_s2": 200_000,
    "servo_force_limit_mn": 340_000,
    "servo_force_delay_ns": FORCE_DELAY_NS,
    "servo_crossover_hz": 400,
    "lead_ns": 50_000 + FORCE_DELAY_NS,
}


@dataclass
class Meter:
    """Instants [cycles] of each tick's latch of U's scale and of what the converter receives."""

    latched: int = 0
    delays: list[int] = field(default_factory=list)
    order: list[list[int]] = field(default_factory=list)

    def connect(self, session: Session) -> None:
        """Watch the counter of U's scale and the AD5754R."""
        chip, dac, timer = session.chip, session.board.dac, session.chip.tim[1]
        read, exchange = timer.read, dac.exchange

        def latch(offset: int, size: int) -> int:
            if offset == TIM1_CNT:
                self.latched = chip.clock.now
                self.order.append([])
            return read(offset, size)

        def take(frame: int, bits: int) -> int:
            back = exchange(frame, bits)
            channel = frame >> 16
            if self.order:
                self.order[-1].append(channel)
            if channel == 0:
                self.delays.append(chip.clock.now - self.latched)
                assert not session.chip.gpio.level("PE13") or dac.words[0] == frame & 0xFFFF
            return back

        timer.read = latch  # type: ignore[method-assign]
        dac.exchange = take  # type: ignore[method-assign]


@pytest.fixture(scope="module")
def cut() -> tuple[Session, Meter]:
    """Return a session from power-on through a cut, its U a mass that the image's forces move."""
    session = Session(image=build_with("BOARD_U_FORCE_MN", str(FORCE_MN)))
    session.board.has_u_force = True
    session.start()
    session.set_up()
    for name, value in PARAMETERS.items():
        session.remote.set(name, value)
    session.remote.do(ENABLE)
    session.remote.wait_for("ready", 1.0)
    session.turn_spindle()
    meter = Meter()
    meter.connect(session)
    session.cut()
    return session, meter


def test_loop_is_closed_through_the_port(cut: tuple[Session, Meter]) -> None:
    """U follows the table without a fault; its forces are those of its acceleration."""
    session, _ = cut
    assert session.remote.newest().faults == ()
    in_cut = [
        record
        for record, seen in zip(session.records, session.board.ticks[1:], strict=False)
        if seen.in_cut
    ]
    assert len(in_cut) > 1000
    assert max(abs(record["u_nm"]) for record in in_cut) > 50_000
    off = [
        abs(after["u_nm"] - before["out_u_nm"])
        for before, after in zip(in_cut, in_cut[2:], strict=False)
    ]
    assert max(off) < 1000
    assert max(abs(record["force_q6"]) for record in in_cut) > 64 * 10_000


def test_voltage_is_the_force(cut: tuple[Session, Meter]) -> None:
    """Nearest code of 345 N at +10 V in every tick; 0 V while enable is low."""
    session, _ = cut
    for record, seen in zip(session.records, session.board.ticks[1:], strict=False):
        mn = signed16(seen.words[0]) * FORCE_MN / 32768
        wanted_mn = record["force_q6"] / 64 if seen.enable else 0.0
        assert mn == pytest.approx(wanted_mn, abs=0.51 * FORCE_MN / 32768)


def test_force_leaves_first_and_soon(cut: tuple[Session, Meter]) -> None:
    """Its frame acts alone, within the stated time of the scale's latch; then X, Z, spindle."""
    _, meter = cut
    assert {tuple(channels) for channels in meter.order[1:-1]} == {(0, 1, 2, 3)}
    assert max(meter.delays) < LATENCY_US * CYCLES_PER_US
    assert min(meter.delays) > LATENCY_US * CYCLES_PER_US / 2


def test_open_limit_switch_ends_the_force_at_once(cut: tuple[Session, Meter]) -> None:
    """Fault u_travel: enable falls and clears the output. Each switch has its bit."""
    session, _ = cut
    assert session.board.ticks[-1].enable == 1
    for pin, bit in zip(LIMITS, (LIMIT_LOW, LIMIT_HIGH), strict=True):
        assert not session.records[-1]["inputs"] & bit
        session.chip.gpio.drive(pin, 0)
        session.chip.run(session.chip.seconds(101e-6))
        assert session.records[-1]["inputs"] & bit
        assert session.board.ticks[-1].enable == 0
        assert session.board.ticks[-1].words[0] == 0
    assert "u_travel" in session.remote.status().faults
