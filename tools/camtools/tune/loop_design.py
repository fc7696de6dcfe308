# SPDX-License-Identifier: Apache-2.0
"""A position loop for a force drive: its response, its margins, and a proposal.

The loop is that of firmware/servo, MATHS.md (234) and (235). The plant is a mass driven by
an amplifier of first order, after a delay and the hold of a step; a mode may move the scale as
MATHS.md (123) gives it.

>>> drive = Plant(mass_kg=1.5, amplifier_hz=1500.0, delay_s=25e-6, step_hz=20000.0)
>>> judged = margins(Loop(300.0, 20.0, 4000.0, 10.0, 4000.0, 0.5, 0.5), drive)
>>> f"{judged.gain_db:.1f} dB, {judged.phase_deg:.0f} degrees"
'16.7 dB, 33 degrees'
"""

from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import differential_evolution

Reals = NDArray[np.float64]
Complexes = NDArray[np.complex128]

LEAST_GAIN_DB = 6.0
LEAST_PHASE_DEG = 30.0
MASSES = (0.7, 1.0, 1.3)  # relative; the margins hold at each
EXTREME_MASSES = (0.5, 2.0)  # relative; the loop is stable there
BACK_S = 0.02  # after this time a step of force has gone
_LINES: Reals = np.arange(5.0, 4000.0, 5.0)  # [Hz] of the response to a step


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


@dataclass(frozen=True)
class Loop:
    """The parameters of cam_servo_design.h that make the loop."""

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


class NoLoopError(ValueError):
    """There is no loop with the margins."""


def controller_response(loop: Reals, plant: Plant, hz: Reals) -> Complexes:
    """Return the response of loops in N/m.

    Parameters
    ----------
    loop
        Fields of Loop, one row each; one column for each loop.
    plant
        For its mass and rate.
    hz
        Frequencies below half the rate.
    """
    crossover, ratio, pole, integral, notch, zero_damping, pole_damping = loop[..., None]
    s = 2j * plant.step_hz * np.tan(np.pi * hz / plant.step_hz) / (2.0 * np.pi)
    lead = _lead(s, ratio, pole)
    gain = (
        plant.mass_kg * (2.0 * np.pi * crossover) ** 2 / np.abs(_lead(1j * crossover, ratio, pole))
    )
    q = s / (plant.step_hz / np.pi * np.tan(np.pi * notch / plant.step_hz))
    notched = (q * q + 2.0 * zero_damping * q + 1.0) / (q * q + 2.0 * pole_damping * q + 1.0)
    response: Complexes = gain * (1.0 + integral / s) * lead * notched
    return response


def _lead(s: Complexes, ratio: Reals, pole: Reals) -> Complexes:
    lead: Complexes = (1.0 + s * ratio / pole) / (1.0 + s / pole)
    return lead


def compliance(plant: Plant, hz: Reals) -> Complexes:
    """Return what the scale sees per force at the mass, in m/N."""
    s = 2j * np.pi * hz
    omega = 2.0 * np.pi * plant.mode_hz
    share = plant.mode_share if plant.mode_hz > 0.0 else 0.0
    mode = share / (s * s + 2.0 * plant.mode_damping * omega * s + omega**2)
    response: Complexes = (1.0 / (s * s) - mode) / plant.mass_kg
    return response


def actuator_response(plant: Plant, hz: Reals) -> Complexes:
    """Return force per command: amplifier, delay, hold."""
    s = 2j * np.pi * hz
    delay = np.exp(-s * (plant.delay_s + 0.5 / plant.step_hz))
    response: Complexes = delay * np.sinc(hz / plant.step_hz) / (1.0 + hz * 1j / plant.amplifier_hz)
    return response


def _grid(plant: Plant) -> Reals:
    """Frequencies up to half the rate, dense about the mode."""
    rough = np.geomspace(1.0, 0.499 * plant.step_hz, 500)
    width = np.sinh(np.linspace(-3.0, 3.0, 81)) / 40.0
    return np.sort(
        np.concatenate([rough, plant.mode_hz * (1.0 + width)]) if plant.mode_hz else rough
    )


def _least(values: Reals, crossings: NDArray[np.bool_]) -> Reals:
    """Return the least amount of the values at the crossings of each row; infinity without one."""
    least: Reals = np.min(np.where(crossings, np.abs(values), np.inf), axis=-1)
    return least


def _judge(opened: Complexes) -> tuple[Reals, Reals, NDArray[np.bool_]]:
    """Return gain margins in dB, phase margins in degrees, and stability, by Nyquist.

    With three poles at 0 and none to the right, 1 + L turns by three right angles.
    """
    level, imag = 20.0 * np.log10(np.abs(opened)), opened.imag
    turned = np.degrees(np.unwrap(np.angle(1.0 + opened), axis=-1))
    is_crossing = (imag[..., 1:] * imag[..., :-1] < 0.0) & (opened.real[..., 1:] < 0.0)
    # Between two lines the level at the crossing is linear, and so is the angle at 0 dB.
    part = imag[..., :-1] / (imag[..., :-1] - imag[..., 1:] + 1e-300)
    gain = _least(level[..., :-1] + part * np.diff(level), is_crossing)
    angle = np.degrees(np.unwrap(np.angle(-opened), axis=-1))
    share = level[..., :-1] / (level[..., :-1] - level[..., 1:] + 1e-300)
    at_unity = angle[..., :-1] + share * np.diff(angle)
    wrapped = (at_unity + 180.0) % 360.0 - 180.0
    phase = _least(wrapped, level[..., 1:] * level[..., :-1] < 0.0)
    return gain, phase, np.abs(turned[..., -1] - turned[..., 0] - 270.0) < 30.0


def _opened(loops: Reals, plant: Plant) -> Complexes:
    hz = _grid(plant)
    outside = actuator_response(plant, hz) * compliance(plant, hz)
    return controller_response(loops, plant, hz) * outside


def margins(loop: Loop, plant: Plant, mass: float = 1.0) -> Margins:
    """Judge a loop.

    Parameters
    ----------
    loop
        Made for the mass of the plant.
    plant
        The drive.
    mass
        The real mass, relative to that of the plant.
    """
    gain, phase, is_stable = _judge(_opened(np.array(astuple(loop)), plant) / mass)
    return Margins(float(gain), float(phase), bool(is_stable))


def _step(loops: Reals, plant: Plant) -> Reals:
    """Return the response in m to a step of 1 N over 0.1 s, one row for each loop."""
    opened = controller_response(loops, plant, _LINES) * actuator_response(plant, _LINES)
    moved = compliance(plant, _LINES)
    lines = moved / (1.0 + opened * moved) / (2j * np.pi * _LINES)
    n = 2 * (_LINES.size + 1)
    row = np.fft.irfft(np.insert(lines, 0, 0.0, axis=-1), n) * n * _LINES[0]
    response: Reals = (row - row[..., [-1]])[..., : n // 2]
    return response


def _with_depth(found: Reals) -> Reals:
    """Return loops whose notch has the damping of its zeros instead of its depth."""
    return np.concatenate([found[:5], found[5:6] * found[6:], found[6:]])


def _cost(found: Reals, plant: Plant) -> Reals:
    """Return the peak in um after a step of 10 N, and more for what is missing."""
    loops = _with_depth(found)
    opened = _opened(loops, plant)
    step = np.abs(_step(loops, plant)) * 1e7
    late = step[..., int(BACK_S / 0.1 * step.shape[-1]) :].max(axis=-1)
    cost = step.max(axis=-1) + 5.0 * np.maximum(0.0, late - 0.08)
    for mass in (*MASSES, *EXTREME_MASSES):
        gain, phase, is_stable = _judge(opened / mass)
        cost += np.where(is_stable, 0.0, 30.0)
        if mass in MASSES:
            cost += 2.0 * np.maximum(0.0, 1.03 * LEAST_GAIN_DB - gain)
            cost += 0.5 * np.maximum(0.0, 1.03 * LEAST_PHASE_DEG - phase)
    total: Reals = cost
    return total


def propose(plant: Plant) -> Loop:
    """Propose the loop whose peak after a step of force is the smallest.

    Its margins are 6 dB and 30 degrees over the mass +-30 %. Among such loops those are preferred
    that are stable from half the mass to twice the mass, and back within 0.1 um 20 ms after a step
    of 10 N.

    Raises
    ------
    NoLoopError
        No loop has these margins.
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
    loop = Loop(*(float(v) for v in _with_depth(found.x)))
    for mass in MASSES:
        at = margins(loop, plant, mass)
        if not at.is_stable or at.gain_db < LEAST_GAIN_DB or at.phase_deg < LEAST_PHASE_DEG:
            raise NoLoopError(
                f"no loop has margins of {LEAST_GAIN_DB:g} dB and {LEAST_PHASE_DEG:g} degrees at "
                f"{mass:g} of the mass (best: {at.gain_db:.1f} dB, {at.phase_deg:.0f} degrees): "
                "shorten the delay or damp the mode"
            )
    return loop
