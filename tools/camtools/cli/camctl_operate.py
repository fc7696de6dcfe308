"""Commands of camctl for an operator: overrides, trim, parts, axes by hand, tools.

>>> signals = {"has_end": 1, "turns_left": 250.0, "turns_whole": 1000.0, "pass_speed": 500.0}
>>> _reached_text("cutting", signals | {"pass": 2, "passes": 3})
'in pass 2 of 3 at 75 %, 750 of 1000 turns'
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, TextIO

from camtools.base.arguments import Option, Word, finite, not_negative, positive, whole
from camtools.base.errors import CamtoolsError
from camtools.base.quantities import NM_PER_MM
from camtools.base.signals import Interrupted
from camtools.cli.camctl_control import Control, Seconds, refuse_fault
from camtools.link import operator
from camtools.link.controller import Link, Status
from camtools.link.messages import Refused
from camtools.link.refusal_text import ask_done
from camtools.link.status_text import IN_CUT, cut_progress, name_of

_OVER = ("ready", "off", "fault")
_ROW_S = 2.0
_SAME_LINE = "\x1b[K\r"


def _until_over(link: Link) -> None:
    """Wait until a cut is over; refused on a fault, lost command, or the end of the status."""
    status = link.status
    while status.state not in _OVER:
        # A process that was stopped for a while finds that its time is over, and looks again.
        if not link.next_row(_ROW_S) and not link.next_row(_ROW_S):
            raise Refused(f"{link.where}: the status stopped; is the controller on?")
    link.rights.confirm()
    refuse_fault(link)


def follow_cut(link: Link, out: TextIO) -> str:
    """Show how far a cut is until it is over, and return what came of it; control-C stops it.

    It has to stay: without its heartbeats command would be lost, and the cut would end by that.
    Raises Refused: it was stopped, ended in a fault or off, or command was lost.
    """
    is_drawn, shown, turns, has_end = out.isatty(), "", 0.0, True
    reached = "before the first turn"

    def show(status: Status) -> None:
        nonlocal shown, turns, has_end, reached
        turns = max(turns, status.signals.get("turns_whole", 0.0))
        has_end = bool(status.signals.get("has_end", 1.0))
        if status.state in ("rehearsing", "engaging", "cutting", "holding"):
            reached = _reached_text(status.state, status.signals)
        progress = cut_progress(status.state, status.signals)
        tens = "" if progress.fraction is None else f"{progress.fraction * 10:.0f}"
        key = progress.text if is_drawn else status.state + tens
        if status.state in IN_CUT and key != shown:
            shown = key
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
    if name_of(status.signals, "start_wait") == "unsteady":
        raise Refused(
            "start: ended before the cut, because the spindle does not turn steadily; check its "
            "drive, then start again"
        )
    if not has_end and state == "ready":
        return "start: stopped, as every cut whose Z is moved by another controller"
    cause = "the controller was disabled" if state == "off" else "the cut was stopped"
    raise Refused(f"start: {cause} {reached}, so the part is not complete; state {state}")


def _reached_text(state: str, signals: Mapping[str, float]) -> str:
    fraction = cut_progress(state, signals).fraction
    if fraction is None:
        return f"while {state}"
    number, n_passes = int(signals.get("pass", 0)), int(signals.get("passes", 0))
    in_pass = f"in pass {number} of {n_passes} " if n_passes > 1 else ""
    whole = signals["turns_whole"]
    return f"{in_pass}at {100 * fraction:.0f} %, {fraction * whole:.0f} of {whole:.0f} turns"


def _parts(link: Link) -> int:
    return int(ask_done(link, "get_parts").value)


def override(
    control: Control,
    what: Annotated[str, Word("what to override", choices=operator.OVERRIDES)],
    percent: Annotated[
        float | None,
        Word("override in %%: feed 0 .. 150, spindle 50 .. 120 (default: print it)", read=finite),
    ] = None,
) -> None:
    """Print or set the override of feed or spindle speed; the change is ramped."""
    name, link = f"{what}_override", control.link
    if percent is None:
        control.say(f"override {what} = {operator.value_text(name, operator.value_of(link, name))}")
    else:
        control.say(operator.set_override(link, what, percent))


def trim(
    control: Control,
    measure: Annotated[str, Word("what the offset is measured on", choices=operator.MEASURES)],
    value: Annotated[
        float | None,
        Word("offset in mm, positive for a larger part (default: print it)", "MM", read=finite),
    ] = None,
) -> None:
    """Print or set the wear offset of X; ramped, also while cutting."""
    link = control.link
    control.say(
        operator.trim_text(operator.value_of(link, "trim"))
        if value is None
        else operator.set_trim(link, measure, value)
    )


def parts(
    control: Control,
    number: Annotated[
        int | None, Word("new value of the counter (default: print it)", "N", read=whole)
    ] = None,
) -> None:
    """Print or set the part counter."""
    link = control.link
    control.say(f"parts = {_parts(link)}" if number is None else operator.set_parts(link, number))


def _to_its_end(link: Link, command: str, axis: str, what: str, **value: float) -> str:
    """Return the line of an order that is over; interrupted, the axis is at rest."""
    try:
        end = operator.carry_out(link, command, axis, **value)
    except Interrupted:
        operator.rest(link, axis)
        end = "interrupted"
    return operator.end_text(link, axis, end, what)


def jog_axis(
    control: Control,
    axis: Annotated[str, Word("axis to move", choices=tuple(operator.AXES))],
    sense: Annotated[
        str | None, Word("direction; leave out with --step", choices=("+", "-"))
    ] = None,
    *,
    speed: Annotated[
        float | None,
        Option("speed in mm/s (default: 1, or the axis limit if lower)", read=positive),
    ] = None,
    seconds: Seconds = None,
    step: Annotated[
        float | None,
        Option("signed distance in mm, moved at the highest jog speed", "MM", read=finite),
    ] = None,
) -> None:
    """In manual: move an axis until control-C, or by one step."""
    link = control.link
    if (sense is None) == (step is None):
        raise CamtoolsError([f"jog {axis}: give either + or -, or --step MM"])
    if step is not None:
        if speed is not None or seconds is not None:
            problem = f"jog {axis}: a step has no --speed and no --seconds"
            raise CamtoolsError([f"{problem}; leave them out"])
        control.say(_to_its_end(link, "step", axis, "jog", step=step))
        return
    usual_mm_per_s = min(1.0, operator.parameter(link, f"{axis}_jog_um_per_s") / 1000)
    mm_per_s = usual_mm_per_s if speed is None else speed
    end = "done"
    try:
        end = operator.jog(
            link, axis, -mm_per_s if sense == "-" else mm_per_s, operator.for_seconds(seconds)
        )
    except Interrupted:  # how a jog that is held ends
        operator.rest(link, axis)
    control.say(operator.end_text(link, axis, end, "jog"))


def home_axis(control: Control, axis: str) -> None:
    """Find the home of an axis and wait until it is found."""
    control.say(f"home {_to_its_end(control.link, 'home_axis', axis, 'home')}")


def zero(
    control: Control,
    axis: Annotated[str, Word("axis to set", choices=("x", "z"))],
    *,
    diameter: Annotated[
        float | None, Option("diameter that the tool tip touches, for x", "MM", read=not_negative)
    ] = None,
    height: Annotated[
        float | None, Option("height on the drawing that the tip touches, for z", "MM", read=finite)
    ] = None,
) -> None:
    """Set the position of an axis to a known value; nothing moves."""
    value, unwanted = (diameter, height) if axis == "x" else (height, diameter)
    if value is None or unwanted is not None:
        given = "diameter" if axis == "x" else "height"
        raise CamtoolsError([f"zero {axis}: give --{given} MM, and nothing else"])
    control.say(operator.set_zero(control.link, axis, value))


def tool(
    control: Control,
    number: Annotated[
        int | None,
        Word(
            f"tool 1 .. {operator.N_TOOLS}, 0 for none (default: print all)",
            "N",
            read=whole,
            choices=range(operator.N_TOOLS + 1),
        ),
    ] = None,
    *,
    x: Annotated[
        float | None,
        Option("X offset of the tip in mm, away from the spindle axis", "MM", read=finite),
    ] = None,
    z: Annotated[
        float | None,
        Option("Z offset of the tip in mm, towards greater heights", "MM", read=finite),
    ] = None,
) -> None:
    """Print the tool offsets, select a tool, set its offsets."""
    link, say = control.link, control.say
    for axis, offset in (("x", x), ("z", z)):
        if offset is None:
            continue
        if not number:
            remedy = f"give the number of a tool, 1 .. {operator.N_TOOLS}"
            raise CamtoolsError([f"tool: --{axis} {offset}: {remedy}"])
        operator.set_tool_offset(link, number, axis, offset)
    if number is not None:
        operator.set_tool(link, number)
    chosen = round(operator.parameter(link, "tool"))
    for n in range(1, operator.N_TOOLS + 1):
        x_mm, z_mm = (
            operator.parameter(link, f"tool_{n}_{axis}_nm") / NM_PER_MM for axis in ("x", "z")
        )
        say(f"tool {n}: x {x_mm:.6f} mm, z {z_mm:.6f} mm{', in use' if n == chosen else ''}")
    if not chosen:
        say("no tool is in use")


def where(control: Control) -> None:
    """Print the axis positions."""
    link, say = control.link, control.say
    s = link.listen().signals
    part = {"u": s["u_actual"], "x": s["x"], "z": s["z"]}
    for axis in operator.AXES:
        homed = "homed" if s[f"homed_{axis}"] else "not homed"
        here = f"{axis} {operator.place_mm(link, axis):.6f} mm"
        say(f"{here}, of the part {part[axis]:.6f} mm, {homed}")
