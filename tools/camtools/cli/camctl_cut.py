# SPDX-License-Identifier: Apache-2.0
"""Commands of camctl about what changes while a part is cut: overrides, trim, parts.

>>> signals = {"has_end": 1, "turns_left": 250.0, "turns_whole": 1000.0, "pass_speed": 500.0}
>>> _reached_text("cutting", signals | {"pass": 2, "passes": 3})
'in pass 2 of 3 at 75 %, 750 of 1000 turns'
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, TextIO

from camtools.base.arguments import Word, finite, whole
from camtools.base.command import Interrupted
from camtools.cli.camctl_control import Control
from camtools.link.controller import Link, Status
from camtools.link.messages import NAMES, Refused
from camtools.link.progress import IN_CUT, cut_progress
from camtools.link.refusal_text import ask_done
from camtools.link.settings import (
    MEASURES,
    OVERRIDES,
    set_override,
    set_parts,
    set_trim,
    trim_text,
    value_of,
    value_text,
)

_OVER = ("ready", "off", "fault")
_ROW_S = 2.0
_SAME_LINE = "\x1b[K\r"


def _until_over(link: Link) -> None:
    """Wait until a cut is over.

    Raises
    ------
    Refused
        It ends in a fault, command was lost, or the status stops.
    """
    status = link.status
    while status.state not in _OVER:
        # A process that was stopped for a while finds that its time is over, and looks again.
        if not link.next_row(_ROW_S) and not link.next_row(_ROW_S):
            raise Refused(f"{link.where}: the status stopped; is the controller on?")
    link.rights.confirm()
    if status.state == "fault":
        link.wait(lambda: bool(status.faults), 0.1)
        raise Refused(f"fault: {', '.join(status.faults)}; see status, then reset")


def follow_cut(link: Link, out: TextIO) -> str:
    """Show how far a cut is until it is over, and return what came of it; control-C stops it.

    It has to stay: without its heartbeats command would be lost, and the cut would end by that.

    Raises
    ------
    Refused
        It was stopped, ended in a fault or off, or command was lost.
    """
    is_drawn, told, turns, has_end = out.isatty(), "", 0.0, True
    reached = "before the first turn"

    def show(status: Status) -> None:
        nonlocal told, turns, has_end, reached
        turns = max(turns, status.signals.get("turns_whole", 0.0))
        has_end = bool(status.signals.get("has_end", 1.0))
        if status.state in ("rehearsing", "engaging", "cutting", "holding"):
            reached = _reached_text(status.state, status.signals)
        progress = cut_progress(status.state, status.signals)
        tens = "" if progress.fraction is None else f"{progress.fraction * 10:.0f}"
        key = progress.text if is_drawn else status.state + tens
        if status.state in IN_CUT and key != told:
            told = key
            out.write(f"{status.state}: {progress.text}" + (_SAME_LINE if is_drawn else "\n"))
            out.flush()

    try:
        before = _parts(link)
        link.listen()
        link.on_row = show
        _until_over(link)
    except Interrupted:
        link.ask("stop")
        _until_over(link)
        raise Refused("start: stopped by control-C before its end") from None
    finally:
        link.on_row = lambda status: None
    if _parts(link) > before:
        return f"start: part cut, {turns:.0f} turns"
    status = link.listen()
    state = status.state
    if NAMES["start_wait"].get(int(status.signals["start_wait"])) == "unsteady":
        raise Refused(
            "start: ended before the cut, because the spindle does not turn steadily; check its "
            "drive, then start again"
        )
    if not has_end and state == "ready":
        return "start: stopped, as every cut whose Z is moved by another controller"
    cause = "the controller was disabled" if state == "off" else "the cut was stopped"
    raise Refused(f"start: {cause} {reached}, so the part is not complete; state {state}")


def _reached_text(state: str, signals: Mapping[str, float]) -> str:
    """Return how far a cut has come."""
    fraction = cut_progress(state, signals).fraction
    if fraction is None:
        return f"while {state}"
    number, of = int(signals.get("pass", 0)), int(signals.get("passes", 0))
    in_pass = f"in pass {number} of {of} " if of > 1 else ""
    whole = signals["turns_whole"]
    return f"{in_pass}at {100 * fraction:.0f} %, {fraction * whole:.0f} of {whole:.0f} turns"


def _parts(link: Link) -> int:
    """Return how many complete parts the controller has counted."""
    return int(ask_done(link, "get_parts").value)


def override(
    control: Control,
    what: Annotated[str, Word("what to override", choices=OVERRIDES)],
    percent: Annotated[
        float | None,
        Word("override in %%: feed 0 .. 150, spindle 50 .. 120 (default: print it)", read=finite),
    ] = None,
) -> None:
    """Print or set the override of feed or spindle speed; the change is ramped."""
    name, link = f"{what}_override", control.link
    if percent is None:
        control.say(f"override {what} = {value_text(name, value_of(link, name))}")
    else:
        control.say(set_override(link, what, percent))


def trim(
    control: Control,
    measure: Annotated[str, Word("what the offset is measured on", choices=MEASURES)],
    value: Annotated[
        float | None,
        Word("offset in mm, positive for a larger part (default: print it)", "MM", read=finite),
    ] = None,
) -> None:
    """Print or set the wear offset of X; ramped, also while cutting."""
    link = control.link
    control.say(
        trim_text(value_of(link, "trim")) if value is None else set_trim(link, measure, value)
    )


def parts(
    control: Control,
    number: Annotated[
        int | None, Word("new value of the counter (default: print it)", "N", read=whole)
    ] = None,
) -> None:
    """Print or set the part counter."""
    link = control.link
    control.say(f"parts = {_parts(link)}" if number is None else set_parts(link, number))
