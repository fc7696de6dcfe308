"""The table of parameters, searched and judged, and what they say of a U that takes forces.

>>> row = rows({"lead_ns": 100000})[0]
>>> row["name"], row["value"], row["unit"], row["range"], row["group"], row["is_default"]
('lead_ns', 100000, 'ns', '0 .. 20000000', 'axis u', True)
"""

from collections.abc import Mapping
from typing import Any

from camtools.link.kept_values import INFOS, group_of
from camtools.tune.parameters import ranges

# Ends of names that are units, and how those are written that do not stand for themselves.
_UNITS = (
    *("nm", "um_per_s", "mm_per_s2", "nm_per_s", "ns", "us", "us2", "ms", "mHz", "mrpm"),
    *("mrad_per_s2", "udeg", "mdeg", "udeg_per_s", "mdeg_per_s", "deg_per_s2", "ppm"),
    *("ppm_per_s", "percent", "counts", "turns", "nturn", "per_turn"),
)
_WRITTEN = {"mrpm": "r/min / 1000", "percent": "%", "nturn": "1e-9 turn", "per_turn": "per turn"}
_SMALL = (("udeg", "1e-6 deg"), ("mdeg", "1e-3 deg"))


def unit_of(name: str) -> str:
    """Return the unit that ends a parameter's name; "" where it is a number or a choice.

    >>> unit_of("u_speed_um_per_s"), unit_of("swing_mdeg_per_s"), unit_of("tool")
    ('um/s', '1e-3 deg/s', '')
    """
    if name == "counts_per_turn":
        return "counts per turn"
    unit = max((end for end in _UNITS if name.endswith(f"_{end}")), key=len, default="")
    text = _WRITTEN.get(unit) or unit.replace("_per_", "/")
    for letters, words in _SMALL:
        text = text.replace(letters, words)
    return text


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
    is_measured = values.get("servo_measured", 0) != 0
    return (
        f"Loop in force: crossover {values['servo_crossover_hz']} Hz, mass "
        f"{values['servo_mass_g'] / _PER_UNIT:g} kg. Limits, which stay: {limit:g} N, "
        f"{continuous:g} N for ever, thermal {thermal:g} s."
        + ("" if is_measured else " Not measured on this drive: measure it before the first cut.")
    )
