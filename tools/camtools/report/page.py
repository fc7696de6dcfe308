"""The page of a report: one self-contained HTML file.

>>> data_uri(b"abc")
'data:image/png;base64,YWJj'
"""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup
from matplotlib.figure import Figure

from camtools.report.board import Board
from camtools.report.page_scripts import Live, css_text, scripts_of, twin_of
from camtools.report.picture_text import sentences_of
from camtools.report.sheet_page import SheetPages
from camtools.report.text import ReportRow, fault_story, margins_of, origin_rows, verdict_of
from camtools.sim.results import AnyCut

_TEMPLATE = "page.html.j2"


class Picture(NamedTuple):
    """A picture with its title and what to look for."""

    key: str  # names the file: cut_KEY.png
    title: str
    text: str
    draw: Callable[[], Figure]


def data_uri(png: bytes) -> str:
    """Return an image as text that a page can hold."""
    return "data:image/png;base64," + b64encode(png).decode("ascii")


def trace_text(outcome: AnyCut) -> str:
    """Return what the trace holds, in one sentence."""
    ticks = f"{outcome.trace.t_s.size:,}".replace(",", "\u2009")
    if outcome.is_trace_complete:
        return f"trace.parquet holds every tick of the run, {ticks} of them."
    last_s = float(outcome.trace.t_s[-1]) if outcome.trace.t_s.size else 0.0
    return (
        "This cut is long, so trace.parquet, the pictures of U, following error and sequence, and "
        f"the comparison hold the first {last_s:.1f} s only: {ticks} ticks of a run ended there."
    )


class Caption(NamedTuple):
    """Title of a picture and what to look for."""

    key: str  # names the file: cut_KEY.png
    title: str
    text: str


# What the simulator leaves out of a tool that turns sections.
EDGE_IS_A_POINT = (
    "In a section the edge is a point; feed marks are not modelled, and the tool bends only where "
    "the machine file gives its stiffness."
)


_MAP_TEXT = (
    "The surface unrolled: red is metal left standing, blue is cut too deep, each cell shows its "
    "worst point, grey was not cut."
)


class Page(NamedTuple):
    """What a report says of a part of one kind."""

    source: str
    rows: list[ReportRow]
    shown: Sequence[tuple[Picture | Caption, bytes]]  # pictures and their PNGs, in order
    modelled: str  # what the simulator leaves out of the tool, a sentence
    compared: str  # what the gauge compares
    what: str  # what was cut
    live: Live | None = None  # what is alive of it
    sheets: SheetPages | None = None  # what a roundness instrument would print


class _Shown(NamedTuple):
    """A picture as the template shows it."""

    key: str
    title: str
    text: str
    image: str
    sentence: str
    twin: str  # the chart of the board that shows the same, or nothing
    is_alive: bool


class _Chart(NamedTuple):
    """A chart of the board as the template shows it."""

    id: str
    title: str
    text: str
    sentence: str
    is_wide: bool = False


def _shown(page: Page, sentences: dict[str, str]) -> list[_Shown]:
    charts = page.live.charts if page.live else {}
    return [
        _Shown(
            *(one.key, one.title, one.text, data_uri(png)),
            sentences.get(one.key, one.title),
            twin_of(one.key, page.live),
            one.key in charts,
        )
        for one, png in page.shown
    ]


def _board_charts(board: Board, shown: list[_Shown]) -> list[_Chart]:
    """Return the charts of a board with the words of the pictures whose place they take."""
    texts = {one.twin: one.text for one in shown if one.twin}
    scale = (
        f"The shape is enlarged {board.shape} times, each section against its own largest radius; "
        "errors and tolerance, the green band, as chosen above. "
        if board.shape > 1
        else "The shape is as drawn; errors and tolerance, the green band, are enlarged as chosen "
        "above. "
    )
    deviations = f"Deviations from a cylinder are enlarged {board.space} times; drag to turn it. "
    space = deviations if board.space > 1 else "As drawn; drag to turn it. "
    dotted = "Dotted: the tolerance, which may lie outside; zoom out to see it. "
    kept = "Kept sections stay beside the chosen one. "
    return [
        _Chart("error-map", "Error map", texts.get("error-map", _MAP_TEXT), board.sentence, True),
        _Chart("section", "Section", scale, f"The chosen section. {scale}{board.sentence}"),
        _Chart("profile", "Profile", dotted, "Radius and error over the height at the angle."),
        _Chart("unrolled", "Section unrolled", dotted + kept, "Error of the section.", True),
        _Chart("space", "In space", space + texts.get("space", ""), board.sentence, True),
    ]


def _environment() -> Environment:
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).resolve().parents[1] / "report"),
        undefined=StrictUndefined,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["data_uri"] = data_uri
    return environment


def render_page(outcome: AnyCut, page: Page) -> str:
    """Return the HTML page of a part of any kind; the clock of the computer is not in it."""
    sentences = sentences_of(outcome) | (page.live.sentences if page.live else {})
    shown, live = _shown(page, sentences), page.live
    board = live.board if live else None
    verdict = verdict_of(outcome, page.sheets.out if page.sheets else ())
    date = outcome.origin.date if outcome.origin else ""
    left = f"{outcome.name}: {verdict.title}"
    running_title, running_date = Markup(css_text(left)), Markup(css_text(date))
    return (
        _environment()
        .get_template(_TEMPLATE)
        .render(
            name=outcome.name,
            source=page.source,
            summary=outcome.summary,
            verdict=verdict,
            rows=[row for row in page.rows if row.name != "computing time"],
            origin=origin_rows(outcome),
            margins=margins_of(outcome),
            story=fault_story(outcome) if outcome.has_fault else [],
            shown=shown,
            sheets=page.sheets,
            board=board,
            board_charts=_board_charts(board, shown) if board else [],
            scripts=scripts_of(live),
            running_title=running_title,
            running_date=running_date,
            modelled=page.modelled,
            compared=page.compared,
            what=page.what,
            trace=trace_text(outcome),
            is_trace_complete=outcome.is_trace_complete,
        )
    )
