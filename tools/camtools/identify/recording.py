"""A record of an excited U: what is wrong with it, and what its lines say, MATHS.md (151).

>>> import numpy as np
>>> grid = Grid.of(20_000.0)
>>> t = np.arange(4000) / 4000
>>> wave = 1000.0 * np.cos(2 * np.pi * 5 * t)
>>> spectra = spectra_of(grid, np.tile(wave, (2, 1)), np.tile(0.5 * wave, (2, 1)), quantum_nm=0.0)
>>> abs(spectra.y[spectra.bins == 5]).round(3)
array([500.])
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats, Ints
from camtools.identify.multisine import N_DROPPED, Complexes, Grid

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
    n_dropped: int = N_DROPPED

    @property
    def is_coarse(self) -> bool:
        """A drive that rounds its commands as its scale does plays another wave."""
        return self.quantum_nm >= _COARSE_NM

    def rounded(self) -> SettledRecord:
        """Return the record with set-points rounded to the quantum of the scale."""
        return replace(self, u_nm=np.round(self.u_nm / self.quantum_nm) * self.quantum_nm)

    @property
    def period_nm(self) -> Floats:
        """Set-points of a settled period, about their mean; all of them are alike."""
        period = self.u_nm[self.n_dropped]
        return np.asarray(period - period.mean())

    @property
    def settled(self) -> tuple[Floats, Floats]:
        """Set-points and positions of the periods that count."""
        return self.u_nm[self.n_dropped :], self.y_nm[self.n_dropped :]


def record_of(
    grid: Grid,
    tick: Ints,
    u_nm: Floats,
    y_nm: Floats,
    quantum_nm: float,
    n_dropped: int = N_DROPPED,
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
    if n_periods < n_dropped + MIN_PERIODS:
        problem = (
            f"{tick.size} ticks are {n_periods} periods, a fit needs {n_dropped + MIN_PERIODS}"
        )
        raise CamtoolsError([f"record: {problem}; {_AGAIN}"])
    n = n_periods * grid.n_ticks
    u, y = (np.asarray(row[-n:], np.float64).reshape(n_periods, -1) for row in (u_nm, y_nm))
    _check(u[n_dropped:], y[n_dropped:])
    return SettledRecord(grid, u, y, quantum_nm, n_dropped)


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

    def with_friction(self, shares: Floats) -> Spectra:
        """Return the same lines with another friction, its mean over each tick of the periods."""
        hold = np.sinc(self.bins / self.grid.n_ticks)
        half_tick = np.exp(-0.5 * self.s / self.grid.tick_hz)
        of = np.fft.rfft(shares)[:, self.bins] * (2.0 / self.grid.n_ticks) * half_tick / hold
        return replace(self, friction=of.mean(axis=0), friction_of=of)

    def only(self, rows: npt.NDArray[np.bool_]) -> Spectra:
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
