"""The spindle as it plays a law, against differential equations solved by another method."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from camtools.base.quantities import Floats
from camtools.cut.speed_law import N_GRID, Load, full, grid_rad, uniform
from camtools.cut.spindle_loop import SpindleLoop, _PlayedSpindle, played_ripple

FAST = SpindleLoop(1000.0, 1e6, 1e4, 0.0)


def oval_load(swing: float = 0.33) -> Load:
    """Return a section whose area swings about its mean twice per turn."""
    phi = np.pi * np.arange(N_GRID) / N_GRID
    return Load(5 * (1 - swing * np.cos(2 * phi)), np.sin(2 * phi) / 10, np.cos(2 * phi) / 5, np.pi)


@pytest.mark.parametrize(
    ("alpha", "told"), [(1e9, 90.0), (400.0, 90.0), (400.0, 20.0), (50.0, 80.0)]
)
def test_step_solves_the_spindle(alpha: float, told: float) -> None:
    """Speed and angle with and without torque to spare, up and down."""
    loop = SpindleLoop(40.0, alpha, 1e3, 0.0)
    spindle = _PlayedSpindle(1, 60.0, loop)
    spindle.step(np.array([told]), 0.05)

    def slope(_t: float, y: Floats) -> list[float]:
        return [float(np.clip(40.0 * (told - y[0]), -alpha, alpha)), float(y[0])]

    exact = solve_ivp(slope, (0, 0.05), [60.0, 0.0], rtol=1e-10, atol=1e-12, max_step=1e-4)
    assert spindle.omega[0] == pytest.approx(exact.y[0, -1], abs=1e-4)
    assert spindle.phi[0] == pytest.approx(exact.y[1, -1], abs=1e-5)


def test_uniform_turning_ripples_by_the_area() -> None:
    """And the spindle's own ripple comes on top."""
    law = uniform(oval_load())
    assert played_ripple([law], 25.0, FAST)[0] == pytest.approx(0.66, abs=1e-3)
    noisy = FAST._replace(ripple=0.002)
    assert played_ripple([law], 25.0, noisy)[0] == pytest.approx(0.664, abs=1e-3)


def test_fast_loop_plays_the_law() -> None:
    """What is left is the hold of the set-point."""
    law = full(oval_load())
    assert law.ripple < 1e-9
    assert played_ripple([law], 25.0, FAST)[0] < 0.003


def test_set_point_below_0_is_not_taken() -> None:
    """A loop of 40 rad/s cannot brake as the law asks at 600 r/min: the ripple is told."""
    law = full(oval_load())
    assert law.fall * 62.8 > 40
    assert played_ripple([law], 62.8, SpindleLoop(40.0, 1e6, 1e4, 0.0))[0] > 0.05


def test_weak_torque_is_told() -> None:
    """Half of the acceleration that the law needs."""
    law = full(oval_load())
    needed = law.peaks[0] * 25.0**2
    assert played_ripple([law], 25.0, SpindleLoop(1000.0, needed / 2, 1e4, 0.0))[0] > 0.05


def test_set_points_are_those_of_the_inverse() -> None:
    """They are r + c r r' on the grid."""
    law = full(oval_load())
    phi = grid_rad(law.load)
    told = law.set_points(0.5)
    step = 1e-5
    slope = (law.ratio(phi + step) - law.ratio(phi - step)) / (2 * step)
    np.testing.assert_allclose(told, law.ratio(phi) * (1 + 0.5 * slope), rtol=1e-6)
