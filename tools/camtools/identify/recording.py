"""Excitations of U, which are periodic sums of sines, and records of them, MATHS.md (150), (151).

The period is a whole number of ticks, so that every line stands in a bin of the discrete Fourier
transform and none leaks into another. Odd lines carry the multisine; the carrier is an even line,
large and slow, that keeps U moving, for a slide that sticks has no transfer function.

>>> grid = Grid.of(20_000.0)
>>> grid.n_ticks, grid.line_hz, float(grid.bins[-1] * grid.line_hz)
(4000, 5.0, 695.0)
>>> wave = 1000.0 * np.cos(2 * np.pi * 5 * np.arange(4000) / 4000)
>>> spectra = spectra_of(grid, np.tile(wave, (2, 1)), np.tile(0.5 * wave, (2, 1)), quantum_nm=0.0)
>>> abs(spectra.y[spectra.bins == 5]).round(3)
array([500.])
"""

from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple, Self

import numpy as np
import numpy.typing as npt

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import NM_PER_MM, Floats, Ints

Complexes = npt.NDArray[np.complex128]

LINE_HZ = 5.0
HIGHEST_HZ = 700.0
FLAT_HZ = 100.0  # amplitudes are alike up to here and fall with 1/f above
TICKS_PER_HIGHEST = 12  # a line has at least so many ticks: images of the hold stay small
CARRIER_LINE = 4  # 20 Hz
N_PERIODS, N_DROPPED = 5, 1
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
    ) -> Self:
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


MIN_PERIODS = 2
_COARSE_NM = 100.0
_AGAIN = "nothing is fitted, excite again"


@dataclass(frozen=True, eq=False)
class SettledRecord:
    """Set-points and measured positions of U in every tick of some periods, a row each."""

    grid: Grid
    u_nm: Floats  # written in a tick; in the first periods, those dropped, U settles
    y_nm: Floats  # measured in the same tick, before the set-point was written
    quantum_nm: float  # of the scale, 0 when it is not known

    @property
    def is_coarse(self) -> bool:
        """A drive that rounds its commands as its scale does plays another wave."""
        return self.quantum_nm >= _COARSE_NM

    def rounded(self) -> Self:
        """Return the record with set-points rounded to the quantum of the scale."""
        return replace(self, u_nm=np.round(self.u_nm / self.quantum_nm) * self.quantum_nm)

    @property
    def period_nm(self) -> Floats:
        """Set-points of a settled period, about their mean; all of them are alike."""
        period = self.u_nm[N_DROPPED]
        return np.asarray(period - period.mean())

    @property
    def settled(self) -> tuple[Floats, Floats]:
        """Set-points and positions of the periods that count."""
        return self.u_nm[N_DROPPED:], self.y_nm[N_DROPPED:]


def record_of(
    grid: Grid, tick: Ints, u_nm: Floats, y_nm: Floats, quantum_nm: float
) -> SettledRecord:
    """Return the whole periods at the end of a record.

    `tick`, shape (n,): number of each tick. `u_nm`, `y_nm`, shape (n,): while U plays the wave in
    full; the fading of its begin may be in periods that are dropped. Raises `CamtoolsError`: ticks
    are missing, there are too few periods, U did not move, or its set-points do not repeat.
    """
    gaps = np.flatnonzero(np.diff(tick) != 1)
    if gaps.size:
        many = "gap" if gaps.size == 1 else "gaps"
        problem = f"{gaps.size} {many}, the first after tick {int(tick[gaps[0]])}"
        raise CamtoolsError([f"record: {problem}; {_AGAIN}"])
    n_periods = tick.size // grid.n_ticks
    if n_periods < (least := N_DROPPED + MIN_PERIODS):
        problem = f"{tick.size} ticks are {n_periods} periods, a fit needs {least}"
        raise CamtoolsError([f"record: {problem}; {_AGAIN}"])
    n = n_periods * grid.n_ticks
    u, y = (np.asarray(row[-n:], np.float64).reshape(n_periods, -1) for row in (u_nm, y_nm))
    _check(u[N_DROPPED:], y[N_DROPPED:])
    return SettledRecord(grid, u, y, quantum_nm)


def _check(u_nm: Floats, y_nm: Floats) -> None:
    off_nm = float(np.max(np.abs(u_nm - u_nm[0])))
    if off_nm > 1.0:
        problem = f"the set-points of two periods differ by {off_nm:.0f} nm"
        raise CamtoolsError([f"record: {problem}: U did not play the wave; {_AGAIN}"])
    if float(np.ptp(u_nm)) == 0 or float(np.ptp(y_nm)) == 0:
        what = "U was not excited" if float(np.ptp(u_nm)) == 0 else "U did not move"
        remedy = "see that its drive is enabled and its scale is connected"
        raise CamtoolsError([f"record: {what}; {remedy}"])


STICTION_NM_S = 1e6  # friction counts in full from this speed on: 1 mm/s
_VELOCITY_HZ = 1500.0  # what is faster is noise of the scale
_SNR = 3.0  # amplitude of a line over its noise that a fit needs
_ROUNDED = 1 / np.sqrt(12)  # rms of what rounding adds, per quantum


@dataclass(frozen=True, eq=False)
class Spectra:
    """The n excited lines of a record; amplitudes as of a cosine, nm."""

    grid: Grid
    bins: Ints  # that stand above their noise
    n_lost: int  # lines that do not
    s: Complexes  # j times the angular frequency [rad/s]
    u: Complexes  # mean set-points with their hold's attenuation, but not its delay
    y: Complexes  # mean positions
    friction: Complexes  # mean direction in which U moves, -1 .. 1
    u_of: Complexes  # of each period, shape (n_periods, n), as the next two
    y_of: Complexes
    friction_of: Complexes
    noise_nm: Floats  # rms of the error of y: of periods or, if larger, of rounding by the scale

    @property
    def frequency_hz(self) -> Floats:
        """Of the lines [Hz]."""
        return np.asarray(self.bins * self.grid.line_hz)

    @property
    def n_periods(self) -> int:
        """Periods in the record."""
        return int(self.y_of.shape[0])

    def with_friction(self, shares: Floats) -> Self:
        """Return the same lines with another friction, its mean over each tick of the periods."""
        hold = np.sinc(self.bins / self.grid.n_ticks)
        half_tick = np.exp(-0.5 * self.s / self.grid.tick_hz)
        of = np.fft.rfft(shares)[:, self.bins] * (2.0 / self.grid.n_ticks) * half_tick / hold
        return replace(self, friction=of.mean(axis=0), friction_of=of)

    def only(self, rows: npt.NDArray[np.bool_]) -> Self:
        """Return some of the lines."""
        some = {name: row[..., rows] for name, row in vars(self).items() if np.ndim(row)}
        return replace(self, **some)


def _direction(grid: Grid, y: Complexes) -> Complexes:
    """Return the spectrum of the direction of motion from that of the position, as rfft."""
    frequency_hz = np.arange(y.shape[-1]) * grid.line_hz
    speed = np.where(frequency_hz <= _VELOCITY_HZ, 2j * np.pi * frequency_hz, 0.0) * y
    speed_nm_s = np.fft.irfft(speed, grid.n_ticks)
    return np.asarray(np.fft.rfft(np.clip(speed_nm_s / STICTION_NM_S, -1.0, 1.0)))


def spectra_of(grid: Grid, u_nm: Floats, y_nm: Floats, quantum_nm: float) -> Spectra:
    """Return the excited lines of settled periods; the quantum of the scale is 0 if not known."""
    bins = grid.excited
    n_periods = y_nm.shape[0]
    u_full, y_full = np.fft.rfft(u_nm), np.fft.rfft(y_nm)
    scale = 2.0 / grid.n_ticks
    direction = _direction(grid, y_full)[:, bins] * scale
    u_of, y_of = u_full[:, bins] * scale, y_full[:, bins] * scale
    y = y_of.mean(axis=0)
    scatter = np.sqrt(np.sum(np.abs(y_of - y) ** 2, axis=0) / max(1, n_periods - 1) / n_periods)
    rounded = quantum_nm * _ROUNDED * np.sqrt(2.0 * scale)
    noise_nm = np.maximum(scatter, rounded)
    seen = np.abs(y) > _SNR * noise_nm
    hold = np.sinc(bins / grid.n_ticks)
    all_lines = Spectra(
        grid=grid,
        bins=bins,
        n_lost=int(np.sum(~seen)),
        s=np.asarray(2j * np.pi * bins * grid.line_hz, np.complex128),
        u=u_of.mean(axis=0) * hold,
        y=y,
        friction=direction.mean(axis=0),
        u_of=u_of * hold,
        y_of=y_of,
        friction_of=direction,
        noise_nm=noise_nm,
    )
    return all_lines.only(seen)
