# SPDX-License-Identifier: Apache-2.0
"""A preview in words and rows: verdict, margins, size of the table.

>>> verdict_words({"is_feasible": True, "highest_rpm": 3000.0, "asked_rpm": 2500.0,
...                "decided_by": "spindle_rpm"})
('feasible', 'at most 3000.0 r/min: spindle_rpm decides; asked for 2500 r/min')
"""

from __future__ import annotations

from typing import Any

from camtools.cut.feasibility import tenth_below

_NAMES = {
    "u_stroke": "U stroke",
    "u_speed": "U speed",
    "u_acceleration": "U acceleration",
    "spindle_speed": "spindle speed",
    "feed": "feed per turn",
    "z_speed": "Z speed",
    "z_acceleration": "Z acceleration",
    "x_speed": "X speed",
    "x_acceleration": "X acceleration",
    "tick_rate": "spindle speed of the ticks",
    "spindle_acceleration": "spindle acceleration",
    "spindle_loop": "spindle loop",
    "spindle_set_point": "spindle set-point",
    "swing_range": "swing",
    "swing_speed": "swing speed",
    "swing_acceleration": "swing acceleration",
}


def verdict_words(told: dict[str, Any]) -> tuple[str, str]:
    """Return the verdict in a word, and the speed in a sentence."""
    speed = f"at most {tenth_below(told['highest_rpm'])} r/min: {told['decided_by']} decides"
    if told["highest_rpm"] <= 0:
        speed = f"at no speed: {told['decided_by']} decides"
    word = "feasible" if told["is_feasible"] else "not feasible"
    return word, f"{speed}; asked for {told['asked_rpm']:g} r/min"


def _digits(value: float) -> str:
    """Return a number with five digits, without an exponent.

    >>> _digits(250000.0), _digits(0.123456), _digits(87654.3)
    ('250000', '0.12346', '87654')
    """
    return f"{value:.0f}" if abs(value) >= 10_000 else f"{value:.5g}"


def margin_rows(told: dict[str, Any]) -> list[dict[str, str]]:
    """Return what the table needs of each limit, the nearest one first."""
    rows = sorted(told["margins"], key=lambda one: float(one["left_percent"]))
    return [
        {
            "limit": _NAMES.get(one["name"], one["name"]),
            "needed": f"{_digits(one['needed'])} {one['unit']}",
            "of": f"{_digits(one['limit'])} {one['unit']}",
            "left": f"{one['left_percent']:.1f} %",
        }
        for one in rows
    ]


def table_words(told: dict[str, Any]) -> list[str]:
    """Return the size of the table and of its channels in lines."""
    table = told["table"]
    size = f"{table['bytes']:,}".replace(",", " ")
    tolerance = table["tolerance_nm"]
    within = "" if tolerance is None else f", within {tolerance:g} nm"
    lines = [f"table of {size} bytes{within}"]
    for one in table["channels"]:
        n = one["knots_per_pattern"]
        repeats = one["patterns_per_turn"]
        knots = f"{n} knots" if repeats == 1 else f"{n} knots, {repeats} times per turn"
        if n == 1:
            knots = "over the height"
        size = f"{one['bytes']:,}".replace(",", " ")
        lines.append(f"{one['name']}: {size} bytes, {one['n_slices']} slices, {knots}")
    return lines
