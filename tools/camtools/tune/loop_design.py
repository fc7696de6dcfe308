"""A position loop for a force drive: its response, its margins, and a proposal.

The loop is that of firmware/servo, MATHS.md (234) and (235). The plant is a mass on drag and
stiffness, driven by an amplifier of first order, after a delay and the hold of a step; a mode may
move the scale as MATHS.md (123) gives it.

>>> drive = Plant(mass_kg=1.5, amplifier_hz=1500.0, delay_s=25e-6, step_hz=20000.0)
>>> judged = margins(Loop(300.0, 20.0, 4000.0, 10.0, 4000.0, 0.5, 0.5), drive)
>>> f"{judged.gain_db:.1f} dB, {judged.phase_deg:.0f} degrees"
'16.7 dB, 33 degrees'
"""

from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import differential_evolution

from camtools.sim.uncertain import usual_spreads

Reals = NDArray[np.float64]
Complexes = NDArray[np.complex128]

LEAST_GAIN_DB = 6.0
LEAST_PHASE_DEG = 30.0
_MASS = usual_spreads()["u.mass_kg"]
assert _MASS.margins is not None and _MASS.stable is not None
_OFF, _FACTOR = _MASS.margins, _MASS.stable
MASSES = (1.0 - _OFF, 1.0, 1.0 + _OFF)  # relative; the margins hold at each
EXTREME_MASSES = (1.0 / _FACTOR, _FACTOR)  # relative; the loop is stable there
BACK_S = 0.02  # after this time a step of force has gone
_FASTEST_HZ = 4000.0  # of the response to a step
_STATIC: Reals = np.array([1e-6])  # [Hz]
_MOST_SUMMED, _MOST_LED = 2.0**-2 * 1e6, 2.0**12 * 1e6  # [N/m] per step, of integral and lead
_MOST_SHARE = 0.95  # of these, since parameters are rounded


@dataclass(frozen=True)
class Plant:
    """A force drive without its loop."""

    mass_kg: float
    amplifier_hz: float
    delay_s: float  # from the latch of the scale to the force, without its hold
    step_hz: float
    mode_hz: float = 0.0  # 0: none
    mode_damping: float = 0.03
    mode_share: float = 0.0
    drag_n_s_per_m: float = 0.0
    stiffness_n_per_m: float = 0.0


@dataclass(frozen=True)
class Loop:
    """The parameters of cam_servo_design() that make the loop."""

    crossover_hz: float
    lead_ratio: float  # pole over zero
    pole_hz: float
    integral_hz: float
    notch_hz: float  # above 0
    notch_zero: float  # damping
    notch_pole: float  # damping


@dataclass(frozen=True)
class Margins:
    """Distances from instability."""

    gain_db: float
    phase_deg: float
    is_stable: bool

    @property
    def is_enough(self) -> bool:
        """The loop is stable with the least margins or more."""
        has_gain = self.gain_db >= LEAST_GAIN_DB
        return self.is_stable and has_gain and self.phase_deg >= LEAST_PHASE_DEG


def controller_response(loop: Reals, plant: Plant, hz: Reals) -> Complexes:
    """Return the response in N/m of loops (rows: fields of Loop) below half the rate."""
    crossover, ratio, pole, integral, notch, zero_damping, pole_damping = loop[..., None]
    s = 2j * plant.step_hz * np.tan(np.pi * hz / plant.step_hz) / (2.0 * np.pi)
    lead = _lead(s, ratio, pole)
    gain = _gain(plant, crossover, ratio, pole)
    q = s / (plant.step_hz / np.pi * np.tan(np.pi * notch / plant.step_hz))
    notched = (q * q + 2.0 * zero_damping * q + 1.0) / (q * q + 2.0 * pole_damping * q + 1.0)
    return np.asarray(gain * (1.0 + integral / s) * lead * notched)


def _lead(s: Complexes, ratio: Reals, pole: Reals) -> Complexes:
    return np.asarray((1.0 + s * ratio / pole) / (1.0 + s / pole))


def _gain(plant: Plant, crossover: Reals, ratio: Reals, pole: Reals) -> Reals:
    s: Complexes = np.asarray(1j * crossover)
    omega = 2.0 * np.pi * crossover
    return np.asarray(plant.mass_kg * omega**2 / np.abs(_lead(s, ratio, pole)))


def word_shares(loops: Reals, plant: Plant) -> Reals:
    """Return which share integral and lead take of what the firmware holds; it refuses above 1."""
    crossover, ratio, pole, integral = loops[:4]
    gain = _gain(plant, crossover, ratio, pole)
    summed = 2.0 * np.pi * integral / plant.step_hz
    led = (ratio - 1.0) * (1.0 - integral / pole) / (1.0 + np.pi * pole / plant.step_hz)
    return np.asarray(gain * np.stack([summed / _MOST_SUMMED, led / _MOST_LED]))


def compliance(plant: Plant, hz: Reals, mass: float = 1.0) -> Complexes:
    """Return what the scale sees per force at a relative real mass, in m/N."""
    s = 2j * np.pi * hz
    omega = 2.0 * np.pi * plant.mode_hz
    share = plant.mode_share if plant.mode_hz > 0.0 else 0.0
    mode = s * s * share / (s * s + 2.0 * plant.mode_damping * omega * s + omega**2)
    slide = mass * plant.mass_kg * s * s + plant.drag_n_s_per_m * s + plant.stiffness_n_per_m
    return np.asarray((1.0 - mode) / slide)


def late_response(plant: Plant, hz: Reals) -> Complexes:
    """Return force per command: amplifier, delay, and the hold without its attenuation."""
    delay = np.exp(-2j * np.pi * hz * (plant.delay_s + 0.5 / plant.step_hz))
    return np.asarray(delay / (1.0 + hz * 1j / plant.amplifier_hz))


def response_grid(plant: Plant) -> Reals:
    """Return frequencies up to half the rate, dense about the mode."""
    rough = np.geomspace(1.0, 0.499 * plant.step_hz, 500)
    width = np.sinh(np.linspace(-3.0, 3.0, 81)) / 40.0
    near = [plant.mode_hz * (1.0 + width)] if plant.mode_hz else []
    return np.sort(np.concatenate([rough, *near]))


def _least(values: Reals, crossings: NDArray[np.bool_]) -> Reals:
    """Return the least amount of the values at the crossings of each row; infinity without one."""
    return np.asarray(np.min(np.where(crossings, np.abs(values), np.inf), axis=-1))


def _judged(
    opened: Complexes, masses: tuple[float, ...] = (1.0,)
) -> tuple[list[Reals], list[Reals]]:
    """Return gain margins in dB and phase margins in degrees, for each relative mass."""
    level, imag = 20.0 * np.log10(np.abs(opened)), opened.imag
    is_crossing = (imag[..., 1:] * imag[..., :-1] < 0.0) & (opened.real[..., 1:] < 0.0)
    # Between two lines the level at the crossing is linear, and so is the angle at 0 dB.
    part = imag[..., :-1] / (imag[..., :-1] - imag[..., 1:] + 1e-300)
    step = np.diff(level)
    at_crossing = level[..., :-1] + part * step
    angle = np.degrees(np.unwrap(np.angle(-opened), axis=-1))
    turn, gains, phases = np.diff(angle), [], []
    for mass in masses:
        lighter_db = 20.0 * np.log10(mass)
        here = level - lighter_db
        gains.append(_least(at_crossing - lighter_db, is_crossing))
        at_unity = angle[..., :-1] - here[..., :-1] / (step - 1e-300) * turn
        wrapped = (at_unity + 180.0) % 360.0 - 180.0
        phases.append(_least(wrapped, here[..., 1:] * here[..., :-1] < 0.0))
    return gains, phases


def _is_stable(opened: Complexes) -> NDArray[np.bool_]:
    """Return stability, by Nyquist."""
    angle = np.angle(1.0 + opened)
    step = np.diff(angle)
    turned = (step - 2.0 * np.pi * np.round(step / (2.0 * np.pi))).sum(axis=-1)
    start, first = np.degrees(angle[..., 0]), np.degrees(np.angle(opened[..., 0]))
    first -= np.where(first > 45.0, 360.0, 0.0)
    end = start - 360.0 * np.round((start - first) / 360.0) + np.degrees(turned)
    return np.asarray(np.abs(end) < 30.0)


def open_loop(loops: Reals, plant: Plant, hz: Reals, mass: float = 1.0) -> Complexes:
    """Return the response of loops, made for the mass of the plant, at a relative real mass."""
    held = late_response(plant, hz) * np.sinc(hz / plant.step_hz)
    return controller_response(loops, plant, hz) * (held * compliance(plant, hz, mass))


def margins(loop: Loop, plant: Plant, mass: float = 1.0) -> Margins:
    """Judge a loop that is made for the mass of the plant at a relative real mass."""
    opened = open_loop(np.array(astuple(loop)), plant, response_grid(plant), mass)
    [gain], [phase] = _judged(opened)
    return Margins(float(gain), float(phase), bool(_is_stable(opened)))


def closed_compliance(loops: Reals, plant: Plant, hz: Reals, mass: float = 1.0) -> Complexes:
    """Return what the scale sees per force with loops closed, in m/N; arguments of `open_loop`."""
    moved = compliance(plant, hz, mass)
    return np.asarray(moved / (1.0 + open_loop(loops, plant, hz, mass)))


def step_response(loops: Reals, plant: Plant, line_hz: float, mass: float = 1.0) -> Reals:
    """Return the response [m] to 1 N, a row each, over half the period of a line."""
    hz = np.arange(line_hz, min(_FASTEST_HZ, 0.45 * plant.step_hz), line_hz)
    static = closed_compliance(loops, plant, _STATIC, mass).real  # 0 with an integral
    lines = (closed_compliance(loops, plant, hz, mass) - static) / (2j * np.pi * hz)
    n = 2 * (hz.size + 1)
    row = np.fft.irfft(np.insert(lines, 0, 0.0, axis=-1), n) * n * line_hz
    ended = row[..., [3 * n // 4]]  # away from the jump that a static response has at 0
    return np.asarray((row - ended + static)[..., : n // 2])


def _with_depth(found: Reals) -> Reals:
    """Return loops whose notch has the damping of its zeros instead of its depth."""
    return np.concatenate([found[:5], found[5:6] * found[6:], found[6:]])


def _cost(found: Reals, plant: Plant) -> Reals:
    """Return the logarithm of the peak after a step of force, and more for what is missing."""
    loops = _with_depth(found)
    opened = open_loop(loops, plant, response_grid(plant))
    step = np.abs(step_response(loops, plant, 5.0)) * 1e7
    late = step[..., int(BACK_S / 0.1 * step.shape[-1]) :].max(axis=-1)
    cost = np.log(step.max(axis=-1)) + 0.5 * np.log(np.maximum(1.0, late / 0.08))
    for mass, gain, phase in zip(MASSES, *_judged(opened, MASSES), strict=True):
        lack = np.maximum(0.0, 1.03 - gain / LEAST_GAIN_DB)
        lack += np.maximum(0.0, 1.03 - phase / LEAST_PHASE_DEG)
        cost += 10.0 * (lack + np.where(_is_stable(opened / mass), 0.0, 3.0))
    cost += 10.0 * np.maximum(0.0, word_shares(loops, plant) - _MOST_SHARE).sum(axis=0)
    for mass in EXTREME_MASSES:
        cost += np.where(_is_stable(opened / mass), 0.0, 5.0)
    return np.asarray(cost)


def best(plant: Plant) -> Loop:
    """Return the loop whose peak after a step of force is the smallest.

    Preferred are the least margins at MASSES, stability at EXTREME_MASSES, and 0.1 um 20 ms after a
    step of 10 N. Where none has all, some are lacking.
    """
    fastest = plant.step_hz / 5.0
    about = plant.mode_hz if plant.mode_hz > 0.0 else fastest / 4.0
    bounds = [
        (fastest / 100.0, fastest / 4.0),
        (4.0, 100.0),
        (0.4 * fastest, fastest),
        (1.0, 60.0),
        (0.5 * about, min(2.5 * about, 0.24 * plant.step_hz)),
        (0.05, 1.0),  # depth of the notch
        (0.1, 1.2),
    ]
    found = differential_evolution(
        _cost, bounds, args=(plant,), vectorized=True, updating="deferred", rng=1, popsize=10,
        maxiter=80, tol=1e-6, polish=False,
    )  # fmt: skip
    return Loop(*(float(v) for v in _with_depth(found.x)))
