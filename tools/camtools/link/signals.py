# SPDX-License-Identifier: Apache-2.0
"""Signals of a recording in the units of people.

>>> unit_of("u_actual_nm", 20000)
Unit(name='u_actual_um', factor=0.001, is_wrapping=False)
>>> unit_of("angle_q32", 20000).name, unit_of("u_force_q6", 20000).name
('angle_deg', 'u_force_n')
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from camtools.link.messages import FAULT_TEXTS, NAMES
from camtools.link.scope import Recording

Floats = npt.NDArray[np.float64]
FAULTS = tuple(FAULT_TEXTS)
# Bits of hal.h by their numbers, hal_in_* and hal_out_*.
_AT = (
    "estop drive_ready bus_lost home_u home_x home_z index_u index_x index_z acknowledge key "
    "limit_u_low limit_u_high"
)
INPUTS = dict(enumerate(_AT.split()))
OUTPUTS = {0: "enable", 1: "fault", 2: "in_cut"}
BITS = {"faults": dict(enumerate(FAULTS)), "inputs": INPUTS, "outputs": OUTPUTS}
_TURN = 2.0**32
_S_PER_MIN = 60.0


@dataclass(frozen=True)
class Unit:
    """How a signal is shown."""

    name: str  # of the column; the last word is the unit
    factor: float  # that unit per unit of the controller
    is_wrapping: bool = False  # it counts from 0 to 2^32, not from -2^31


def unit_of(signal: str, tick_hz: int) -> Unit:
    """Return how a signal of that tick rate is shown; what has no unit stays as it is."""
    factors = {
        "_force_q6": ("_force_n", 1e-3 / 64),
        "_nm": ("_um", 1e-3),
        "_q6": ("_um", 1e-3 / 64),
        "vel_q10": ("vel_mm_per_s", 1e-6 / 1024 * tick_hz),
        "acc_q10": ("acc_m_per_s2", 1e-9 / 1024 * tick_hz**2),
        "speed_q32": ("speed_rpm", tick_hz * _S_PER_MIN / _TURN),
        "_q32": ("_deg", 360 / _TURN),
        "_mrpm": ("_rpm", 1e-3),
    }
    for end, (told, factor) in factors.items():
        if signal.endswith(end):
            return Unit(signal.removesuffix(end) + told, factor, signal == "angle_q32")
    return Unit(signal, 1)


def physical(recording: Recording) -> dict[str, Floats]:
    """Return the columns of a recording in the units of people, by their names in these."""
    columns = {}
    for signal in recording.signals:
        unit = unit_of(signal, recording.tick_hz)
        whole = recording[signal] % 2**32 if unit.is_wrapping else recording[signal]
        columns[unit.name] = whole.astype(np.float64) * unit.factor
    return columns


def faults_in(bits: int) -> list[str]:
    """Return the names of faults, a bit each."""
    return [name for i, name in enumerate(FAULTS) if bits >> i & 1]


def state_name(number: int) -> str:
    """Return the name of a state; its number where it has none."""
    return NAMES["state"].get(number, str(number))
