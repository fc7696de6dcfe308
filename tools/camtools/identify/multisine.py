"""The excitation of U: a periodic sum of sines, and its limits, MATHS.md (150).

The period is a whole number of ticks, so that every line stands in a bin of the discrete Fourier
transform and none leaks into another. Odd lines carry the multisine; the carrier is an even line,
large and slow, that keeps U moving, for a slide that sticks has no transfer function.

>>> grid = Grid.of(20_000.0)
>>> grid.n_ticks, grid.line_hz, float(grid.bins[-1] * grid.line_hz)
(4000, 5.0, 695.0)
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from camtools.base.quantities import Floats, Ints

Complexes = npt.NDArray[np.complex128]

LINE_HZ = 5.0
HIGHEST_HZ = 700.0
FLAT_HZ = 100.0  # amplitudes are alike up to here and fall with 1/f above
TICKS_PER_HIGHEST = 12  # a line has at least so many ticks: images of the hold stay small
CARRIER_LINE = 4  # 20 Hz
N_PERIODS, N_DROPPED = 5, 1
NM_PER_MM = 1e6
_N_ROUNDS = 150
_OVERSAMPLED = 8


@dataclass(frozen=True)
class Grid:
    """The lines of an excitation at a tick rate."""

    tick_hz: float
    n_ticks: int  # of a period
    highest_hz: float  # no line lies above

    @classmethod
    def of(
        cls, tick_hz: float, highest_hz: float = HIGHEST_HZ, least_ticks: int = TICKS_PER_HIGHEST
    ) -> Grid:
        """Return the grid of a tick rate [Hz]; a period of the highest line has least_ticks."""
        highest_hz = min(highest_hz, tick_hz / least_ticks)
        return cls(tick_hz, round(tick_hz / LINE_HZ), highest_hz)

    @property
    def line_hz(self) -> float:
        """Distance of neighbouring bins [Hz]."""
        return self.tick_hz / self.n_ticks

    @property
    def bins(self) -> Ints:
        """Odd bins that the multisine excites, rising."""
        return np.arange(1, int(self.highest_hz / self.line_hz + 1e-9) + 1, 2, dtype=np.int64)

    @property
    def excited(self) -> Ints:
        """All excited bins, the carrier's with them, rising."""
        return np.sort(np.append(self.bins, CARRIER_LINE))


class WavePeaks(NamedTuple):
    """What a wave asks of U at most, all of it at or above 0."""

    travel_mm: float  # to either side of its middle
    speed_mm_s: float
    acceleration_mm_s2: float


@dataclass(frozen=True)
class Wave:
    """One period of an excitation about its middle."""

    grid: Grid
    u_nm: Ints  # shape (n_ticks,); whole multiples of the quantum
    rms_nm: float  # of the multisine alone
    carrier_nm: float  # amplitude of the carrier
    peaks: WavePeaks  # of the continuous wave


def _shape(bins: Ints, line_hz: float) -> Floats:
    """Return the amplitudes of the lines for 1 rms."""
    frequency_hz = bins * line_hz
    shape = np.where(frequency_hz <= FLAT_HZ, 1.0, FLAT_HZ / frequency_hz)
    return np.asarray(shape / np.sqrt(0.5 * np.sum(shape**2)))


def _wave_of(bins: Ints, lines: Complexes, n: int) -> Floats:
    spectrum = np.zeros(n // 2 + 1, np.complex128)
    spectrum[bins] = lines * (n / 2)
    return np.asarray(np.fft.irfft(spectrum, n))


@cache
def _phases(n_lines: int) -> Floats:
    """Return phases [rad] for which the acceleration of odd lines has a low crest."""
    bins = 2 * np.arange(n_lines, dtype=np.int64) + 1
    amplitude = _shape(bins, LINE_HZ) * bins**2  # of the acceleration
    power = amplitude**2 / np.sum(amplitude**2)
    before = np.concatenate(([0.0], np.cumsum(power)[:-1]))
    phase = -2 * np.pi * np.cumsum(before) * 2
    n = 1 << int(np.ceil(np.log2(int(np.max(bins)) * _OVERSAMPLED)))
    best, best_peak = phase, np.inf
    for i in range(_N_ROUNDS):
        wave = _wave_of(bins, amplitude * np.exp(1j * phase), n)
        peak = float(np.max(np.abs(wave)))
        if peak < best_peak:
            best, best_peak = phase, peak
        level = peak * (0.75 + 0.22 * i / _N_ROUNDS)
        phase = np.angle(np.fft.rfft(np.clip(wave, -level, level))[bins])
    return best


def _peaks(bins: Ints, lines: Complexes, line_hz: float) -> WavePeaks:
    n = 1 << int(np.ceil(np.log2(int(np.max(bins)) * _OVERSAMPLED)))
    s = 2j * np.pi * line_hz * bins
    waves = (_wave_of(bins, lines * s**order, n) for order in range(3))
    return WavePeaks(*(float(np.max(np.abs(wave))) / NM_PER_MM for wave in waves))


def multisine(grid: Grid, rms_nm: float, carrier_nm: float, quantum_nm: float = 1.0) -> Wave:
    """Return an excitation, always the same, rounded to whole multiples of a quantum."""
    bins = grid.bins
    lines = rms_nm * _shape(bins, grid.line_hz) * np.exp(1j * _phases(bins.size))
    bins = np.append(bins, CARRIER_LINE)
    lines = np.append(lines, -1j * carrier_nm)
    quantum = max(1.0, quantum_nm)
    exact = _wave_of(bins, lines, grid.n_ticks)
    return Wave(
        grid=grid,
        u_nm=np.asarray(np.round(np.round(exact / quantum) * quantum), np.int64),
        rms_nm=rms_nm,
        carrier_nm=carrier_nm,
        peaks=_peaks(bins, lines, grid.line_hz),
    )
