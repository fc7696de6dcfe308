r"""What a controller is configured with, and machine files with other numbers for it.

>>> print(with_keys("[u]\nmode_hz = 3\n", "controller", {"k1_ns": 5}), end="")
[u]
mode_hz = 3
<BLANKLINE>
[controller]
k1_ns = 5
"""

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import reduce
from typing import Self

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.identify.fit import FRICTION, K1, K2, LEAD


def frequency_and_damping(values: Floats) -> tuple[float, float]:
    """Return natural frequency [Hz] and damping of a drive with constants of a fit."""
    k2_s2 = max(float(values[K2]), 1e-18)
    return 1 / (2 * np.pi * k2_s2**0.5), float(values[K1]) / (2 * k2_s2**0.5)


@dataclass(frozen=True)
class Believed:
    """Parameters of the controller (firmware/param/cam_param.h) that matter here."""

    tick_hz: float
    k1_ns: int
    k2_us2: int
    lead_ns: int
    u_scale_latency_ns: int
    u_scale_nm: int
    u_stroke_nm: int
    u_speed_um_per_s: int
    u_acceleration_mm_per_s2: int

    @classmethod
    def of(cls, tick_hz: float, parameters: Mapping[str, int]) -> Self:
        """Return those of a controller from all of its parameters."""
        return cls(tick_hz, *(int(parameters[name]) for name in PARAMETERS))

    @property
    def values(self) -> Floats:
        """Constants as a fit finds them: the scale's latency added to the lead."""
        values = np.zeros(4)
        values[K1], values[K2] = self.k1_ns * 1e-9, self.k2_us2 * 1e-12
        values[LEAD] = (self.lead_ns + self.u_scale_latency_ns) * 1e-9
        return values

    def settings(self, values: Floats) -> dict[str, int]:
        """Return the parameters that constants of a fit ask for, in the order of their setting."""
        return {
            "k1_ns": round(float(values[K1]) * 1e9),
            "k2_us2": round(float(values[K2]) * 1e12),
            "lead_ns": max(0, round(float(values[LEAD]) * 1e9) - self.u_scale_latency_ns),
            "u_friction_nm": max(0, round(float(values[FRICTION]))),
        }

    def machine_keys(self, values: Floats) -> dict[str, float]:
        """Return the keys of [believed.u] of a machine file whose drive is of kind position."""
        hz, damping = frequency_and_damping(values)
        lead_s = float(values[LEAD]) - self.u_scale_latency_ns * 1e-9
        return {
            "bandwidth_hz": round(hz, 3),
            "damping": round(damping, 5),
            "delay_us": round(max(0.0, lead_s - 0.5 / self.tick_hz) * 1e6, 3),
        }


PARAMETERS = tuple(field.name for field in fields(Believed)[1:])
_TABLE = re.compile(r"^\s*\[([^\[\]]+)\]\s*(#.*)?$")


def with_keys(text: str, table: str, keys: Mapping[str, float]) -> str:
    """Return a machine file with new values in one table, or refuse a table in a line."""
    lines, inside, at = [], False, None
    for line in text.splitlines():
        found = _TABLE.match(line)
        name = re.sub(r"\s", "", found[1]) if found else None
        inside = name == table if found else inside
        key = line.split("=", 1)[0].strip() if "=" in line else ""
        if inside and key in keys:
            continue
        lines.append(line)
        if name == table:
            at = len(lines)
    new = [f"{key} = {value:.10g}" for key, value in keys.items()]
    if at is None:
        lines += ["", f"[{table}]", *new]
    else:
        lines[at:at] = new
    changed = "\n".join(lines) + "\n"
    _check(text, changed, table, keys)
    return changed


def _check(text: str, changed: str, table: str, keys: Mapping[str, float]) -> None:
    try:
        wanted, found = tomllib.loads(text), tomllib.loads(changed)
        reduce(lambda tree, word: tree.setdefault(word, {}), table.split("."), wanted).update(keys)
        is_good = wanted == found
    except (tomllib.TOMLDecodeError, AttributeError):  # the latter: a key is no table
        is_good = False
    if not is_good:
        remedy = f"write it as [{table}] with one key a line"
        raise CamtoolsError([f"machine file: {table}: its keys cannot be replaced; {remedy}"])
