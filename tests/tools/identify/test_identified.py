# SPDX-License-Identifier: Apache-2.0
"""Constants found, against drives of another make whose constants are known (drive_plant.py)."""

from dataclasses import replace

import numpy as np
import pytest

from camtools.identify.fit import K1, K2, LEAD
from camtools.identify.identified import Identified, Limits, identify
from camtools.identify.multisine import Grid, multisine
from camtools.identify.recording import record_of
from tests.tools.cases.drive_plant import Plant, faded, played

N_PERIODS = 5
GRID = Grid.of(20_000.0)


def identified(
    plants: list[Plant], rms_nm: float, grid: Grid = GRID, *, with_mode: bool = True
) -> list[Identified]:
    """Excite drives and return what is found of each."""
    u_nm = faded(multisine(grid, rms_nm, 300_000.0), N_PERIODS)
    y_nm = played(plants, u_nm, grid.tick_hz)
    ticks = np.arange(u_nm.size)
    records = [
        record_of(grid, ticks, u_nm, row, plant.quantum_nm)
        for plant, row in zip(plants, y_nm, strict=True)
    ]
    return [identify(record, with_mode=with_mode) for record in records]


def errors(found: Identified, plant: Plant, grid: Grid = GRID) -> tuple[float, float, float]:
    """Return the errors of k1 and k2 as shares, and of the lead [s]."""
    plain = found.plain
    return (
        plain.k1_s / plant.k1_s - 1,
        plain.k2_s2 / plant.k2_s2 - 1,
        plain.lead_s - plant.lead_s(grid.tick_hz),
    )


DRIVES = [
    Plant(),
    Plant(hz=220, damping=0.5, delay_us=125),
    Plant(hz=450, damping=1.1, delay_us=50),
    Plant(hz=150, damping=0.7, delay_us=200),
]


def test_constants_are_within_a_percent() -> None:
    """1 % of k1 and k2, 2 us of lead, friction up to 20 m/s2, scales up to 1 um."""
    plants = [
        replace(drive, quantum_nm=quantum_nm, friction_m_s2=friction)
        for drive in DRIVES
        for friction in (5.0, 20.0)
        for quantum_nm in (10.0, 100.0, 1000.0)
    ]
    all_found = identified(plants, 38_000.0, with_mode=False)  # as 250 m/s2 allow
    for plant, found in zip(plants, all_found, strict=True):
        k1, k2, lead_s = errors(found, plant)
        assert abs(k1) < 0.01 and abs(k2) < 0.01 and abs(lead_s) < 2e-6, plant
        assert found.problems(Limits()) == [], plant
        expected = max(0.03 * plant.friction_m_s2, 1.0 if plant.quantum_nm >= 1000 else 0.1)
        assert abs(found.plain.friction_m_s2 - plant.friction_m_s2) < expected, plant


def test_default_machine_with_friction() -> None:
    """As expected of control by a scale of 10 nm: far below a percent."""
    plant = Plant(friction_m_s2=5)
    (found,) = identified([plant], 25_000.0)
    k1, k2, lead_s = errors(found, plant)
    assert abs(k1) < 1e-3 and abs(k2) < 1e-3 and abs(lead_s) < 0.5e-6
    assert found.plain.friction_m_s2 == pytest.approx(5, abs=0.05)
    assert not found.has_mode
    assert found.gain.share == pytest.approx(1, abs=1e-3)


@pytest.mark.parametrize("tick_hz", [10_000.0, 40_000.0])
def test_other_tick_rates(tick_hz: float) -> None:
    """The grid adapts."""
    grid = Grid.of(tick_hz)
    plant = Plant(friction_m_s2=5)
    (found,) = identified([plant], 25_000.0, grid, with_mode=False)
    k1, k2, lead_s = errors(found, plant, grid)
    assert abs(k1) < 0.01 and abs(k2) < 0.01 and abs(lead_s) < 2e-6
    assert found.problems(Limits()) == []


def test_mode_is_said_to_bias_the_fit_and_by_how_much() -> None:
    """The reported bias is the true one; the drive beside its mode is found."""
    plants = [
        Plant(mode_hz=800, mode_share=0.1),
        Plant(mode_hz=800, mode_share=0.1, friction_m_s2=10),
        Plant(mode_hz=400, mode_share=0.02),
        Plant(mode_hz=1500, mode_share=0.2, friction_m_s2=5),
    ]
    for plant, found in zip(plants, identified(plants, 25_000.0), strict=True):
        k1, k2, lead_s = errors(found, plant)
        assert found.has_mode, plant
        assert found.problems(Limits()) == []
        assert found.with_mode is not None
        assert found.judged(Limits()) is found.with_mode
        beside = found.with_mode.values
        assert beside[[K1, K2]] == pytest.approx([plant.k1_s, plant.k2_s2], rel=4e-3)
        assert found.with_mode.mode.hz == pytest.approx(plant.mode_hz, rel=0.04)
        assert found.bias[K1] == pytest.approx(k1, abs=2e-3)
        assert found.bias[K2] == pytest.approx(k2, abs=4e-3)
        assert found.bias[LEAD] == pytest.approx(lead_s, abs=3e-6)


def test_standard_deviations_are_honest() -> None:
    """Over many records of noise, errors are as large as is said: chi squared of each constant."""
    plant = Plant(quantum_nm=10.0)
    u_nm = faded(multisine(GRID, 25_000.0, 300_000.0, 10.0), N_PERIODS)
    clean = played([plant], u_nm, GRID.tick_hz)[0]
    rng = np.random.default_rng(3)
    ticks = np.arange(u_nm.size)
    squares = []
    for _ in range(60):
        y_nm = clean + rng.normal(0, 300.0, clean.size)
        found = identify(record_of(GRID, ticks, u_nm, y_nm, 10.0), with_mode=False)
        off = np.array(errors(found, plant)) * [plant.k1_s, plant.k2_s2, 1]
        squares.append((off / found.plain.sigmas[[K1, K2, LEAD]]) ** 2)
    chi = np.mean(squares, axis=0)
    assert np.all(chi > 0.5) and np.all(chi < 1.8), chi


def test_scale_that_is_wrong_is_noticed() -> None:
    """A drive that moves 3 % more than commanded has a gear or a scale that is wrong."""
    (found,) = identified([Plant(gain=1.03)], 25_000.0, with_mode=False)
    assert found.gain.share == pytest.approx(1.03, abs=2e-3)
    assert any("U moves 1.03" in problem for problem in found.problems(Limits()))
    worse = replace(found.plain, misfit=1.5, covariance=1e-8 * np.eye(4))  # 100 us
    said = replace(found, plain=worse).problems(Limits())
    assert any("lead is known to 100 us" in problem for problem in said)
    assert any("leaves 150 %" in problem for problem in said)
