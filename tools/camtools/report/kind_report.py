"""The report of a kind of part: the kind declares rows and views, everything else follows.

>>> from camtools.report.text import quantity
>>> rows = [quantity("cut", lambda cut: "a ring"), quantity("swing", lambda cut: "")]
>>> report = KindReport("ring", "angle", lambda cut: (0.0, 9.0), rows, [], lambda cut: None)
>>> [row.name for row in rows_of(report, None)]
['cut']
"""

from __future__ import annotations

import os
import pickle
import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Generic, TypeVar

from matplotlib.figure import Figure

from camtools.plots.style import drawing, png_of
from camtools.report.board import board_of
from camtools.report.page import Page, Shown, render_page
from camtools.report.sheet import Subject
from camtools.report.sheet_page import SheetPages, sheet_pages
from camtools.report.text import ReportRow, RowsOf
from camtools.report.views import CutT, View

_T = TypeVar("_T")


def _answer(work: Callable[[], object], out: int) -> None:
    """Write what the work returns, or what it raises, and end this process."""
    try:
        try:
            said = (True, work())
        except Exception as err:
            said = (False, err)
        with os.fdopen(out, "wb") as pipe:
            pickle.dump(said, pipe)
    finally:
        os._exit(0)


@contextmanager
def beside(work: Callable[[], _T]) -> Iterator[Callable[[], _T]]:
    """Begin work in a fork of this process.

    `work`: sees all that is here; it must not use threads, and its result can be pickled. Yields
    waits for the result and returns it, or raises what the work raised; the process ends with the
    context, done or not. Raises `EOFError`: from the callable: the process was ended.
    """
    source, out = os.pipe()
    child = os.fork()
    if child == 0:
        _answer(work, out)
    os.close(out)

    def result() -> _T:
        is_good, value = pickle.load(pipe)
        if not is_good:
            raise value
        return value  # type: ignore[no-any-return]

    with os.fdopen(source, "rb") as pipe:
        try:
            yield result
        finally:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)


# What the simulator leaves out of a tool that turns sections.
EDGE_IS_A_POINT = (
    "Within a section the cutting edge is a point; feed marks are not modelled, and the tool bends "
    "only if the machine file gives its stiffness."
)
TOOL_PATH = "the tool's true path"


@dataclass(frozen=True)
class KindReport(Generic[CutT]):
    """What a kind of part shows of a cut."""

    what: str  # was cut: "skirt"
    angle: str  # from where the angle of the surface counts
    heights_mm: Callable[[CutT], tuple[float, float]]
    rows: Sequence[RowsOf]  # the summary, machine limits apart, in order
    views: Sequence[View[CutT]]  # in order
    subject: Callable[[CutT], Subject]  # what of a measurement sheet applies
    modelled: Callable[[CutT], str] = lambda _: EDGE_IS_A_POINT
    compared: str = TOOL_PATH  # by the gauge
    space: Callable[[CutT], int | None] = lambda _: None  # enlargement of the part in space


def rows_of(report: KindReport[CutT], cut: CutT) -> list[ReportRow]:
    """Return the summary of a cut."""
    return [row for rows in report.rows for row in rows(cut)]


def picture_of(view: View[CutT], cut: CutT) -> Figure:
    """Draw a view."""
    return view.draw(cut)


def page_of(
    report: KindReport[CutT], cut: CutT, pngs: dict[str, bytes], sheets: SheetPages | None = None
) -> str:
    """Return the HTML page with the pictures that are given by key."""
    shown = [
        Shown(
            *(view.key, view.title, view.text, pngs[view.key], view.words(cut), view.twin),
            view.chart(cut) if view.chart else None,
        )
        for view in report.views
        if view.is_on_page and view.key in pngs and view.when(cut)
    ]
    board = board_of(
        cut.surface,
        report.heights_mm(cut),
        cut.summary["cut"]["feed_mm"],
        cut.summary["form_error_um"]["tolerance"],
        report.space(cut),
    )
    page = Page(
        source=cut.generated.part.part.source,
        rows=rows_of(report, cut),
        shown=shown,
        modelled=report.modelled(cut),
        compared=report.compared,
        what=report.what,
        angle=report.angle,
        board=board,
        sheets=sheets,
    )
    return render_page(cut, page)


def make_report(report: KindReport[CutT], cut: CutT) -> dict[str, bytes]:
    """Return page, pictures and sheets of a cut by file name."""
    with drawing(), beside(lambda: sheet_pages(cut, report.subject(cut))) as drawn_sheets:
        pngs = {view.key: png_of(picture_of(view, cut)) for view in report.views if view.when(cut)}
        sheets = drawn_sheets()
    files = {f"cut_{key}.png": png for key, png in pngs.items()}
    files |= sheets.files if sheets is not None else {}
    return files | {"report.html": page_of(report, cut, pngs, sheets).encode("utf-8")}
