r"""The scripts of a page: plotly.js from its package, our page.js, and the numbers, all inlined.

The page's policy names each script by its hash, so that nothing else is ever executed.

>>> json_script({"name": "</script>"})
Markup('{"name":"\\u003c/script\\u003e"}')
"""

from __future__ import annotations

import json
from base64 import b64encode
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

from markupsafe import Markup

from camtools.base.json_text import Json
from camtools.report.board import Board, board_data
from camtools.report.charts import TurnOfU, board_charts, following_chart, motion_chart
from camtools.report.motion import following_by_angle
from camtools.sim.results import CUTTING, CutTrace

_HERE = Path(__file__).resolve().parent
# Each picture that a chart of the board takes the place of, and that chart.
_TWINS = {
    "map": "error-map",
    "sections": "section",
    "section": "section",
    "profile": "unrolled",
    "height": "profile",
    "skirt": "space",
}


class Live(NamedTuple):
    """What of a report is alive.

    Attributes
    ----------
    board : Board or None
        The linked charts of the surface; None where nothing was gauged.
    angle : str
        From where the angle counts, for axes.
    charts : dict
        Charts of plotly.js by the key of the picture whose place they take.
    sentences : dict
        What pictures show, in words, by key.
    """

    board: Board | None
    angle: str
    charts: dict[str, Json]
    sentences: dict[str, str]


def json_script(value: Json) -> Markup:
    """Return a value as JSON that nothing in it can end or turn into markup."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False)
    for sign in "<>&":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return Markup(text)


@cache
def script_texts() -> tuple[str, str]:
    """Return plotly.js and our own script."""
    from plotly.offline import get_plotlyjs

    return get_plotlyjs(), (_HERE / "page.js").read_text(encoding="utf-8")


@cache
def policy(*texts: str) -> str:
    """Return what the page may do: run these scripts and show its own pictures, no more."""
    digests = (b64encode(sha256(text.encode()).digest()).decode() for text in texts)
    scripts = " ".join(f"'sha256-{digest}'" for digest in digests) or "'none'"
    return (
        f"default-src 'none'; script-src {scripts}; style-src 'unsafe-inline'; "
        "img-src data: blob:; base-uri 'none'; form-action 'none'"
    )


def css_text(text: str) -> str:
    r"""Return a text as the inside of a string of CSS.

    >>> css_text('a"b')
    'a\\000022b'
    """
    return "".join(one if one.isalnum() and one.isascii() else f"\\{ord(one):06x}" for one in text)


class Scripts(NamedTuple):
    """What the template inlines."""

    policy: Markup
    plotly: Markup
    ours: Markup
    figures: Markup
    data: Markup
    style: Markup


def scripts_of(live: Live | None) -> Scripts:
    """Return the scripts of a page and what they show; none for a page that is not alive."""
    style = Markup((_HERE / "page.css").read_text(encoding="utf-8"))
    if live is None:
        return Scripts(Markup(policy()), *(Markup(),) * 4, style)
    charts = dict(live.charts)
    if live.board is not None:
        charts |= board_charts(live.board, live.angle)
    texts = script_texts()
    data = {} if live.board is None else board_data(live.board)
    plotly, ours = (Markup(text) for text in texts)
    about = Markup(policy(*texts))
    return Scripts(about, plotly, ours, json_script(charts), json_script(data), style)


def charts_of(trace: CutTrace, motion: TurnOfU | None, key: str = "motion") -> dict[str, Json]:
    """Return the charts of U by the key of the picture whose place they take."""
    charts = {} if motion is None else {key: motion_chart(motion)}
    if (trace.state == CUTTING).any():
        charts["following"] = following_chart(following_by_angle(trace))
    return charts


def twin_of(key: str, live: Live | None) -> str:
    """Return the chart of the board that takes the place of a picture; empty for none."""
    return _TWINS.get(key, "") if live is not None and live.board is not None else ""
