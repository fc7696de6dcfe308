# SPDX-License-Identifier: Apache-2.0
"""Position switches on the simulated lathe: where they act by the spindle's true angle."""

import json
from math import degrees
from pathlib import Path

import pytest

from camtools.base.json_text import Json
from camtools.skirt.table.generate import GeneratedSkirt
from camtools.table.image import pack
from tests.tools.cases.camsim_cases import camsim

TICK_HZ = 20_000
RPM = 2470.0  # no whole number of ticks per turn
DEG_PER_TICK = RPM * 6 / TICK_HZ


def cut(folder: Path, table: bytes, **settings: int) -> list[Json]:
    """Return what the summary says of the switches of a short cut."""
    path = folder / "part.camtab"
    path.write_bytes(table)
    words = [word for name, value in settings.items() for word in ("--set", f"{name}={value}")]
    summary = folder / "s.json"
    machine = folder / "m.toml"
    machine.write_text("[spindle]\nripple = 0\n")
    command: tuple[str | Path, ...] = (
        "--machine",
        machine,
        "--rpm",
        str(RPM),
        "--feed",
        "2",
        "--no-learning",
        *words,
        "--summary",
        summary,
    )
    done = camsim("run", path, *command)
    assert done.returncode == 0, done.stderr
    found: list[Json] = json.loads(summary.read_text())["switches"]
    return found


@pytest.mark.parametrize("dead_time_ns", [0, 7_300_000])
def test_switches_act_in_the_tick_nearest_to_their_windows(
    dead_time_ns: int, tmp_path: Path, generated: GeneratedSkirt
) -> None:
    """With their dead time, twice per turn; the run-up of the spindle shows in the largest."""
    [found] = cut(
        tmp_path,
        pack(generated.table),
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


def test_height_opens_and_closes_a_switch(tmp_path: Path, generated: GeneratedSkirt) -> None:
    """Two outputs with two windows of the height; one of them covers the whole turn."""
    first, second = cut(
        tmp_path,
        pack(generated.table),
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


def test_without_switches_the_summary_does_not_speak_of_them(
    tmp_path: Path, generated: GeneratedSkirt
) -> None:
    """There is no such key, and a cut is that of before."""
    path = tmp_path / "part.camtab"
    path.write_bytes(pack(generated.table))
    summary = tmp_path / "s.json"
    assert camsim("run", path, "--feed", "2", "--summary", summary).returncode == 0
    assert "switches" not in json.loads(summary.read_text())
