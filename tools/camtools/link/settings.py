# SPDX-License-Identifier: Apache-2.0
"""What an operator sets: overrides, trim, parts, tools, the datum.

>>> radius_of("diameter", -0.012)
-0.006
>>> trim_text(-0.006)
'trim: diameter -0.012 mm, radius -0.006 mm'
"""

from __future__ import annotations

from camtools.base.quantities import NM_PER_MM
from camtools.link.controller import Link
from camtools.link.messages import NUMBERS, value_text
from camtools.link.refusal_text import ask_done

OVERRIDES = ("feed", "spindle")
MEASURES = ("diameter", "radius")
N_TOOLS = 4


def parameter(link: Link, name: str) -> float:
    """Return the value of a parameter in force."""
    return ask_done(link, "get_parameter", NUMBERS["parameter"][name]).value


def set_quick(link: Link, name: str, value: float) -> str:
    """Set speed, feed, amplitude or phase; return what is so now."""
    answer = ask_done(link, f"set_{name}", 0, **{name: value})
    return f"{name} = {value_text(name, answer.value)}"


def set_override(link: Link, what: str, percent: float) -> str:
    """Set the override of feed or spindle; return what is so now."""
    name = f"{what}_override"
    index = NUMBERS["parameter"][f"{name}_ppm"]
    answer = ask_done(link, f"set_{name}", index, **{name: percent})
    return f"override {what} = {value_text(name, answer.value)}"


def radius_of(measure: str, value_mm: float) -> float:
    """Return a trim of a diameter or of a radius as one of the radius."""
    return value_mm / 2 if measure == "diameter" else value_mm


def trim_text(radius_mm: float) -> str:
    """Return a trim as people read it."""
    return f"trim: diameter {2 * radius_mm:.9g} mm, radius {radius_mm:.9g} mm"


def set_trim(link: Link, measure: str, value_mm: float) -> str:
    """Set the trim of X; return what is so now."""
    wanted_mm = radius_of(measure, value_mm)
    answer = ask_done(link, "set_trim", NUMBERS["parameter"]["x_trim_nm"], trim=wanted_mm)
    return trim_text(answer.value)


def set_parts(link: Link, number: int) -> str:
    """Set the number of parts from which is counted on; return what is so now."""
    return f"parts = {ask_done(link, 'set_parts', parts=number).value:.0f}"


def set_tool(link: Link, number: int) -> str:
    """Choose the tool whose offsets count, 0: none; return what is so now."""
    ask_done(link, "set_tool", tool=number)
    return f"tool {number} is in use" if number else "no tool is in use"


def set_tool_offset(link: Link, number: int, axis: str, mm: float) -> str:
    """Set an offset of a tool, along x or z; return what is so now."""
    index = NUMBERS["parameter"][f"tool_{number}_{axis}_nm"]
    nm = min(max(round(mm * NM_PER_MM), -(2**31)), 2**31 - 1)  # the controller tells its range
    answer = ask_done(link, "set_parameter", index, value=nm)
    return f"tool {number}: {axis} {answer.value / NM_PER_MM:.6f} mm"


def set_zero(link: Link, axis: str, mm: float) -> str:
    """Say where the tool is: x, the diameter that it touches; z, its height in the drawing."""
    if axis == "x":
        given, answer = "diameter", ask_done(link, "zero_x", diameter=mm)
    else:
        given, answer = "height", ask_done(link, "zero_z", height=mm)
    return f"zero {axis}: {given} {mm:.9g} mm here, datum {answer.value:.6f} mm"
