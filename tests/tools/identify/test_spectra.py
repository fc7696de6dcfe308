# SPDX-License-Identifier: Apache-2.0
"""Lines of a record, their noise, friction as a spectrum."""

import numpy as np
import pytest

from camtools.identify.multisine import Grid, multisine
from camtools.identify.spectra import spectra_of

GRID = Grid.of(20_000.0)


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
