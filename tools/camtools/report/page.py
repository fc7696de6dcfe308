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
from matplotlib.figure import Figure

from camtools.report.text import ReportRow, fault_story, margins_of, verdict_of
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

    title: str
    text: str


# What the simulator leaves out of a tool that turns sections.
EDGE_IS_A_POINT = (
    "In a section the edge is a point; feed marks are not modelled, and the tool bends only where "
    "the machine file gives its stiffness."
)


class Page(NamedTuple):
    """What a report says of a part of one kind."""

    source: str
    rows: list[ReportRow]
    shown: Sequence[tuple[Picture | Caption, bytes]]  # pictures and their PNGs, in order
    modelled: str  # what the simulator leaves out of the tool, a sentence
    compared: str  # what the gauge compares
    what: str  # what was cut


def render_page(outcome: AnyCut, page: Page) -> str:
    """Return the HTML page of a part of any kind."""
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).resolve().parents[1] / "report"),
        undefined=StrictUndefined,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(_TEMPLATE).render(
        name=outcome.name,
        source=page.source,
        summary=outcome.summary,
        verdict=verdict_of(outcome),
        rows=page.rows,
        margins=margins_of(outcome),
        story=fault_story(outcome) if outcome.has_fault else [],
        shown=[(picture, data_uri(png)) for picture, png in page.shown],
        modelled=page.modelled,
        compared=page.compared,
        what=page.what,
        trace=trace_text(outcome),
        is_trace_complete=outcome.is_trace_complete,
    )
