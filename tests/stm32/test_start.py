"""The image after its start: memory, clocks, pins; encoder, bus and lines outside of a cut."""

import re

import numpy as np
import pytest

from camtools.base.project import VERSION
from tests.stm32.board import COUNTS_PER_TURN, INDEX_AT, READY, TABLE, TICK_CLOCKS
from tests.stm32.emulator import Chip
from tests.stm32.host import CLOCK_HZ, IMAGE, ROOT
from tests.stm32.image import Image
from tests.stm32.models.bus import UnmodelledError
from tests.stm32.models.gpio import ANALOGUE
from tests.stm32.remote import ENABLE, KEY, PARAMS, SET, STATE, TAKE, errors
from tests.stm32.session import Session

ERR = errors()
DRIVE_READY = 1 << 1
MIDDLE = 2048  # of the internal DAC: U = 0
BOOT = {"stm_reset", "stm_boot_fill", "on_boot_fault"}
SYSTEM_MEMORY, CODE, OTHER = 0x1FF00000, 0x08000000, 0x08040000
AFTER_RESET = {"PA13", "PA14", "PB4"}  # the debug port's, RM0433 11.3.1
# UM2407: USB with its power switch and overcurrent, ST-LINK, LEDs, button, Ethernet.
UM2407 = {
    *("PA8", "PA9", "PA10", "PA11", "PA12", "PD10", "PG7", "PA13", "PA14", "PB0", "PB14", "PC13"),
    *("PA1", "PA2", "PA7", "PB13", "PC1", "PC4", "PC5", "PG11", "PG13"),
}
PROTECTION = (  # RDP, WPSN, BOR_LEV; level, firmware protected, brown-out level
    *((0xAA, 0xFF, 0, 0, 0, 0), (0x00, 0xFE, 1, 1, 0, 1), (0xCC, 0xFC, 2, 2, 1, 2)),
)


def test_only_the_start_up_is_in_flash() -> None:
    """Neither main() nor the main loop: flash may be erased while they run."""
    image = Image(IMAGE)
    assert image.functions[".boot"] == BOOT
    assert image.sizes[".boot"] <= 512


@pytest.mark.parametrize(
    ("address", "why"),
    [
        (0x40001000, "no device"),  # TIM6
        (0x58024404, "no register"),  # RCC_HSICFGR
        (0x40000800, "without its clock"),  # TIM4
        (0x00000010, "null pointer"),
    ],
)
def test_unknown_addresses_end_the_run(address: int, why: str) -> None:
    """An access that no model knows fails with the address and the place in the code."""
    chip = Chip(Image(IMAGE), hse_hz=8_000_000)
    chip.power_on()
    load = b"\x00\x48\x00\x68"  # ldr r0, [pc]; ldr r0, [r0]; the word after them is loaded first
    chip.put_instructions(
        chip.pc, b"\x00\xbf" * (chip.pc // 2 % 2) + load + address.to_bytes(4, "little")
    )
    with pytest.raises(UnmodelledError, match=f"{why}.*0x{address:08x}.*stm_reset"):
        chip.run(10)


def test_clocks_and_converters_start_by_the_manual(started: Session) -> None:
    """Rates of core, lines and bus; U's own converter floats until it shows the middle."""
    chip = started.chip
    assert chip.rcc.core_hz() == 480_000_000
    assert chip.usart3.baud() == pytest.approx(115_200, rel=0.005)
    assert chip.fdcan1.bit_hz() == 500_000
    assert chip.fdcan1.data_bit_hz() == 2_000_000
    assert 0.75 <= chip.fdcan1.sample_point() <= 0.875
    assert chip.spi3.bit_hz() == 20_000_000
    assert chip.spi3.select_high_s() == pytest.approx(350e-9)  # the data sheet asks for 100 ns
    codes = [code for _, code in started.board.at_pa4]
    shown = started.board.at_pa4[: codes.index(MIDDLE) + 1]
    first = next(at for at, code in shown if code is not None)
    assert shown[-1][0] - first < chip.seconds(1e-6)
    assert set(codes[codes.index(MIDDLE) :]) == {MIDDLE}
    assert started.remote.newest().reset == "power_on"
    assert chip.rcc.v["rsr"] == 0, "cleared for the next reset"
    assert started.remote.lines()[:2] == [f"camturn {VERSION}", "start: power on"]


def test_core_reads_ahead_neither_in_system_memory_nor_in_code(started: Session) -> None:
    """The protection unit forbids both; tables are read ahead, the purpose of the cache."""
    mpu = started.chip.nvic.mpu
    forbidden = [*range(SYSTEM_MEMORY, SYSTEM_MEMORY + (1 << 20), 1 << 16)]
    forbidden += range(CODE, OTHER, 1 << 14)
    assert not any(mpu.invites(address) for address in forbidden)
    assert mpu.invites(OTHER) and mpu.invites(TABLE)


def test_protection_of_the_chip_is_reported(started: Session) -> None:
    """By the option bytes: any RDP but two is level 1, a bit of 0 protects one of two sectors."""
    chip = started.chip
    for rdp, wpsn, bor, level, is_protected, brown_out in PROTECTION:
        if rdp != PROTECTION[0][0]:
            chip.reset("pin")
            chip.usart3.sent.clear()
            options = 0x031600F0 | rdp << 8 | bor << 2
            chip.flash.v |= {"optsr_cur": options, "wpsn_cur1": wpsn}
            assert started.remote.started().reset == "pin"
        line = f"port: read-out protection level {level}, write protection of the firmware "
        line += f"{is_protected}, brown-out level {brown_out} (UPDATE.md)"
        assert line in started.remote.lines()


def test_only_the_wired_pins_are_used_and_none_of_the_board(started: Session) -> None:
    """Pins in use are those of the wiring table, once each; the Nucleo's own parts keep theirs."""
    wiring = (
        (ROOT / "hal/stm32h743/README.md").read_text().split("## Wiring")[1].split("\n\n## ")[0]
    )
    cells = [row.split("|")[2] for row in wiring.splitlines() if row.startswith("| ")]
    wired = [pin for cell in cells for pin in re.findall(r"P[A-K]\d+", cell)]
    used = {
        f"P{letter}{pin}"
        for letter, port in started.chip.gpio.ports.items()
        for pin in range(16)
        if port.mode(pin) != ANALOGUE and f"P{letter}{pin}" not in AFTER_RESET
    }
    assert len(wired) == len(set(wired))
    assert used | {"PA4"} == set(wired)
    assert not set(wired) & UM2407


def turn(session: Session, rpm: float, turns: float) -> None:
    """Turn the spindle by hand at a constant speed."""
    session.board.is_held = True
    session.board.rpm = rpm
    session.chip.run(session.chip.seconds(abs(turns * 60 / rpm)))
    session.board.rpm = 0.0
    session.chip.run(session.chip.seconds(2e-4))


def test_index_is_at_the_same_place_in_both_senses(started: Session) -> None:
    """Over several indexes forward and back: the place latched is the same modulo a turn."""
    start = int(0.1 * COUNTS_PER_TURN)
    n_before = started.records[-1]["n_index"]
    turn(started, 5000.0, 3.0)
    forward = started.records[-1]
    turn(started, -5000.0, 5.0)
    backward = started.records[-1]
    assert forward["n_index"] - n_before == 3
    assert backward["n_index"] - forward["n_index"] == 5
    for record in (forward, backward):
        place = record["index_counts"] - (record["index_counts"] >> 31 << 32)  # signed
        assert place % COUNTS_PER_TURN == INDEX_AT - start
    assert backward["counts"] > 2**31, "the counter passed zero downwards"
    turns = started.board.scale_counts[0]
    assert backward["counts"] == (turns - start) % 2**32


def test_edges_have_their_times(started: Session) -> None:
    """Counter and time of the last edge are on the line of the spindle, in both senses."""
    for rpm in (900.0, -2400.0, 7.0):
        n = len(started.records)
        turn(started, rpm, 0.25 if abs(rpm) > 100 else 0.005)
        at = np.array(
            [(r["clock"], r["edge_clock"], r["counts"]) for r in started.records[n + 40 : -6]]
        )
        age = (at[:, 0] - at[:, 1]) % 2**32
        slope = rpm / 60 * COUNTS_PER_TURN / CLOCK_HZ  # [counts] per clock
        assert age.max() <= 1 / abs(slope) + TICK_CLOCKS, "the edge is the last one"
        line = np.unwrap(at[:, 2], period=2**32) - slope * np.unwrap(at[:, 1], period=2**32)
        assert np.ptp(line) <= 0.002 + abs(slope), "a clock of TIM5 at most, and rounding"


def test_edge_that_is_not_wired_is_reported_and_keeps_the_drives_off(started: Session) -> None:
    """Without the wires to TIM5 there is no silent guess: the drives are not ready for good."""
    assert started.records[-1]["inputs"] & DRIVE_READY
    started.board.is_stamped = False
    turn(started, 1500.0, 0.1)
    assert not started.records[-1]["inputs"] & DRIVE_READY
    assert "port: spindle edges without a time" in "\n".join(started.remote.lines())


def test_bus_carries_a_status_every_10_ms_and_bus_off_heals(started: Session) -> None:
    """After a bus-off the image joins the bus again by itself."""
    n = len(started.remote.frames(STATE))
    started.chip.run(started.chip.seconds(0.05))
    assert len(started.remote.frames(STATE)) - n in (4, 5, 6)
    started.chip.fdcan1.go_bus_off()
    n = len(started.remote.frames(STATE))
    started.chip.run(started.chip.seconds(0.04))
    assert len(started.remote.frames(STATE)) > n + 1


def test_inputs_without_a_wire_allow_nothing(started: Session) -> None:
    """Key, button and chains have pull-down resistors; each is needed."""
    remote, chip = started.remote, started.chip
    remote.session = remote.raw(TAKE)[1]
    stroke = PARAMS.index("u_stroke_nm")
    assert remote.raw(SET, stroke, 1_300_000)[0] == ERR["locked"]
    assert remote.raw(ENABLE)[0] == ERR["acknowledge"]
    for name in (READY, "PE10"):
        chip.gpio.drive(name, None)
    chip.gpio.drive(KEY, 1)
    chip.run(chip.seconds(2e-3))
    assert remote.raw(SET, stroke, 1_300_000)[0] == 0
    assert remote.command(ENABLE)[0] == ERR["estop"]
    chip.gpio.drive("PE10", 1)
    chip.run(chip.seconds(1e-3))
    assert remote.command(ENABLE)[0] == ERR["drive"]
