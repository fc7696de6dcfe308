# SPDX-License-Identifier: Apache-2.0
"""Subcommands of camctl about axes by hand: jog, homing, zero, tools.

>>> speed_of("-", 2.5)
-2.5
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

from camtools.base.command import Interrupted
from camtools.base.errors import CamtoolsError
from camtools.link.controller import NUMBERS, Link, Refused
from camtools.link.hand import AXES, END_TEXTS, carry_out, jog, place_mm, rest
from camtools.link.refusal import ask_done

USUAL_MM_PER_S = 1.0
N_TOOLS = 4
Say = Callable[[str], None]


def speed_of(sense: str, mm_per_s: float) -> float:
    """Return a speed with the sign of its sense, "+" or "-"."""
    return -mm_per_s if sense == "-" else mm_per_s


def _parameter(link: Link, name: str) -> float:
    return ask_done(link, "get_parameter", NUMBERS["parameter"][name]).value


def _told(link: Link, axis: str, end: str, what: str) -> str:
    """Return the line of an order that is over.

    Raises
    ------
    Refused
        It did not succeed.
    """
    here = f"{axis} {place_mm(link, axis):.6f} mm"
    if end in ("done", "limit"):
        return here + (f", {END_TEXTS[end]}" if end == "limit" else "")
    raise Refused(f"{what} {axis}: {END_TEXTS.get(end, end)}; {here}")


def _to_its_end(link: Link, command: str, axis: str, **value: float) -> str:
    """Return what an order came to; interrupted, the axis is at rest."""
    try:
        return carry_out(link, command, axis, **value)
    except Interrupted:
        rest(link, axis)
        return "interrupted"


def jog_axis(link: Link, arguments: argparse.Namespace, say: Say) -> None:
    """Move an axis while this runs, or by a step."""
    axis: str = arguments.axis
    if (arguments.sense is None) == (arguments.step is None):
        raise CamtoolsError([f"jog {axis}: give either + or -, or --step MM"])
    if arguments.step is not None:
        if arguments.speed is not None or arguments.seconds is not None:
            raise CamtoolsError([f"jog {axis}: a step has no --speed and no --seconds; leave them"])
        say(_told(link, axis, _to_its_end(link, "step", axis, step=arguments.step), "jog"))
        return
    most = _parameter(link, f"{axis}_jog_um_per_s") / 1000
    speed = min(USUAL_MM_PER_S, most) if arguments.speed is None else arguments.speed
    end = "done"
    try:
        end = jog(link, axis, speed_of(arguments.sense, speed), arguments.seconds)
    except Interrupted:  # how a jog that is held ends
        rest(link, axis)
    say(_told(link, axis, end, "jog"))


def home_axis(link: Link, axis: str, say: Say) -> None:
    """Find the home of an axis and wait until it is found."""
    say(f"home {_told(link, axis, _to_its_end(link, 'home_axis', axis), 'home')}")


def zero(link: Link, arguments: argparse.Namespace, say: Say) -> None:
    """Tell the controller where the tool is."""
    axis: str = arguments.axis
    given, other = ("diameter", "height") if axis == "x" else ("height", "diameter")
    value: float | None = getattr(arguments, given)
    if value is None or getattr(arguments, other) is not None:
        raise CamtoolsError([f"zero {axis}: give --{given} MM, and nothing else"])
    if axis == "x":
        answer = ask_done(link, "zero_x", diameter=value)
    else:
        answer = ask_done(link, "zero_z", height=value)
    say(f"zero {axis}: {given} {value:.9g} mm here, datum {answer.value:.6f} mm")


def tool(link: Link, arguments: argparse.Namespace, say: Say) -> None:
    """Print the tools, set the offsets of one, choose one."""
    number: int | None = arguments.number
    for axis in ("x", "z"):
        offset: float | None = getattr(arguments, axis)
        if offset is None:
            continue
        if not number:
            raise CamtoolsError([f"tool: --{axis} {offset}: give a tool, 1 .. {N_TOOLS}"])
        index = NUMBERS["parameter"][f"tool_{number}_{axis}_nm"]
        nm = min(max(round(offset * 1e6), -(2**31)), 2**31 - 1)  # the controller tells its range
        ask_done(link, "set_parameter", index, value=nm)
    if number is not None:
        ask_done(link, "set_tool", tool=number)
    chosen = round(_parameter(link, "tool"))
    for n in range(1, N_TOOLS + 1):
        x, z = (_parameter(link, f"tool_{n}_{axis}_nm") / 1e6 for axis in ("x", "z"))
        say(f"tool {n}: x {x:.6f} mm, z {z:.6f} mm{', in use' if n == chosen else ''}")
    if not chosen:
        say("no tool is in use")


def where(link: Link, say: Say) -> None:
    """Print where the axes are."""
    s = link.listen().signals
    part = {"u": s["u_actual"], "x": s["x"], "z": s["z"]}
    for axis in AXES:
        homed = "homed" if s[f"homed_{axis}"] else "not homed"
        say(f"{axis} {place_mm(link, axis):.6f} mm, of the part {part[axis]:.6f} mm, {homed}")
