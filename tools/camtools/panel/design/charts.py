"""A preview for people: charts as options of ECharts, words and rows.

They are drawn for a light page; a style sheet inverts them on a dark one.

>>> options = section({"nominal_mm": 46.0, "deviation_um": [0.0, -100.0, 0.0, -100.0]}, None)
>>> [one["name"] for one in options["series"]]
['nominal circle', 'drawing']

>>> verdict_words({"is_feasible": True, "highest_rpm": 3000.0, "asked_rpm": 2500.0,
...                "decided_by": "spindle_rpm"})
('feasible', 'at most 3000.0 r/min, limited by spindle_rpm; required 2500 r/min')
"""

from __future__ import annotations

from math import floor, log10
from typing import Any

from camtools.base.quantities import UM_PER_MM
from camtools.cut.feasibility import tenth_below

INK, FAINT, BLUE, ORANGE, RED, GREEN = (
    *("#37474f", "#cfd8dc", "#0d5a9c", "#b34700", "#b00020", "#2e6b34"),
)
_COLOURS = (BLUE, ORANGE, GREEN, "#6a3d9a")
_SHARE = 0.3  # of the radius that the largest deviation takes
_STEPS = (1.0, 2.0, 5.0, 10.0)
_EVERY = 2  # of the angles of a section one of so many is drawn
MOTION = (
    ("u_um", "U", "µm"),
    ("velocity_mm_s", "velocity", "mm/s"),
    ("acceleration_m_s2", "acceleration", "m/s²"),
    ("jerk_km_s3", "jerk", "km/s³"),
)

Options = dict[str, Any]


def magnification_of(nominal_mm: float, deviation_um: list[float]) -> float:
    """Return how many times deviations are enlarged so that they are seen: 1, 2, 5, 10 ...

    >>> magnification_of(46.0, [0.0, -150.0])
    50.0
    """
    largest_mm = max((abs(one) for one in deviation_um), default=0.0) / UM_PER_MM
    wanted = _SHARE * nominal_mm / largest_mm if largest_mm > 0 else 1.0
    if wanted <= 1:
        return 1.0
    decade = 10.0 ** floor(log10(wanted))
    return max(step * decade for step in _STEPS if step * decade <= wanted)


def _axis(name: str, **more: Any) -> Options:  # noqa: ANN401 (options of ECharts)
    return {
        "type": "value",
        "scale": True,
        "name": name,
        "nameLocation": "middle",
        "nameTextStyle": {"color": INK, "fontSize": 13},
        "axisLabel": {"color": INK, "fontSize": 12, "hideOverlap": True},
        "axisLine": {"lineStyle": {"color": INK}},
        "splitLine": {"lineStyle": {"color": FAINT}},
        **more,
    }


_LEGEND: Options = {
    "bottom": 0,
    "icon": "rect",
    "itemHeight": 4,
    "textStyle": {"color": INK, "fontSize": 12},
}


def _line(name: str, data: list[Any], colour: str, **more: Any) -> Options:  # noqa: ANN401
    return {
        "name": name,
        "type": "line",
        "showSymbol": False,
        "data": data,
        "itemStyle": {"color": colour},
        "lineStyle": {"color": colour, "width": 2},
        **more,
    }


def _dashed(colour: str) -> Options:
    return {"lineStyle": {"color": colour, "width": 1.5, "type": "dashed"}}


def section(curves: Options, magnification: float | None) -> Options:
    """Return the section with its nominal circle, deviations magnified.

    Parameters
    ----------
    magnification : float or None
        None: as many times as shows them well.
    """
    nominal_mm, off_um = curves["nominal_mm"], curves["deviation_um"]
    factor = magnification or magnification_of(nominal_mm, off_um)
    radius_um = nominal_mm * UM_PER_MM / factor  # of the nominal circle on the scale
    most = max(0.0, max(off_um))
    shown = off_um[::_EVERY]
    step = 360 / len(shown)
    # Less than 0 on a radius axis is drawn mirrored: what lies beyond the centre is cut off.
    around = [[max(off + radius_um, 0.0), i * step] for i, off in enumerate([*shown, shown[0]])]
    circle = [[radius_um, angle] for angle in range(0, 361, 3)]
    scale = "true to scale" if factor == 1 else f"deviations {factor:g} times"
    polar = {"coordinateSystem": "polar", "silent": True}
    return {
        "animation": False,
        "title": {
            "text": f"section at {curves.get('height_mm', 0.0):.6g} mm",
            "subtext": f"{scale}, radius {nominal_mm:.6g} mm",
            "left": "center",
            "textStyle": {"color": INK, "fontSize": 15},
            "subtextStyle": {"color": INK, "fontSize": 13},
        },
        "legend": _LEGEND,
        "polar": {"radius": "62%", "center": ["50%", "52%"]},
        "angleAxis": {
            "type": "value",
            "min": 0,
            "max": 360,
            "interval": 30,
            "startAngle": 0,
            "clockwise": False,
            "axisLine": {"show": False},
            "axisTick": {"show": False},
            "axisLabel": {"color": INK, "formatter": "{value}°"},
            "splitLine": {"lineStyle": {"color": FAINT}},
        },
        "radiusAxis": {
            "type": "value",
            "min": 0,
            "max": radius_um + 1.15 * most if most > 0 else 1.05 * radius_um,
            "axisLabel": {"show": False},
            "axisTick": {"show": False},
            "axisLine": {"show": False},
            "splitLine": {"show": False},
        },
        "series": [
            _line("nominal circle", circle, INK, **polar) | _dashed(INK),
            _line("drawing", around, BLUE, **polar),
        ],
    }


def profile(curves: Options) -> Options:
    """Return diameters over the height, the height of the section marked."""
    over = curves["profile"]
    series = [
        _line(name, [list(point) for point in zip(values, over["z_mm"], strict=True)], colour)
        for (name, values), colour in zip(over["curves"].items(), _COLOURS * 2, strict=False)
    ]
    if series:
        series[0]["markLine"] = {
            "silent": True,
            "symbol": "none",
            "data": [{"yAxis": curves["height_mm"]}],
            "label": {"formatter": "section", "position": "insideEndTop", "color": ORANGE},
            "lineStyle": {"color": ORANGE, "type": "dashed"},
        }
    return {
        "animation": False,
        "title": _title("profile"),
        "legend": _LEGEND,
        "tooltip": {"trigger": "item"},
        "grid": {"left": 62, "right": 24, "top": 40, "bottom": 76},
        "xAxis": _axis("diameter / mm", nameGap=28, boundaryGap=["4%", "4%"]),
        "yAxis": _axis("height / mm", nameGap=44),
        "series": series,
    }


def _title(text: str) -> Options:
    return {"text": text, "left": "center", "textStyle": {"color": INK, "fontSize": 15}}


def motion(curves: Options, limits: dict[str, float]) -> Options:
    """Return U, velocity, acceleration and jerk over a turn, one above the other.

    Parameters
    ----------
    limits : dict
        Of the machine, by the name of the curve; each is drawn where the scale reaches it.
    """
    n = len(MOTION)
    part = 100 / n
    grids, x_axes, y_axes, series, peaks = [], [], [], [], []
    for i, (key, name, unit) in enumerate(MOTION):
        values = curves["motion"][key]
        step = 360 / len(values)
        points = [[i_angle * step, value] for i_angle, value in enumerate([*values, values[0]])]
        grids.append(
            {"left": 84, "right": 20, "top": f"{i * part + 6:.1f}%", "height": f"{part - 8.5:.1f}%"}
        )
        is_last = i == n - 1
        x_axes.append(
            _axis("drawing's angle / °" if is_last else "", gridIndex=i, nameGap=24)
            | {"min": 0, "max": 360, "interval": 45, "scale": False}
            | {"axisLabel": {"color": INK, "show": is_last}}
        )
        y_axes.append(_axis(f"{name} / {unit}", gridIndex=i, nameGap=62, splitNumber=3))
        peaks.append(_peak(curves, key, name, unit, limits.get(key), i * part))
        line = _line(name, points, _COLOURS[0], xAxisIndex=i, yAxisIndex=i)
        if (limit := limits.get(key)) is not None:
            line["markLine"] = _limit_lines(limit, unit)
        series.append(line)
    speed = f"{curves['rpm']:.6g} r/min"
    kind = "mean " if curves["is_modulated"] else ""
    return {
        "animation": False,
        "title": [_title(f"U at {kind}{speed}") | {"left": 20}, *peaks],
        "tooltip": {"trigger": "axis"},
        "axisPointer": {"link": [{"xAxisIndex": "all"}]},
        "grid": grids,
        "xAxis": x_axes,
        "yAxis": y_axes,
        "series": series,
    }


def _peak(
    curves: Options, key: str, name: str, unit: str, limit: float | None, top_percent: float
) -> Options:
    """Return a line above a panel: the largest value, and how much of the limit that is."""
    if key == "u_um":
        text = f"stroke {curves['stroke_um']:.5g} {unit}"
    else:
        text = f"{name} up to {curves['peaks'][key]:.5g}"
        if limit is not None:
            text += f", {100 * curves['peaks'][key] / limit:.3g} % of {limit:.6g}"
    return {
        "text": text,
        "right": 20,
        "top": f"{top_percent + 2.6:.1f}%",
        "textStyle": {"color": INK, "fontSize": 12, "fontWeight": "normal"},
    }


def _limit_lines(limit: float, unit: str) -> Options:
    return {
        "silent": True,
        "symbol": "none",
        "data": [{"yAxis": limit}, {"yAxis": -limit}],
        "label": {"formatter": f"limit {limit:.6g} {unit}", "position": "insideStartBottom"}
        | {"color": RED},
        "lineStyle": {"color": RED, "type": "dashed"},
    }


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
    speed = f"at most {tenth_below(told['highest_rpm'])} r/min, limited by {told['decided_by']}"
    if told["highest_rpm"] <= 0:
        speed = f"at no speed, limited by {told['decided_by']}"
    word = "feasible" if told["is_feasible"] else "not feasible"
    return word, f"{speed}; required {told['asked_rpm']:g} r/min"


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
