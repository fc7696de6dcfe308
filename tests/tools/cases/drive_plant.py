# SPDX-License-Identifier: Apache-2.0
"""A drive of U to judge the identification by: not the simulator's, not the fit's.

Exact flow of the linear part over short steps, Coulomb friction as a set-valued force between them
(Strang's splitting, so sticking is exact), dead time in steps, a mode between scale and slide, a
scale that rounds. Many drives are moved at once, one a column.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm
from scipy.signal import lfilter, ss2tf

from camtools.base.quantities import Floats
from camtools.identify.multisine import Wave

STEP_S = 12.5e-6  # at most; dead times are whole multiples
FADE_PERIODS = 0.25


@dataclass(frozen=True)
class Plant:
    """One drive: natural frequency, damping, dead time, friction, quantum, mode."""

    hz: float = 300.0
    damping: float = 0.7
    delay_us: float = 75.0
    friction_m_s2: float = 0.0
    quantum_nm: float = 10.0
    mode_hz: float = 0.0
    mode_damping: float = 0.03
    mode_share: float = 0.0
    gain: float = 1.0

    @property
    def k1_s(self) -> float:
        """Return the velocity term of its inverse."""
        return 2 * self.damping / (2 * np.pi * self.hz)

    @property
    def k2_s2(self) -> float:
        """Return the acceleration term of its inverse."""
        return 1 / (2 * np.pi * self.hz) ** 2

    def lead_s(self, tick_hz: float) -> float:
        """Return its dead time with half a tick of hold."""
        return self.delay_us * 1e-6 + 0.5 / tick_hz


def _flow(plant: Plant, dt_s: float) -> tuple[Floats, Floats]:
    """Return state and input matrices of a step; states y, v of slide and of the mode."""
    w, d = 2 * np.pi * plant.hz, plant.damping
    a = np.zeros((5, 5))
    a[0, 1] = 1
    a[1] = [-w * w, -2 * d * w, 0, 0, w * w * plant.gain]
    if plant.mode_hz > 0:
        wm = 2 * np.pi * plant.mode_hz
        a[2, 3] = 1
        a[3] = -plant.mode_share * a[1]
        a[3, 2] -= wm * wm
        a[3, 3] -= 2 * plant.mode_damping * wm
    flow = expm(a * dt_s)
    return flow[:4, :4], flow[:4, 4]


def faded(wave: Wave, n_periods: int) -> Floats:
    """Return set-points: the wave again and again, faded in."""
    u = np.tile(wave.u_nm, n_periods).astype(np.float64)
    n = int(FADE_PERIODS * wave.grid.n_ticks)
    x = np.arange(n) / n
    u[:n] *= x**3 * (10 - 15 * x + 6 * x * x)
    return u


def _rub(state: Floats, kick: Floats, share: Floats) -> None:
    """Take the speed that friction takes in half a step; the mode feels it as any acceleration."""
    loss = np.sign(state[:, 1]) * np.minimum(np.abs(state[:, 1]), kick)
    state[:, 1] -= loss
    state[:, 3] += share * loss


def _linear(plant: Plant, u_nm: Floats, steps: int, dt_s: float) -> Floats:
    """Return the positions of a drive without friction."""
    n = 4 if plant.mode_hz > 0 else 2
    flow, given = _flow(plant, dt_s)
    seen = np.array([[1.0, 0.0, 1.0, 0.0]])[:, :n]
    up, down = ss2tf(flow[:n, :n], given[:n, None], seen, np.zeros((1, 1)))
    lag, quantum = round(plant.delay_us * 1e-6 / dt_s), max(plant.quantum_nm, 1e-9)
    held = np.concatenate([np.zeros(lag), np.repeat(np.round(u_nm / quantum) * quantum, steps)])
    moved = lfilter(up[0], down, held[: u_nm.size * steps])[::steps]
    return np.asarray(np.round(moved / quantum) * quantum)


def played(plants: list[Plant], u_nm: Floats, tick_hz: float) -> Floats:
    """Return the measured positions at the ticks, shape (plants, ticks)."""
    steps = int(np.ceil(1 / tick_hz / STEP_S - 1e-9))
    dt_s = 1 / tick_hz / steps
    if not any(plant.friction_m_s2 for plant in plants):
        return np.array([_linear(plant, u_nm, steps, dt_s) for plant in plants])
    flows, inputs = zip(*(_flow(plant, dt_s) for plant in plants), strict=True)
    flow, given = np.array(flows), np.array(inputs)
    kick = np.array([plant.friction_m_s2 for plant in plants]) * 1e9 * dt_s / 2
    lag = np.array([round(plant.delay_us * 1e-6 / dt_s) for plant in plants])
    quantum = np.array([max(plant.quantum_nm, 1e-9) for plant in plants])
    given_nm = np.concatenate([np.zeros(lag.max()), np.repeat(u_nm, steps)])
    places = np.arange(u_nm.size * steps)[:, None] + lag.max() - lag
    commands = np.round(given_nm[places] / quantum) * quantum
    gain = np.array([plant.gain for plant in plants])
    stiffness = np.array([(2 * np.pi * plant.hz) ** 2 for plant in plants])
    share = np.array([plant.mode_share for plant in plants])
    friction = kick / (dt_s / 2)
    state = np.zeros((len(plants), 4))
    measured = np.empty((len(plants), u_nm.size))
    for i in range(u_nm.size):
        measured[:, i] = state[:, 0] + state[:, 2]
        for j in range(steps):
            command = commands[i * steps + j]
            push = np.abs(gain * command - state[:, 0]) * stiffness
            held = (state[:, 1] == 0) & (push <= friction)
            before = state[:, 0].copy()
            _rub(state, kick, share)
            state = np.einsum("pij,pj->pi", flow, state) + given * command[:, None]
            _rub(state, kick, share)
            state[held, 3] += (share * state[:, 1])[held]
            state[held, 1] = 0.0
            state[held, 0] = before[held]
    return np.asarray(np.round(measured / quantum[:, None]) * quantum[:, None])
