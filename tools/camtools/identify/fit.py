"""The constants of a drive of second order with dead time and friction, MATHS.md (152), (153).

>>> from camtools.identify.multisine import Grid
>>> grid = Grid.of(20_000.0)
>>> s = 2j * np.pi * grid.excited * grid.line_hz
>>> u = np.ones_like(s)
>>> y = u * np.exp(-1e-4 * s) / (1 + 7e-4 * s + 3e-7 * s**2)
>>> one = Spectra(grid, grid.excited, 0, s, u, y, 0 * s, u[None], y[None], 0 * s[None], abs(0 * s))
>>> found = fit(one)
>>> round(found.k1_s * 1e6, 2), round(found.k2_s2 * 1e9, 2), round(found.lead_s * 1e6, 2)
(700.0, 300.0, 100.0)
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.identify.multisine import Complexes
from camtools.identify.recording import Spectra

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
    def k1_s(self) -> float:
        """2 damping / natural frequency [s]."""
        return float(self.values[K1])

    @property
    def k2_s2(self) -> float:
        """1 / natural frequency squared [s2]."""
        return float(self.values[K2])

    @property
    def lead_s(self) -> float:
        """Dead time from tick to motion, half a tick of hold and the scale's latency included."""
        return float(self.values[LEAD])

    @property
    def friction_m_s2(self) -> float:
        """Friction as an acceleration [m/s2]."""
        return float(self.values[FRICTION] / self.values[K2] * 1e-9)

    @property
    def sigmas(self) -> Floats:
        """Standard deviations of the values."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def is_physical(self) -> bool:
        """The constants are those of something that could be a drive."""
        return self.k2_s2 > 0 and self.k1_s > 0 and 0 <= self.lead_s < MOST_LEAD_S * 0.999

    def response(self, s: Complexes) -> Complexes:
        """Return the frequency response of the drive, the attenuation of the hold left out."""
        return second_order(s, self.k1_s, self.k2_s2, self.lead_s)


def second_order(s: Complexes, k1_s: float, k2_s2: float, lead_s: float) -> Complexes:
    """Return the response of a drive of second order with dead time."""
    return np.asarray(np.exp(-lead_s * s) / (1 + k1_s * s + k2_s2 * s**2))


def stacked(values: Complexes | Floats) -> Floats:
    """Return real and imaginary parts, one below the other."""
    return np.concatenate([values.real, values.imag])


def solved(columns: Sequence[NDArray[Any]], wanted: NDArray[Any]) -> tuple[Floats, Floats]:
    """Return the factors of columns that sum up to what is wanted, and the stacked residual."""
    matrix = np.column_stack([stacked(column) for column in columns])
    norm = np.linalg.norm(matrix, axis=0)
    norm[norm == 0] = 1.0  # no motion, no friction to find
    values = np.linalg.pinv(matrix / norm) @ stacked(wanted) / norm
    return values, matrix @ values - stacked(wanted)


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
        columns = [self.s * self.y, self.s**2 * self.y, self.friction]
        self.matrix = np.column_stack([stacked(column) for column in columns])
        norm = np.linalg.norm(self.matrix, axis=0)
        self.scale = np.where(norm > 0, norm, 1.0)  # no motion, no friction to find
        self.inverse = np.linalg.pinv(self.matrix / self.scale)

    def solve(self, lead_s: float) -> tuple[Floats, Floats]:
        """Return k1, k2, c and the stacked residual for a dead time."""
        wanted = stacked(self.u * np.exp(-lead_s * self.s) - self.y)
        values = self.inverse @ wanted / self.scale
        return values, self.matrix @ values - wanted

    def cost(self, lead_s: float, *, is_physical: bool = False) -> float:
        """Return the sum of the squares of the residual, on demand infinite for no drive."""
        values, residual = self.solve(lead_s)
        is_drive = not is_physical or min(values[K1], values[K2]) > 0
        return float(residual @ residual) if is_drive else np.inf

    def jacobian(self, lead_s: float) -> Floats:
        """Return the derivatives of the residual: k1, k2, c, dead time."""
        by_lead = stacked(self.s * self.u * np.exp(-lead_s * self.s))
        return np.column_stack([self.matrix, by_lead])


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
    return float(found.x)


def _covariance(lines: _Lines, spectra: Spectra, values: Floats, residual: Floats) -> Floats:
    """Return the covariance: White's sandwich, or the scatter of the periods if that is larger."""
    jacobian = lines.jacobian(float(values[LEAD]))
    scale = np.linalg.norm(jacobian, axis=0)
    scale[scale == 0] = 1.0
    inverse = np.linalg.pinv(jacobian / scale) / scale[:, None]
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
    inverse = 1 + values[K1] * s + values[K2] * s**2
    of = spectra.y_of * inverse + values[FRICTION] * spectra.friction_of
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
        inverse = 1 + linear[K1] * spectra.s + linear[K2] * spectra.s**2
    values = np.append(linear, lead_s)
    n = spectra.s.size
    left = residual[:n] + 1j * residual[n:]
    return DriveFit(
        values=values,
        covariance=_covariance(lines, spectra, values, residual),
        residual=np.asarray(left / (lines.weight * np.abs(spectra.y)), np.complex128),
        misfit=weighted_rms(residual, lines.weight, spectra),
    )


class Gain(NamedTuple):
    """Share of a commanded way that U moves, and what a fit with that share leaves."""

    share: float
    cost: float  # sum of the squares of the weighted residual


def moved_per_commanded(spectra: Spectra, found: DriveFit) -> Gain:
    """Return the gain that fits best beside the other constants; 1 if the scale is right."""
    lines = _Lines(spectra, 1 + found.k1_s * spectra.s + found.k2_s2 * spectra.s**2)
    columns = [lines.s * lines.y, lines.s**2 * lines.y, lines.friction, lines.y]
    values, left = solved(columns, np.asarray(lines.u * np.exp(-found.lead_s * lines.s)))
    return Gain(float(1 / values[-1]), float(left @ left))
