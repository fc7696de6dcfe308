"""What an operator sets and moves by hand: overrides, trim, parts, tools, the datum, axes.

>>> radius_of("diameter", -0.012)
-0.006
>>> trim_text(-0.006)
'trim: diameter -0.012 mm, radius -0.006 mm'

>>> AXES["x"], END_TEXTS["no_switch"]
(1, 'no home switch or stop within the travel of the search')
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from camtools.base.quantities import NM_PER_MM
from camtools.link.controller import PERIOD_S, Link
from camtools.link.kept_values import INFOS
from camtools.link.messages import NAMES, NUMBERS, Refused, check_range
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
    """Set a parameter; return the value in force. A refusal names the setting as shown."""
    answer = link.ask("set_parameter", parameter=NUMBERS["parameter"][name], value=value)
    return require(link, answer, f"set {shown}").value


def value_text(name: str, value: float) -> str:
    """Return a value of a setting with its unit."""
    return f"{value:.10g} {SETTINGS[name].unit}"


def _set_in_unit(link: Link, name: str, value: float) -> float:
    """Set a parameter in the unit of operators, within its range; return the value in force."""
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


AXES = {"u": 0, "x": 1, "z": 2}
REPEAT_S = 0.1  # an order holds for 250 ms
_BEGIN_S, _PAGES_S = 1.0, 1.0  # of the controller's own time
_LONGEST_S = 3600.0
END_TEXTS = {
    "interrupted": "interrupted; the axis has stopped",
    "stopped": "stopped by another command or a fault",
    "silent": "the controller heard nothing from here for 250 ms; is the bus too busy?",
    "limit": "at the limit of its travel",
    "no_switch": "no home switch or stop within the travel of the search",
    "no_release": "the home switch stays active within the travel of the search, or U does not "
    "leave its stop",
    "no_index": "no index after the switch within the travel of the search",
    "no_stroke": "at this home, U would be outside its stroke; set u_home_nm to "
    "the position of U there",
}


def place_mm(link: Link, axis: str) -> float:
    """Return where an axis is, in the machine's numbers."""
    return ask_done(link, "get_place", AXES[axis]).value


def end_text(link: Link, axis: str, end: str, what: str) -> str:
    """Return the line of an order that is over; refused where it did not succeed."""
    here = f"{axis} {place_mm(link, axis):.6f} mm"
    if end in ("done", "limit"):
        return here + (f", {END_TEXTS[end]}" if end == "limit" else "")
    raise Refused(f"{what} {axis}: {END_TEXTS.get(end, end)}; {here}")


def _check_state(link: Link) -> None:
    """Raise when the state manual was left."""
    status = link.status
    if status.state in ("manual", "unknown"):
        return
    link.wait(lambda: bool(status.faults), 0.1)
    faults = f": {', '.join(status.faults)}" if status.faults else ""
    raise Refused(f"manual has ended, the state is {status.state}{faults}; see status")


@contextlib.contextmanager
def _braked(link: Link) -> Iterator[None]:
    """Brake what moves, however the block ends."""
    try:
        yield
    except BaseException:
        with contextlib.suppress(Refused):
            link.ask("stop")
        raise


def _orders(link: Link) -> float:
    """Return the number of orders that were begun, from the next page of the status."""
    link.status.signals.pop("hand_orders", None)
    if not link.wait_in_its_time(lambda: "hand_orders" in link.status.signals, _PAGES_S):
        link.listen()
    return link.status.signals["hand_orders"]


def carry_out(link: Link, command: str, axis: str, **value: float) -> str:
    """Give an order that ends by itself, keep it alive, and return what came of it.

    command: step or home_axis; axis: u, x or z. Raises Refused: the controller refused it, or left
    the state manual.
    """
    before, order = _orders(link), f"{command.replace('_', ' ')} {axis}"
    with _braked(link):
        ask_done(link, command, AXES[axis], **value)
        begun_s, rows = time.monotonic(), link.status.n_rows
        is_begun, due_s = False, begun_s + REPEAT_S
        while time.monotonic() - begun_s < _LONGEST_S:
            link.wait(lambda: False, min(REPEAT_S, max(0.0, due_s - time.monotonic())))
            ask_done(link, "keep_alive")
            due_s = time.monotonic() + REPEAT_S
            _check_state(link)
            if is_begun and (end := _quick_end(link)) != "runs":
                return end
            if not is_begun and link.status.signals.get("hand_orders", before) != before:
                is_begun = True
                link.status.signals.pop("hand_end", None)  # a page of before tells another order's
            if not is_begun and (link.status.n_rows - rows) * PERIOD_S > _BEGIN_S:
                raise Refused(f"{order}: the order did not start; try again")
    raise Refused(f"{order}: not finished after {_LONGEST_S:.0f} s; stop the axis")


def _quick_end(link: Link) -> str:
    """Return what the order came to, by the pages since the last call."""
    end = link.status.signals.pop("hand_end", None)
    return "runs" if end is None else NAMES["hand_end"].get(int(end), "unknown")


def for_seconds(seconds: float | None) -> Callable[[], bool]:
    """Return a function that is true until a time from now on has passed; None: an hour."""
    end_s = time.monotonic() + (_LONGEST_S if seconds is None else seconds)
    return lambda: time.monotonic() < end_s


def jog(link: Link, axis: str, mm_per_s: float, goes_on: Callable[[], bool]) -> str:
    """Move an axis by repeating the order, until that is wanted no more or it stands at its limit.

    goes_on: whether to move on; asked before each order, and with each frame of the status. Returns
    "done" when it was wanted no more, "limit" at the end of the travel; the axis is at rest. Raises
    Refused: the controller refused it, or left the state manual.
    """
    link.status.signals.pop("hand_end", None)
    end = "done"
    with _braked(link):
        while goes_on() and end == "done":
            ask_done(link, "jog", AXES[axis], jog_speed=mm_per_s)
            link.wait(lambda: not goes_on(), REPEAT_S)
            _check_state(link)
            end = "limit" if _quick_end(link) == "limit" else "done"
    rest(link, axis)
    return end


def rest(link: Link, axis: str) -> None:
    """Brake an axis and wait until it stands."""
    ask_done(link, "jog", AXES[axis], jog_speed=0.0)
    link.wait(lambda: False, 0.05)
    last = None
    for _ in range(1000):
        here = place_mm(link, axis)
        if here == last:
            return
        last = here
        link.wait(lambda: False, 0.02)
