# SPDX-License-Identifier: Apache-2.0
"""Charts that compare runs, as options of ECharts.

>>> scale_of([np.array([[0.1, -0.4]]), np.array([[np.nan, 0.2]])])
0.4
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from camtools.base.quantities import Floats
from camtools.panel.design.charts import BLUE, FAINT, GREEN, INK, ORANGE
from camtools.panel.runs.compare import ErrorCurves

COLOURS = (BLUE, ORANGE, GREEN, "#6a3d9a")
# From metal taken too much to metal left, with the tolerance of the eye in the middle.
_MAP_COLOURS = ["#08306b", "#2171b5", "#9ecae1", "#f7f7f7", "#fdae6b", "#d94801", "#7f2704"]

Options = dict[str, Any]


def _axis(name: str, gap: int) -> Options:
    return {
        "type": "value",
        "scale": True,
        "name": name,
        "nameLocation": "middle",
        "nameGap": gap,
        "nameTextStyle": {"color": INK, "fontSize": 13},
        "axisLabel": {"color": INK, "fontSize": 12, "hideOverlap": True},
        "axisLine": {"lineStyle": {"color": INK}},
        "splitLine": {"lineStyle": {"color": FAINT}},
    }


def _points(x: Floats, y: Floats) -> list[list[float | None]]:
    """Return points for a line, a hole where a number is missing."""
    return [
        [round(float(a), 5), None if not np.isfinite(b) else round(float(b), 6)]
        for a, b in zip(x, y, strict=True)
    ]


def _lines(
    title: str, axes: tuple[Options, Options], named: Sequence[tuple[str, list[Any]]]
) -> Options:
    return {
        "animation": False,
        "title": {"text": title, "left": "center", "textStyle": {"color": INK, "fontSize": 15}},
        "legend": {"bottom": 0, "textStyle": {"color": INK}},
        "tooltip": {"trigger": "axis"},
        "grid": {"left": 72, "right": 24, "top": 40, "bottom": 76},
        "xAxis": axes[0],
        "yAxis": axes[1],
        "series": [
            {
                "name": name,
                "type": "line",
                "showSymbol": False,
                "data": data,
                "itemStyle": {"color": colour},
                "lineStyle": {"color": colour, "width": 2, "type": style},
            }
            for (name, data), colour, style in zip(
                named, COLOURS, ("solid", "dashed", "dotted", "solid"), strict=False
            )
        ],
    }


def over_height(names: Sequence[str], curves: Sequence[ErrorCurves | None]) -> Options:
    """Return the largest form error of each band of the height."""
    named = [
        (name, _points(one.z_mm, one.worst_um))
        for name, one in zip(names, curves, strict=True)
        if one is not None
    ]
    axes = _axis("height / mm", 28), _axis("largest |form error| / µm", 52) | {"scale": False}
    return _lines("form error over the height", axes, named)


def over_angle(names: Sequence[str], curves: Sequence[ErrorCurves | None]) -> Options:
    """Return the mean following error while cutting, over the drawing's angle."""
    named = [
        (name, _points(one.angle_deg, one.following_um))
        for name, one in zip(names, curves, strict=True)
        if one is not None and one.following_um is not None
    ]
    x_axis = _axis("drawing's angle / °", 28) | {"min": 0, "max": 360, "interval": 45}
    axes = x_axis, _axis("mean following error / µm", 52)
    return _lines("following error over the angle", axes, named)


def sections(
    names: Sequence[str], found: Sequence[tuple[Floats, Floats] | None], z_mm: float
) -> Options:
    """Return the form error of one band of the height, over the drawing's angle."""
    named = [
        (name, _points(*one)) for name, one in zip(names, found, strict=True) if one is not None
    ]
    x_axis = _axis("drawing's angle / °", 28) | {"min": 0, "max": 360, "interval": 45}
    axes = x_axis, _axis("form error / µm", 52)
    return _lines(f"form error of the section at {z_mm:.4g} mm", axes, named)


def scale_of(maps: Sequence[Floats]) -> float:
    """Return the largest magnitude of all maps, which the colours of all of them end at [um]."""
    largest = max((float(np.nanmax(np.abs(one))) for one in maps if one.size), default=0.0)
    return float(f"{largest:.3g}") if np.isfinite(largest) and largest > 0 else 1.0


def error_map(name: str, curves: ErrorCurves, scale_um: float) -> Options:
    """Return a map of the form error over angle and height.

    Parameters
    ----------
    scale_um : float
        Where the colours end; the same for maps that stand side by side.
    """
    cells = [
        [column, row, round(float(value), 5)]
        for row, line in enumerate(curves.map_um)
        for column, value in enumerate(line)
        if np.isfinite(value)
    ]
    every = len(curves.angle_deg) // 8
    angles = [f"{angle - curves.angle_deg[0]:.0f}°" for angle in curves.angle_deg]
    shown = {"color": INK, "interval": every - 1}
    heights = [f"{z:.1f}" for z in curves.z_mm]
    return {
        "animation": False,
        "title": {"text": name, "left": "center", "textStyle": {"color": INK, "fontSize": 15}},
        "grid": {"left": 64, "right": 20, "top": 40, "bottom": 96},
        "tooltip": {"formatter": "{c}"},
        "xAxis": {"type": "category", "data": angles, "axisLabel": shown},
        "yAxis": {
            "type": "category",
            "data": heights,
            "name": "height / mm",
            "nameLocation": "middle",
            "nameGap": 44,
            "nameTextStyle": {"color": INK},
            "axisLabel": {"color": INK, "interval": len(heights) // 6},
        },
        "visualMap": {
            "min": -scale_um,
            "max": scale_um,
            "precision": 3,
            "calculable": False,
            "orient": "horizontal",
            "left": "center",
            "bottom": 4,
            "text": [f"+{scale_um:g} µm: metal left", f"{-scale_um:g} µm"],
            "textStyle": {"color": INK},
            "inRange": {"color": _MAP_COLOURS},
        },
        "series": [{"type": "heatmap", "data": cells, "silent": False, "progressive": 0}],
    }
