"""Error of U over the lessons of learning, as options of ECharts and as words.

>>> points_of([(1, 8.0), (2, 0.0), (4, 0.5)])
[[1, 8.0], [4, 0.5]]
"""

from collections.abc import Mapping, Sequence
from typing import Any

from camtools.link.messages import NAMES
from camtools.panel.views.echart import text_style

MOST_POINTS = 300
_FAINT, _LINE = "#c4ccd0", "#0d47a1"


def points_of(lessons: Sequence[tuple[int, float]]) -> list[list[float]]:
    """Return the points of a logarithmic scale, which has no zero, thinned evenly to the newest."""
    pairs = [[turn, round(error, 4)] for turn, error in lessons if error > 0]
    stride = -(-len(pairs) // MOST_POINTS) or 1
    return pairs[::-1][::stride][::-1]


def words(signals: Mapping[str, float]) -> str:
    """Return what learning does, a clause; why not everything is learned in brackets."""
    phase = NAMES["learn_phase"].get(int(signals.get("learn_phase", -1)), "unknown")
    reason = NAMES["learn_reason"].get(int(signals.get("learn_reason", 0)), "unknown")
    why = "" if reason == "all" else f" ({reason.replace('_', ' ')})"
    turns = signals.get("learn_turns", 0.0)
    if not turns:
        return f"{phase}{why}; nothing learned yet"
    now, first = signals.get("learn_error", 0.0), signals.get("learn_begin_error", 0.0)
    errors = f"{now:.3f} µm rms now, {first:.3f} µm at first"
    return f"{phase}{why}; {errors}, after {turns:.0f} turns"


def options() -> dict[str, Any]:
    """Return the options of an empty chart."""
    label, line = text_style(13), {"color": _LINE, "width": 2}
    axis = {"axisLabel": label, "splitLine": {"lineStyle": {"color": _FAINT}}}
    named = {"nameTextStyle": label, "nameLocation": "middle"}
    lessons = {"id": "lessons", "type": "line", "symbolSize": 5, "silent": True, "data": []}
    return {
        "animation": False,
        "grid": [{"left": 64, "right": 18, "top": 12, "bottom": 46}],
        "xAxis": [{"type": "value", "name": "turns learned", "nameGap": 28, **axis, **named}],
        "yAxis": [{"type": "log", "name": "rms / µm", "nameGap": 46, **axis, **named}],
        "series": [lessons | {"lineStyle": line, "itemStyle": {"color": _LINE}}],
    }
