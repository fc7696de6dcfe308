# SPDX-License-Identifier: Apache-2.0
"""Sign and mass of a force drive from a pulse in each direction.

>>> import numpy as np
>>> force = np.concatenate([[0.0] * 100, [10.0] * 200, [-10.0] * 200, [0.0] * 100])
>>> force = np.concatenate([force, -force])
>>> position = -np.cumsum(np.cumsum(force)) / 2.0 * 5e-5**2
>>> found = pulse_fit(20_000.0, force, position)
>>> found.sign, round(found.mass_kg, 2), found.friction_n < 0.1
(-1, 2.0, True)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats

_SMOOTH_S = 1e-3  # window of the speed
_MOVING = 0.05  # of the greatest speed: friction counts in full from there on
_MOST_SCATTER = 0.3  # of the mass, between the directions


class Pulse(NamedTuple):
    """What pulses show."""

    sign: int  # 1: a positive force moves the scale up; -1: down
    mass_kg: float
    mass_sigma_kg: float  # half of the difference between the directions
    friction_n: float


def _sums(row: Floats, step_s: float) -> Floats:
    return np.asarray(np.cumsum(row) * step_s)


def _one(tick_hz: float, force_n: Floats, position_m: Floats) -> tuple[float, float]:
    """Return motion per force [1/kg] and per friction [m/s2], by the sums of both.

    The single sum of the force takes up the delay.
    """
    step_s, n = 1.0 / tick_hz, max(1, round(_SMOOTH_S * tick_hz))
    smooth = np.convolve(np.pad(position_m, n, mode="edge"), np.ones(n) / n, mode="same")[n:-n]
    speed = np.gradient(smooth, step_s)
    sense = np.clip(speed / (_MOVING * np.abs(speed).max() + 1e-30), -1.0, 1.0)
    impulse = _sums(force_n, step_s)
    columns = [np.ones_like(force_n), impulse, _sums(impulse, step_s)]
    columns.append(_sums(_sums(sense, step_s), step_s))
    matrix = np.column_stack(columns)
    size = np.linalg.norm(matrix, axis=0) + 1e-300
    found = np.linalg.lstsq(matrix / size, position_m, rcond=None)[0] / size
    return float(found[2]), float(-found[3])


def pulse_fit(tick_hz: float, force_n: Floats, position_m: Floats) -> Pulse:
    """Return sign and mass.

    Parameters
    ----------
    tick_hz : float
        Rate of the record.
    force_n, position_m : ndarray, shape (n,)
        From rest: a pulse in one direction in the first half, in the other in the second; each
        ends at rest.

    Raises
    ------
    CamtoolsError
        The scale did not move, or the directions differ in sign or by more than 30 % of the mass.
    """
    half = force_n.size // 2
    parts = (slice(0, half), slice(half, None))
    if any(np.ptp(force_n[part]) == 0 or np.ptp(position_m[part]) == 0 for part in parts):
        problem = "no force or no motion in one of the directions"
        raise CamtoolsError([f"pulse: {problem}; see amplifier, scale and brake, push harder"])
    (first, rub), (second, rub_2) = (_one(tick_hz, force_n[p], position_m[p]) for p in parts)
    mean, off = 0.5 * (first + second), 0.5 * abs(first - second)
    if first * second <= 0 or off > _MOST_SCATTER * abs(mean):
        problem = f"the directions give masses of {1 / first:.3g} and {1 / second:.3g} kg"
        raise CamtoolsError([f"pulse: {problem}; free the slide, push harder or for longer"])
    mass_kg = 1.0 / abs(mean)
    friction_n = 0.5 * (rub + rub_2) * mass_kg
    return Pulse(int(np.sign(mean)), mass_kg, mass_kg * off / abs(mean), friction_n)
