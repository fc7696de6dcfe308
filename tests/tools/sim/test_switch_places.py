# SPDX-License-Identifier: Apache-2.0
"""Position switches on the simulated lathe: where they act by the spindle's true angle."""

from math import degrees
from pathlib import Path

import pytest

from camtools.base.json_text import Json
from tests.tools.cases.camsim_cases import cut

TICK_HZ = 20_000
RPM = 2470.0  # no whole number of ticks per turn
DEG_PER_TICK = RPM * 6 / TICK_HZ


def switches(table: Path, folder: Path, **settings: int) -> list[Json]:
    """Return the figures of the switches in the summary of a short cut."""
    machine = folder / "m.toml"
    machine.write_text("[spindle]\nripple = 0\n")
    words = [word for name, value in settings.items() for word in ("--set", f"{name}={value}")]
    options = ("--machine", machine, "--rpm", str(RPM), "--feed", "2", "--no-learning")
    found: list[Json] = cut(table, folder, *options, *words)["switches"]
    return found


@pytest.mark.parametrize("dead_time_ns", [0, 7_300_000])
def test_switches_act_in_the_tick_nearest_to_their_windows(
    dead_time_ns: int, table: Path, tmp_path: Path
) -> None:
    """With their dead time, twice per turn; the run-up of the spindle shows in the largest."""
    [found] = switches(
        table,
        tmp_path,
        switch_3_per_turn=2,
        switch_3_on_udeg=30_000_000,
        switch_3_off_udeg=75_500_000,
        switch_3_dead_time_ns=dead_time_ns,
    )
    assert (found["output"], found["on_deg"], found["off_deg"]) == (3, 30, 75.5)
    assert found["times_on"] == found["times_off"] > 60
    assert found["other_on"] == found["other_off"] == 0
    for error in (found["on_error_deg"], found["off_error_deg"]):
        assert abs(error["mean"]) <= 0.3 * DEG_PER_TICK
        # While the spindle runs up at 500 rad/s2 it turns farther in the dead time than before.
        dead_time_s = dead_time_ns * 1e-9
        run_up_deg = degrees(500 / 2 * dead_time_s**2) + (0.3 if dead_time_ns else 0)
        assert abs(error["max"]) <= 0.55 * DEG_PER_TICK + run_up_deg


def test_height_opens_and_closes_a_switch(table: Path, tmp_path: Path) -> None:
    """Two outputs with two windows of the height; one of them covers the whole turn."""
    first, second = switches(
        table,
        tmp_path,
        switch_1_per_turn=1,
        switch_1_off_udeg=360_000_000,
        switch_1_z_low_nm=10_000_000,
        switch_1_z_high_nm=20_000_000,
        switch_2_per_turn=1,
        switch_2_off_udeg=90_000_000,
        switch_2_z_low_nm=30_000_000,
        switch_2_z_high_nm=40_000_000,
    )
    low_mm, high_mm = first["z_mm"]
    fed_mm = 0.05  # in the ticks until a height is looked at, and by the lag of Z
    assert low_mm == pytest.approx(10, abs=fed_mm)
    assert high_mm == pytest.approx(20, abs=fed_mm)
    assert 30 - fed_mm <= second["z_mm"][0] < second["z_mm"][1] <= 40 + fed_mm
    assert second["times_on"] in (4, 5, 6), "10 mm at 2 mm per turn"
