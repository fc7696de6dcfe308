"""U with friction, against a solution from event to event in closed form.

The simulator integrates by Runge-Kutta in sub-steps. Here every piece of constant command is solved
exactly, the reversals are roots found by scipy, and rest is rest. The commands are those of a cut,
as the trace of camsim has them.
"""

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

from tests.tools.cases.camsim_cases import cut

TICK_S, DELAY_S = 50e-6, 75e-6
OMEGA, DAMPING = 2 * np.pi * 300.0, 0.7
BOUND_NM = 0.05
MACHINE = """
[spindle]
limit_rpm = 3500
[u]
quantum_nm = 0
command_quantum_nm = 10
speed_mm_per_s = 800
acceleration_mm_per_s2 = 500000
stroke_mm = 3
friction_m_per_s2 = {friction}
[cut]
kc_n_per_mm2 = 0
[controller]
following_limit_nm = 300000
"""


def flow(pos: float, vel: float, rest: float, time_s: float) -> tuple[float, float]:
    """Return position and speed after a time about a place of rest."""
    q = OMEGA * np.sqrt(1 - DAMPING**2)
    c, s, decay = np.cos(q * time_s), np.sin(q * time_s), np.exp(-DAMPING * OMEGA * time_s)
    off = pos - rest
    b = (vel + DAMPING * OMEGA * off) / q
    moved = decay * (off * c + b * s)
    return rest + moved, decay * q * (b * c - off * s) - DAMPING * OMEGA * moved


def speed(time_s: float, pos: float, vel: float, rest: float) -> float:
    """Return the speed of `flow`."""
    return flow(pos, vel, rest, time_s)[1]


def piece(
    pos: float, vel: float, command: float, friction: float, time_s: float
) -> tuple[float, float]:
    """Return position [nm] and speed [nm/s] after a piece of constant command."""
    while time_s > 0:
        pull = OMEGA**2 * (command - pos)
        if vel == 0 and abs(pull) <= friction:
            return pos, 0.0
        sign = np.sign(vel) if vel != 0 else np.sign(pull)
        rest = command - sign * friction / OMEGA**2
        after = flow(pos, vel, rest, time_s)
        if sign * after[1] >= 0:
            return after
        start = 0.0 if vel != 0 else time_s * 1e-9
        until = brentq(speed, start, time_s, (pos, vel, rest), xtol=1e-16, rtol=1e-14)
        pos, vel, time_s = flow(pos, vel, rest, until)[0], 0.0, time_s - until
    return pos, vel


@pytest.mark.parametrize("friction", [pytest.param(5.0, marks=pytest.mark.long), 20.0])
def test_slide_with_friction_moves_as_the_closed_form(oval30: Path, friction: float) -> None:
    """Every tick agrees within the header's bound and the rounding of the trace."""
    words = ("--turns-limit", 3, "--tolerance-um", 999)
    trace = cut(oval30, *words, machine=MACHINE.format(friction=friction), tables=["trace"]).trace
    enabled = trace["out_outputs"].astype(int) & 1
    command = np.round(trace["out_u_nm"] / 10) * 10
    seen = trace["u_act_nm"]
    first = int(np.argmax(enabled))
    assert seen[first] == 0
    pos, vel, stuck, off = 0.0, 0.0, 0, []
    part = DELAY_S % TICK_S
    for i in range(first, len(seen) - 1):
        pos, vel = piece(pos, vel, command[i - 2], friction * 1e9, part)
        pos, vel = piece(pos, vel, command[i - 1], friction * 1e9, TICK_S - part)
        off.append(pos - seen[i + 1])
        stuck += vel == 0
    assert np.abs(seen).max() > 0.95e6
    assert stuck > 10
    assert np.abs(off).max() < 0.5 + BOUND_NM  # half a step of the trace
    moving = np.abs(np.diff(off, prepend=0)) > 0.01
    assert np.std(np.array(off)[moving]) == pytest.approx(np.sqrt(1 / 12), rel=0.03)
