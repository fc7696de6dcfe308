"""What a record says about U's drive and its friction, and whether it may be believed.

The direction of motion that a scale shows is blurred by its quantum, and says nothing about a slide
that sticks, whose friction is whatever holds it. The drive with its friction, played forward from
the set-points, has neither fault.

>>> still = friction_of(np.array([7e-4, 3e-7, 5.0, 1e-4]), np.zeros(200), 1e-4)
>>> bool(np.all(still == 0))
True
"""

from dataclasses import dataclass
from math import copysign

import numpy as np
from scipy.linalg import expm

from camtools.base.quantities import Floats
from camtools.base.solvers import OF_RECORD, unsolved
from camtools.identify.fit import (
    FRICTION,
    K1,
    K2,
    LEAD,
    DriveFit,
    ModeFit,
    fit,
    fit_mode,
    moved_per_commanded,
)
from camtools.identify.recording import SettledRecord, Spectra, spectra_of

_STEPS = 3  # of each of the two pieces of a tick


def _step(k1_s: float, k2_s2: float, dt_s: float) -> tuple[float, ...]:
    """Return the exact flow of the drive without friction about its command."""
    drive = np.array([[0.0, 1.0], [-1 / k2_s2, -k1_s / k2_s2]])
    return tuple(float(value) for value in expm(drive * dt_s).ravel())


class _Slide:
    """A slide that is pulled to a command and rubs. `y`, `v`: place [nm] and speed [nm/s]."""

    def __init__(self, k2_s2: float, friction_nm: float) -> None:
        self.k2_s2, self.friction_nm = k2_s2, friction_nm
        self.y = self.v = 0.0

    def move(self, command: float, flow: tuple[float, ...], dt_s: float) -> float:
        """Let a step pass, exactly or to an even stop; return the integral of friction."""
        v = self.v
        if v == 0.0 and abs(command - self.y) <= self.friction_nm:
            return (command - self.y) / self.friction_nm * dt_s
        sign = copysign(1.0, v if v != 0.0 else command - self.y)
        pp, pv, vp, vv = flow
        off = self.y - command + sign * self.friction_nm
        after = vp * off + vv * v
        if after * sign >= 0:
            self.y += (pp - 1) * off + pv * v
            self.v = after
            return sign * dt_s
        moving_s = dt_s * v / (v - after)
        self.y += 0.5 * v * moving_s
        self.v = 0.0
        return sign * moving_s + self._goes_on(command, dt_s - moving_s)

    def _goes_on(self, command: float, rest_s: float) -> float:
        """Hold what has stopped, or let it turn back, for the rest of a step."""
        push = command - self.y
        if abs(push) <= self.friction_nm:
            return push / self.friction_nm * rest_s
        sign = copysign(1.0, push)
        acceleration = (push - sign * self.friction_nm) / self.k2_s2
        self.v = acceleration * rest_s
        self.y += 0.5 * self.v * rest_s
        return sign * rest_s


def friction_of(values: Floats, u_nm: Floats, tick_s: float) -> Floats:
    """Return the mean friction of a drive in each tick from rest, of its greatest, -1 .. 1."""
    k1_s, k2_s2, friction_nm, lead_s = (float(value) for value in values)
    if friction_nm <= 0:
        return np.zeros(u_nm.size)
    delay = max(0.0, lead_s / tick_s - 0.5)
    n_delay, part = int(delay), delay - int(delay)
    commands = [0.0] * (n_delay + 1) + [float(value) for value in u_nm]
    pieces = [(0, part * tick_s / _STEPS), (1, (1 - part) * tick_s / _STEPS)]
    steps = [(late, dt_s, _step(k1_s, k2_s2, dt_s)) for late, dt_s in pieces if dt_s > 0]
    slide = _Slide(k2_s2, friction_nm)
    shares = np.empty(u_nm.size)
    for i in range(u_nm.size):
        taken_s = 0.0
        for late, dt_s, flow in steps:
            for _ in range(_STEPS):
                taken_s += slide.move(commands[i + late], flow, dt_s)
        shares[i] = taken_s / tick_s
    return shares


_MOST_ROUNDS = 20  # friction played with the constants found so far
_MODE_ROUNDS = 3
_RATHER_A_MODE = 2.0  # a gain that is off explains less than that
_SETTLED_SIGMAS = 0.1
_FRICTION_SIGMAS = 3.0
_MODE_GAIN = 4.0  # a mode is there when it makes the sum of the squares smaller by this
# What a fit must keep to be applied: standard deviation and bias of k1, k2 and lead [s], ...
_MOST_SHARE, _MOST_LEAD_S = 0.01, 2e-6
_MOST_MISFIT, _MOST_GAIN_OFF = 0.05, 0.01


@dataclass(frozen=True, eq=False)
class Identified:
    """The constants of U's drive with their doubts."""

    spectra: Spectra  # with the friction that the fit found
    plain: DriveFit  # of a drive of second order
    with_mode: ModeFit | None  # of one with a mode as well
    gain: float  # share of a commanded way that U moves
    gain_cost: float  # sum of the squares that a fit with that share leaves

    @property
    def has_mode(self) -> bool:
        """A mode explains most of what the plain fit leaves, so that the fit is biased."""
        with_mode = self.with_mode
        return (
            with_mode is not None
            and with_mode.plain_cost > _MODE_GAIN * with_mode.cost
            and self.gain_cost > _RATHER_A_MODE * with_mode.cost
        )

    @property
    def bias(self) -> Floats:
        """Plain fit minus the drive beside its mode: k1 and k2 as shares, 0, lead [s]."""
        bias = np.zeros(4)
        if self.with_mode is not None and self.has_mode:
            free = self.with_mode.values
            bias[[K1, K2]] = self.plain.values[[K1, K2]] / free[[K1, K2]] - 1
            bias[LEAD] = self.plain.values[LEAD] - free[LEAD]
        return bias

    @property
    def biasing(self) -> ModeFit | None:
        """The fit with a mode, where that biases the plain one beyond the limits."""
        most = (_MOST_SHARE, _MOST_SHARE, _MOST_LEAD_S)
        return self.with_mode if np.any(np.abs(self.bias)[[K1, K2, LEAD]] > most) else None

    @property
    def judged(self) -> DriveFit | ModeFit:
        """The fit that counts: that of the drive beside its mode where a mode biases."""
        return self.biasing or self.plain

    def problems(self) -> list[str]:
        """Return why the constants are not to be applied; an empty list when they are."""
        judged = self.judged
        if not judged.is_physical:
            return ["no drive of second order has such a response"]
        found = []
        sigmas = np.sqrt(np.diag(judged.covariance))
        for name, i in (("k1", K1), ("k2", K2)):
            share = float(sigmas[i] / judged.values[i])
            if share > _MOST_SHARE:
                known = f"{name} is known to {100 * share:.3g} % only"
                found.append(f"{known}, at most {100 * _MOST_SHARE:g} %")
        if sigmas[LEAD] > _MOST_LEAD_S:
            known = f"lead is known to {sigmas[LEAD] * 1e6:.3g} us"
            found.append(f"{known}, at most {_MOST_LEAD_S * 1e6:g} us")
        if judged.misfit > _MOST_MISFIT:
            left = f"the fit leaves {100 * judged.misfit:.3g} % of what was measured"
            found.append(f"{left}, at most {100 * _MOST_MISFIT:g} %")
        if not self.has_mode and abs(self.gain - 1) > _MOST_GAIN_OFF:
            moved = f"U moves {self.gain:.4f} of what is commanded"
            found.append(f"{moved}, at most {_MOST_GAIN_OFF:g} off; correct the scale of the drive")
        return found


def is_rubbing(found: DriveFit) -> bool:
    """Return whether friction stands above its error."""
    return bool(found.values[FRICTION] > _FRICTION_SIGMAS * found.sigmas[FRICTION])


def _rubbing(spectra: Spectra, record: SettledRecord, values: Floats) -> Spectra:
    """Return the lines with the friction of a drive of these constants."""
    period_nm = record.period_nm  # played twice: what remains of the begin has died away then
    shares = friction_of(values, np.tile(period_nm, 2), 1 / record.grid.tick_hz)
    return spectra.with_friction(np.tile(shares[period_nm.size :], (spectra.n_periods, 1)))


def _fit_plain(record: SettledRecord) -> tuple[Spectra, DriveFit]:
    """Return the lines and their fit with friction as played, where that explains more."""
    spectra = spectra_of(record.grid, *record.settled, record.quantum_nm)
    found = fit(spectra)
    for _ in range(_MOST_ROUNDS):
        if not (found.is_physical and is_rubbing(found)):
            break
        played = _rubbing(spectra, record, found.values)
        better = fit(played)
        if better.misfit >= found.misfit:
            break
        moved = np.abs(better.values - found.values)
        spectra, found = played, better
        if np.all(moved < _SETTLED_SIGMAS * better.sigmas):
            break
    else:
        raise unsolved("record: friction", OF_RECORD)
    return spectra, found


def _fit_mode(spectra: Spectra, record: SettledRecord, plain: DriveFit) -> ModeFit | None:
    """Return the fit with a mode, its own friction played; each round leaves less than before."""
    found = fit_mode(spectra, plain)
    if found is None or not is_rubbing(plain) or found.plain_cost < _MODE_GAIN * found.cost:
        return found
    for _ in range(_MODE_ROUNDS):
        if min(found.values[K1], found.values[K2], found.values[LEAD]) <= 0:
            break
        better = fit_mode(_rubbing(spectra, record, found.values), plain, found)
        if better is None or better.cost >= found.cost:
            break
        found = better
    return found


def identify(record: SettledRecord, *, with_mode: bool = True) -> Identified:
    """Return what a record says about U's drive.

    A scale that is coarse may belong to a drive that rounds its commands likewise; the record with
    rounded set-points is believed where it leaves less. Raises `CamtoolsError`: too few lines stand
    above their noise.
    """
    spectra, plain = _fit_plain(record)
    if record.is_coarse:
        rounded = record.rounded()
        rounded_spectra, rounded_plain = _fit_plain(rounded)
        if rounded_plain.misfit < plain.misfit:
            record, spectra, plain = rounded, rounded_spectra, rounded_plain
    looks = with_mode and plain.is_physical
    mode = _fit_mode(spectra, record, plain) if looks else None
    return Identified(spectra, plain, mode, *moved_per_commanded(spectra, plain))
