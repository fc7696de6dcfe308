"""MATHS.md (141) to (145): the equations of learning, apart from the firmware that uses them."""

import itertools
import tomllib

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.tools.cases.camsim_cases import ROOT

Complexes = NDArray[np.complex128]
GAINS = (0.1, 0.15, 0.3, 0.5, 0.6)
TURN_S = 60 / 3000


def radius(gain: float, rho: float, phi_rad: float, turns: int) -> float:
    """Return the largest root of E[n+1] = E[n] - g rho e^(j phi) E[n-d]."""
    polynomial = np.zeros(turns + 2, complex)
    polynomial[0], polynomial[1] = 1, -1
    polynomial[-1] += gain * rho * np.exp(1j * phi_rad)
    return float(np.abs(np.roots(polynomial)).max())


@pytest.mark.parametrize("turns", [0, 1, 2])
def test_the_bound_is_where_the_roots_leave_the_circle(turns: int) -> None:
    """MATHS.md (144), half to twice the gain and up to 80 degrees: the bound itself."""
    for rho, phi_deg in itertools.product((0.5, 0.8, 1.0, 1.4, 2.0), range(-80, 81, 10)):
        phi = np.radians(phi_deg)
        most = 2 * np.sin((np.pi / 2 - abs(phi)) / (2 * turns + 1)) / rho
        assert radius(0.98 * most, rho, phi, turns) < 1 < radius(1.02 * most, rho, phi, turns)


def drive(s: Complexes, bandwidth_hz: float, damping: float, delay_us: float) -> Complexes:
    """Return the frequency response of a drive."""
    w = 2 * np.pi * bandwidth_hz
    response = np.exp(-s * delay_us * 1e-6) / (1 + 2 * damping * s / w + (s / w) ** 2)
    return np.asarray(response, np.complex128)


def off_model(believed: dict[str, float], harmonics: Complexes) -> Complexes:
    """Return the true answer of U over that of the believed drive, both seen from the led angle."""
    s = 2j * np.pi * harmonics / TURN_S
    true = drive(s, 300, 0.7, 75)
    of_model = drive(s, believed["bandwidth_hz"], believed["damping"], believed["delay_us"])
    return np.asarray(true / of_model, np.complex128)


@pytest.mark.parametrize("machine", ["wrong", "perkins", "doubles"])
def test_layer_1_is_stable_on_the_machines_that_are_believed_wrong(machine: str) -> None:
    """At the harmonics of an ellipse, with the answer of the believed drive and every gain."""
    text = (ROOT / "tests" / "learn" / "machines" / f"{machine}.toml").read_text()
    believed = tomllib.loads(text)["believed"]["u"]
    ratios = off_model(believed, np.array([2, 4], np.complex128))
    for gain, ratio in itertools.product(GAINS, ratios):
        assert radius(gain, float(abs(ratio)), float(np.angle(ratio)), 0) < 1


def test_a_mode_turns_the_phase_so_far_that_the_model_diverges() -> None:
    """A mode at 800 Hz seen by the scale is harmonic 16: without the probe it would be driven."""
    s = 2j * np.pi * np.arange(1, 17) / TURN_S
    w = 2 * np.pi * 800.0
    with_mode = 1 - s**2 / (s**2 + 2 * 0.03 * w * s + w**2)
    radii = [radius(0.5, float(abs(m)), float(np.angle(m)), 0) for m in with_mode]
    assert max(radii[:12]) < 1 < max(radii[14:])


def test_both_constants_follow_from_the_error_of_one_harmonic() -> None:
    """MATHS.md (141) against the exact response of a drive whose constants are a little wrong."""
    w = 2 * np.pi * 2 / TURN_S
    k1, k2, by1, by2 = 743e-6, 281e-9, 2e-6, -1.5e-9
    answer = 1 / (1 + 1j * w * (k1 + by1) - w**2 * (k2 + by2))
    error = 1 - (1 + 1j * w * k1 - w**2 * k2) * answer
    v = answer
    assert np.imag(error * np.conj(v)) / (w * abs(v) ** 2) == pytest.approx(by1, rel=1e-9)
    assert -np.real(error * np.conj(v)) / (w**2 * abs(v) ** 2) == pytest.approx(by2, rel=1e-9)


def test_a_straight_line_between_two_ticks_costs_62_nanometres() -> None:
    """MATHS.md (145): 0.5 mm, harmonic 2 of 3000 r/min, 20 kHz, half way between two ticks."""
    w = 2 * np.pi * 100 / 20_000
    phase = np.linspace(0, 2 * np.pi, 721)
    line = 0.5 * (np.cos(phase - w / 2) + np.cos(phase + w / 2))
    off_nm = 0.5e6 * (np.cos(phase) - line).max()
    assert off_nm == pytest.approx(0.5e6 * w**2 / 8, rel=1e-3)
    assert f"{off_nm:.0f}" == "62"
