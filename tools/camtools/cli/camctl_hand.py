# SPDX-License-Identifier: Apache-2.0
"""Commands of camctl about axes by hand: jog, homing, zero, tools.

>>> speed_of("-", 2.5)
-2.5
"""

from __future__ import annotations

from typing import Annotated

from camtools.base.arguments import Option, Word, finite, not_negative, positive, whole
from camtools.base.command import Interrupted
from camtools.base.errors import CamtoolsError
from camtools.base.quantities import NM_PER_MM
from camtools.cli.camctl_control import SECONDS_HELP, Control
from camtools.link.controller import Link
from camtools.link.manual_axes import (
    AXES,
    carry_out,
    end_text,
    for_seconds,
    jog,
    place_mm,
    rest,
    usual_mm_per_s,
)
from camtools.link.settings import N_TOOLS, parameter, set_tool, set_tool_offset, set_zero


def speed_of(sense: str, mm_per_s: float) -> float:
    """Return a speed with the sign of its sense, "+" or "-"."""
    return -mm_per_s if sense == "-" else mm_per_s


def _to_its_end(link: Link, command: str, axis: str, **value: float) -> str:
    """Return what an order came to; interrupted, the axis is at rest."""
    try:
        return carry_out(link, command, axis, **value)
    except Interrupted:
        rest(link, axis)
        return "interrupted"


def jog_axis(
    control: Control,
    axis: Annotated[str, Word("axis to move", choices=tuple(AXES))],
    sense: Annotated[
        str | None, Word("direction; leave out with --step", choices=("+", "-"))
    ] = None,
    *,
    speed: Annotated[
        float | None,
        Option("speed in mm/s (default: 1, or the axis limit if lower)", read=positive),
    ] = None,
    seconds: Annotated[float | None, Option(SECONDS_HELP, read=positive)] = None,
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
            raise CamtoolsError(
                [f"jog {axis}: a step has no --speed and no --seconds; leave them out"]
            )
        control.say(end_text(link, axis, _to_its_end(link, "step", axis, step=step), "jog"))
        return
    mm_per_s = usual_mm_per_s(link, axis) if speed is None else speed
    end = "done"
    try:
        end = jog(link, axis, speed_of(str(sense), mm_per_s), for_seconds(seconds))
    except Interrupted:  # how a jog that is held ends
        rest(link, axis)
    control.say(end_text(link, axis, end, "jog"))


def home_axis(control: Control, axis: str) -> None:
    """Find the home of an axis and wait until it is found."""
    link = control.link
    control.say(f"home {end_text(link, axis, _to_its_end(link, 'home_axis', axis), 'home')}")


def zero(
    control: Control,
    axis: Annotated[str, Word("axis to set", choices=("x", "z"))],
    *,
    diameter: Annotated[
        float | None,
        Option("diameter that the tool tip touches, for x", "MM", read=not_negative),
    ] = None,
    height: Annotated[
        float | None,
        Option("height on the drawing that the tip touches, for z", "MM", read=finite),
    ] = None,
) -> None:
    """Set the position of an axis to a known value; nothing moves."""
    value, other = (diameter, height) if axis == "x" else (height, diameter)
    if value is None or other is not None:
        given = "diameter" if axis == "x" else "height"
        raise CamtoolsError([f"zero {axis}: give --{given} MM, and nothing else"])
    control.say(set_zero(control.link, axis, value))


def tool(
    control: Control,
    number: Annotated[
        int | None,
        Word(
            f"tool 1 .. {N_TOOLS}, 0 for none (default: print all)",
            "N",
            read=whole,
            choices=range(N_TOOLS + 1),
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
            raise CamtoolsError(
                [f"tool: --{axis} {offset}: give the number of a tool, 1 .. {N_TOOLS}"]
            )
        set_tool_offset(link, number, axis, offset)
    if number is not None:
        set_tool(link, number)
    chosen = round(parameter(link, "tool"))
    for n in range(1, N_TOOLS + 1):
        x_mm, z_mm = (parameter(link, f"tool_{n}_{axis}_nm") / NM_PER_MM for axis in ("x", "z"))
        say(f"tool {n}: x {x_mm:.6f} mm, z {z_mm:.6f} mm{', in use' if n == chosen else ''}")
    if not chosen:
        say("no tool is in use")


def where(control: Control) -> None:
    """Print the axis positions."""
    link, say = control.link, control.say
    s = link.listen().signals
    part = {"u": s["u_actual"], "x": s["x"], "z": s["z"]}
    for axis in AXES:
        homed = "homed" if s[f"homed_{axis}"] else "not homed"
        say(f"{axis} {place_mm(link, axis):.6f} mm, of the part {part[axis]:.6f} mm, {homed}")
