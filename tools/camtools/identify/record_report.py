# SPDX-License-Identifier: Apache-2.0
"""What a recording of another instrument shows, as text and as JSON.

>>> constants_of(np.array([1.0, 7e-4, 3e-7, 1e-4]), "command_um")["k1 ns"]
700000.0
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from camtools.base.json_text import Json
from camtools.base.quantities import Floats
from camtools.identify.foreign_record import FORCES, ForeignRecord
from camtools.identify.linear_model import (
    DELAY,
    RATE,
    SECOND,
    STATIC,
    LinearModel,
    jackknife,
)

_NS, _US2, _UM = 1e9, 1e12, 1e6  # per s, s2 and m


def constants_of(values: Floats, command: str) -> dict[str, float]:
    """Return constants by name and unit.

    Parameters
    ----------
    values : ndarray, shape (4,)
        As of `LinearModel`.
    command : str
        Name of the column of the command or force.
    """
    static, rate, second, delay_s = (float(values[i]) for i in (STATIC, RATE, SECOND, DELAY))
    ringing = max(static / second, 0.0) ** 0.5 if second else 0.0  # rad/s
    shape = {
        "delay ns": delay_s * _NS,
        "natural frequency Hz": ringing / (2 * np.pi),
        "damping": rate / (2 * second * ringing) if ringing else float("inf"),
    }
    if command in FORCES:
        return {"mass kg": second, "viscous N s/m": rate, "stiffness N/m": static} | shape
    gain, unit = (_UM / static, "um/V") if command == "command_v" else (1 / static, "")
    drive = {"k1 ns": rate / static * _NS, "k2 us2": second / static * _US2}
    return {f"gain {unit}".strip(): gain} | drive | shape


def _deviations(found: LinearModel, command: str) -> list[float]:
    rows = [list(constants_of(one, command).values()) for one in found.replicas]
    return [float(one) for one in jackknife(np.array(rows))]


def record_lines(found: LinearModel, record: ForeignRecord) -> Iterator[str]:
    """Yield the report, line by line."""
    hz = np.abs(found.lines.s) / (2 * np.pi)
    coherence = found.lines.coherence
    held = "held for each step" if found.lines.hold_s else "continuous"
    yield (
        f"record: {record.u.size} rows at {record.rate_hz:.6g} Hz; command {held}; {hz.size} lines "
        f"{hz[0]:.3g} .. {hz[-1]:.4g} Hz, coherence {np.median(coherence):.4g} in the median, "
        f"{coherence.min():.3g} at least"
    )
    yield f"{'':<22}{'found':>14}{'deviation':>12}"
    constants = constants_of(found.values, record.command)
    for (name, value), sigma in zip(
        constants.items(), _deviations(found, record.command), strict=True
    ):
        yield f"{name:<22}{value:>14.6g}{sigma:>12.2g}"
    yield f"misfit {100 * found.misfit:.3g} %, {found.chi:.3g} times the deviations of the lines"
    yield from (f"a linear model does not hold: {one}" for one in found.problems)


def record_numbers(found: LinearModel, record: ForeignRecord) -> Json:
    """Return the report for other programs."""
    constants = constants_of(found.values, record.command)
    sigmas = _deviations(found, record.command)
    return {
        "constants": {
            name: {"found": value, "deviation": sigma}
            for (name, value), sigma in zip(constants.items(), sigmas, strict=True)
        },
        "command_hold_s": found.lines.hold_s,
        "lines": int(found.lines.s.size),
        "coherence_median": float(np.median(found.lines.coherence)),
        "misfit": found.misfit,
        "misfit_deviations": found.chi,
        "problems": found.problems,
    }
