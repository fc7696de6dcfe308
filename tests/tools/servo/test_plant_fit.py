# SPDX-License-Identifier: Apache-2.0
"""The fit of a force drive from records of a closed loop over a plant that is integrated here."""

import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from camtools.base.errors import CamtoolsError
from camtools.cli.tune import main
from camtools.tune.loop_design import Plant
from camtools.tune.plant_fit import fit_record
from camtools.tune.pulse import pulse_fit
from tests.tools.servo.test_servo_loop import FAST, SLOW, SOFT, STEP_HZ, Drive

PERIOD = STEP_HZ // 5
RIGID = replace(FAST, mode_hz=0.0, mode_share=0.0)
RINGING = replace(SOFT, mode_hz=700.0)


def excitation() -> NDArray[np.float64]:
    """Return a period: odd lines of 5 Hz to 2 kHz, 30 N rms, and 40 N at 20 Hz."""
    phase, at = np.random.default_rng(7), np.arange(PERIOD) / STEP_HZ
    wave = 40.0 * np.sin(2 * math.pi * 20 * at)
    for line in range(1, 401, 2):
        wave += 3.0 * np.cos(2 * math.pi * 5 * line * at + phase.uniform(0, 2 * math.pi))
    return wave


@cache
def record(plant: Plant, friction_n: float, quantum_nm: float) -> NDArray[np.float64]:
    """Return injected force, whole force and reading [m] of six periods, in a loop of 25 Hz."""
    drive, injected = Drive(plant, friction_n), excitation()
    omega = 2 * math.pi * 25.0
    kp, kd, out = 0.5 * plant.mass_kg * omega**2, 0.9 * plant.mass_kg * omega, []
    speed = total_n = last_m = 0.0
    for i in range(6 * PERIOD):
        read_m = round(drive.scale_m() * 1e9 / quantum_nm) * quantum_nm * 1e-9
        speed += 0.1 * ((read_m - last_m) * STEP_HZ - speed)
        last_m = read_m
        total_n -= 10.0 * kp * read_m / STEP_HZ
        force_n = total_n - kp * read_m - kd * speed + float(injected[i % PERIOD])
        out.append((injected[i % PERIOD], force_n, read_m))
        drive.move(force_n, 0.0)
    return np.array(out).T


def truth(plant: Plant, friction_n: float) -> list[float]:
    """Return the constants in the order of the fit."""
    lag_s = 0.5 / math.pi / plant.amplifier_hz
    plain = [plant.mass_kg, 0.0, 0.0, friction_n, plant.delay_s, lag_s]
    mode = [plant.mode_hz, plant.mode_damping, plant.mode_share]
    return plain + (mode if plant.mode_hz else [])


CASES = pytest.mark.parametrize(
    ("plant", "friction_n", "quantum_nm"),
    [(SLOW, 5.0, 100.0), (SLOW, 0.0, 10.0), (RIGID, 5.0, 100.0), (RINGING, 2.0, 1000.0)],
    ids=["friction", "fine", "rigid", "ringing"],
)


@CASES
def test_deviations_cover_the_truth(plant: Plant, friction_n: float, quantum_nm: float) -> None:
    """Each constant is within three deviations, and the deviations are small."""
    injected, force_n, position_m = record(plant, friction_n, quantum_nm)
    found = fit_record(STEP_HZ, injected, force_n, position_m, quantum_nm)
    right = np.array(truth(plant, friction_n))
    assert found.values.size == right.size
    assert np.all(np.abs(found.values - right) <= 3.0 * found.sigmas)
    most = [0.01, 1.0, 80.0, 0.3, 40e-6, 40e-6, 3.0, 0.003, 0.06]
    assert np.all(found.sigmas <= most[: right.size])
    late = float(found.values[4:6].sum() - right[4:6].sum())
    assert abs(late) <= 3.0 * found.late_sigma_s <= 15e-6


def test_feedback_does_not_bias_the_fit() -> None:
    """White noise of 1 um in the reading goes round the loop; the injected signal does not."""
    drive, injected, random = Drive(RIGID, 0.0), excitation(), np.random.default_rng(5)
    rows, speed, last_m = [], 0.0, 0.0
    for i in range(8 * PERIOD):
        read_m = drive.scale_m() + random.normal(0.0, 1e-6)
        speed += 0.3 * ((read_m - last_m) * STEP_HZ - speed)
        last_m = read_m
        force_n = float(injected[i % PERIOD]) - 3e4 * read_m - 300.0 * speed
        rows.append((injected[i % PERIOD], force_n, read_m))
        drive.move(force_n, 0.0)
    found = fit_record(STEP_HZ, *np.array(rows).T)
    assert abs(found.mass_kg - 1.5) <= min(0.03, 3.0 * found.sigmas[0])
    assert abs(found.values[4:6].sum() - truth(RIGID, 0.0)[4] - truth(RIGID, 0.0)[5]) <= 10e-6


def test_signal_that_does_not_repeat_is_refused() -> None:
    """Its remedy is in the error; a short record has another."""
    injected, force_n, position_m = record(SLOW, 5.0, 100.0)
    with pytest.raises(CamtoolsError, match=r"does not repeat every 0\.2 s; inject a multisine"):
        fit_record(STEP_HZ, injected * np.linspace(0, 1, injected.size), force_n, position_m)
    with pytest.raises(CamtoolsError, match=r"10000 ticks; 4 periods .* record for longer"):
        fit_record(STEP_HZ, injected[:10000], force_n[:10000], position_m[:10000])


@pytest.mark.parametrize("sign", [1, -1])
def test_pulses_give_sign_and_mass(sign: int) -> None:
    """40 N for 10 ms each way against a friction of 5 N, on a scale of 100 nm."""
    drive, rows = Drive(SLOW, 5.0), []
    for way in (1.0, -1.0):
        for i in range(3000):
            force_n = 40.0 * way if 200 <= i < 400 else 0.0
            rows.append((force_n, sign * round(drive.scale_m() * 1e7) * 1e-7))
            drive.move(force_n, 0.0)
    found = pulse_fit(STEP_HZ, *np.array(rows).T)
    assert found.sign == sign
    assert found.mass_kg == pytest.approx(1.5, rel=0.02)
    assert found.friction_n == pytest.approx(5.0, rel=0.1)
    assert found.mass_sigma_kg < 0.03


def test_pulse_without_motion_is_refused() -> None:
    """A brake that holds must not give a mass."""
    force_n = np.tile(np.r_[np.zeros(100), np.ones(100), np.zeros(800)], 2)
    with pytest.raises(CamtoolsError, match=r"no force or no motion .* brake"):
        pulse_fit(STEP_HZ, force_n, np.zeros(2000))


def test_record_is_fitted_and_tuned_in_one_go(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Limits come from the drive file; without one their parameters are left out."""
    row, place = record(SLOW, 5.0, 100.0), tmp_path / "scope.csv"
    lines = [
        f"{i / STEP_HZ:.6f},{a:.6f},{b:.6f},{c * 1e6:.4f}" for i, (a, b, c) in enumerate(row.T)
    ]
    place.write_text("time_s,injected_n,force_n,position_um\n" + "\n".join(lines) + "\n")
    assert main(["--record", str(place), "-o", str(tmp_path / "out")]) == 0
    report = capsys.readouterr().out
    assert "mass_kg                   1.5" in report
    assert "margins at 0.7 of the mass: 6." in report
    text = (tmp_path / "out" / "scope_servo.toml").read_text()
    assert "servo_force_limit_mn" not in text
    (tmp_path / "limits.toml").write_text("force_limit_n = 400.0\nscale_quantum_nm = 100.0\n")
    given = [str(tmp_path / "limits.toml"), "--record", str(place), "-o", str(tmp_path / "out")]
    assert main(given) == 0
    assert "servo_force_limit_mn = 400000" in (tmp_path / "out" / "limits_servo.toml").read_text()


def test_record_without_a_column_is_one_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The header that is expected is in the remedy."""
    (tmp_path / "scope.csv").write_text("time_s,force_n,position_um\n0,1,2\n")
    assert main(["--record", str(tmp_path / "scope.csv")]) == 2
    error = capsys.readouterr().err
    assert 'write a header as "time_s,injected_n,force_n,position_um"' in error
