# SPDX-License-Identifier: Apache-2.0
"""What the position switches did, in words; without the libraries of pictures.

>>> switch_rows({})
[]
"""

from __future__ import annotations

from camtools.base.json_text import Json
from camtools.report.text import ReportRow


def _error_text(name: str, error: Json | None, count: int) -> str:
    """Return how far from the end of its window a switch acts."""
    if error is None:
        return f"never {name} by its angle"
    return f"{name} {count:.0f} times, {error['mean']:+.2f}° (at most {error['max']:+.2f}°)"


def _switch_text(one: Json) -> str:
    """Return all of one switch."""
    other = one["other_on"] + one["other_off"]
    per_turn = one["windows_per_turn"]
    times = f", {per_turn:.0f} times per turn" if per_turn > 1 else ""
    dead = f", dead time {one['dead_time_us']:g} µs" if one["dead_time_us"] else ""
    windows = f"{one['on_deg']:g}° .. {one['off_deg']:g}°{times}{dead}"
    texts = [
        windows,
        _error_text("on", one["on_error_deg"], one["times_on"]),
        _error_text("off", one["off_error_deg"], one["times_off"]),
        *([f"{other:.0f} changes by height, state or sense"] if other else []),
    ]
    return "; ".join(texts)


def switch_rows(summary: Json) -> list[ReportRow]:
    """Return a row for each position switch in use.

    Parameters
    ----------
    summary : Json
        Of camsim; its `switches` are those of host_sim/results/sim_switch_summary.h.
    """
    return [
        ReportRow(f"position switch {one['output']:.0f}", _switch_text(one))
        for one in summary.get("switches", [])
    ]
