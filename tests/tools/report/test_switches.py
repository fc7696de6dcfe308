# SPDX-License-Identifier: Apache-2.0
"""What a report says of the position switches, and its picture."""

from typing import Any

import numpy as np
import pytest

from camtools.plots.style import drawing, png_of
from camtools.report.switches import draw_switches, switches
from camtools.report.switches_text import switch_rows
from tests.tools.cases.report_cases import made_up_summary

ONE: dict[str, Any] = {
    "output": 3,
    "windows_per_turn": 2,
    "on_deg": 170,
    "off_deg": 190,
    "dead_time_us": 3000,
    "times_on": 64,
    "times_off": 63,
    "other_on": 1,
    "other_off": 1,
    "on_error_deg": {"mean": 0.02, "max": 0.4},
    "off_error_deg": {"mean": -0.03, "max": -0.41},
    "z_mm": [0, 62],
}
NEVER: dict[str, Any] = ONE | {
    "output": 8,
    "windows_per_turn": 1,
    "dead_time_us": 0,
    "times_on": 0,
    "times_off": 0,
    "other_on": 0,
    "other_off": 0,
    "on_error_deg": None,
    "off_error_deg": None,
}


def test_every_switch_has_a_row() -> None:
    """Window, dead time, deviations; what never acted says so."""
    rows = switch_rows(made_up_summary(switches=[ONE, NEVER]))
    assert [row.name for row in rows] == ["position switch 3", "position switch 8"]
    assert rows[0].value == (
        "170° .. 190°, 2 times per turn, dead time 3000 µs; on 64 times, +0.02° (at most +0.40°); "
        "off 63 times, -0.03° (at most -0.41°); 2 changes by height, state or direction"
    )
    assert rows[1].value == "170° .. 190°; never switched on by angle; never switched off by angle"


def test_picture_has_the_windows_and_where_they_acted() -> None:
    """Two windows, of which one passes 0; marks on their ends."""
    with drawing():
        figure = draw_switches(made_up_summary(switches=[ONE, NEVER]))
        (axes,) = figure.axes
        bars = [
            (path.get_extents().x0, path.get_extents().x1)
            for path in axes.collections[0].get_paths()
        ]
        assert sorted(bars) == [(0, 10), (170, 190), (350, 360)]
        assert len(axes.collections[1].get_paths()) == 1
        marks = {line.get_label(): np.asarray(line.get_xdata()) for line in axes.lines}
        assert marks["acted: on"] == pytest.approx([170.02, 350.02])
        assert marks["acted: off"] == pytest.approx([189.97, 9.97])
        assert png_of(figure).startswith(b"\x89PNG")


def test_no_switch_has_no_picture() -> None:
    """Nothing is drawn, and there is no row."""
    assert switches(made_up_summary()) == {}
    assert switch_rows(made_up_summary()) == []
