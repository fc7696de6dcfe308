"""The constants of a drive of second order with dead time and friction, MATHS.md (152) .. (155).

A drive that rings has the same constants beside one mode, for comparison.

>>> from camtools.identify.recording import Grid
>>> grid = Grid.of(20_000.0)
>>> s = 2j * np.pi * grid.excited * grid.line_hz
>>> u = np.ones_like(s)
>>> y = u * np.exp(-1e-4 * s) / (1 + 7e-4 * s + 3e-7 * s**2)
>>> periods = u[None], y[None], 0 * s[None]
>>> spectra = Spectra(grid, grid.excited, 0, s, u, y, 0 * s, *periods, abs(0 * s))
>>> found = fit(spectra)
>>> (found.values * [1e6, 1e9, 1, 1e6]).round(2).tolist()
[700.0, 300.0, 0.0, 100.0]
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares, minimize_scalar

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.base.solvers import OF_RECORD, converged
from camtools.identify.recording import Complexes, Spectra

MOST_LEAD_S = 0.02  # the range of the parameter lead_ns
_PER_TURN = 16  # places at which the search begins, per turn of the highest line
MIN_LINES = 5
_N_WEIGHTED = 3  # rounds of weighting by the response found so far
_LIKENESS = 0.003  # a line is weighted by its amplitude as long as its noise is a smaller share
K1, K2, FRICTION, LEAD = range(4)


@dataclass(frozen=True, eq=False)
class DriveFit:
    """Constants of U's drive with what is known about their errors."""

    values: Floats  # k1 [s], k2 [s2], friction c [nm], dead time with half a tick of hold [s]
    covariance: Floats  # shape (4, 4); of the values, from residuals and scatter
    residual: Complexes  # shape (n,); of each line, as a share of its amplitude
    misfit: float  # rms of the residual, lines that stand little above their noise counting less

    @property
    def sigmas(self) -> Floats:
        """Standard deviations of the values."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def is_physical(self) -> bool:
        """The constants are those of something that could be a drive."""
        is_early = 0 <= self.values[LEAD] < MOST_LEAD_S * 0.999
        return bool(np.all(self.values[[K1, K2]] > 0) and is_early)

    def response(self, s: Complexes) -> Complexes:
        """Return the frequency response of the drive, the attenuation of the hold left out."""
        return second_order(s, self.values)


def slide_of(s: Complexes, values: Floats) -> Complexes:
    """Return what the equation of a drive multiplies the place of U by."""
    return np.asarray(1 + values[K1] * s + values[K2] * s**2, np.complex128)


def second_order(s: Complexes, values: Floats) -> Complexes:
    """Return the response of a drive without its friction; values as of `DriveFit`."""
    return np.asarray(np.exp(-values[LEAD] * s) / slide_of(s, values))


def stacked(values: Complexes | Floats) -> Floats:
    """Return real and imaginary parts, one below the other."""
    return np.concatenate([values.real, values.imag])


def solved(columns: Sequence[NDArray[Any]], wanted: NDArray[Any]) -> tuple[Floats, Floats]:
    """Return the factors of columns that sum up to what is wanted, and the stacked residual."""
    matrix, inverse, norm = _inverted(list(map(stacked, columns)))
    values = inverse @ stacked(wanted) / norm
    return values, matrix @ values - stacked(wanted)


def _inverted(columns: Sequence[Floats]) -> tuple[Floats, Floats, Floats]:
    """Return the matrix of columns, the pseudo-inverse of their directions, and their norms."""
    matrix = np.column_stack(columns)
    norm = np.linalg.norm(matrix, axis=0)
    norm[norm == 0] = 1.0  # no motion, no friction to find
    return matrix, np.linalg.pinv(matrix / norm), norm


def line_weights(spectra: Spectra, inverse: Complexes | float) -> Floats:
    """Return the weights of the lines: 1 / |y| where noise allows; `inverse` of the response."""
    noise = spectra.noise_nm * np.abs(inverse)
    return np.asarray(1 / np.hypot(np.abs(spectra.y), noise / _LIKENESS))


def weighted_rms(residual: Floats, weight: Floats, spectra: Spectra) -> float:
    """Return the rms of a stacked and weighted residual, as a share of the amplitude."""
    return float(np.sqrt(np.sum(residual**2) / np.sum((weight * np.abs(spectra.y)) ** 2)))


class _Lines:
    """The linear least squares of one record for any dead time."""

    def __init__(self, spectra: Spectra, inverse: Complexes | float = 1.0) -> None:
        weight = line_weights(spectra, inverse)
        self.s, self.weight = spectra.s, weight
        self.u = spectra.u * weight
        self.y = spectra.y * weight
        self.friction = spectra.friction * weight
        self.columns = [self.s * self.y, self.s**2 * self.y, self.friction]
        self.matrix, self.inverse, self.norm = _inverted(list(map(stacked, self.columns)))

    def solve(self, lead_s: float) -> tuple[Floats, Floats]:
        """Return k1, k2, c and the stacked residual for a dead time."""
        wanted = stacked(self.u * np.exp(-lead_s * self.s) - self.y)
        values = self.inverse @ wanted / self.norm
        return values, self.matrix @ values - wanted

    def cost(self, lead_s: float, *, is_physical: bool = False) -> float:
        """Return the sum of the squares of the residual, on demand infinite for no drive."""
        values, residual = self.solve(lead_s)
        is_drive = not is_physical or min(values[K1], values[K2]) > 0
        return float(residual @ residual) if is_drive else np.inf


def _lead(lines: _Lines) -> float:
    """Return the dead time of the least residual: a coarse search, then Brent's method."""
    highest_hz = float(np.abs(lines.s[-1])) / (2 * np.pi)
    places, step = np.linspace(
        0.0, MOST_LEAD_S, int(MOST_LEAD_S * highest_hz * _PER_TURN) + 2, retstep=True
    )
    i = int(np.argmin([lines.cost(place, is_physical=True) for place in places]))
    low, high = max(0.0, places[i] - step), min(MOST_LEAD_S, places[i] + step)
    found = minimize_scalar(
        lines.cost, bounds=(low, high), method="bounded", options={"xatol": 1e-11}
    )
    return float(converged(found, "record: dead time", OF_RECORD).x)


def _covariance(lines: _Lines, spectra: Spectra, values: Floats, residual: Floats) -> Floats:
    """Return the covariance: White's sandwich, or the scatter of the periods if that is larger."""
    by_lead = stacked(lines.s * lines.u * np.exp(-values[LEAD] * lines.s))
    _, inverse, norm = _inverted([lines.matrix, by_lead])
    inverse = inverse / norm[:, None]
    free = residual.size / max(1, residual.size - values.size)
    left = residual**2 * free
    between = _between(spectra, values, lines.weight)
    covariance = (inverse * left) @ inverse.T
    scatter = (inverse * between) @ inverse.T
    stretch = np.sqrt(np.maximum(1.0, np.diag(scatter) / np.maximum(np.diag(covariance), 1e-300)))
    return np.asarray(covariance * np.outer(stretch, stretch))


def _between(spectra: Spectra, values: Floats, weight: Floats) -> Floats:
    """Return the variance of the mean of the stacked residual, from the scatter of the periods."""
    n = spectra.n_periods
    if n < 2:
        return np.zeros(2 * spectra.s.size)
    s = spectra.s
    of = spectra.y_of * slide_of(s, values) + values[FRICTION] * spectra.friction_of
    of = (of - spectra.u_of * np.exp(-values[LEAD] * s)) * weight
    power = np.sum(np.abs(of - of.mean(axis=0)) ** 2, axis=0) / (n - 1) / n
    return np.concatenate([power, power]) / 2


def fit(spectra: Spectra) -> DriveFit:
    """Return the constants of a drive, or refuse too few lines above their noise."""
    if spectra.s.size < MIN_LINES:
        n_all = spectra.s.size + spectra.n_lost
        problem = f"{spectra.s.size} of {n_all} lines stand above the noise"
        raise CamtoolsError([f"record: {problem}; a fit needs {MIN_LINES}, give a larger --rms-um"])
    inverse: Complexes | float = 1.0
    for _ in range(_N_WEIGHTED):
        lines = _Lines(spectra, inverse)
        lead_s = _lead(lines)
        linear, residual = lines.solve(lead_s)
        inverse = slide_of(spectra.s, linear)
    values = np.append(linear, lead_s)
    n = spectra.s.size
    left = residual[:n] + 1j * residual[n:]
    return DriveFit(
        values=values,
        covariance=_covariance(lines, spectra, values, residual),
        residual=np.asarray(left / (lines.weight * np.abs(spectra.y)), np.complex128),
        misfit=weighted_rms(residual, lines.weight, spectra),
    )


def moved_per_commanded(spectra: Spectra, found: DriveFit) -> tuple[float, float]:
    """Return the share of a commanded way that fits best beside the other constants, and its cost.

    The share is 1 if the scale is right; the cost is the sum of the squares of the weighted
    residual.
    """
    lines = _Lines(spectra, slide_of(spectra.s, found.values))
    wanted = np.asarray(lines.u * np.exp(-found.values[LEAD] * lines.s))
    values, left = solved([*lines.columns, lines.y], wanted)
    return float(1 / values[-1]), float(left @ left)


_STARTS_HZ = (120.0, 200.0, 320.0, 480.0, 640.0, 800.0, 1000.0, 1300.0, 1800.0, 2600.0)
_START_DAMPING = 0.05
_MODE_LINES = 12
_STEP = 1e-5  # of a difference
_FIRST_STEPS = 20  # of each search, before the best goes on
_LOWEST_HZ, _HIGHEST_HZ, _MOST_DAMPING = 40.0, 8000.0, 0.3


@dataclass(frozen=True)
class Mode:
    """What is measured, as a share of what a slide without the mode would move."""

    hz: float
    damping: float
    lead_out: float  # of the acceleration: 1 when nothing rings
    drag_out: float  # of the speed [1/s]: 2 damping times the angular frequency when nothing rings

    def factor(self, s: Complexes) -> Complexes:
        """Return that share for s = j times the angular frequency [rad/s]."""
        w = 2 * np.pi * self.hz
        below = s**2 + 2 * self.damping * w * s + w * w
        return np.asarray((self.lead_out * s**2 + self.drag_out * s + w * w) / below)

    @property
    def share(self) -> float:
        """Greatest deviation of the factor from 1, at resonance."""
        s = np.array([2j * np.pi * self.hz])
        return float(np.abs(self.factor(s) - 1)[0])


@dataclass(frozen=True, eq=False)
class ModeFit:
    """The constants of a drive and of its mode."""

    values: Floats  # as of `DriveFit`
    mode: Mode
    place: Floats  # values over scale, log of frequency and damping, how far the numerator is off
    place_covariance: Floats  # that the residual gives it, shape (8, 8)
    scale: Floats
    misfit: float  # rms of the residual, as a share of the amplitude
    cost: float  # sum of the squares that was made least
    plain_cost: float  # of the fit without a mode

    @property
    def covariance(self) -> Floats:
        """Covariance of the values, shape (4, 4)."""
        return np.asarray(self.place_covariance[:4, :4] * np.outer(self.scale, self.scale))

    @property
    def is_physical(self) -> bool:
        """The constants are those of something that could be a drive."""
        return bool(np.all(self.values[[K1, K2]] > 0) and 0 <= self.values[LEAD] < MOST_LEAD_S)

    def response(self, s: Complexes) -> Complexes:
        """Return the frequency response, the attenuation of the hold left out."""
        return _response_at(self.place, self.scale, s)

    def shares(self, s: Complexes) -> Complexes:
        """Return by how much of itself the response changes per unit of each part of `place`."""
        by = np.empty((self.place.size, s.size), np.complex128)
        for i, step in enumerate(np.eye(self.place.size) * _STEP):
            ends = (_response_at(self.place + side * step, self.scale, s) for side in (1, -1))
            by[i] = (next(ends) - next(ends)) / (2 * _STEP)
        return by / self.response(s)

    @property
    def slow_values(self) -> Floats:
        """Constants far below the mode: first terms of the inverse response in powers of s."""
        w = 2 * np.pi * self.mode.hz
        drag = (2 * self.mode.damping * w - self.mode.drag_out) / w**2
        lead = (1 - self.mode.lead_out) / w**2 - drag * self.mode.drag_out / w**2
        k1_s, k2_s2 = self.values[K1], self.values[K2]
        values = self.values.copy()
        values[K1] = k1_s + drag
        values[K2] = k2_s2 + k1_s * drag + lead
        return np.asarray(values)


def _mode_at(place: Floats) -> Mode:
    hz, damping = float(np.exp(place[4])), float(np.exp(place[5]))
    return Mode(hz, damping, 1 + float(place[6]), (2 * damping + float(place[7])) * 2 * np.pi * hz)


def _response_at(place: Floats, scale: Floats, s: Complexes) -> Complexes:
    return second_order(s, place[:4] * scale) * _mode_at(place).factor(s)


class _Residual:
    """The equation of the drive with a mode, in numbers near 1."""

    def __init__(self, spectra: Spectra, plain: DriveFit) -> None:
        self.weight = line_weights(spectra, slide_of(spectra.s, plain.values))
        self.spectra = spectra
        k1_s, k2_s2, friction, _ = np.abs(plain.values)
        self.scale = np.array([k1_s, k2_s2, max(friction, 1.0), 1e-4])

    def __call__(self, x: Floats) -> Floats:
        values, spectra = x[:4] * self.scale, self.spectra
        slide = spectra.y / _mode_at(x).factor(spectra.s)
        left = slide_of(spectra.s, values) * slide + values[FRICTION] * spectra.friction
        return stacked((left - spectra.u * np.exp(-values[LEAD] * spectra.s)) * self.weight)


def _begins(start: Floats, near: ModeFit | None) -> Iterator[Floats]:
    """Yield where to begin: near what is known, or at several frequencies."""
    if near is not None:
        mode = near.mode
        drag = mode.drag_out / (2 * np.pi * mode.hz) - 2 * mode.damping
        place = [np.log(mode.hz), np.log(mode.damping), mode.lead_out - 1, drag]
        yield np.concatenate([start, place])
        return
    for hz in _STARTS_HZ:
        for lead_out in (0.2, -0.2):
            yield np.concatenate([start, [np.log(hz), np.log(_START_DAMPING), lead_out, 0.0]])


def fit_mode(spectra: Spectra, plain: DriveFit, near: ModeFit | None = None) -> ModeFit | None:
    """Return the constants beside one mode, from several begins or one.

    None for few lines, or if the fit does not converge; the drive may still have a mode.
    """
    if spectra.s.size < _MODE_LINES:
        return None
    residual = _Residual(spectra, plain)
    start = (plain if near is None else near).values / residual.scale
    no_mode = [np.log(1000.0), -3.0, 0.0, 0.0]
    still = residual(np.append(plain.values / residual.scale, no_mode))
    low = [-np.inf] * 4 + [np.log(_LOWEST_HZ), np.log(1e-3), -4.0, -2.0]
    high = [np.inf] * 4 + [np.log(_HIGHEST_HZ), np.log(_MOST_DAMPING), 4.0, 2.0]
    tried = []
    for begin in _begins(start, near):
        begin = np.clip(begin, np.array(low) + 1e-9, np.array(high) - 1e-9)
        tried.append(least_squares(residual, begin, bounds=(low, high), max_nfev=_FIRST_STEPS))
    best = min(tried, key=lambda found: found.cost)
    best = least_squares(residual, best.x, bounds=(low, high), xtol=1e-12, ftol=1e-12)
    if not best.success:
        return None
    variance = 2 * best.cost / (best.fun.size - best.x.size)
    return ModeFit(
        values=np.asarray(best.x[:4] * residual.scale),
        mode=_mode_at(best.x),
        place=best.x,
        place_covariance=np.linalg.pinv(best.jac.T @ best.jac) * variance,
        scale=residual.scale,
        misfit=weighted_rms(best.fun, residual.weight, spectra),
        cost=float(2 * best.cost),
        plain_cost=float(still @ still),
    )
