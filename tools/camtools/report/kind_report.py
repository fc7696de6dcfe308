"""The report of a kind of part: the kind declares rows and views, everything else follows.

>>> from camtools.report.text import quantity
>>> rows = [quantity("cut", lambda cut: "a ring"), quantity("swing", lambda cut: "")]
>>> report = KindReport("ring", "angle", lambda cut: (0.0, 9.0), rows, [], lambda cut: None)
>>> [row.name for row in rows_of(report, None)]
['cut']
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import Any, Generic, TypeVar

from camtools.plots.style import drawing
from camtools.report.board import board_of
from camtools.report.page import Page, Shown, render_page
from camtools.report.sheet import Subject
from camtools.report.sheet_page import SheetPages, sheet_pages
from camtools.report.text import ReportRow, RowsOf
from camtools.report.views import CutT, View

_T = TypeVar("_T")


def _answer(work: Callable[[], object], out: Connection) -> None:
    """Send what the work returns, or what it raises."""
    try:
        out.send((True, work()))
    except Exception as err:
        out.send((False, err))


@contextmanager
def beside(work: Callable[[], _T]) -> Iterator[Callable[[], _T]]:
    """Begin work in a fork, without threads; yield what waits for its result, or for its error.

    The process ends with the context, done or not; where it was ended before, EOFError is raised.
    """
    fork = get_context("fork")
    source, out = fork.Pipe(duplex=False)
    child = fork.Process(target=_answer, args=(work, out))
    child.start()
    out.close()

    def result() -> _T:
        is_good, value = source.recv()
        if not is_good:
            raise value
        return value  # type: ignore[no-any-return]

    try:
        yield result
    finally:
        child.kill()
        child.join()
        source.close()


# What the simulator leaves out of a tool that turns sections.
EDGE_IS_A_POINT = (
    "Within a section the cutting edge is a point; feed marks are not modelled, and the tool bends "
    "only if the machine file gives its stiffness."
)
TOOL_PATH = "the tool's true path"


@dataclass(frozen=True)
class KindReport(Generic[CutT]):
    """What a kind of part shows of a cut, and the pictures of its table."""

    what: str  # was cut: "skirt"
    angle: str  # from where the angle of the surface counts
    heights_mm: Callable[[CutT], tuple[float, float]]
    rows: Sequence[RowsOf]  # the summary, machine limits apart, in order
    views: Sequence[View[CutT]]  # in order
    subject: Callable[[CutT], Subject]  # what of a measurement sheet applies
    hint: str = ""  # where errors of the map come from
    modelled: Callable[[CutT], str] = lambda _: EDGE_IS_A_POINT
    compared: str = TOOL_PATH  # by the gauge
    space: Callable[[CutT], int | None] = lambda _: None  # enlargement of the part in space
    pictures: Callable[[Any], dict[str, bytes]] = lambda _: {}  # of a table, as PNG by topic


def rows_of(report: KindReport[CutT], cut: CutT) -> list[ReportRow]:
    """Return the summary of a cut."""
    return [row for rows in report.rows for row in rows(cut)]


def page_of(
    report: KindReport[CutT], cut: CutT, pngs: dict[str, bytes], sheets: SheetPages | None = None
) -> str:
    """Return the HTML page with the pictures that are given by key."""
    shown = [
        Shown(
            *(view.key, view.title, view.text, view.words(cut), pngs.get(view.key)),
            view.chart(cut) if view.chart else None,
        )
        for view in report.views
        if view.when(cut)
    ]
    board = board_of(
        cut.surface,
        report.heights_mm(cut),
        cut.summary["cut"]["feed_mm"],
        cut.summary["form_error_um"]["tolerance"],
        report.space(cut),
    )
    words = (report.modelled(cut), report.compared, report.what, report.angle, report.hint)
    source = cut.generated.part.part.source
    return render_page(cut, Page(source, rows_of(report, cut), shown, *words, board, sheets))


def make_report(report: KindReport[CutT], cut: CutT) -> dict[str, bytes]:
    """Return page, pictures and sheets of a cut by file name."""
    with drawing(), beside(lambda: sheet_pages(cut, report.subject(cut))) as drawn_sheets:
        pngs = {view.key: view.png(cut) for view in report.views if view.draw and view.when(cut)}
        sheets = drawn_sheets()
    files = {f"cut_{key}.png": png for key, png in pngs.items()}
    files |= sheets.files if sheets is not None else {}
    return files | {"report.html": page_of(report, cut, pngs, sheets).encode("utf-8")}
