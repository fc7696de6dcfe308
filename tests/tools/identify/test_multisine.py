# SPDX-License-Identifier: Apache-2.0
"""The excitation: its lines, its crest, its peaks."""

import numpy as np
import pytest

from camtools.identify.multisine import CARRIER_LINE, Grid, multisine


@pytest.mark.parametrize("tick_hz", [20_000.0, 40_000.0, 10_000.0, 5000.0, 7777.0, 100_000.0])
def test_only_odd_lines_and_the_carrier_are_excited(tick_hz: float) -> None:
    """Flat up to 100 Hz, then with 1/f; nothing elsewhere but rounding."""
    grid = Grid.of(tick_hz)
    wave = multisine(grid, 25_000.0, 150_000.0)
    assert wave.u_nm.size == grid.n_ticks
    amplitude = np.abs(np.fft.rfft(wave.u_nm)) * 2 / grid.n_ticks
    assert amplitude[CARRIER_LINE] == pytest.approx(150_000.0, abs=1.0)
    flat = amplitude[1]
    for i in grid.bins:
        hz = i * grid.line_hz
        assert amplitude[i] == pytest.approx(flat * min(1.0, 100.0 / hz), abs=1.0)
    amplitude[grid.excited] = 0.0
    assert amplitude.max() < 1.0
    assert grid.bins[-1] * grid.line_hz <= min(700.0, tick_hz / 12)


def test_amplitude_is_the_rms_of_the_odd_lines() -> None:
    """Parseval, with the carrier left out."""
    grid = Grid.of(20_000.0)
    wave = multisine(grid, 25_000.0, 300_000.0)
    spectrum = np.fft.rfft(wave.u_nm)
    spectrum[CARRIER_LINE] = 0
    assert np.std(np.fft.irfft(spectrum)) == pytest.approx(25_000.0, rel=1e-4)


def test_crest_of_the_acceleration_is_low() -> None:
    """Random phases have 3 and more, Schroeder's 1.7 and more."""
    grid = Grid.of(20_000.0)
    wave = multisine(grid, 25_000.0, 0.0)
    line = np.zeros(grid.n_ticks // 2 + 1, complex)
    line[grid.bins] = np.fft.rfft(wave.u_nm)[grid.bins] * (2j * np.pi * grid.bins * 5.0) ** 2
    acceleration = np.fft.irfft(line)
    assert np.max(np.abs(acceleration)) / np.std(acceleration) < 1.68


def test_peaks_are_those_of_the_wave() -> None:
    """Travel, speed and acceleration against differences of a finely ticked wave."""
    grid = Grid.of(100_000.0)
    wave = multisine(grid, 1e6, 3e6)
    u_mm = wave.u_nm * 1e-6
    speed = np.gradient(np.tile(u_mm, 3), 1 / grid.tick_hz)
    acceleration = np.gradient(speed, 1 / grid.tick_hz)[grid.n_ticks : 2 * grid.n_ticks]
    assert wave.peaks.travel_mm == pytest.approx(np.max(np.abs(u_mm)), rel=0.01)
    assert wave.peaks.speed_mm_s == pytest.approx(np.max(np.abs(speed)), rel=0.01)
    assert wave.peaks.acceleration_mm_s2 == pytest.approx(np.max(np.abs(acceleration)), rel=0.01)


def test_wave_keeps_to_the_quantum_of_the_scale() -> None:
    """A drive that rounds its commands plays what the fit knows."""
    wave = multisine(Grid.of(20_000.0), 50_000.0, 300_000.0, quantum_nm=1000.0)
    assert np.all(wave.u_nm % 1000 == 0)
