# SPDX-License-Identifier: Apache-2.0
"""The table of parameters: value, unit, range, group and meaning, searched and judged.

>>> row = rows({"lead_ns": 100000})[0]
>>> row["name"], row["value"], row["unit"], row["range"], row["group"], row["is_default"]
('lead_ns', 100000, 'ns', '0 .. 20000000', 'axis u', True)
>>> judged("lead_ns", "1e5"), judged("lead_ns", "100 000"), judged("lead_ns", "30000000")
('give a whole number', 100000, 'out of range; give 0 .. 20000000')
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from camtools.link.parameters import INFOS, group_of

_UNITS = {
    "nm": "nm",
    "um_per_s": "um/s",
    "mm_per_s2": "mm/s2",
    "nm_per_s": "nm/s",
    "ns": "ns",
    "us": "us",
    "us2": "us2",
    "ms": "ms",
    "mHz": "mHz",
    "mrpm": "r/min / 1000",
    "mrad_per_s2": "mrad/s2",
    "udeg": "1e-6 deg",
    "mdeg": "1e-3 deg",
    "udeg_per_s": "1e-6 deg/s",
    "mdeg_per_s": "1e-3 deg/s",
    "deg_per_s2": "deg/s2",
    "ppm": "ppm",
    "ppm_per_s": "ppm/s",
    "percent": "%",
    "counts": "counts",
    "turns": "turns",
    "nturn": "1e-9 turn",
    "per_turn": "per turn",
}


def unit_of(name: str) -> str:
    """Return the unit that ends a parameter's name; "" where it is a number or a choice.

    >>> unit_of("u_speed_um_per_s"), unit_of("tool")
    ('um/s', '')
    """
    if name == "counts_per_turn":
        return "counts per turn"
    found = [end for end in _UNITS if name.endswith(f"_{end}")]
    return _UNITS[max(found, key=len)] if found else ""


def rows(values: Mapping[str, int]) -> list[dict[str, Any]]:
    """Return a row for each parameter that is known, in the order of the controller."""
    return [
        {
            "name": name,
            "value": values[name],
            "unit": unit_of(name),
            "range": f"{info.low} .. {info.high}",
            "default": info.default,
            "is_default": values[name] == info.default,
            "group": group_of(name).replace("_", " "),
            "meaning": info.what,
        }
        for name, info in INFOS.items()
        if name in values
    ]


def judged(name: str, text: str) -> int | str:
    """Return what was typed as a value, or why it is none, a clause."""
    plain = text.strip().replace(" ", "").replace("_", "")
    try:
        value = int(plain)
    except ValueError:
        return "give a whole number"
    info = INFOS[name]
    if not info.low <= value <= info.high:
        return f"out of range; give {info.low} .. {info.high}"
    return value
