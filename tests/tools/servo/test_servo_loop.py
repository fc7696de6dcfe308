"""The position loop of the firmware, closed over a force drive; its fit."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.cli.tune import main
from camtools.tune.excited import pulse_fit
from camtools.tune.loop_design import Loop, Plant, margins
from camtools.tune.plant_fit import PlantFit, fit_lines, record_lines
from tests.tools.cases.drive_plant import Drive, designed, library

STEP_HZ = 20000
MOTION_M = 0.5e-3  # 1 mm p-p
SLOW = Plant(1.5, 1500.0, 75e-6, STEP_HZ, 1200.0, 0.03, -0.2)
QUICK = replace(SLOW, delay_s=25e-6)
FAST = replace(QUICK, amplifier_hz=3000.0)
SOFT = replace(SLOW, mode_share=1.0)


def params(loop: Loop, plant: Plant, **others: int) -> dict[str, int]:
    """Return the parameters of the loop for a proposal."""
    hold_s, amplifier_s = 0.5 / plant.step_hz, 0.5 / math.pi / plant.amplifier_hz
    return {
        "servo_mass_g": round(plant.mass_kg * 1e3),
        "servo_crossover_hz": round(loop.crossover_hz),
        "servo_lead_percent": round(loop.lead_ratio * 100.0),
        "servo_pole_hz": math.floor(loop.pole_hz),
        "servo_integral_mHz": round(loop.integral_hz * 1e3),
        "servo_notch_hz": round(loop.notch_hz),
        "servo_notch_zero_permille": round(loop.notch_zero * 1e3),
        "servo_notch_pole_permille": round(loop.notch_pole * 1e3),
        "servo_force_delay_ns": round((plant.delay_s + hold_s + amplifier_s) * 1e9),
        **dict.fromkeys(("u_scale_latency_ns", "servo_drag_mn_s_per_m", "servo_friction_mn"), 0),
        "servo_stiffness_n_per_m": 0,
        **dict.fromkeys(("servo_force_limit_mn", "servo_continuous_mn"), 500_000),
        "servo_force_rate_n_per_ms": 1_000_000,
        "servo_thermal_ms": 20_000,
    } | others


def opened(values: dict[str, int]) -> None:
    """Start the loop."""
    for name, value in values.items():
        assert library().servo_set(name.encode(), value) == 0, name
    assert library().servo_open(STEP_HZ)


def closed(
    drive: Drive,
    steps: int,
    outer_n: Callable[[int], float],
    motion: Callable[[int], tuple[float, float, float]] = lambda _: (0.0, 0.0, 0.0),
    quantum_nm: float = 10.0,
) -> Floats:
    """Return the readings of the scale in um after each step."""
    seen = np.empty(steps)
    for i in range(steps):
        read_nm = round(drive.scale_m() * 1e9 / quantum_nm) * quantum_nm
        pos_m, vel, acc = motion(i)
        per_step = 1024e9 / STEP_HZ
        force = library().servo_step(
            round(pos_m * 64e9), round(vel * per_step), round(acc * per_step / STEP_HZ),
            round(read_nm * 64.0),
        )  # fmt: skip
        drive.move(force / 64e3, outer_n(i))
        seen[i] = drive.scale_m() * 1e6
    return seen


@pytest.mark.long
@pytest.mark.parametrize("mass_kg", [pytest.param(5.0, marks=pytest.mark.long), 60.0])
def test_proposal_for_a_heavy_slide_fits_the_words_of_the_firmware(mass_kg: float) -> None:
    """Integral and lead of a heavy slide are limited by what the firmware holds."""
    heavy = replace(FAST, mass_kg=mass_kg)
    loop = designed(heavy)
    opened(params(loop, heavy))
    assert margins(loop, heavy).is_enough


@cache
def step_response(plant: Plant, friction_n: float, mass: float = 1.0) -> Floats:
    """Return what the scale sees of a step of 10 N at rest, in um, for 60 ms."""
    opened(params(designed(plant), plant))
    drive = Drive(replace(plant, mass_kg=mass * plant.mass_kg), friction_n)
    seen = closed(drive, 1300, lambda i: 10.0 if i >= 100 else 0.0)
    assert np.abs(seen[:100]).max() < 0.02
    return seen[100:]


@cache
def played(plant: Plant, outer_n: float) -> tuple[Floats, Floats]:
    """Return readings of 100 Hz, 1 mm p-p, and what they should be, in um.

    The motion rises over 0.1 s; an outer force acts from 0.2 s on.
    """
    values = params(designed(plant), plant, servo_friction_mn=5000)
    opened(values)
    omega, rise = 2.0 * math.pi * 100.0, round(0.1 * STEP_HZ)

    def due(at: float, size: float) -> tuple[float, float, float]:
        sine, cosine = math.sin(omega * at), math.cos(omega * at)
        return size * sine, size * omega * cosine, -size * omega**2 * sine

    def motion(i: int) -> tuple[float, float, float]:  # when the force acts
        return due(
            i / STEP_HZ + values["servo_force_delay_ns"] * 1e-9, MOTION_M * min(1.0, i / rise)
        )

    seen = closed(Drive(plant), 3 * rise, lambda i: outer_n if i >= 2 * rise else 0.0, motion)
    right = [due((i + 1) / STEP_HZ, MOTION_M)[0] * 1e6 for i in range(3 * rise)]
    return seen, np.array(right)


CASES = pytest.mark.parametrize(
    ("plant", "most_um"),
    [
        pytest.param(SLOW, 3.5, id="75 us"),
        pytest.param(QUICK, 2.2, id="25 us", marks=pytest.mark.long),
        pytest.param(FAST, 1.1, id="25 us and 3 kHz", marks=pytest.mark.long),
        pytest.param(SOFT, 6.0, id="soft"),
    ],
)
BACK = round(0.02 * STEP_HZ)


@pytest.mark.long
@CASES
def test_step_of_force_stays_below_its_peak_and_is_back_after_20_ms(
    plant: Plant, most_um: float
) -> None:
    """10 N on 1.5 kg, at rest without friction and in motion with a friction of 5 N."""
    at_rest = step_response(plant, 0.0)
    in_motion = (played(plant, 10.0)[0] - played(plant, 0.0)[0])[round(0.2 * STEP_HZ) :]
    for seen in (at_rest, in_motion):
        assert np.abs(seen).max() <= most_um
        assert np.abs(seen[BACK:]).max() <= 0.1


@pytest.mark.long
@CASES
def test_step_of_force_at_rest_in_friction(plant: Plant, most_um: float) -> None:
    """Friction halves the peak and holds the mass there until the integral has passed it."""
    seen = np.abs(step_response(plant, 5.0))
    assert seen.max() <= 0.6 * most_um
    assert seen[BACK:].max() <= 1.0
    assert seen[2 * BACK :].max() <= 0.1


@CASES
def test_gain_margin_is_that_of_the_closed_loop(plant: Plant, most_um: float) -> None:
    """A mass that is smaller by the gain margin is the last stable one."""
    margin = 10.0 ** (-margins(designed(plant), plant).gain_db / 20.0)
    assert margin <= 0.7 * 10.0 ** (-6.0 / 20.0) * 1.001
    stable = np.abs(step_response(plant, 0.0, 1.05 * margin))
    assert stable[-100:].max() < 0.5 * stable[:100].max()
    unstable = np.abs(step_response(plant, 0.0, 0.95 * margin))
    assert unstable[-100:].max() > 2.0 * most_um


@pytest.mark.parametrize(
    ("plant", "most_um"),
    [
        (SLOW, 0.45),
        pytest.param(QUICK, 0.26, marks=pytest.mark.long),
        pytest.param(FAST, 0.08, marks=pytest.mark.long),
    ],
)
def test_feed_forward_is_led_by_the_whole_delay(plant: Plant, most_um: float) -> None:
    """With the right mass and friction, before any learning; 295 N at the peak."""
    seen, right = played(plant, 0.0)
    assert np.abs(seen - right)[round(0.15 * STEP_HZ) :].max() <= most_um


PERIOD = STEP_HZ // 5
RIGID = replace(FAST, mode_hz=0.0, mode_share=0.0)
RINGING = replace(SOFT, mode_hz=700.0)


def excitation() -> Floats:
    """Return a period: odd lines of 5 Hz to 2 kHz, 30 N rms, and 40 N at 20 Hz."""
    phase, at = np.random.default_rng(7), np.arange(PERIOD) / STEP_HZ
    wave = 40.0 * np.sin(2 * math.pi * 20 * at)
    for line in range(1, 401, 2):
        wave += 3.0 * np.cos(2 * math.pi * 5 * line * at + phase.uniform(0, 2 * math.pi))
    return wave


@cache
def record(plant: Plant, friction_n: float, quantum_nm: float) -> Floats:
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


def fit_record(
    injected: Floats, force_n: Floats, position_m: Floats, quantum_nm: float = 0.0
) -> PlantFit:
    """Return the constants of a record."""
    return fit_lines(record_lines(STEP_HZ, injected, force_n, position_m, quantum_nm))


@pytest.mark.long
@pytest.mark.parametrize(
    ("plant", "friction_n", "quantum_nm"),
    [(SLOW, 5.0, 100.0), (SLOW, 0.0, 10.0), (RIGID, 5.0, 100.0), (RINGING, 2.0, 1000.0)],
    ids=["friction", "fine", "rigid", "ringing"],
)
def test_deviations_cover_the_truth(plant: Plant, friction_n: float, quantum_nm: float) -> None:
    """Each constant is within three deviations, and the deviations are small."""
    injected, force_n, position_m = record(plant, friction_n, quantum_nm)
    found = fit_record(injected, force_n, position_m, quantum_nm)
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
    found = fit_record(*np.array(rows).T)
    assert abs(found.mass_kg - 1.5) <= min(0.03, 3.0 * found.sigmas[0])
    assert abs(found.values[4:6].sum() - truth(RIGID, 0.0)[4] - truth(RIGID, 0.0)[5]) <= 10e-6


def test_records_without_a_fit_are_refused() -> None:
    """A signal that does not repeat, a short record, a pulse without motion; with remedies."""
    injected, force_n, position_m = record(SLOW, 5.0, 100.0)
    with pytest.raises(CamtoolsError, match=r"does not repeat every 0\.2 s; inject a multisine"):
        fit_record(injected * np.linspace(0, 1, injected.size), force_n, position_m)
    with pytest.raises(CamtoolsError, match=r"10000 ticks; 4 periods .* record for longer"):
        fit_record(injected[:10000], force_n[:10000], position_m[:10000])
    force_n = np.tile(np.r_[np.zeros(100), np.ones(100), np.zeros(800)], 2)
    with pytest.raises(CamtoolsError, match=r"no force or no motion .* brake"):
        pulse_fit(STEP_HZ, force_n, np.zeros(2000))


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


@pytest.mark.long
def test_record_is_fitted_and_tuned_in_one_go(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Limits come from the drive file; without one their parameters are left out."""
    row, place = record(SLOW, 5.0, 100.0), tmp_path / "scope.csv"
    head = "time_s,injected_n,force_n,position_um"
    columns = [np.arange(row.shape[1]) / STEP_HZ, *row]
    columns[3] = columns[3] * 1e6
    np.savetxt(place, np.transpose(columns), "%.6f", ",", header=head, comments="")
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
