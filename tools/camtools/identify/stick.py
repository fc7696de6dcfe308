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

_STEPS = 3  # of each of the two pieces of a tick, friction acting between them


def _step(k1_s: float, k2_s2: float, dt_s: float) -> tuple[float, ...]:
    """Return the exact flow of the drive without friction about its command."""
    drive = np.array([[0.0, 1.0], [-1 / k2_s2, -k1_s / k2_s2]])
    return tuple(float(value) for value in expm(drive * dt_s).ravel())


def friction_of(values: Floats, u_nm: Floats, tick_s: float) -> Floats:
    """Return the friction of a drive in each tick, as a share of its greatest, -1 .. 1.

    Between two steps the drive moves as without friction; friction takes speed away (Strang's
    splitting, of second order in the step), and holds what it has stopped against a push below it.

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
    friction_nm = max(0.0, friction_nm)
    delay = max(0.0, lead_s / tick_s - 0.5)
    n_delay, part = int(delay), delay - int(delay)
    commands = [0.0] * (n_delay + 1) + [float(value) for value in u_nm]
    pieces = [(0, part * tick_s / _STEPS), (1, (1 - part) * tick_s / _STEPS)]
    steps = [
        (late, friction_nm / k2_s2 * dt_s / 2, _step(k1_s, k2_s2, dt_s))
        for late, dt_s in pieces
        if dt_s > 0
    ]
    greatest = sum(2 * _STEPS * kick for _, kick, _ in steps) or 1.0
    y = v = 0.0
    shares = np.empty(u_nm.size)
    for i in range(u_nm.size):
        taken = 0.0
        for late, kick, (pp, pv, vp, vv) in steps:
            command = commands[i + late]
            for _ in range(_STEPS):
                if v == 0.0 and abs(command - y) <= friction_nm:
                    taken += 2 * kick * (command - y) / (friction_nm or 1.0)
                    continue
                loss = copysign(min(abs(v), kick), v)
                taken += loss
                v -= loss
                off = y - command
                y, v = command + pp * off + pv * v, vp * off + vv * v
                loss = copysign(min(abs(v), kick), v)
                taken += loss
                v -= loss
        shares[i] = taken / greatest
    return shares
