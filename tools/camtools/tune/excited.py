"""A force drive excited: by its set-point in a closed loop, or by a pulse in each direction.

>>> force = np.concatenate([[0.0] * 100, [10.0] * 200, [-10.0] * 200, [0.0] * 100])
>>> force = np.concatenate([force, -force])
>>> position = -np.cumsum(np.cumsum(force)) / 2.0 * 5e-5**2
>>> found = pulse_fit(20_000.0, force, position)
>>> found.sign, round(found.mass_kg, 1), found.friction_n < 0.1
(-1, 2.0, True)
"""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.ndimage import maximum_filter1d

from camtools.base.errors import CamtoolsError
from camtools.base.project import ROOT
from camtools.base.quantities import Floats
from camtools.identify.configured_drive import Believed
from camtools.identify.drives import SimulatedU
from camtools.identify.excitation_plan import Play, U, Wishes, plan
from camtools.identify.fit import solved
from camtools.identify.recording import Spectra
from camtools.pipeline.load import load, make
from camtools.table.image import pack
from camtools.tune.parameters import ranges
from camtools.tune.plant_fit import PlantFit, fit_lines, record_lines

_PART = ROOT / "tools" / "parts" / "perkins240.toml"
_SIGNALS = ("u_set_q6", "u_actual_nm", "u_force_q6")
_LEAST_TICKS = 8  # in a period of the highest line: images of the hold hardly move a mass
_SLOW_MRPM = 100_000  # the limits of a first power-up suffice for this cut
HIGHEST_HZ = 2500.0


class Recorded(NamedTuple):
    """What was recorded while U was excited; one value for each tick."""

    tick_hz: float
    scale_nm: int  # [nm] of a count
    values: dict[str, int]  # parameters of the loop in force
    set_m: Floats  # [m] set-point
    force_n: Floats  # [N]
    actual_m: Floats  # [m] position


class Measured(NamedTuple):
    """What an excitation shows."""

    tick_hz: float
    values: dict[str, int]  # parameters of the loop in force
    lines: Spectra  # of force [N] and position [nm]
    fit: PlantFit


@contextmanager
def simulated_u(machine: bytes, name: str) -> Iterator[SimulatedU]:
    """Give U of a machine file, known to the user by a name."""
    image = pack(replace(make(load(_PART), _PART).table.table, spindle_mrpm=_SLOW_MRPM))
    with tempfile.TemporaryDirectory(prefix="tune.") as folder:
        yield SimulatedU(Path(folder), machine, name, image)


def recorded(u: U, name: str, highest_hz: float = HIGHEST_HZ) -> Recorded:
    """Excite a U that takes forces, up to a line of 50 Hz or more, and record it, or refuse."""
    believed, values = u.believed(), u.values(ranges())
    if values["servo_crossover_hz"] == 0:
        problem = "servo_crossover_hz = 0: U takes positions, or its loop is not set"
        remedy = "use tools/identify, or set a weak loop first (hal/RETROFIT.md)"
        raise CamtoolsError([f"{name}: {problem}; {remedy}"])
    outside = plan(believed, Wishes(highest_hz=highest_hz, least_ticks=_LEAST_TICKS)).play
    play = outside._replace(place_nm=outside.place_nm // 2)  # a weak loop overshoots
    _, set_q6, actual_nm, force_q6 = u.played(play, _SIGNALS)
    if not force_q6.any():
        problem = "no force was recorded, so its U takes positions"
        raise CamtoolsError([f"{name}: {problem}; use tools/identify"])
    signals = (set_q6 / 64e9, force_q6 / 64e3, actual_nm / 1e9)
    return Recorded(believed.tick_hz, believed.u_scale_nm, values, *signals)


def fitted(record: Recorded) -> Measured:
    """Fit the drive to a record; raise CamtoolsError where that is of no use."""
    signals = (record.set_m, record.force_n, record.actual_m)
    lines = record_lines(record.tick_hz, *signals, record.scale_nm)
    return Measured(record.tick_hz, record.values, lines, fit_lines(lines))


def measure(u: U, name: str, highest_hz: float = HIGHEST_HZ) -> Measured:
    """Excite U and fit its drive; arguments and errors of `recorded` and `fitted`."""
    return fitted(recorded(u, name, highest_hz))


_SMOOTH_S = 3e-4  # window of the speed
_STANDING = 0.01  # of the greatest speed: below, friction takes up the force
_MOST_SCATTER = 0.3  # of the mass, between the directions
_OF_STROKE = 0.1
_LEAST_TRAVEL = 0.05  # of the planned travel: less shows loop and friction more than the mass
_LEAST_S, _MOST_S = 2e-3, 50e-3
_FADE_TICKS = 16


class Pulse(NamedTuple):
    """What pulses show."""

    sign: int  # 1: a positive force moves the scale up; -1: down
    mass_kg: float
    mass_sigma_kg: float  # half of the difference between the directions
    friction_n: float


def _sums(row: Floats, step_s: float) -> Floats:
    return np.asarray(np.cumsum(row) * step_s)


def _pushed(tick_hz: float, force_n: Floats, position_m: Floats) -> tuple[float, float]:
    """Return motion per force [1/kg] and per friction [m/s2], by the sums of both."""
    step_s, n = 1.0 / tick_hz, max(1, round(_SMOOTH_S * tick_hz))
    smooth = np.convolve(np.pad(position_m, n, mode="edge"), np.ones(n) / n, mode="same")[n:-n]
    speed = np.gradient(smooth, step_s)
    fastest = np.abs(speed).max() + 1e-30
    sense = np.clip(speed / (_STANDING * fastest), -1.0, 1.0)
    soon = maximum_filter1d(np.abs(speed), 2 * n + 1, origin=-n)  # greatest of the next 2 n ticks
    impulse = _sums(np.where(soon < _STANDING * fastest, 0.0, force_n), step_s)
    time = np.arange(force_n.size) * step_s  # of a speed at the start
    rubbed = _sums(_sums(sense, step_s), step_s)
    columns = [np.ones_like(force_n), time, impulse, _sums(impulse, step_s), rubbed]
    found, _ = solved(columns, position_m)
    return float(found[3]), float(-found[4])


def pulse_fit(tick_hz: float, force_n: Floats, position_m: Floats) -> Pulse:
    """Return sign and mass from a pulse in each direction, a half each, from rest to rest.

    Refuses a scale that did not move, and directions that differ in sign or by 30 % of the mass.
    """
    half = force_n.size // 2
    parts = (slice(0, half), slice(half, None))
    if any(np.ptp(force_n[part]) == 0 or np.ptp(position_m[part]) == 0 for part in parts):
        problem = "no force or no motion in one of the directions"
        raise CamtoolsError([f"pulse: {problem}; see amplifier, scale and brake, push harder"])
    (first, rub), (second, rub_2) = (_pushed(tick_hz, force_n[p], position_m[p]) for p in parts)
    mean, off = 0.5 * (first + second), 0.5 * abs(first - second)
    if first * second <= 0 or off > _MOST_SCATTER * abs(mean):
        problem = f"the directions give masses of {1 / first:.3g} and {1 / second:.3g} kg"
        raise CamtoolsError([f"pulse: {problem}; free the slide, push harder or weaken the loop"])
    mass_kg = 1.0 / abs(mean)
    friction_n = 0.5 * (rub + rub_2) * mass_kg
    return Pulse(int(np.sign(mean)), mass_kg, mass_kg * off / abs(mean), friction_n)


def pulse_play(force_n: float, mass_kg: float, believed: Believed) -> Play:
    """Return a force, its opposite, twice as long a rest, in each direction, over 0.1 stroke."""
    travel_m = _OF_STROKE * believed.u_stroke_nm * 1e-9
    seconds = min(max(float(np.sqrt(travel_m * mass_kg / force_n)), _LEAST_S), _MOST_S)
    n = round(seconds * believed.tick_hz)
    push = np.concatenate([np.zeros(n), np.ones(n), -np.ones(n), np.zeros(2 * n)])
    samples = np.asarray(np.round(1e3 * force_n * np.concatenate([push, -push])), np.int64)
    return Play(samples, "mN", n_periods=1, fade_ticks=_FADE_TICKS, place_nm=0)


def measure_pulse(u: U, force_n: float) -> Pulse:
    """Push U in both directions with a force [N]; return sign, mass and friction.

    Its loop may be weak, because the whole force is recorded. Refuses a U that hardly moved.
    """
    if force_n <= 0:
        raise CamtoolsError([f"pulse of {force_n:g} N: give a force above 0 N"])
    believed, values = u.believed(), u.values(["servo_mass_g"])
    play = pulse_play(force_n, values["servo_mass_g"] / 1e3, believed)
    _, actual_nm, force_q6 = u.played(play, ("u_actual_nm", "u_force_q6"))
    if np.ptp(actual_nm) < _LEAST_TRAVEL * _OF_STROKE * believed.u_stroke_nm:
        problem = f"U moved by {np.ptp(actual_nm) * 1e-3:.3g} um alone"
        raise CamtoolsError([f"pulse: {problem}; set a weaker loop, of 30 Hz, or push harder"])
    return pulse_fit(believed.tick_hz, force_q6 / 64e3, (actual_nm - actual_nm[0]) / 1e9)


def pulse_lines(found: Pulse) -> Iterator[str]:
    """Yield the report."""
    down = "DOWN: swap the motor's wires, or the sense of the scale"
    yield f"a positive force moves the scale {'up' if found.sign > 0 else down}"
    yield f"mass {found.mass_kg:.4g} kg, the directions differ by {2 * found.mass_sigma_kg:.2g} kg"
    yield f"friction {max(0.0, found.friction_n):.3g} N"


def pulse_settings(found: Pulse) -> dict[str, int]:
    """Return the parameters that a pulse measures."""
    friction_mn = max(0, round(1e3 * found.friction_n))
    return {"servo_mass_g": round(1e3 * found.mass_kg), "servo_friction_mn": friction_mn}
