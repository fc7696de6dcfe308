"""What the charts of all pages share, as options of ECharts.

They are drawn for a light page; a style sheet inverts them on a dark one.

>>> titled("profile")["title"]["text"]
'profile'
"""

from typing import Any

INK, FAINT, BLUE, ORANGE, RED, GREEN = (
    *("#37474f", "#cfd8dc", "#0d5a9c", "#b34700", "#b00020", "#2e6b34"),
)
COLOURS = (BLUE, ORANGE, GREEN, "#6a3d9a")
TURN = {"min": 0, "max": 360, "interval": 45, "scale": False}  # of an axis of angles
Options = dict[str, Any]


def text_style(size: int = 12) -> Options:
    """Return how text is written."""
    return {"color": INK, "fontSize": size}


def title(text: str) -> Options:
    """Return a title in the middle."""
    return {"text": text, "left": "center", "textStyle": text_style(15)}


def titled(text: str, **more: Any) -> Options:  # noqa: ANN401 (options of ECharts)
    """Return the options of a chart with a title, which does not move by itself."""
    return {"animation": False, "title": title(text), **more}


def axis(name: str, gap: int, **more: Any) -> Options:  # noqa: ANN401
    """Return an axis of values with its name, which is so far from the line [px]."""
    return {
        "type": "value",
        "scale": True,
        "name": name,
        "nameLocation": "middle",
        "nameGap": gap,
        "nameTextStyle": text_style(13),
        "axisLabel": text_style() | {"hideOverlap": True},
        "axisLine": {"lineStyle": {"color": INK}},
        "splitLine": {"lineStyle": {"color": FAINT}},
        **more,
    }


def line(name: str, data: list[Any], colour: str, **more: Any) -> Options:  # noqa: ANN401
    """Return a series without symbols."""
    return {
        "name": name,
        "type": "line",
        "showSymbol": False,
        "data": data,
        "itemStyle": {"color": colour},
        "lineStyle": {"color": colour, "width": 2},
        **more,
    }


def mark_lines(at: list[float], text: str, place: str, colour: str) -> Options:
    """Return dashed lines at heights of a chart, with a text."""
    return {
        "silent": True,
        "symbol": "none",
        "data": [{"yAxis": y} for y in at],
        "label": {"formatter": text, "position": place, "color": colour},
        "lineStyle": {"color": colour, "type": "dashed"},
    }
