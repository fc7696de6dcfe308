"""A part that is cut in several passes: a part for each of them, its records and its verdict.

>>> records_of([], [])
()
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, Protocol, Self, TypeVar

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import NM_PER_MM, NM_PER_UM
from camtools.cut.feasibility import HighestSpeed
from camtools.part.common import PartFile, Pass, SectionProcess, Tool, check_feed, check_tracks
from camtools.table.channel import PassRecord
from camtools.table.header import check_tolerance
from camtools.table.image import Table


class PassedPart(PartFile, Protocol):
    """A part that may be cut in several passes."""

    @property
    def process(self) -> SectionProcess:
        """How it is cut."""

    def model_copy(self, *, update: Mapping[str, Any] | None = None) -> Self:
        """Return a copy with other tables."""


PartT = TypeVar("PartT", bound=PassedPart)


def checked_passes(part: PartT, tool: Tool, tolerance_nm: float | None) -> list[PartT]:
    """Return the part as each of its passes cuts it, the last one at the end.

    Raises CamtoolsError: the tolerance is out of range, a feed is beyond the part, or its tracks do
    not meet.
    """
    if tolerance_nm is not None:
        check_tolerance(tolerance_nm)
    process, passes = part.process, []
    for planned in process.passes or [Pass(allowance_um=0)]:
        own = {
            "feed_mm": planned.feed_mm or process.feed_mm,
            "spindle_rpm": planned.spindle_rpm or process.spindle_rpm,
        }
        passes.append(part.model_copy(update={"process": process.model_copy(update=own)}))
        check_feed(passes[-1])
    check_tracks(tool, passes[-1].process.feed_mm)
    return passes


def records_of(passes: Sequence[Pass], parts: Sequence[PassedPart]) -> tuple[PassRecord, ...]:
    """Return the records of passes in a table, none of a part that is cut in one."""
    return tuple(
        PassRecord(
            round(planned.allowance_um * NM_PER_UM),
            round(own.process.feed_mm * NM_PER_MM),
            round(own.process.spindle_rpm * 1000),
        )
        for planned, own in zip(passes, parts, strict=False)
    )


def judge_passes(
    parts: Sequence[PartT], table: Table, judge: Callable[[PartT, Table], HighestSpeed]
) -> HighestSpeed:
    """Return the highest speed of the last pass; refuse by the name of the first infeasible one.

    `judge` returns the highest speed of a part with the table at its own speed and feed.
    """
    for number, part in enumerate(parts, start=1):
        feed_nm, mrpm = round(part.process.feed_mm * NM_PER_MM), part.process.spindle_rpm * 1000
        try:
            best = judge(part, replace(table, feed_nm=feed_nm, spindle_mrpm=round(mrpm)))
        except CamtoolsError as error:
            which = f"process.pass number {number}: " if len(parts) > 1 else ""
            raise CamtoolsError([which + line for line in error.lines]) from error
    return best
