# SPDX-License-Identifier: Apache-2.0
r"""A recording of an excited force drive: read, fitted, reported.

>>> rows = "".join(f"{i * 1e-3},{i % 7},{i % 5},{i % 3}\n" for i in range(4096))
>>> found = parse_loop_record("time_s,injected_n,force_n,position_um\n" + rows, "scope.csv")
>>> round(found.rate_hz), float(found.values["position"][2])
(1000, 2e-06)
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from camtools.base.quantities import Floats
from camtools.identify.foreign_record import FORCES, LENGTHS, POSITIONS, Table, parse_table
from camtools.tune.plant_fit import (
    DELAY,
    DRAG,
    FRICTION,
    LAG,
    MASS,
    MODE_DAMPING,
    MODE_HZ,
    MODE_SHARE,
    STIFFNESS,
    PlantFit,
    fit_record,
)

_HEADER = "time_s,injected_n,force_n,position_um"
_INJECTED = {"injected_n": 1.0, "injected_kn": 1e3}
_SETPOINTS = {f"setpoint_{unit}": metres for unit, metres in LENGTHS.items()}
_NAMES = {
    MASS: ("mass_kg", 1.0),
    DRAG: ("drag_n_s_per_m", 1.0),
    STIFFNESS: ("stiffness_n_per_m", 1.0),
    FRICTION: ("friction_n", 1.0),
    DELAY: ("delay_us", 1e6),
    MODE_HZ: ("mode_hz", 1.0),
    MODE_DAMPING: ("mode_damping", 1.0),
    MODE_SHARE: ("mode_share", 1.0),
}
_NEVER_BELOW_0 = (DRAG, STIFFNESS, FRICTION, DELAY)


def parse_loop_record(text: str, file: str) -> Table:
    """Return injected signal, force and position of a text; errors as of `parse_table`."""
    kinds = {"injected": _INJECTED | _SETPOINTS, "force": FORCES, "position": POSITIONS}
    return parse_table(text, file, kinds, _HEADER)


def fit_table(record: Table, quantum_nm: float) -> PlantFit:
    """Return the constants of a record; errors as of `fit_record`."""
    values = record.values
    return fit_record(
        record.rate_hz, values["injected"], values["force"], values["position"], quantum_nm
    )


def with_fit(keys: dict[str, Any], found: PlantFit, tick_hz: float) -> dict[str, Any]:
    """Return the keys of a drive file with the constants that were found.

    Drag, stiffness, friction and delay below 0 are 0.
    """
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
