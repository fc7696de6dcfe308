r"""The page of a report: one self-contained HTML file with its pictures, numbers and scripts.

The page's policy names each script by its hash, so that nothing else is ever executed.

>>> json_script({"name": "</script>"})
Markup('{"name":"\\u003c/script\\u003e"}')
"""

import json
from base64 import b64encode
from collections.abc import Sequence
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import NamedTuple

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from camtools.base.text import Json
from camtools.report.board import Board, board_data
from camtools.report.charts import board_charts
from camtools.report.sheet_page import SheetPages
from camtools.report.text import ReportRow, fault_story, margins_of, origin_rows, verdict_of
from camtools.sim.results import AnyCut

_HERE = Path(__file__).resolve().parent
_MAP_TEXT = (
    "The surface unrolled: red is metal left standing, blue is cut too deep, each cell shows its "
    "worst point, grey areas were not cut or are windows. "
)


class Shown(NamedTuple):
    """A picture or chart of a page."""

    key: str
    title: str
    text: str  # what to look for
    sentence: str  # what it shows
    png: bytes | None = None
    chart: Json | None = None  # of plotly.js, where there is no picture
    is_wide: bool = False  # beside no other chart of the board


class Page(NamedTuple):
    """What a page has that depends on the kind of the part."""

    source: str
    rows: Sequence[ReportRow]
    shown: Sequence[Shown]  # in order
    modelled: str  # what the simulator leaves out of the tool, a sentence
    compared: str  # what the gauge compares
    what: str  # what was cut
    angle: str  # from where the angle of the surface counts
    hint: str = ""  # where errors of the map come from
    board: Board | None = None  # linked charts of the surface
    sheets: SheetPages | None = None  # what a roundness instrument would print


def data_uri(png: bytes) -> str:
    """Return an image as text that a page can hold."""
    return "data:image/png;base64," + b64encode(png).decode("ascii")


def trace_text(outcome: AnyCut) -> str:
    """Return what the trace holds, in one sentence."""
    ticks = f"{outcome.trace.t_s.size:,}".replace(",", "\u2009")
    if outcome.is_trace_complete:
        return f"trace.parquet holds all {ticks} ticks of the run."
    last_s = float(outcome.trace.t_s[-1]) if outcome.trace.t_s.size else 0.0
    return (
        "Because this cut is long, trace.parquet, the comparison, the charts of U and of its "
        "following error, and the picture of the sequence cover the first "
        f"{last_s:.1f} s only: {ticks} ticks of a shorter run."
    )


def _board_charts(board: Board, hint: str) -> list[Shown]:
    """Return the charts of a board with their words."""
    bands = "errors and tolerance, the green band, "
    scale = f"The shape is as drawn; {bands}are enlarged as chosen above. "
    if board.shape > 1:
        about = "each section against its own largest radius"
        scale = f"The shape is enlarged {board.shape} times, {about}; {bands}as chosen above. "
    deviations = f"Deviations from a cylinder are enlarged {board.space} times; drag to turn it. "
    space = deviations if board.space > 1 else "As drawn; drag to turn it. "
    dotted = "Dotted: the tolerance; zoom out if it is not in view. "
    kept, height = "Kept sections stay visible. ", "the height at the chosen angle"
    chosen = "Error of the chosen section."
    return [
        Shown("error-map", "Error map", _MAP_TEXT + hint, board.sentence, is_wide=True),
        Shown("section", "Section", scale, f"The chosen section. {scale}{board.sentence}"),
        Shown("profile", "Profile", dotted, f"Radius and error over {height}."),
        Shown("unrolled", "Section unrolled", dotted + kept, chosen, is_wide=True),
        Shown("space", "In space", space, board.sentence, is_wide=True),
    ]


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
    """Return a text as the inside of a string of CSS."""
    return "".join(
        sign if sign.isalnum() and sign.isascii() else f"\\{ord(sign):06x}" for sign in text
    )


@cache
def _environment() -> Environment:
    kept = {"autoescape": True, "trim_blocks": True, "lstrip_blocks": True}
    found = Environment(loader=FileSystemLoader(_HERE), undefined=StrictUndefined, **kept)  # type: ignore[arg-type]
    found.filters["data_uri"] = data_uri
    return found


def render_page(outcome: AnyCut, page: Page) -> str:
    """Return the HTML page of a part of any kind; the clock of the computer is not in it."""
    board, sheets = page.board, page.sheets
    charts = {shown.key: shown.chart for shown in page.shown if shown.chart is not None}
    verdict = verdict_of(outcome, *((sheets.out, sheets.undecided) if sheets else ()))
    plotly, ours = script_texts()
    template = _environment().get_template("page.html.j2")
    return template.render(
        name=outcome.name,
        page=page,
        summary=outcome.summary,
        verdict=verdict,
        rows=[row for row in page.rows if row.name != "computing time"],
        origin=origin_rows(outcome),
        margins=margins_of(outcome),
        story=fault_story(outcome) if outcome.has_fault else [],
        sheets=sheets,
        board=board,
        board_charts=_board_charts(board, page.hint) if board else [],
        policy=Markup(policy(plotly, ours)),
        style=Markup((_HERE / "page.css").read_text(encoding="utf-8")),
        plotly=Markup(plotly),
        ours=Markup(ours),
        figures=json_script(charts | (board_charts(board, page.angle) if board else {})),
        data=json_script(board_data(board) if board else {}),
        running_title=Markup(css_text(f"{outcome.name}: {verdict.title}")),
        running_date=Markup(css_text(outcome.origin.date if outcome.origin else "")),
        trace=trace_text(outcome),
        is_trace_complete=outcome.is_trace_complete,
    )
