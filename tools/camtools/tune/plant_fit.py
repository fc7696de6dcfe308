r"""The constants of a force drive from a record in which it was excited, or of another instrument.

An injected signal that repeats every period is what the means over the periods keep: noise that
the loop feeds back into the force goes, so that it does not bias position over force.

>>> grid = Grid.of(20_000.0, 1600.0)
>>> hz = grid.excited * grid.line_hz
>>> true = Plant(1.5, 1500.0, 75e-6, grid.tick_hz, drag_n_s_per_m=8.0, stiffness_n_per_m=2000.0)
>>> s, y = 2j * np.pi * hz, 1e9 * late_response(true, hz) * compliance(true, hz)
>>> spectra = Spectra(grid, grid.excited, 0, s, 1 + 0 * s, y, 0 * s, 1 + 0 * s[None], y[None],
...               0 * s[None], 1e-4 * abs(y))
>>> found = fit_lines(spectra)
>>> round(found.mass_kg, 3), round(found.delay_s * 1e6, 1), round(found.amplifier_hz, -1)
(1.5, 75.0, 1500.0)
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.base.solvers import OF_RECORD, converged
from camtools.identify.fit import stacked
from camtools.identify.foreign_record import FORCES, LENGTHS, POSITIONS, Table, parse_table
from camtools.identify.recording import LINE_HZ, Grid, Spectra, spectra_of
from camtools.tune.loop_design import Plant, compliance, late_response

MASS, DRAG, STIFFNESS, FRICTION, DELAY, LAG, MODE_HZ, MODE_DAMPING, MODE_SHARE = range(9)
N_PLAIN = 6
_NM = 1e9
_FRICTION_LIKENESS = 0.02  # of the friction: the law is not exact
_LIKENESS = 0.002  # a line is weighted by its amplitude as long as its noise is a smaller share
_HIGHEST = 0.2  # of the rate: highest line
_MIN_LINES = 12
_MIN_PERIODS = 3
_DROPPED = 1
_LATE_S, _LEAST_LAG_S = 1e-4, 1.6e-6  # the latter: 100 kHz
_START_LATE = (1.5, 1.0)  # delay and lag together, square of the lag; in _LATE_S
_LOW: Floats = np.array([1e-3, -np.inf, -np.inf, -np.inf, 0.0, 0.0, 0.05, 1e-3, -5.0])
_HIGH: Floats = np.array([np.inf] * 4 + [100.0, 1e4, 8.0, 0.5, 5.0])
_STARTS_HZ = (300.0, 600.0, 900.0, 1200.0, 1600.0, 2200.0)
_LEAST_GAIN = 0.5  # of the sum of squares, that a mode must save
_SAME = 0.01  # of an injected signal that repeats


@dataclass(frozen=True, eq=False)
class PlantFit:
    """Constants in SI units, in the order of MASS .. MODE_SHARE; without a mode six of them."""

    values: Floats
    sigmas: Floats  # standard deviations
    late_sigma_s: float
    misfit: float  # rms of what is left, over the deviations of the lines
    n_lines: int

    @property
    def mass_kg(self) -> float:
        """Moving mass."""
        return float(self.values[MASS])

    @property
    def delay_s(self) -> float:
        """From the latch of the scale to the force, without hold and amplifier."""
        return float(self.values[DELAY])

    @property
    def amplifier_hz(self) -> float:
        """Corner of the amplifier."""
        return float(0.5 / np.pi / max(float(self.values[LAG]), _LEAST_LAG_S))

    @property
    def has_mode(self) -> bool:
        """A mode was found."""
        return self.values.size > N_PLAIN


def plant_at(values: Floats, tick_hz: float) -> Plant:
    """Return the drive of constants, in the order of MASS .. MODE_SHARE."""
    mass_kg, drag, stiffness, _, delay_s, lag_s, *mode = (float(value) for value in values)
    amplifier_hz = 0.5 / np.pi / max(lag_s, 1e-15)
    plant = Plant(mass_kg, amplifier_hz, delay_s, tick_hz, *mode)
    return replace(plant, drag_n_s_per_m=drag, stiffness_n_per_m=stiffness)


class _Residual:
    """What constants leave of the lines, over their deviations.

    Its numbers are near 1. Delay and lag are searched as their sum and the square of the lag: where
    the lag is small, the first alone shows.
    """

    def __init__(self, spectra: Spectra, friction_n: float = 0.0) -> None:
        self.spectra = spectra
        force = float(np.sqrt(np.sum(np.abs(spectra.u) ** 2)))
        omega = float(np.abs(spectra.s).min())
        self.mass = float(np.median(np.abs(spectra.u * _NM / (spectra.y * spectra.s**2))))
        inertia = self.mass * np.abs(spectra.s**2)
        rubbed = _NM * _FRICTION_LIKENESS * abs(friction_n) * np.abs(spectra.friction) / inertia
        likeness = np.hypot(rubbed, _LIKENESS * np.abs(spectra.y))
        self.noise = np.hypot(spectra.noise_nm, likeness) / _NM
        base = [self.mass, self.mass * omega, self.mass * omega**2, force]
        self.scale = np.array([*base, _LATE_S, _LATE_S**2, 1000.0, 1.0, 1.0])

    def values(self, x: Floats) -> Floats:
        """Return the constants of what is searched."""
        values = np.asarray(x * self.scale[: x.size])
        lag = float(np.sqrt(values[LAG]))
        values[DELAY], values[LAG] = values[DELAY] - lag, lag
        return values

    def __call__(self, x: Floats) -> Floats:
        spectra, values = self.spectra, self.values(x)
        plant, hz = plant_at(values, spectra.grid.tick_hz), spectra.frequency_hz
        push = spectra.u * late_response(plant, hz) - values[FRICTION] * spectra.friction
        return stacked((push * compliance(plant, hz) - spectra.y / _NM) / self.noise)


def _solve(residual: _Residual, begin: Floats, most: int | None = None) -> tuple[Floats, float]:
    begin = np.clip(begin, _LOW[: begin.size] + 1e-9, _HIGH[: begin.size])
    bounds = (_LOW[: begin.size], _HIGH[: begin.size])
    found = least_squares(residual, begin, bounds=bounds, x_scale="jac", max_nfev=most)
    if most is None:
        found = converged(found, "record: constants", OF_RECORD)
    return np.asarray(found.x), float(2.0 * found.cost)


def _best(residual: _Residual) -> Floats:
    """Return the constants, with a mode where that is clearly better."""
    plain, cost = _solve(residual, np.array([1.0, 0.1, 0.1, 0.01, *_START_LATE]))
    begin = [*plain[:DELAY], *_START_LATE]
    modes = [[hz / 1000.0, 0.04, share] for hz in _STARTS_HZ for share in (-0.2, 0.2)]
    tried = [_solve(residual, np.array(begin + mode), 30) for mode in modes]
    mode, mode_cost = _solve(residual, min(tried, key=lambda solution: solution[1])[0])
    return mode if mode_cost < _LEAST_GAIN * cost else plain


def fit_lines(spectra: Spectra) -> PlantFit:
    """Return the constants of lines of force [N] and position [nm], or refuse too few."""
    if spectra.s.size < _MIN_LINES:
        problem = f"{spectra.s.size} lines stand above their noise, {_MIN_LINES} are needed"
        raise CamtoolsError([f"record: {problem}; excite more, or record for longer"])
    residual = _Residual(spectra)
    x = _best(residual)
    residual = _Residual(spectra, float(residual.values(x)[FRICTION]))
    x, cost = _solve(residual, _best(residual))
    return _fit_at(residual, x, cost)


def _fit_at(residual: _Residual, x: Floats, cost: float) -> PlantFit:
    """Return the fit, its deviations from those of the lines and from what is left."""
    steps = np.diag(1e-5 * np.maximum(np.abs(x), 1e-2))
    sides = [(residual(x + d) - residual(np.maximum(x - d, _LOW[: x.size]))) for d in steps]
    by = [2.0 * d.sum() if (x - d >= _LOW[: x.size]).all() else d.sum() for d in steps]
    jac = np.column_stack([side / width for side, width in zip(sides, by, strict=True)])
    per_line = max(1.0, cost / (2 * residual.spectra.s.size - x.size))
    variance = np.maximum(np.diag(np.linalg.pinv(jac.T @ jac)), 0.0) * per_line
    raw = np.sqrt(variance) * residual.scale[: x.size]
    sigmas, late = raw.copy(), float(raw[DELAY])
    square = x[LAG] * residual.scale[LAG]
    sigmas[LAG] = np.sqrt(square + raw[LAG]) - np.sqrt(square)
    sigmas[LAG] = max(sigmas[LAG], np.sqrt(square) - np.sqrt(max(0.0, square - raw[LAG])))
    sigmas[DELAY] = np.hypot(late, sigmas[LAG])
    misfit = float(np.sqrt(cost / (2 * residual.spectra.s.size)))
    return PlantFit(residual.values(x), sigmas, late, misfit, residual.spectra.s.size)


def record_lines(
    tick_hz: float, injected: Floats, force_n: Floats, position_m: Floats, quantum_nm: float = 0.0
) -> Spectra:
    """Return the lines of force [N] and position [nm] of a record, one value of each a tick.

    The injected set-point or force, in any unit, repeats every 0.2 s, in odd lines of 5 Hz and one
    of 20 Hz (`multisine`). Refuses a record that is too short, or does not repeat.
    """
    grid = Grid(tick_hz, round(tick_hz / LINE_HZ), _HIGHEST * tick_hz)
    n = force_n.size // grid.n_ticks - _DROPPED
    if n < _MIN_PERIODS:
        need = f"{_MIN_PERIODS + _DROPPED} periods of {grid.n_ticks} ticks are needed"
        raise CamtoolsError([f"record: {force_n.size} ticks; {need}: record for longer"])
    signal, force, position = (
        row[-n * grid.n_ticks :].reshape(n, -1) for row in (injected, force_n, position_m)
    )
    if np.abs(signal - signal.mean(axis=0)).max() > _SAME * np.ptp(signal) or not np.ptp(signal):
        problem = f"the injected signal does not repeat every {grid.n_ticks / tick_hz:g} s"
        raise CamtoolsError([f"record: {problem}; inject a multisine of that period"])
    lines = spectra_of(grid, force, position * _NM, quantum_nm)
    power = np.abs(np.fft.rfft(signal.mean(axis=0))[lines.bins])
    odd = power[lines.bins % 2 == 1]  # without the carrier, which is far larger
    return lines.only(np.asarray(power > 1e-3 * odd.max(initial=0.0)))


_HEADER = "time_s,injected_n,force_n,position_um"
_INJECTED = {"injected_n": 1.0, "injected_kn": 1e3}
_SETPOINTS = {f"setpoint_{unit}": metres for unit, metres in LENGTHS.items()}
_NAMES = {  # of each constant that a drive file has, with its unit
    i: (name, 1e6 if i == DELAY else 1.0)
    for i, name in (
        *((MASS, "mass_kg"), (DRAG, "drag_n_s_per_m"), (STIFFNESS, "stiffness_n_per_m")),
        *((FRICTION, "friction_n"), (DELAY, "delay_us"), (MODE_HZ, "mode_hz")),
        *((MODE_DAMPING, "mode_damping"), (MODE_SHARE, "mode_share")),
    )
}
_NEVER_BELOW_0 = (DRAG, STIFFNESS, FRICTION, DELAY)


def parse_loop_record(text: str, file: str) -> Table:
    """Return injected signal, force and position of a text; errors as of `parse_table`."""
    kinds = {"injected": _INJECTED | _SETPOINTS, "force": FORCES, "position": POSITIONS}
    return parse_table(text, file, kinds, _HEADER)


def fit_table(record: Table, quantum_nm: float) -> PlantFit:
    """Return the constants of a record; errors as of `record_lines` and `fit_lines`."""
    injected, force_n, position_m = record.values.values()
    return fit_lines(record_lines(record.rate_hz, injected, force_n, position_m, quantum_nm))


def with_fit(keys: dict[str, Any], found: PlantFit, tick_hz: float) -> dict[str, Any]:
    """Return the keys of a drive file with what was found, at least 0 where it cannot be less."""
    new: dict[str, Any] = {"tick_hz": round(tick_hz, 3), "amplifier_hz": found.amplifier_hz}
    for i, value in enumerate(found.values):
        if i in _NAMES:
            name, unit = _NAMES[i]
            new[name] = unit * max(float(value), 0.0 if i in _NEVER_BELOW_0 else -np.inf)
    if not found.has_mode:
        new["mode_hz"] = 0.0
    return keys | new


def fit_lines_of(found: PlantFit) -> Iterator[str]:
    """Yield the constants with their deviations."""
    yield f"{'':<20}{'found':>12}{'deviation':>12}"
    for i, (name, unit) in _NAMES.items():
        if i < found.values.size:
            yield _row(name, unit * found.values[i], unit * found.sigmas[i])
    lag = found.values[LAG]
    yield _row("amplifier lag us", 1e6 * lag, 1e6 * found.sigmas[LAG])
    yield _row("delay and lag us", 1e6 * (lag + found.values[DELAY]), 1e6 * found.late_sigma_s)
    yield f"misfit {found.misfit:.2g} times the deviations of {found.n_lines} lines"


def _row(name: str, value: float | Floats, sigma: float | Floats) -> str:
    return f"{name:<20}{value:>12.5g}{sigma:>12.2g}"
