# SPDX-License-Identifier: Apache-2.0
"""Whether U takes forces, and what is to be known of its loop, by the parameters.

>>> has_force_drive({"servo_mass_g": 1500, "servo_crossover_hz": 0})
False
>>> has_force_drive({"servo_mass_g": 2100, "servo_crossover_hz": 0})
True
"""

from __future__ import annotations

from collections.abc import Mapping

from camtools.link.parameters import INFOS
from camtools.tune.parameters import ranges

_NOT_SET = (
    "The loop of U is not set (servo_crossover_hz = 0), so its drives cannot be enabled. Load a "
    "weak loop below: hal/RETROFIT.md, first power-up of a U that takes forces, step 3."
)
_PER_UNIT = 1e3  # of mN, ms and g


def has_force_drive(values: Mapping[str, int]) -> bool:
    """Return whether a parameter of the loop differs from its default, as with a force drive."""
    return any(values.get(name, INFOS[name].default) != INFOS[name].default for name in ranges())


def loop_text(values: Mapping[str, int]) -> str:
    """Return the loop in force and the limits that stay as they are, or what is to be set first."""
    if values["servo_crossover_hz"] == 0:
        return _NOT_SET
    limit, continuous, thermal = (
        values[f"servo_{name}"] / _PER_UNIT
        for name in ("force_limit_mn", "continuous_mn", "thermal_ms")
    )
    return (
        f"Loop in force: crossover {values['servo_crossover_hz']} Hz, mass "
        f"{values['servo_mass_g'] / _PER_UNIT:g} kg. Limits, which stay: {limit:g} N, "
        f"{continuous:g} N for ever, thermal {thermal:g} s."
    )
