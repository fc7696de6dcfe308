"""The line of tools/run about a drive that is worse than believed."""

import math
from pathlib import Path

import pytest

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import omega_rad_s
from camtools.sim.drive_mismatch import mismatch
from tests.tools.cases.cut_cases import made_of, written
from tests.tools.cases.part_cases import sure


def lag(hz: float, damping: float, delay_s: float, omega: float) -> complex:
    """Return the response of a drive of second order with a dead time."""
    natural, s = 2 * math.pi * hz, 1j * omega
    drive = natural**2 / (s * s + 2 * damping * natural * s + natural**2)
    angle = -omega * delay_s
    return drive * complex(math.cos(angle), math.sin(angle))


def test_error_without_learning_is_what_the_drive_misses(table: Path) -> None:
    """Compare with the ratio of two frequency responses at twice the speed of the spindle."""
    found = mismatch(table, "", ["--set", "ripple_turns=0"], 2500.0)
    omega = 2 * omega_rad_s(2500)
    half_tick_s = 25e-6
    ratio = lag(285, 0.735, 78.75e-6 + half_tick_s, omega) / lag(
        300, 0.7, 75e-6 + half_tick_s, omega
    )
    assert found.without_um == pytest.approx(75 * abs(ratio - 1), rel=0.1)
    assert found.turns > 620


def test_learning_takes_it_away(table: Path) -> None:
    """It is on where U is measured, as on a machine whose controller believes something."""
    found = mismatch(table, "", [], 2500.0)
    assert found.learns
    assert sure(found.with_um) < 0.1 * sure(found.without_um)
    assert found.text().endswith(" with it")


@pytest.mark.long
def test_ripple_is_learned_on_a_flank_of_nine_mm_per_rad(tmp_path: Path) -> None:
    """A step of the learned angle moves U by its slope, and must not exceed its acceleration."""
    made = made_of("p4c-35")
    machine = made.kind.machine(made.table.part)
    found = mismatch(written(made, tmp_path), machine, [], 150.0)
    assert found.faults == ()
    assert sure(found.with_um) < 12.1 < 20 < sure(found.without_um)  # 12 um are the blends


def test_fault_is_named(table: Path) -> None:
    """A drive that misses more than its following error may be."""
    words = ["--set", "following_limit_nm=1000"]
    found = mismatch(table, "", words, 2500.0)
    assert found.faults == ("following_error",)
    assert found.with_um is None
    assert found.text().endswith(": fault following_error")


def test_long_cut_is_cut_short(table: Path) -> None:
    """300 000 ticks, 15 s at 20 kHz: at 60 r/min 15 turns, and those in which the feed ends."""
    found = mismatch(table, "", [], 60.0)
    assert 15 <= found.turns < 100
    assert found.text().endswith(f", over the first {found.turns:.0f} of 680 turns")


def test_slow_ticks_give_as_many_ticks(table: Path) -> None:
    """At 5 kHz and 600 r/min 300 000 ticks are 600 turns, not 150."""
    found = mismatch(table, "[machine]\ntick_hz = 5000\n", [], 600.0)
    assert 600 <= found.turns < 680


def test_what_cannot_be_cut_says_why(table: Path) -> None:
    """Infeasible, no machine, a table twice as TOML forbids and the simulator allows, no table."""
    for machine, words, why in (
        ("", ["--rpm", "9000"], "9000"),
        ("nothing", [], "TOML"),
        ("[u]\ndelay_us = 75\n[u]\ndamping = 0.7\n", [], "TOML"),
    ):
        with pytest.raises(CamtoolsError, match=why):
            mismatch(table, machine, words, 2500.0)
    with pytest.raises(CamtoolsError, match="none"):
        mismatch(table.with_name("none.camtab"), "", [], 2500.0)
