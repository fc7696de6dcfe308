# SPDX-License-Identifier: Apache-2.0
"""Encoder, bus and lines of the image, where a cut does not lead."""

import re

import numpy as np
import pytest

from tests.stm32.board import COUNTS_PER_TURN, INDEX_AT, TICK_CLOCKS
from tests.stm32.host import CLOCK_HZ, ROOT
from tests.stm32.models.fdcan import Frame
from tests.stm32.models.gpio import ANALOGUE
from tests.stm32.remote import COMMAND, ENABLE, GET, PARAMS, STATE, errors
from tests.stm32.session import Session

ERR = errors()
DRIVE_READY = 1 << 1
MIDDLE = 2048  # of the internal DAC: U = 0
AFTER_RESET = {"PA13", "PA14", "PB4"}  # the debug port's, RM0433 11.3.1
# UM2407: USB with its power switch and overcurrent, ST-LINK, LEDs, button, Ethernet.
UM2407 = {
    *("PA8", "PA9", "PA10", "PA11", "PA12", "PD10", "PG7", "PA13", "PA14", "PB0", "PB14", "PC13"),
    *("PA1", "PA2", "PA7", "PB13", "PC1", "PC4", "PC5", "PG11", "PG13"),
}


def pins_of(cell: str) -> list[str]:
    """Return the pins that a cell of the wiring table names, "PE0 .. PE7" one by one."""
    pins = re.findall(r"P[A-K]\d+", cell)
    if ".." in cell:
        first, last = (int(pin[2:]) for pin in pins)
        pins = [f"{pins[0][:2]}{i}" for i in range(first, last + 1)]
    return pins


@pytest.fixture
def session(started: Session) -> Session:
    """Return a board in state off, its spindle turned by hand."""
    started.board.is_held = True
    return started


def turn(session: Session, rpm: float, turns: float) -> None:
    """Turn the spindle by hand at a constant speed."""
    session.board.rpm = rpm
    session.chip.run(session.chip.seconds(abs(turns * 60 / rpm)))
    session.board.rpm = 0.0
    session.chip.run(session.chip.seconds(2e-4))


def test_index_lies_at_the_same_place_in_both_senses(session: Session) -> None:
    """Over several indexes forward and back: the place latched is the same modulo a turn."""
    start = int(0.1 * COUNTS_PER_TURN)
    n_before = session.records[-1]["n_index"]
    turn(session, 5000.0, 3.0)
    forward = session.records[-1]
    turn(session, -5000.0, 5.0)
    backward = session.records[-1]
    assert forward["n_index"] - n_before == 3
    assert backward["n_index"] - forward["n_index"] == 5
    for record in (forward, backward):
        place = record["index_counts"] - (record["index_counts"] >> 31 << 32)  # signed
        assert place % COUNTS_PER_TURN == INDEX_AT - start
    assert backward["counts"] > 2**31, "the counter passed zero downwards"
    turns = session.board.scale_counts[0]
    assert backward["counts"] == (turns - start) % 2**32


def test_edges_have_their_times(session: Session) -> None:
    """Counter and time of the last edge lie on the line of the spindle, in both senses."""
    for rpm in (900.0, -2400.0, 7.0):
        n = len(session.records)
        turn(session, rpm, 0.25 if abs(rpm) > 100 else 0.005)
        at = np.array(
            [(r["clock"], r["edge_clock"], r["counts"]) for r in session.records[n + 40 : -6]]
        )
        age = (at[:, 0] - at[:, 1]) % 2**32
        slope = rpm / 60 * COUNTS_PER_TURN / CLOCK_HZ  # [counts] per clock
        assert age.max() <= 1 / abs(slope) + TICK_CLOCKS, "the edge is the last one"
        line = np.unwrap(at[:, 2], period=2**32) - slope * np.unwrap(at[:, 1], period=2**32)
        assert np.ptp(line) <= 0.002 + abs(slope), "a clock of TIM5 at most, and rounding"


def test_edge_that_is_not_wired_is_told_of_and_keeps_the_drives_off(session: Session) -> None:
    """Without the wires to TIM5 there is no silent guess: the drives are not ready for good."""
    assert session.records[-1]["inputs"] & DRIVE_READY
    session.board.is_stamped = False
    turn(session, 1500.0, 0.1)
    assert not session.records[-1]["inputs"] & DRIVE_READY
    assert "port: spindle edges without a time" in "\n".join(session.remote.lines())


def test_bus_carries_parameters_and_the_status(session: Session) -> None:
    """A parameter comes back, one beyond the end is refused, a status comes every 10 ms."""
    place = PARAMS.index("counts_per_turn")
    assert session.remote.command(GET, place) == (0, COUNTS_PER_TURN)
    assert session.remote.command(GET, len(PARAMS))[0] == ERR["param_id"]
    n = len(session.remote.frames(STATE))
    session.chip.run(session.chip.seconds(0.05))
    assert len(session.remote.frames(STATE)) - n in (4, 5, 6)


def test_only_the_wired_pins_are_used_and_none_of_the_board(session: Session) -> None:
    """Pins in use are those of the wiring table, once each; the Nucleo's own parts keep theirs."""
    wiring = (
        (ROOT / "hal/stm32h743/README.md").read_text().split("## Wiring")[1].split("\n\n## ")[0]
    )
    cells = [row.split("|")[2] for row in wiring.splitlines() if row.startswith("| ")]
    wired = [pin for cell in cells for pin in pins_of(cell)]
    ports = session.chip.gpio.ports
    used = {
        f"P{letter}{pin}"
        for letter in "ABCDE"
        for pin in range(16)
        if ports[letter].mode(pin) != ANALOGUE and f"P{letter}{pin}" not in AFTER_RESET
    }
    assert len(wired) == len(set(wired))
    assert used | {"PA4"} == set(wired)
    assert not set(wired) & UM2407


def test_foreign_and_broken_frames_do_no_harm(session: Session) -> None:
    """Other identifiers are ignored, a command of another length is refused."""
    answers = len(session.remote.frames(0x5C0))
    for i in range(20):
        session.board.send(Frame(0x100 + i, bytes(i % 9)))
    session.chip.run(session.chip.seconds(0.01))
    assert len(session.remote.frames(0x5C0)) == answers
    session.board.send(Frame(COMMAND, bytes([ENABLE, 0, 0])))
    session.chip.run(session.chip.seconds(0.01))
    answer = session.remote.frames(0x5C0)[-1].data
    assert int.from_bytes(answer[2:4], "little", signed=True) == ERR["frame"]
    assert session.chip.fdcan1.lost == 0


def test_bus_off_heals(session: Session) -> None:
    """Behind a bus-off the image joins the bus again by itself."""
    session.chip.fdcan1.go_bus_off()
    n = len(session.remote.frames(STATE))
    session.chip.run(session.chip.seconds(0.04))
    assert len(session.remote.frames(STATE)) > n + 1


def test_rates_are_those_of_the_manual(session: Session) -> None:
    """Bit rates of the lines and the bus, and where the bus is sampled."""
    chip = session.chip
    assert chip.rcc.core_hz() == 480_000_000
    assert chip.usart3.baud() == pytest.approx(115_200, rel=0.005)
    assert chip.fdcan1.bit_hz() == 500_000
    assert chip.fdcan1.data_bit_hz() == 2_000_000
    assert 0.75 <= chip.fdcan1.sample_point() <= 0.875
    assert chip.spi3.bit_hz() == 20_000_000


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
