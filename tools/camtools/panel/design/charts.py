"""A preview for people: charts as options of ECharts, words and rows.

>>> options = section({"nominal_mm": 46.0, "deviation_um": [0.0, -100.0, 0.0, -100.0]}, None)
>>> [curve["name"] for curve in options["series"]]
['nominal circle', 'drawing']

>>> verdict_words({"is_feasible": True, "highest_rpm": 3000.0, "asked_rpm": 2500.0,
...                "decided_by": "spindle_rpm"})
('feasible', 'at most 3000.0 r/min, limited by spindle_rpm; required 2500 r/min')
"""

from math import floor, log10
from typing import Any

from camtools.base.quantities import UM_PER_MM
from camtools.cut.feasibility import tenth_below
from camtools.panel.views.echart import (
    BLUE,
    COLOURS,
    FAINT,
    INK,
    ORANGE,
    RED,
    TURN,
    Options,
    axis,
    line,
    mark_lines,
    text_style,
    title,
    titled,
)

_SHARE = 0.3  # of the radius that the largest deviation takes
_STEPS = (1.0, 2.0, 5.0, 10.0)
_EVERY = 2  # of the angles of a section one of so many is drawn
_LEGEND: Options = {"bottom": 0, "icon": "rect", "itemHeight": 4, "textStyle": text_style()}
_OFF = {"show": False}
_RATES = ("speed", "acceleration")
_MOTION = (
    ("u_um", "U", "µm"),
    ("velocity_mm_s", "velocity", "mm/s"),
    ("acceleration_m_s2", "acceleration", "m/s²"),
    ("jerk_km_s3", "jerk", "km/s³"),
)


def magnification_of(nominal_mm: float, deviation_um: list[float]) -> float:
    """Return how many times deviations are enlarged so that they are seen: 1, 2, 5, 10 ...

    >>> magnification_of(46.0, [0.0, -150.0])
    50.0
    """
    largest_mm = max((abs(off) for off in deviation_um), default=0.0) / UM_PER_MM
    wanted = _SHARE * nominal_mm / largest_mm if largest_mm > 0 else 1.0
    if wanted <= 1:
        return 1.0
    decade = 10.0 ** floor(log10(wanted))
    return max(step * decade for step in _STEPS if step * decade <= wanted)


def section(curves: Options, magnification: float | None) -> Options:
    """Return the section with its nominal circle, magnified so that it is seen well by default."""
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
    dashed = {"lineStyle": {"color": INK, "width": 1.5, "type": "dashed"}}
    whole = {"type": "value", "min": 0}
    return {
        "animation": False,
        "title": title(f"section at {curves.get('height_mm', 0.0):.6g} mm")
        | {"subtext": f"{scale}, radius {nominal_mm:.6g} mm", "subtextStyle": text_style(13)},
        "legend": _LEGEND,
        "polar": {"radius": "62%", "center": ["50%", "52%"]},
        "angleAxis": whole
        | {"max": 360, "interval": 30, "startAngle": 0, "clockwise": False}
        | {"axisLabel": {"color": INK, "formatter": "{value}°"}, "axisLine": _OFF}
        | {"axisTick": _OFF, "splitLine": {"lineStyle": {"color": FAINT}}},
        "radiusAxis": whole
        | {"max": radius_um + 1.15 * most if most > 0 else 1.05 * radius_um}
        | dict.fromkeys(("axisLabel", "axisTick", "axisLine", "splitLine"), _OFF),
        "series": [
            line("nominal circle", circle, INK, **polar) | dashed,
            line("drawing", around, BLUE, **polar),
        ],
    }


def profile(curves: Options) -> Options:
    """Return diameters over the height, the height of the section marked."""
    over = curves["profile"]
    series = [
        line(name, [list(point) for point in zip(values, over["z_mm"], strict=True)], colour)
        for (name, values), colour in zip(over["curves"].items(), COLOURS * 2, strict=False)
    ]
    if series:
        at = [curves["height_mm"]]
        series[0]["markLine"] = mark_lines(at, "section", "insideEndTop", ORANGE)
    return titled(
        "profile",
        legend=_LEGEND,
        tooltip={"trigger": "item"},
        grid={"left": 62, "right": 24, "top": 40, "bottom": 76},
        xAxis=axis("diameter / mm", 28, boundaryGap=["4%", "4%"]),
        yAxis=axis("height / mm", 44),
        series=series,
    )


def motion(curves: Options, limits: dict[str, float]) -> Options:
    """Return U, velocity, acceleration and jerk over a turn, one above the other.

    The limits of the machine, by the name of the curve, are drawn where the scale reaches them.
    """
    part = 100 / len(_MOTION)
    grids, x_axes, y_axes, series, peaks = [], [], [], [], []
    for i, (key, name, unit) in enumerate(_MOTION):
        values, limit = curves["motion"][key], limits.get(key)
        step = 360 / len(values)
        points = [[i_angle * step, value] for i_angle, value in enumerate([*values, values[0]])]
        place = {"top": f"{i * part + 6:.1f}%", "height": f"{part - 8.5:.1f}%"}
        grids.append({"left": 84, "right": 20, **place})
        is_last = i == len(_MOTION) - 1
        labels = {"color": INK, "show": is_last}
        x_name = "drawing's angle / °" if is_last else ""
        x_axes.append(axis(x_name, 24, gridIndex=i, axisLabel=labels, **TURN))
        y_axes.append(axis(f"{name} / {unit}", 62, gridIndex=i, splitNumber=3))
        peaks.append(_peak(curves, key, name, unit, limit, i * part))
        series.append(line(name, points, COLOURS[0], xAxisIndex=i, yAxisIndex=i))
        if limit is not None:
            words = f"limit {limit:.6g} {unit}"
            series[-1]["markLine"] = mark_lines([limit, -limit], words, "insideStartBottom", RED)
    kind = "mean " if curves["is_modulated"] else ""
    return {
        "animation": False,
        "title": [title(f"U at {kind}{curves['rpm']:.6g} r/min") | {"left": 20}, *peaks],
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
    style = text_style() | {"fontWeight": "normal"}
    return {"text": text, "right": 20, "top": f"{top_percent + 2.6:.1f}%", "textStyle": style}


_NAMES = {
    **{f"{name}_{what}": f"{name.upper()} {what}" for name in "uzx" for what in _RATES},
    **{f"{what}_{rate}": f"{what} {rate}" for what in ("spindle", "swing") for rate in _RATES},
    "u_stroke": "U stroke",
    "feed": "feed per turn",
    "tick_rate": "spindle speed of the ticks",
    "spindle_loop": "spindle loop",
    "spindle_set_point": "spindle set-point",
    "swing_range": "swing",
}


def verdict_words(verdict: dict[str, Any]) -> tuple[str, str]:
    """Return the verdict in a word, and the speed in a sentence."""
    highest_rpm, decides = verdict["highest_rpm"], verdict["decided_by"]
    speed = f"at most {tenth_below(highest_rpm)} r/min" if highest_rpm > 0 else "at no speed"
    word = "feasible" if verdict["is_feasible"] else "not feasible"
    return word, f"{speed}, limited by {decides}; required {verdict['asked_rpm']:g} r/min"


def _digits(value: float) -> str:
    """Return a number with five digits, without an exponent.

    >>> _digits(250000.0), _digits(0.123456), _digits(87654.3)
    ('250000', '0.12346', '87654')
    """
    return f"{value:.0f}" if abs(value) >= 10_000 else f"{value:.5g}"


def margin_rows(verdict: dict[str, Any]) -> list[dict[str, str]]:
    """Return what the table needs of each limit, the nearest one first."""
    return [
        {
            "limit": _NAMES.get(margin["name"], margin["name"]),
            "needed": f"{_digits(margin['needed'])} {margin['unit']}",
            "of": f"{_digits(margin['limit'])} {margin['unit']}",
            "left": f"{margin['left_percent']:.1f} %",
        }
        for margin in sorted(verdict["margins"], key=lambda margin: float(margin["left_percent"]))
    ]


def _bytes_text(n_bytes: int) -> str:
    return f"{n_bytes:,} bytes".replace(",", " ")


def table_words(verdict: dict[str, Any]) -> list[str]:
    """Return the size of the table and of its channels in lines."""
    table = verdict["table"]
    tolerance = table["tolerance_nm"]
    within = "" if tolerance is None else f", within {tolerance:g} nm"
    lines = [f"table of {_bytes_text(table['bytes'])}{within}"]
    for channel in table["channels"]:
        n, repeats = channel["knots_per_pattern"], channel["patterns_per_turn"]
        knots = f"{n} knots" if repeats == 1 else f"{n} knots, {repeats} times per turn"
        if n == 1:
            knots = "over the height"
        size, n_slices = _bytes_text(channel["bytes"]), channel["n_slices"]
        lines.append(f"{channel['name']}: {size}, {n_slices} slices, {knots}")
    return lines
