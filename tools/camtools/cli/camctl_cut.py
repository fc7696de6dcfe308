# SPDX-License-Identifier: Apache-2.0
"""Subcommands of camctl about what changes while a part is cut: overrides, trim, parts.

>>> parser = Parser(prog="tools/camctl")
>>> add_cut(parser.add_subparsers())
>>> parser.parse_args(["override", "feed", "90"]).what
'feed'
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

from camtools.base.argument_types import finite, whole
from camtools.base.command import Parser
from camtools.base.quantities import NM_PER_MM
from camtools.link.controller import Link, value_text
from camtools.link.refusal import ask_done
from camtools.link.settings import (
    MEASURES,
    OVERRIDES,
    parameter,
    set_override,
    set_parts,
    set_trim,
    trim_text,
)

Say = Callable[[str], None]


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


def override(link: Link, arguments: argparse.Namespace, say: Say) -> None:
    """Set an override, or print it."""
    name = f"{arguments.what}_override"
    if arguments.percent is None:
        percent = parameter(link, f"{name}_ppm") / 1e4
        say(f"override {arguments.what} = {value_text(name, percent)}")
    else:
        say(set_override(link, arguments.what, arguments.percent))


def trim(link: Link, arguments: argparse.Namespace, say: Say) -> None:
    """Set the trim of X, or print it."""
    if arguments.value is None:
        say(trim_text(parameter(link, "x_trim_nm") / NM_PER_MM))
    else:
        say(set_trim(link, arguments.measure, arguments.value))


def parts(link: Link, arguments: argparse.Namespace, say: Say) -> None:
    """Set the number of parts, or print it."""
    if arguments.number is None:
        say(f"parts = {ask_done(link, 'get_parts').value:.0f}")
    else:
        say(set_parts(link, arguments.number))
