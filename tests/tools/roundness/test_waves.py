# SPDX-License-Identifier: Apache-2.0
"""Filter and harmonics against the standard's own convolution and against least squares."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from camtools.base.quantities import Floats
from camtools.roundness.oval import axes_of
from camtools.roundness.waves import UPR_CHOICES, harmonics, low_pass, transmission

N = 3600
PHI = 2 * np.pi * np.arange(N) / N


def convolved(profile: Floats, cutoff_upr: float) -> Floats:
    """Return the filtered profile by ISO 16610-21: sums with the weights, around the turn."""
    alpha, wave = np.sqrt(np.log(2) / np.pi), 1 / cutoff_upr
    x = np.arange(-N, N + 1) / N  # one turn to both sides is where the weights have vanished
    weights = np.exp(-np.pi * (x / (alpha * wave)) ** 2) / (alpha * wave) / N
    around = np.concatenate([profile, profile, profile])
    sums = np.convolve(around, weights, mode="same")
    return np.asarray(sums[N : 2 * N], dtype=np.float64)


@pytest.mark.parametrize("upr", UPR_CHOICES)
def test_filter_is_the_convolution_of_the_standard(upr: int) -> None:
    """Steps, noise and waves come out the same by both ways, up to what sampled weights alias."""
    draw = np.random.default_rng(upr)
    profile = draw.normal(size=N) + 3.0 * (PHI > 2) + np.cos(upr * PHI)
    aliased = 1e-9 + float(transmission(N / 2, upr))  # 1e-4 of the noise at 500, else nothing
    assert low_pass(profile, upr) == pytest.approx(convolved(profile, upr), abs=aliased)


@pytest.mark.parametrize("upr", UPR_CHOICES)
def test_half_is_let_through_at_the_cutoff(upr: int) -> None:
    """A wave at the cut-off keeps half of its height and its phase, the mean stays as it is."""
    wave = np.cos(upr * PHI - 0.7)
    assert low_pass(5 + wave, upr) == pytest.approx(5 + wave / 2, abs=1e-12)
    alpha = np.sqrt(np.log(2) / np.pi)
    order = np.arange(4.0 * upr)
    of_standard = np.exp(-np.pi * (alpha * order / upr) ** 2)
    assert transmission(order, upr) == pytest.approx(of_standard, abs=1e-15)


def test_harmonics_are_those_of_least_squares() -> None:
    """Cosines and sines fitted by lstsq have the amplitudes and the crests of the sums."""
    draw = np.random.default_rng(5)
    profile = draw.normal(size=N).cumsum() * 1e-3
    rows = [np.ones(N)]
    for order in range(1, 51):
        rows += [np.cos(order * PHI), np.sin(order * PHI)]
    fitted = np.linalg.lstsq(np.column_stack(rows), profile, rcond=None)[0]
    for one, (a, b) in zip(harmonics(profile), fitted[1:].reshape(50, 2), strict=True):
        assert one.amplitude == pytest.approx(np.hypot(a, b), abs=1e-12)
        crest_rad = np.radians(one.phase_deg) * one.order
        assert one.amplitude * np.cos(crest_rad) == pytest.approx(a, abs=1e-12)
        assert one.amplitude * np.sin(crest_rad) == pytest.approx(b, abs=1e-12)
        assert 0 <= one.phase_deg < 360 / one.order + 1e-9


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 1000), st.integers(0, N - 1), st.floats(0.1, 10))
def test_filter_and_amplitudes_turn_and_scale_with_the_part(
    seed: int, places: int, scale: float
) -> None:
    """Filtering commutes with turning and scaling; amplitudes stay, crests turn along."""
    profile = np.random.default_rng(seed).normal(size=N)
    other = scale * np.roll(profile, places)
    turned = scale * np.roll(low_pass(profile, 50), places)
    assert low_pass(other, 50) == pytest.approx(turned, abs=1e-9)
    for one, two in zip(harmonics(profile), harmonics(other), strict=True):
        assert two.amplitude == pytest.approx(scale * one.amplitude, abs=1e-9)
        off_deg = two.phase_deg - one.phase_deg - 360 * places / N
        assert np.exp(1j * np.radians(off_deg * one.order)) == pytest.approx(1, abs=1e-6)


@settings(max_examples=60, deadline=None)
@given(st.floats(-80, 80), st.floats(0.01, 0.5), st.floats(0, 0.002))
def test_axes_of_an_ellipse(phase_deg: float, g_mm: float, off_mm: float) -> None:
    """Half axes, phase, and what an eccentricity adds: less than its square over the radius."""
    a, b, at = 46.0, 46.0 - g_mm / 2, PHI - np.radians(phase_deg)
    radius_mm = a * b / np.hypot(b * np.cos(at), a * np.sin(at))
    found = axes_of(radius_mm + off_mm * np.cos(PHI))
    sampled_mm = 2 * g_mm * (np.pi / N) ** 2
    assert found.long_mm == pytest.approx(2 * a, abs=1e-12 + sampled_mm)
    assert found.short_mm == pytest.approx(2 * b, abs=1e-12 + sampled_mm)
    assert found.ovality_mm == pytest.approx(g_mm, abs=2 * sampled_mm + 1e-12)
    assert found.phase_deg == pytest.approx(phase_deg, abs=1e-6)
