# SPDX-License-Identifier: Apache-2.0
"""What wrong constants cost a part, against formulas of one harmonic and against a drive played."""

import numpy as np
import pytest

from camtools.identify.fit import second_order
from camtools.identify.part_error import (
    ToolMotion,
    form_error_nm,
    form_sigma_nm,
    friction_error_nm,
    motion_of,
)
from camtools.skirt.table.generate import GeneratedSkirt
from tests.tools.cases.drive_plant import Plant, played

OVAL = ToolMotion(500_000 * np.cos(4 * np.pi * np.arange(256) / 256), 3000.0)  # 1 mm, 100 Hz
W = 2 * np.pi * 100.0


def values_of(plant: Plant, friction_nm: float = 0.0) -> np.ndarray:
    """Return the constants of a drive at 20 kHz."""
    return np.array([plant.k1_s, plant.k2_s2, friction_nm, plant.lead_s(20_000.0)])


@pytest.mark.parametrize(
    ("off", "expected_nm"),
    [
        ([1e-6, 0, 0, 0], 500_000 * W * 1e-6),
        ([0, 1e-9, 0, 0], 500_000 * W**2 * 1e-9),
        ([0, 0, 0, 1e-6], 500_000 * W * 1e-6),
    ],
)
def test_small_errors_of_one_harmonic(off: list[float], expected_nm: float) -> None:
    """Speed or acceleration times the error of its constant, attenuated by the drive."""
    true = values_of(Plant())
    response = second_order(OVAL.s, *true[[0, 1, 3]])
    slide = abs(1 / (1 + true[0] * 1j * W + true[1] * (1j * W) ** 2)) if off[3] == 0 else 1.0
    error_nm = form_error_nm(OVAL, true + np.array(off), response)
    assert error_nm == pytest.approx(expected_nm * slide, rel=0.01)


def test_slow_drive_against_one_that_is_played() -> None:
    """A drive 10 % slower and more damped than believed is off by tens of micrometres."""
    plant = Plant(hz=270, damping=0.77, quantum_nm=0.1)
    believed = values_of(Plant())
    t = np.arange(4000) / 20_000.0
    u = 500_000 * np.cos(W * (t + believed[3]))
    du, ddu = -500_000 * W * np.sin(W * (t + believed[3])), -(W**2) * u
    y = played([plant], u + believed[0] * du + believed[1] * ddu, 20_000.0)[0]
    left_nm = np.max(np.abs(y - 500_000 * np.cos(W * t))[2000:])
    response = second_order(OVAL.s, *values_of(plant)[[0, 1, 3]])
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
    response = second_order(OVAL.s, *true[[0, 1, 3]])
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
