# SPDX-License-Identifier: Apache-2.0
"""tools/tune: what it reports holds for the firmware's loop on a plant that is integrated here."""

import math
import re
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from camtools.cli.tune import main
from tests.tools.servo.test_servo_loop import QUICK, STEP_HZ, Drive, closed, library, opened

DRIVE = """\
mass_kg = 1.5
amplifier_hz = 1500.0
delay_us = 25.0
tick_hz = 20000.0
mode_hz = 1200.0
mode_damping = 0.03
mode_share = -0.2
scale_quantum_nm = 100.0
force_limit_n = 500.0
continuous_n = 210.0
thermal_s = 20.0
force_rate_n_per_ms = 1000000.0
"""
TASK = "[task]\ntravel_mm = 1.0\nspindle_rpm = 3000.0\nlobes = 2\n"


def tuned(folder: Path, text: str, *options: str) -> int:
    """Run the command on the text of a drive; results go to folder/out."""
    (folder / "coil.toml").write_text(text)
    return main([str(folder / "coil.toml"), "-o", str(folder / "out"), *options])


def number(text: str, pattern: str) -> float:
    """Return the number that a report has at a place."""
    found = re.search(pattern.replace("#", r"([\d.]+)"), text)
    assert found is not None, (pattern, text)
    return float(found[1])


def run_once(folder: Path) -> tuple[str, dict[str, int]]:
    """Return the report of a proposal, and its parameters with the names of the firmware."""
    assert tuned(folder, DRIVE + TASK) == 0
    table = tomllib.loads((folder / "out" / "coil_servo.toml").read_text())["axis_u"]
    assert table.pop("lead_ns") == 10**9 // STEP_HZ + table["servo_force_delay_ns"]
    assert [table.pop(name) for name in ("k1_ns", "k2_us2", "u_friction_nm")] == [0, 0, 0]
    assert all(name.startswith("servo_") for name in table)
    values = {name.removeprefix("servo_"): value for name, value in table.items()}
    text = (folder / "out" / "coil_loop.txt").read_text()
    return text, {"step_hz": STEP_HZ, "scale_delay_ns": 0} | values


def test_firmware_with_the_written_parameters_does_what_the_report_says(tmp_path: Path) -> None:
    """Peak and end of a step, least stiffness, noise; the feed-forward has the drive's delay."""
    text, values = run_once(tmp_path)
    hold_and_lag_ns = 25e3 + 1e9 / (2 * math.pi * 1500)
    assert values["force_delay_ns"] == pytest.approx(25e3 + hold_and_lag_ns, abs=1)
    opened(values)
    seen = np.abs(closed(Drive(QUICK, 0.0), 1300, lambda i: 10.0 if i >= 100 else 0.0)[100:])
    assert seen.max() == pytest.approx(number(text, "peak # um"), rel=0.03)
    back_ms = (np.flatnonzero(seen > 0.1)[-1] + 1) * 1e3 / STEP_HZ
    assert back_ms == pytest.approx(number(text, "after # ms"), abs=0.7)

    opened(values)
    weakest_hz = number(text, "N/um at # Hz")
    turn = 2 * math.pi * weakest_hz / STEP_HZ
    seen = closed(Drive(QUICK, 0.0), 6000, lambda i: 10.0 * math.sin(turn * i))[2000:]
    assert 10.0 / np.abs(seen).max() == pytest.approx(number(text, "stiffness: # N"), rel=0.03)


def test_noise_is_that_of_a_rounded_scale(tmp_path: Path) -> None:
    """White noise of a quantum's rms on the reading gives the force that is reported."""
    text, values = run_once(tmp_path)
    opened(values)
    drive, random, force_n = Drive(QUICK, 0.0), np.random.default_rng(3), np.empty(8000)
    for i in range(force_n.size):
        read_nm = drive.scale_m() * 1e9 + random.uniform(-50.0, 50.0)
        force_n[i] = library().servo_step(0, 0, 0, round(read_nm * 64)) / 64e3
        drive.move(float(force_n[i]), 0.0)
    assert force_n[500:].std() == pytest.approx(number(text, "force: # N rms"), rel=0.08)


def test_task_is_compared_with_the_limits(tmp_path: Path) -> None:
    """0.5 mm at 100 Hz of 1.5 kg: 296 N, 209 N rms."""
    text, _ = run_once(tmp_path)
    peak_n = 1.5 * 0.5e-3 * (2 * math.pi * 100) ** 2
    assert f"{peak_n:.0f} N peak; force_limit_n = 500: enough" in text
    assert f"{peak_n / math.sqrt(2):.0f} N rms; continuous_n = 210: enough" in text
    assert tuned(tmp_path, DRIVE.replace("210.0", "205.0") + TASK) == 0
    assert "continuous_n = 205: NOT ENOUGH" in (tmp_path / "out" / "coil_loop.txt").read_text()


def test_written_parameters_are_judged_as_they_were_proposed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A loop made for a mass that is 20 % too large has a gain that is as much too high."""
    text, _ = run_once(tmp_path)
    kept = tmp_path / "kept.toml"
    kept.write_bytes((tmp_path / "out" / "coil_servo.toml").read_bytes())
    capsys.readouterr()
    assert tuned(tmp_path, DRIVE + TASK, "--loop", str(kept)) == 0
    assert capsys.readouterr().out == text
    lighter = DRIVE.replace("mass_kg = 1.5", f"mass_kg = {1.5 * 1.2}")
    assert tuned(tmp_path, lighter, "--loop", str(kept)) == 0
    gains = [number(one, "at 1 of the mass: # dB") for one in (text, capsys.readouterr().out)]
    assert gains[1] - gains[0] == pytest.approx(20 * math.log10(1.2), abs=0.11)


@pytest.mark.parametrize(
    ("change", "culprit"),
    [
        (("mode_damping = 0.03\nmode_share = -0.2", "mode_damping = 0.001\nmode_share = 1.0"),
         "the mode at 60 Hz: damp or stiffen it"),
        (("delay_us = 25.0", "delay_us = 200.0"), "the delay of 200 us: shorten it"),
        (("amplifier_hz = 1500.0", "amplifier_hz = 250.0"), "the lag of the amplifier of 250 Hz"),
    ],
    ids=["mode", "delay", "amplifier"],
)  # fmt: skip
def test_margins_that_are_missing_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str],
    change: tuple[str, str], culprit: str,
) -> None:  # fmt: skip
    """One line names the cause; nothing is written. The mode has no loop at all."""
    _, values = run_once(tmp_path)
    kept = tmp_path / "kept.toml"
    kept.write_text("".join(f"servo_{name} = {value}\n" for name, value in values.items()))
    (tmp_path / "out").rename(tmp_path / "before")
    text = DRIVE.replace(*change)
    given = ["--loop", str(kept)]
    if culprit.startswith("the mode"):
        text, given = text.replace("mode_hz = 1200.0", "mode_hz = 60.0"), []
    capsys.readouterr()
    assert tuned(tmp_path, text, *given) == 1
    out, error = capsys.readouterr()
    assert out == ""
    assert error.count("\n") == 1
    assert "at least 6 dB and 30 degrees" in error
    assert culprit in error
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("mass_kg = 1.5\n", "", "mass_kg: is missing; add it"),
        ("mass_kg = 1.5", "mass_kg = -1.0", "mass_kg = -1.0: "),
        ("delay_us", "delay_ms", "delay_ms = 25.0: unknown key"),
        ("mass_kg = 1.5", "mass_kg = ", "not TOML"),
        ("continuous_n = 210.0", "continuous_n = 20.0", "servo_continuous_mn = 20000: out of"),
    ],
)  # fmt: skip
def test_bad_drive_is_one_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, problem: str
) -> None:
    """File, key and remedy; nothing is written."""
    assert tuned(tmp_path, DRIVE.replace(old, new)) == 2
    assert problem in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"pole_hz": 4001}, "servo_pole_hz = 4001: out of range 10 .. 4000 at 20000 Hz"),
        ({"notch_hz": 5001}, "servo_notch_hz = 5001: out of range"),
        ({"mass_g": 100_000}, "servo_integral_mHz = 9000: 1.26 times"),
        ({"crossover_hz": None}, "servo_crossover_hz: is missing"),
    ],
)
def test_bad_loop_is_one_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str],
    change: dict[str, int | None], problem: str,
) -> None:  # fmt: skip
    """The bounds are those of the firmware."""
    values = {"mass_g": 1500, "crossover_hz": 200, "lead_percent": 2000, "pole_hz": 4000}
    values |= {"integral_mHz": 9000, "notch_hz": 1200, "notch_zero_permille": 60}
    loop = values | {"notch_pole_permille": 100} | change
    kept = tmp_path / "kept.toml"
    lines = [f"servo_{k} = {v}\n" for k, v in loop.items() if v is not None]
    kept.write_text("[servo]\n" + "".join(lines))
    assert tuned(tmp_path, DRIVE, "--loop", str(kept)) == 2
    assert problem in capsys.readouterr().err


def test_stiff_drive_is_judged_with_its_stiffness() -> None:
    """A loop without integral yields to a constant force as its gain and the flexure allow."""
    from camtools.tune.judgement import judge
    from camtools.tune.loop_design import Loop

    plant = replace(QUICK, mode_hz=0.0, stiffness_n_per_m=2e5, drag_n_s_per_m=50.0)
    judged = judge(Loop(100.0, 10.0, 1000.0, 0.0, 2500.0, 1.0, 1.0), plant)
    lead = abs((1 + 1j) / (1 + 0.1j))
    gain_n_per_m = 1.5 * (2 * math.pi * 100.0) ** 2 / lead
    assert all(one.is_stable for one in judged.at)
    assert judged.step_um[-1] == pytest.approx(1e7 / (gain_n_per_m + 2e5), rel=1e-3)
