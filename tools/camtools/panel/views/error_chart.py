# SPDX-License-Identifier: Apache-2.0
"""Charts of the following error over the angle as options of ECharts, and their small changes.

The charts are drawn for a light page; a style sheet inverts them on a dark one.

>>> [axis["max"] for axis in whole(POLAR, 0.2, 5.0)["radiusAxis"]]
[0.2]
>>> whole(POLAR, 0.2, 5.0)["radiusAxis"][0]["axisLabel"]["showMaxLabel"]
False
>>> change(POLAR, [Series(0, 1, [[90.0, 0.1]])], [])["series"][0]["data"]
[[0.1, 90.0]]
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from camtools.panel.views.error_trail import SLOTS, Points, Series

UNROLLED, POLAR = "unrolled", "polar"
_INK, _FAINT = "#37474f", "#c4ccd0"
_DOTS, _NEWEST, _MEAN, _LIMIT = "#1565c0", "#0d47a1", "#bf360c", "#b00020"
_MEAN_ID, _LIMITS = "mean", ("limit-high", "limit-low")
_ANGLES = [float(angle) for angle in range(0, 361, 6)]
_QUARTER_DEG = 90
Option = dict[str, Any]
Means = Sequence[Sequence[float | None]]


def opacity(age: int) -> float:
    """Return how strongly a series is drawn: the older the fainter."""
    return round(max(0.06, 0.85 * 0.72**age), 3)


def _placed(kind: str, points: Points | Means) -> list[list[float | None]]:
    # In the order of the coordinate system: on a polar one the radius is first.
    return [[error, angle] if kind == POLAR else [angle, error] for angle, error in points]


def _slot(kind: str, slot: int) -> Option:
    return {
        "id": f"turns-{slot}",
        "type": "scatter",
        "coordinateSystem": "polar" if kind == POLAR else "cartesian2d",
        "symbolSize": 3,
        "large": True,
        "largeThreshold": 50,
        "silent": True,
        "itemStyle": {"color": _DOTS, "opacity": opacity(slot)},
        "data": [],
    }


def _line(kind: str, name: str, colour: str, width: float, dash: str) -> Option:
    return {
        "id": name,
        "type": "line",
        "coordinateSystem": "polar" if kind == POLAR else "cartesian2d",
        "showSymbol": False,
        "silent": True,
        "clip": True,
        "lineStyle": {"color": colour, "width": width, "type": dash},
        "data": [],
    }


def _value_axis(full_um: float) -> Option:
    return {
        "type": "value",
        "min": -full_um,
        "max": full_um,
        "interval": full_um / 2,
        "axisLabel": {"color": _INK, "fontSize": 13},
        "splitLine": {"lineStyle": {"color": _FAINT}},
    }


def _angle_axis() -> Option:
    return {
        "type": "value",
        "min": 0,
        "max": 360,
        "interval": _QUARTER_DEG // 2,
        "axisLabel": {"color": _INK, "fontSize": 13, "formatter": "{value}°", "hideOverlap": True},
        "splitLine": {"lineStyle": {"color": _FAINT}},
        "axisLine": {"lineStyle": {"color": _INK}},
    }


def _system(kind: str, full_um: float) -> Option:
    """Return the axes; the drawing's angle counts counter-clockwise, seen from the headstock."""
    if kind == POLAR:
        round_axis = _angle_axis() | {"startAngle": 0, "clockwise": False}
        # Its largest label would touch that of 0 degrees; the unrolled chart has the same scale.
        scale = _value_axis(full_um)
        scale["axisLabel"] |= {"showMaxLabel": False}
        zero = {"axisLine": {"show": False}, "axisTick": {"show": False}}
        return {
            "polar": [{"radius": "76%", "center": ["50%", "51%"]}],
            "angleAxis": [round_axis],
            "radiusAxis": [scale | zero],
        }
    name = {
        "name": "following error / µm",
        "nameLocation": "middle",
        "nameGap": 48,
        "nameTextStyle": {"color": _INK, "fontSize": 13},
    }
    return {
        "grid": [{"left": 72, "right": 18, "top": 14, "bottom": 30}],
        "xAxis": [_angle_axis()],
        "yAxis": [_value_axis(full_um) | name],
    }


def _limits(kind: str, limit_um: float, full_um: float) -> list[Option]:
    """Return the lines of the tolerance, above and below; none where they are beyond the scale.

    A polar axis would show what is below its least value on the other side of the centre.
    """
    angles = _ANGLES if limit_um <= full_um else []
    return [
        {"id": name, "data": _placed(kind, [[angle, sign * limit_um] for angle in angles])}
        for name, sign in zip(_LIMITS, (1, -1), strict=True)
    ]


def whole(kind: str, full_um: float, limit_um: float) -> Option:
    """Return the options of an empty chart."""
    limits = [
        _line(kind, name, _LIMIT, 1.5, "dashed") | data
        for name, data in zip(_LIMITS, _limits(kind, limit_um, full_um), strict=True)
    ]
    mean = _line(kind, _MEAN_ID, _MEAN, 2.5, "solid")
    series = [*(_slot(kind, slot) for slot in range(SLOTS)), *limits, mean]
    return {"animation": False, **_system(kind, full_um), "series": series}


def change(
    kind: str, series: Sequence[Series], means: Means, scale_um: tuple[float, float] | None = None
) -> Option:
    """Return what an update sets: the data that are new, and the scale where it has changed.

    Parameters
    ----------
    means : sequence
        of angle and mean error, empty: that of before stays
    scale_um : tuple of float or None
        full scale and tolerance; None: as before
    """
    told: list[Option] = [
        {
            "id": f"turns-{one.slot}",
            "itemStyle": {"color": _DOTS if one.age else _NEWEST, "opacity": opacity(one.age)},
            **({} if one.points is None else {"data": _placed(kind, one.points)}),
        }
        for one in series
    ]
    if means:
        closed = [*means, [means[0][0], means[0][1]]] if kind == POLAR else means
        told.append({"id": _MEAN_ID, "data": _placed(kind, closed)})
    if scale_um is None:
        return {"series": told}
    full_um, limit_um = scale_um
    axis = "radiusAxis" if kind == POLAR else "yAxis"
    scale = {"min": -full_um, "max": full_um, "interval": full_um / 2}
    return {"series": [*told, *_limits(kind, limit_um, full_um)], axis: [scale]}
