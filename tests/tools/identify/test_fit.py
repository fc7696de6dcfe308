"""Constants found of drives of another make, whose constants are known (drive_plant.py).

What they cost a part, their picture and their report.
"""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from camtools.base.quantities import Floats
from camtools.identify.bode import bode_png, left_by_fit, measured_response
from camtools.identify.configured_drive import Believed
from camtools.identify.fit import FRICTION, K1, K2, LEAD, second_order
from camtools.identify.identified import Identified, friction_of, identify
from camtools.identify.recording import Grid, multisine, record_of, spectra_of
from camtools.identify.report import (
    ToolMotion,
    form_error_nm,
    form_sigma_nm,
    friction_error_nm,
    motion_of,
    report,
)
from camtools.skirt.table.generate import GeneratedSkirt
from tests.tools.cases.drive_plant import Plant, faded, played

N_PERIODS = 5
GRID = Grid.of(20_000.0)


def errors(found: Identified, plant: Plant, grid: Grid = GRID) -> tuple[float, float, float]:
    """Return the errors of k1 and k2 as shares, and of the lead [s]."""
    k1_s, k2_s2, _, lead_s = found.plain.values
    return k1_s / plant.k1_s - 1, k2_s2 / plant.k2_s2 - 1, lead_s - plant.lead_s(grid.tick_hz)


def friction_m_s2(found: Identified) -> float:
    """Return the friction of a drive as an acceleration."""
    return float(found.plain.values[FRICTION] / found.plain.values[K2] * 1e-9)


@dataclass(frozen=True)
class Plays:
    """Drives that are moved at once by one excitation, and their positions."""

    grid: Grid
    plants: list[Plant]
    u_nm: Floats
    y_nm: Floats

    def identified(
        self, plant: Plant, noise_nm: Floats | float = 0.0, *, with_mode: bool = False
    ) -> Identified:
        """Return what is found of a drive, whose scale has a noise."""
        y_nm = self.y_nm[self.plants.index(plant)] + noise_nm
        ticks = np.arange(self.u_nm.size)
        record = record_of(self.grid, ticks, self.u_nm, y_nm, plant.quantum_nm)
        return identify(record, with_mode=with_mode)


def plays(plants: list[Plant], rms_nm: float, grid: Grid, n_periods: int) -> Plays:
    """Excite drives."""
    u_nm = faded(multisine(grid, rms_nm, 300_000.0), n_periods)
    return Plays(grid, plants, u_nm, played(plants, u_nm, grid.tick_hz))


QUIET, RUBBING, GEARED = Plant(), Plant(friction_m_s2=5), Plant(gain=1.03)
RINGING = [
    Plant(mode_hz=800, mode_share=0.1),
    Plant(mode_hz=800, mode_share=0.1, friction_m_s2=10),
    Plant(mode_hz=400, mode_share=0.02),
    Plant(mode_hz=1500, mode_share=0.2, friction_m_s2=5),
]


@pytest.fixture(scope="module")
def at_20_khz() -> Plays:
    """Excite drives as the default machine is."""
    return plays([QUIET, RUBBING, GEARED, *RINGING], 25_000.0, GRID, N_PERIODS)


@pytest.fixture(scope="module")
def at_10_khz() -> Plays:
    """Excite drives at another tick rate, to which the grid adapts."""
    return plays([QUIET, RUBBING], 25_000.0, Grid.of(10_000.0), 4)


DRIVES = [
    Plant(),
    Plant(hz=220, damping=0.5, delay_us=125),
    Plant(hz=450, damping=1.1, delay_us=50),
    Plant(hz=150, damping=0.7, delay_us=200),
]


SCALES = [(friction, quantum_nm) for friction in (5.0, 20.0) for quantum_nm in (10.0, 100.0, 1e3)]


@pytest.mark.parametrize(
    "scales", [[SCALES[0], SCALES[-1]], pytest.param(SCALES[1:-1], marks=pytest.mark.long)]
)
def test_constants_are_within_a_percent(scales: list[tuple[float, float]]) -> None:
    """1 % of k1 and k2, 2 us of lead, friction up to 20 m/s2, scales up to 1 um."""
    plants = [
        replace(drive, quantum_nm=quantum_nm, friction_m_s2=friction)
        for drive in DRIVES
        for friction, quantum_nm in scales
    ]
    all_plays = plays(plants, 38_000.0, GRID, N_PERIODS)  # as 250 m/s2 allow
    for plant in plants:
        found = all_plays.identified(plant)
        k1, k2, lead_s = errors(found, plant)
        assert abs(k1) < 0.01 and abs(k2) < 0.01 and abs(lead_s) < 2e-6, plant
        assert found.problems() == [], plant
        expected = max(0.03 * plant.friction_m_s2, 1.0 if plant.quantum_nm >= 1000 else 0.1)
        assert abs(friction_m_s2(found) - plant.friction_m_s2) < expected, plant


def test_default_machine_with_friction(at_20_khz: Plays, at_10_khz: Plays) -> None:
    """As expected of control by a scale of 10 nm: far below a percent; at 10 kHz a percent."""
    found = at_20_khz.identified(RUBBING, with_mode=True)
    k1, k2, lead_s = errors(found, RUBBING)
    assert abs(k1) < 1e-3 and abs(k2) < 1e-3 and abs(lead_s) < 0.5e-6
    assert friction_m_s2(found) == pytest.approx(5, abs=0.05)
    assert not found.has_mode
    assert found.gain == pytest.approx(1, abs=1e-3)
    found = at_10_khz.identified(RUBBING)
    k1, k2, lead_s = errors(found, RUBBING, at_10_khz.grid)
    assert abs(k1) < 0.01 and abs(k2) < 0.01 and abs(lead_s) < 2e-6
    assert found.problems() == []


@pytest.mark.parametrize(
    "plant", [RINGING[0], *(pytest.param(one, marks=pytest.mark.long) for one in RINGING[1:])]
)
def test_mode_is_said_to_bias_the_fit_and_by_how_much(plant: Plant, at_20_khz: Plays) -> None:
    """The reported bias is the true one; the drive beside its mode is found."""
    found = at_20_khz.identified(plant, with_mode=True)
    k1, k2, lead_s = errors(found, plant)
    assert found.has_mode
    assert found.problems() == []
    assert found.with_mode is not None
    assert found.judged is found.with_mode
    beside = found.with_mode.values
    assert beside[[K1, K2]] == pytest.approx([plant.k1_s, plant.k2_s2], rel=4e-3)
    assert found.with_mode.mode.hz == pytest.approx(plant.mode_hz, rel=0.04)
    assert found.bias[K1] == pytest.approx(k1, abs=2e-3)
    assert found.bias[K2] == pytest.approx(k2, abs=4e-3)
    assert found.bias[LEAD] == pytest.approx(lead_s, abs=3e-6)


@pytest.mark.long
def test_standard_deviations_are_honest(at_20_khz: Plays) -> None:
    """Over many records of noise, errors are as large as is said: chi squared of each constant."""
    rng, squares = np.random.default_rng(3), []
    for _ in range(60):
        found = at_20_khz.identified(QUIET, rng.normal(0, 300.0, at_20_khz.u_nm.size))
        off = np.array(errors(found, QUIET)) * [QUIET.k1_s, QUIET.k2_s2, 1]
        squares.append((off / found.plain.sigmas[[K1, K2, LEAD]]) ** 2)
    chi = np.mean(squares, axis=0)
    assert np.all(chi > 0.5) and np.all(chi < 1.8), chi


def test_scale_that_is_wrong_is_noticed(at_20_khz: Plays) -> None:
    """A drive that moves 3 % more than commanded has a gear or a scale that is wrong."""
    found = at_20_khz.identified(GEARED)
    assert found.gain == pytest.approx(1.03, abs=2e-3)
    assert any("U moves 1.03" in problem for problem in found.problems())
    worse = replace(found.plain, misfit=1.5, covariance=1e-8 * np.eye(4))  # 100 us
    said = replace(found, plain=worse).problems()
    assert any("lead is known to 100 us" in problem for problem in said)
    assert any("leaves 150 %" in problem for problem in said)


def test_measured_response_is_that_of_the_drive_without_friction(at_10_khz: Plays) -> None:
    """Within its noise, though the drive rubs."""
    found = at_10_khz.identified(RUBBING)
    measured, _ = measured_response(found)
    s = found.spectra.s
    lead_s = RUBBING.lead_s(at_10_khz.grid.tick_hz)
    exact = np.exp(-lead_s * s) / (1 + RUBBING.k1_s * s + RUBBING.k2_s2 * s**2)
    assert np.max(np.abs(measured / exact - 1)) < 0.01
    assert bode_png(found, found.plain.values * 1.1, "U").startswith(b"\x89PNG")


def test_what_the_fit_leaves_of_a_line_is_the_distance_of_the_curves(at_10_khz: Plays) -> None:
    """The blue dots below are the gap between dots and curve above: of a drive with a mode, too."""
    y_nm = at_10_khz.y_nm[at_10_khz.plants.index(QUIET)]
    found = at_10_khz.identified(QUIET, 0.02 * np.roll(y_nm, 7))
    measured, _ = measured_response(found)
    s, friction = found.spectra.s, found.plain.values[FRICTION] * found.spectra.friction
    slide = 1 + found.plain.values[K1] * s + found.plain.values[K2] * s**2
    with_friction = measured - friction / slide / found.spectra.u
    gap = np.abs(found.plain.response(s) / measured - 1) * np.abs(measured / with_friction)
    assert left_by_fit(found) == pytest.approx(gap, rel=0.02, abs=1e-4)


def test_noise_is_the_scatter_between_periods() -> None:
    """White noise of sigma gives a line of the mean of n periods an rms of 2 sigma / sqrt(N n)."""
    rng = np.random.default_rng(1)
    wave = multisine(GRID, 25_000.0, 1e5).u_nm
    u = np.tile(wave, (16, 1)).astype(float)
    y = u + rng.normal(0, 100.0, u.shape)
    noise = spectra_of(GRID, u, y, 0.0).noise_nm
    expected = 100.0 * 2 / np.sqrt(GRID.n_ticks * 16)
    assert np.sqrt(np.mean(noise**2)) == pytest.approx(expected, rel=0.05)


def test_lines_below_their_noise_are_left_out() -> None:
    """They are counted."""
    wave = multisine(GRID, 25_000.0, 1e5).u_nm
    y = np.tile(wave, (4, 1)).astype(float)
    spectrum = np.fft.rfft(y)
    spectrum[:, GRID.bins[-10:]] = 0
    spectra = spectra_of(GRID, y, np.fft.irfft(spectrum), 100.0)
    assert spectra.n_lost == 10
    assert spectra.bins.size == GRID.excited.size - 10


def test_friction_of_a_tick_is_that_of_its_middle() -> None:
    """A direction that is a sine in time comes out as that sine, though given by means of ticks."""
    wave = multisine(GRID, 25_000.0, 1e5).u_nm.astype(float)[None]
    edges = 2 * np.pi * 55 * np.arange(GRID.n_ticks + 1) / GRID.tick_hz
    means = -np.diff(np.cos(edges)) / np.diff(edges)
    friction = spectra_of(GRID, wave, wave, 0.0).with_friction(means[None]).friction
    expected = np.where(GRID.excited == 11, -1j, 0)
    assert np.max(np.abs(friction - expected)) < 1e-9


TICK_S = 5e-5
DRIVE = np.array([7e-4, 3e-7, 3000.0, 1e-4])  # friction of 10 m/s2


def test_friction_as_it_is_played() -> None:
    """A slide at rest holds the push, one that moves all of it; a dead time moves it by ticks."""
    shares = friction_of(DRIVE, np.full(400, 1500.0), TICK_S)
    assert abs(shares[-1] - 0.5) < 1e-6
    ramp = 500.0 * np.arange(2000.0)
    assert np.allclose(friction_of(DRIVE, ramp, TICK_S)[1000:], 1.0)
    assert np.allclose(friction_of(DRIVE, -ramp, TICK_S)[1000:], -1.0)
    t = np.arange(4000) * TICK_S
    u_nm = 200_000 * np.sin(2 * np.pi * 40 * t)
    now = friction_of(DRIVE, u_nm, TICK_S)
    later = friction_of(DRIVE + np.array([0, 0, 0, TICK_S]), u_nm, TICK_S)
    assert np.max(np.abs(now[:-1] - later[1:])) < 1e-9


BELIEVED = Believed(10_000.0, 800_000, 300_000, 120_000, 4000, 10, 1_200_000, 400_000, 250_000)


def test_settings_are_the_drive(at_10_khz: Plays) -> None:
    """What would be set, with the latency of the scale taken off the lead."""
    found = at_10_khz.identified(RUBBING, with_mode=True)
    lines = report(found, BELIEVED, OVAL, "oval", is_good=True)
    said = dict(line.split()[2:] for line in lines if line.startswith("tools/camctl set"))
    plant = Plant()
    assert abs(int(said["k1_ns"]) / (plant.k1_s * 1e9) - 1) < 0.003
    assert abs(int(said["k2_us2"]) / (plant.k2_s2 * 1e12) - 1) < 0.003
    assert abs(int(said["lead_ns"]) - (plant.lead_s(10_000.0) * 1e9 - 4000)) < 1000
    keys = dict(line.split(" = ") for line in lines if " = " in line)
    assert abs(float(keys["bandwidth_hz"]) - 300) < 1
    assert abs(float(keys["damping"]) - 0.7) < 0.003
    assert abs(float(keys["delay_us"]) - 71) < 1
    assert any(line.startswith("friction adds up to 1.") for line in lines)
    text = "\n".join(lines)
    assert "oval at 3000 r/min: U moves at up to 314 mm/s and 197 m/s2" in text
    told = "lead: dead time and half a tick of hold; the latency of the scale cannot be separated"
    assert told in text


OVAL = ToolMotion(500_000 * np.cos(4 * np.pi * np.arange(256) / 256), 3000.0)  # 1 mm, 100 Hz
W = 2 * np.pi * 100.0


def values_of(plant: Plant, friction_nm: float = 0.0) -> np.ndarray:
    """Return the constants of a drive at 20 kHz."""
    return np.array([plant.k1_s, plant.k2_s2, friction_nm, plant.lead_s(20_000.0)])


def test_slow_drive_against_one_that_is_played() -> None:
    """A drive 10 % slower and more damped than believed is off by tens of micrometres."""
    plant = Plant(hz=270, damping=0.77, quantum_nm=0.1)
    believed = values_of(Plant())
    t = np.arange(4000) / 20_000.0
    u = 500_000 * np.cos(W * (t + believed[3]))
    du, ddu = -500_000 * W * np.sin(W * (t + believed[3])), -(W**2) * u
    y = played([plant], u + believed[0] * du + believed[1] * ddu, 20_000.0)[0]
    left_nm = np.max(np.abs(y - 500_000 * np.cos(W * t))[2000:])
    response = second_order(OVAL.s, values_of(plant))
    assert form_error_nm(OVAL, believed, response) == pytest.approx(left_nm, rel=0.01)
    assert left_nm > 30_000


def test_deviation_of_the_error_is_that_of_many_draws() -> None:
    """Correlated errors of the constants, drawn."""
    true = values_of(Plant())
    spread = np.diag([3e-6, 1e-9, 0, 1e-6])
    spread[0, 3] = -0.9e-6
    covariance = spread @ spread.T
    rng = np.random.default_rng(4)
    draws = true + rng.normal(size=(400, 4)) @ spread.T
    response = second_order(OVAL.s, true)
    largest = [form_error_nm(OVAL, draw, response) for draw in draws]
    sigma = form_sigma_nm(OVAL, true, covariance)
    assert 0.6 * sigma < np.median(largest) < 1.5 * sigma


def test_friction_is_its_length_times_the_drive() -> None:
    """A square wave of the friction's length at the part's speed."""
    plant = Plant()
    friction_nm = plant.k2_s2 * 10e9
    left = friction_error_nm(OVAL, values_of(plant, friction_nm))
    assert friction_nm < left < 1.4 * friction_nm


def test_motion_is_that_of_the_table(generated: GeneratedSkirt) -> None:
    """Peaks of U at 2500 r/min, against those of the generator."""
    motion = motion_of(generated.table, 2500.0)
    bounds = generated.table.bounds
    omega = 2 * np.pi * 2500 / 60
    assert motion.peak_speed_mm_s == pytest.approx(
        bounds.u1_peak_nm_per_rad * omega * 1e-6, rel=0.02
    )
    assert motion.peak_acceleration_m_s2 == pytest.approx(
        bounds.u2_peak_nm_per_rad2 * omega**2 * 1e-9, rel=0.05
    )
