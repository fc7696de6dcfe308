"""A drive that rings: the same constants beside one mode, for comparison, MATHS.md (154), (155).

>>> s = 2j * np.pi * np.array([10.0, 800.0])
>>> mode = Mode(hz=800.0, damping=0.05, lead_out=1.0, drag_out=0.0)
>>> np.abs(mode.factor(s)).round(3).tolist()
[1.0, 0.0]
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from camtools.base.quantities import Floats
from camtools.identify.fit import (
    FRICTION,
    K1,
    K2,
    LEAD,
    MOST_LEAD_S,
    DriveFit,
    line_weights,
    second_order,
    stacked,
    weighted_rms,
)
from camtools.identify.multisine import Complexes
from camtools.identify.recording import Spectra

_STARTS_HZ = (120.0, 200.0, 320.0, 480.0, 640.0, 800.0, 1000.0, 1300.0, 1800.0, 2600.0)
_START_DAMPING = 0.05
_MIN_LINES = 12
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
    k1_s, k2_s2, _, lead_s = place[:4] * scale
    return np.asarray(second_order(s, k1_s, k2_s2, lead_s) * _mode_at(place).factor(s))


class _Residual:
    """The equation of the drive with a mode, in numbers near 1."""

    def __init__(self, spectra: Spectra, plain: DriveFit) -> None:
        inverse = 1 + plain.k1_s * spectra.s + plain.k2_s2 * spectra.s**2
        self.weight = line_weights(spectra, inverse)
        self.spectra = spectra
        friction = max(abs(float(plain.values[FRICTION])), 1.0)
        self.scale = np.array([abs(plain.k1_s), abs(plain.k2_s2), friction, 1e-4])

    def __call__(self, x: Floats) -> Floats:
        k1_s, k2_s2, friction, lead_s = x[:4] * self.scale
        one = self.spectra
        slide = one.y / _mode_at(x).factor(one.s)
        left = (1 + k1_s * one.s + k2_s2 * one.s**2) * slide + friction * one.friction
        return stacked((left - one.u * np.exp(-lead_s * one.s)) * self.weight)


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
    """Return the constants beside one mode, from several begins or one; none for few lines."""
    if spectra.s.size < _MIN_LINES:
        return None
    residual = _Residual(spectra, plain)
    start = (plain if near is None else near).values / residual.scale
    still = residual(
        np.concatenate([plain.values / residual.scale, [np.log(1000.0), -3.0, 0.0, 0.0]])
    )
    low = [-np.inf] * 4 + [np.log(_LOWEST_HZ), np.log(1e-3), -4.0, -2.0]
    high = [np.inf] * 4 + [np.log(_HIGHEST_HZ), np.log(_MOST_DAMPING), 4.0, 2.0]
    best = None
    for begin in _begins(start, near):
        begin = np.clip(begin, np.array(low) + 1e-9, np.array(high) - 1e-9)
        found = least_squares(residual, begin, bounds=(low, high), max_nfev=_FIRST_STEPS)
        if best is None or found.cost < best.cost:
            best = found
    assert best is not None
    best = least_squares(residual, best.x, bounds=(low, high), xtol=1e-12, ftol=1e-12)
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
