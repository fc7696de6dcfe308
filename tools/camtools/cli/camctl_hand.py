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
from camtools.base.quantities import NM_PER_MM
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

Say = Callable[[str], None]


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


def jog_axis(link: Link, arguments: argparse.Namespace, say: Say) -> None:
    """Move an axis while this runs, or by a step."""
    axis: str = arguments.axis
    if (arguments.sense is None) == (arguments.step is None):
        raise CamtoolsError([f"jog {axis}: give either + or -, or --step MM"])
    if arguments.step is not None:
        if arguments.speed is not None or arguments.seconds is not None:
            raise CamtoolsError([f"jog {axis}: a step has no --speed and no --seconds; leave them"])
        say(end_text(link, axis, _to_its_end(link, "step", axis, step=arguments.step), "jog"))
        return
    speed = usual_mm_per_s(link, axis) if arguments.speed is None else arguments.speed
    end = "done"
    try:
        end = jog(link, axis, speed_of(arguments.sense, speed), for_seconds(arguments.seconds))
    except Interrupted:  # how a jog that is held ends
        rest(link, axis)
    say(end_text(link, axis, end, "jog"))


def home_axis(link: Link, axis: str, say: Say) -> None:
    """Find the home of an axis and wait until it is found."""
    say(f"home {end_text(link, axis, _to_its_end(link, 'home_axis', axis), 'home')}")


def zero(link: Link, arguments: argparse.Namespace, say: Say) -> None:
    """Tell the controller where the tool is."""
    axis: str = arguments.axis
    given, other = ("diameter", "height") if axis == "x" else ("height", "diameter")
    value: float | None = getattr(arguments, given)
    if value is None or getattr(arguments, other) is not None:
        raise CamtoolsError([f"zero {axis}: give --{given} MM, and nothing else"])
    say(set_zero(link, axis, value))


def tool(link: Link, arguments: argparse.Namespace, say: Say) -> None:
    """Print the tools, set the offsets of one, choose one."""
    number: int | None = arguments.number
    for axis in ("x", "z"):
        offset: float | None = getattr(arguments, axis)
        if offset is None:
            continue
        if not number:
            raise CamtoolsError([f"tool: --{axis} {offset}: give a tool, 1 .. {N_TOOLS}"])
        set_tool_offset(link, number, axis, offset)
    if number is not None:
        set_tool(link, number)
    chosen = round(parameter(link, "tool"))
    for n in range(1, N_TOOLS + 1):
        x, z = (parameter(link, f"tool_{n}_{axis}_nm") / NM_PER_MM for axis in ("x", "z"))
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
