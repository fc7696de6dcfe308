# SPDX-License-Identifier: Apache-2.0
"""What an operator sets: overrides, trim, parts, tools, the datum.

>>> radius_of("diameter", -0.012)
-0.006
>>> trim_text(-0.006)
'trim: diameter -0.012 mm, radius -0.006 mm'
"""

from __future__ import annotations

from dataclasses import dataclass

from camtools.base.quantities import NM_PER_MM
from camtools.link.controller import Link
from camtools.link.messages import NUMBERS, check_range
from camtools.link.parameters import INFOS
from camtools.link.refusal_text import ask_done, require


@dataclass(frozen=True)
class Setting:
    """A parameter in the unit of operators."""

    parameter: str
    unit: str
    per_unit: float  # units of the parameter


SETTINGS = {
    "speed": Setting("spindle_mrpm", "r/min", 1e3),
    "feed": Setting("feed_nm", "mm", 1e6),
    "amplitude": Setting("amplitude_ppm", "%", 1e4),
    "phase": Setting("phase_udeg", "deg", 1e6),
    "feed_override": Setting("feed_override_ppm", "%", 1e4),
    "spindle_override": Setting("spindle_override_ppm", "%", 1e4),
    "trim": Setting("x_trim_nm", "mm", 1e6),
}
OVERRIDES = ("feed", "spindle")
MEASURES = ("diameter", "radius")
N_TOOLS = 4


def parameter(link: Link, name: str) -> float:
    """Return the value of a parameter in force."""
    return ask_done(link, "get_parameter", NUMBERS["parameter"][name]).value


def value_of(link: Link, name: str) -> float:
    """Return a setting in force, in the unit of operators."""
    setting = SETTINGS[name]
    return parameter(link, setting.parameter) / setting.per_unit


def _set(link: Link, name: str, value: int, shown: str) -> float:
    """Set a parameter; return the value in force.

    Raises
    ------
    Refused
        It is refused; the text names the setting as shown.
    """
    answer = link.ask("set_parameter", parameter=NUMBERS["parameter"][name], value=value)
    return require(link, answer, f"set {shown}").value


def value_text(name: str, value: float) -> str:
    """Return a value of a setting with its unit.

    >>> value_text("speed", 2500.0)
    '2500 r/min'
    """
    return f"{value:.10g} {SETTINGS[name].unit}"


def _set_in_unit(link: Link, name: str, value: float) -> float:
    """Set a parameter in the unit of operators; return the value in force.

    Raises
    ------
    CamtoolsError
        The value is out of the parameter's range.
    """
    setting = SETTINGS[name]
    info = INFOS[setting.parameter]
    low, high = info.low / setting.per_unit, info.high / setting.per_unit
    check_range(name, value, low, high, setting.unit)
    shown = f"{name.replace('_', ' ')} = {value:.9g}"
    wanted = round(value * setting.per_unit)
    return _set(link, setting.parameter, wanted, shown) / setting.per_unit


def set_quick(link: Link, name: str, value: float) -> str:
    """Set speed, feed, amplitude or phase; return the value in force."""
    return f"{name} = {value_text(name, _set_in_unit(link, name, value))}"


def set_override(link: Link, what: str, percent: float) -> str:
    """Set the override of feed or spindle; return the one in force."""
    name = f"{what}_override"
    return f"override {what} = {value_text(name, _set_in_unit(link, name, percent))}"


def radius_of(measure: str, value_mm: float) -> float:
    """Return a trim of a diameter or of a radius as one of the radius."""
    return value_mm / 2 if measure == "diameter" else value_mm


def trim_text(radius_mm: float) -> str:
    """Return a trim as people read it."""
    return f"trim: diameter {2 * radius_mm:.9g} mm, radius {radius_mm:.9g} mm"


def set_trim(link: Link, measure: str, value_mm: float) -> str:
    """Set the trim of X; return the one in force."""
    return trim_text(_set_in_unit(link, "trim", radius_of(measure, value_mm)))


def set_parts(link: Link, number: int) -> str:
    """Set the number of parts from which is counted on; return what is so now."""
    return f"parts = {ask_done(link, 'set_parts', parts=number).value:.0f}"


def set_tool(link: Link, number: int) -> str:
    """Choose the tool whose offsets apply, 0: none; return it."""
    _set(link, "tool", number, f"tool = {number}")
    return f"tool {number} is in use" if number else "no tool is in use"


def set_tool_offset(link: Link, number: int, axis: str, mm: float) -> str:
    """Set an offset of a tool, along x or z; return the one in force."""
    nm = min(max(round(mm * NM_PER_MM), -(2**31)), 2**31 - 1)  # the controller gives its range
    value = _set(link, f"tool_{number}_{axis}_nm", nm, f"tool {number} {axis} = {mm:.9g}")
    return f"tool {number}: {axis} {value / NM_PER_MM:.6f} mm"


def set_zero(link: Link, axis: str, mm: float) -> str:
    """Say where the tool is: x, the diameter that it touches; z, its height in the drawing."""
    if axis == "x":
        given, answer = "diameter", ask_done(link, "zero_x", diameter=mm)
    else:
        given, answer = "height", ask_done(link, "zero_z", height=mm)
    return f"zero {axis}: {given} {mm:.9g} mm here, datum {answer.value:.6f} mm"
