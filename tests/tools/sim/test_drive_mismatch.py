# SPDX-License-Identifier: Apache-2.0
"""The line of tools/run about a drive that is worse than believed."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import omega_rad_s
from camtools.sim.drive_mismatch import mismatch


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
    assert found.with_um is not None
    assert found.without_um is not None
    assert found.with_um < 0.1 * found.without_um
    assert found.text().endswith(" with it")


def test_long_cut_is_cut_short(table: Path) -> None:
    """300 000 ticks, 15 s at 20 kHz: at 60 r/min 15 turns, and those in which the feed ends."""
    found = mismatch(table, "", [], 60.0)
    assert 15 <= found.turns < 100


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
