# SPDX-License-Identifier: Apache-2.0
"""Subcommands of camctl about what changes while a part is cut: overrides, trim, parts.

>>> radius_of("diameter", -0.012)
-0.006
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

from camtools.base.argument_types import finite, whole
from camtools.base.command import Parser
from camtools.link.controller import NUMBERS, Link, value_text
from camtools.link.refusal import ask_done

OVERRIDES = ("feed", "spindle")
MEASURES = ("diameter", "radius")
Say = Callable[[str], None]


def radius_of(measure: str, value_mm: float) -> float:
    """Return a trim of a diameter or of a radius as one of the radius."""
    return value_mm / 2 if measure == "diameter" else value_mm


def add_cut(commands: argparse._SubParsersAction[Parser]) -> None:
    """Add the subcommands to the command line."""
    one = commands.add_parser("override", help="feed or spindle over its programmed value, ramped")
    one.add_argument("what", choices=OVERRIDES)
    one.add_argument("percent", nargs="?", type=finite, help="feed 0 .. 150, spindle 50 .. 120")
    one = commands.add_parser("trim", help="X off its place, for wear, ramped also while cutting")
    one.add_argument("measure", choices=MEASURES)
    one.add_argument("value", nargs="?", type=finite, metavar="MM", help="positive: a larger part")
    one = commands.add_parser("parts", help="number of parts that were cut")
    one.add_argument("number", nargs="?", type=whole, metavar="N", help="go on counting from here")


def _parameter(link: Link, name: str) -> float:
    return ask_done(link, "get_parameter", NUMBERS["parameter"][name]).value


def override(link: Link, arguments: argparse.Namespace, say: Say) -> None:
    """Set an override, or print it."""
    name = f"{arguments.what}_override"
    if arguments.percent is None:
        percent = _parameter(link, f"{name}_ppm") / 1e4
    else:
        index = NUMBERS["parameter"][f"{name}_ppm"]
        percent = ask_done(link, f"set_{name}", index, **{name: arguments.percent}).value
    say(f"override {arguments.what} = {value_text(name, percent)}")


def trim(link: Link, arguments: argparse.Namespace, say: Say) -> None:
    """Set the trim of X, or print it."""
    if arguments.value is None:
        radius_mm = _parameter(link, "x_trim_nm") * 1e-6
    else:
        wanted_mm = radius_of(arguments.measure, arguments.value)
        index = NUMBERS["parameter"]["x_trim_nm"]
        radius_mm = ask_done(link, "set_trim", index, trim=wanted_mm).value
    say(f"trim: diameter {2 * radius_mm:.9g} mm, radius {radius_mm:.9g} mm")


def parts(link: Link, arguments: argparse.Namespace, say: Say) -> None:
    """Set the number of parts, or print it."""
    if arguments.number is None:
        number = ask_done(link, "get_parts").value
    else:
        number = ask_done(link, "set_parts", parts=arguments.number).value
    say(f"parts = {number:.0f}")
