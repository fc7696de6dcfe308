# SPDX-License-Identifier: Apache-2.0
"""A simulated force drive is measured by its set-point, with the loop of the firmware closed."""

from __future__ import annotations

from pathlib import Path

import pytest

from camtools.base.project_paths import ROOT
from camtools.cli.tune import main
from camtools.tune.excited import fit_machine

_MACHINE = ROOT / "tests" / "scenarios" / "cases" / "machines" / "force.toml"
_MODE = "mode_hz = 1200\nmode_share = -0.2\nmode_on_scale = 1\n"
_LATE_US = 25.0 + 80.0  # delay of the machine file, amplifier of 2 kHz


@pytest.mark.parametrize("mode", ["", _MODE])
def test_the_set_point_shows_mass_delay_and_mode(mode: str, tmp_path: Path) -> None:
    """Mass within 2 %, the delays within 5 us, and a mode only where there is one."""
    file = tmp_path / "drive.toml"
    file.write_text(_MACHINE.read_text("utf-8") + mode, "utf-8")
    found, tick_hz = fit_machine(str(file))
    assert tick_hz == 20_000
    assert found.mass_kg == pytest.approx(1.5, rel=0.02)
    late_us = 1e6 * found.delay_s + 0.5e6 / 3.14159265 / found.amplifier_hz
    assert late_us == pytest.approx(_LATE_US, abs=5.0)
    assert found.has_mode == bool(mode)
    if mode:
        assert found.values[6:9].tolist() == pytest.approx([1200.0, 0.03, -0.2], rel=0.05)


def test_a_loop_is_proposed_for_what_was_measured(tmp_path: Path) -> None:
    """The parameters written carry the mass that was found."""
    assert main(["--machine", str(_MACHINE), "-o", str(tmp_path)]) == 0
    text = (tmp_path / "force_servo.toml").read_text("utf-8")
    (mass,) = (line for line in text.splitlines() if line.startswith("servo_mass_g"))
    assert int(mass.split("=")[1]) == pytest.approx(1500, rel=0.02)
