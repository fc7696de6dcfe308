# SPDX-License-Identifier: Apache-2.0
"""What friction does to a drive whose constants are nearly known, MATHS.md (153).

The direction of motion that a scale shows is blurred by its quantum, and says nothing about a slide
that sticks, whose friction is whatever holds it. The drive with its friction, played forward from
the set-points, has neither fault.

>>> import numpy as np
>>> still = friction_of(np.array([7e-4, 3e-7, 5.0, 1e-4]), np.zeros(200), 1e-4)
>>> bool(np.all(still == 0))
True
"""

from __future__ import annotations

from math import copysign

import numpy as np
from scipy.linalg import expm

from camtools.base.quantities import Floats

_STEPS = 3  # of each of the two pieces of a tick


def _step(k1_s: float, k2_s2: float, dt_s: float) -> tuple[float, ...]:
    """Return the exact flow of the drive without friction about its command."""
    drive = np.array([[0.0, 1.0], [-1 / k2_s2, -k1_s / k2_s2]])
    return tuple(float(value) for value in expm(drive * dt_s).ravel())


class _Slide:
    """A slide that is pulled to a command and rubs.

    Attributes
    ----------
    y, v : float
        place [nm] and speed [nm/s]
    """

    def __init__(self, k2_s2: float, friction_nm: float) -> None:
        self.k2_s2, self.friction_nm = k2_s2, friction_nm
        self.y = self.v = 0.0

    def move(self, command: float, flow: tuple[float, ...], dt_s: float) -> float:
        """Let a step pass; return the time integral of the friction's share [s].

        While the slide moves one way friction only shifts the place to which it is pulled, so that
        the flow is exact; where it stops within the step, it does so with an even deceleration.
        """
        v = self.v
        if v == 0.0 and abs(command - self.y) <= self.friction_nm:
            return self._held(command) * dt_s
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

    def _held(self, command: float) -> float:
        return (command - self.y) / self.friction_nm

    def _goes_on(self, command: float, rest_s: float) -> float:
        """Hold what has stopped, or let it turn back, for the rest of a step."""
        push = command - self.y
        if abs(push) <= self.friction_nm:
            return self._held(command) * rest_s
        sign = copysign(1.0, push)
        acceleration = (push - sign * self.friction_nm) / self.k2_s2
        self.v = acceleration * rest_s
        self.y += 0.5 * self.v * rest_s
        return sign * rest_s


def friction_of(values: Floats, u_nm: Floats, tick_s: float) -> Floats:
    """Return the friction of a drive in each tick, as a share of its greatest, -1 .. 1.

    Parameters
    ----------
    values : ndarray, shape (4,)
        k1 [s] and k2 [s2], both > 0, friction [nm], dead time with half a tick of hold [s]
    u_nm : ndarray, shape (n,)
        set-points from rest on, one a tick
    tick_s : float

    Returns
    -------
    ndarray, shape (n,)
        mean over the tick that begins with the set-point
    """
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
