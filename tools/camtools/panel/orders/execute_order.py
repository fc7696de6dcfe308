"""How each order is carried out, in the link's thread.

>>> sorted(set(ACTIONS) ^ set(RULES))
['jog_end', 'jog_hold', 'take_over']
"""

from collections.abc import Callable, Mapping
from typing import Any

from camtools.base.errors import CamtoolsError, one_line
from camtools.link.controller import Link
from camtools.link.download import check_image, download, select_table
from camtools.link.kept_values import change_kept, parse, problem_of, set_all
from camtools.link.messages import NUMBERS
from camtools.link.operator import (
    carry_out,
    end_text,
    jog,
    set_override,
    set_parts,
    set_quick,
    set_tool,
    set_tool_offset,
    set_trim,
    set_zero,
)
from camtools.link.refusal_text import ask_done
from camtools.link.status_text import level_text, table_report
from camtools.panel.orders.jog_press import Press
from camtools.panel.orders.order import RULES

_PAGES_S = 1.0  # within which every page of the status comes
_SETTLE_S = 0.05  # the state of before is in the status until the next tick's
_MOST_NAME = 60
Arguments = Mapping[str, Any]
Say = Callable[[str], None]
Action = Callable[[Link, Arguments, Say], str]


def _plain(name: str) -> Action:
    def action(link: Link, _arguments: Arguments, _say: Say) -> str:
        ask_done(link, name)
        link.wait(lambda: False, _SETTLE_S)
        return f"{name}: {link.status.state}"

    return action


def _home(link: Link, arguments: Arguments, say: Say) -> str:
    if "axis" not in arguments:
        return _plain("home")(link, arguments, say)
    axis: str = arguments["axis"]
    say(f"home {axis}")
    return f"home {end_text(link, axis, carry_out(link, 'home_axis', axis), 'home')}"


def _step(link: Link, arguments: Arguments, say: Say) -> str:
    axis: str = arguments["axis"]
    say(f"step {axis}")
    return end_text(link, axis, carry_out(link, "step", axis, step=arguments["mm"]), "step")


def _jog(link: Link, arguments: Arguments, say: Say) -> str:
    axis: str = arguments["axis"]
    press: Press = arguments["press"]
    say(f"jog {axis}")
    try:
        end = jog(link, axis, arguments["mm_per_s"], press.is_alive)
    finally:
        press.end("the jog is over")
    return f"{end_text(link, axis, end, 'jog')}; {press.ending}"


def _quick(name: str, argument: str) -> Action:
    return lambda link, given, _say: set_quick(link, name, given[argument])


def _download(link: Link, arguments: Arguments, say: Say) -> str:
    image: bytes = arguments["image"]
    name = one_line(arguments["name"])[:_MOST_NAME]
    check_image(image, name)
    say(f"download of {name}, 0 %")
    download(
        link, image, lambda stored, _s: say(f"download of {name}, {stored * 100 // len(image)} %")
    )
    return f"{name} is downloaded and checked; select activates it"


def _table_next(link: Link, arguments: Arguments, say: Say) -> str:
    _download(link, arguments, say)
    return _select(link, arguments, say)


def _select(link: Link, _arguments: Arguments, say: Say) -> str:
    say("select")
    select_table(link)
    return "; ".join(" ".join(line.split()) for line in table_report(link.status))


def _set(link: Link, arguments: Arguments, _say: Say) -> str:
    name, value = arguments["name"], arguments["value"]
    if problem := problem_of(name, value):
        raise CamtoolsError([problem])
    answer = ask_done(link, "set_parameter", NUMBERS["parameter"][name], value=value)
    return f"{name} = {answer.value:.0f}"


def _params_load(link: Link, arguments: Arguments, say: Say) -> str:
    name = one_line(arguments["name"])[:_MOST_NAME]
    notes: list[str] = []
    values = parse(arguments["text"], name, notes.append)
    say(f"parameters of {name}")
    changes = set_all(link, values)
    shown = ", ".join(f"{key} {old} -> {new}" for key, (old, new) in list(changes.items())[:8])
    more = f" and {len(changes) - 8} more" if len(changes) > 8 else ""
    head = f"{name}: {len(changes)} of {len(values)} parameters changed"
    return "; ".join([f"{head}: {shown}{more}" if changes else head, *notes])


def _memory(action: str) -> Action:
    def carry(link: Link, _arguments: Arguments, say: Say) -> str:
        say(action)
        return change_kept(link, action)

    return carry


def _lock(link: Link, _arguments: Arguments, _say: Say) -> str:
    ask_done(link, "lock")
    link.await_anew("level", _PAGES_S)
    return level_text(link.status.signals)


def _take_over(link: Link, _arguments: Arguments, _say: Say) -> str:
    link.rights.take(over=True)
    return "you have command; the previous commander was notified"


_PLAIN = ("stop", "disable", "enable", "manual", "start", "hold", "resume", "reset")
ACTIONS: Mapping[str, Action] = {
    **{name: _plain(name) for name in _PLAIN},
    **{action: _memory(action) for action in ("keep", "revert", "defaults")},
    "home": _home,
    "jog_begin": _jog,
    "step": _step,
    "zero": lambda link, given, _say: set_zero(link, given["axis"], given["mm"]),
    "tool": lambda link, given, _say: set_tool(link, given["number"]),
    "tool_offset": lambda link, given, _say: set_tool_offset(
        link, given["number"], given["axis"], given["mm"]
    ),
    "feed": lambda link, given, _say: set_override(link, "feed", given["percent"]),
    "spindle": lambda link, given, _say: set_override(link, "spindle", given["percent"]),
    "trim": lambda link, given, _say: set_trim(link, given["measure"], given["mm"]),
    "parts": lambda link, given, _say: set_parts(link, given["number"]),
    "amplitude": _quick("amplitude", "percent"),
    "phase": _quick("phase", "deg"),
    "speed": _quick("speed", "rpm"),
    "feed_per_turn": _quick("feed", "mm"),
    "download": _download,
    "table_next": _table_next,
    "select": _select,
    "set": _set,
    "params_load": _params_load,
    "lock": _lock,
    "push_u": lambda link, given, say: given["tuner"].push(link, given["force_n"], say),
    "measure_loop": lambda link, given, say: given["tuner"].measure(link, say, given["rests"]),
    "apply_loop": lambda link, given, say: given["tuner"].apply(link, say),
    "take_over": _take_over,  # of the service alone: no page orders it by its name
}
assert set(ACTIONS) - {"take_over"} == set(RULES) - {"jog_hold", "jog_end"}
