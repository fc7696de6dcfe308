# SPDX-License-Identifier: Apache-2.0
"""The command line of camctl.

>>> make_parser().parse_args(["scope", "a.csv", "--signals", "state,u_actual_nm"]).signals
'state,u_actual_nm'
"""

from __future__ import annotations

import argparse
from pathlib import Path

from camtools.base.argument_types import finite, not_negative, positive, whole
from camtools.base.command import Parser
from camtools.cli.bus import add_bus_options
from camtools.cli.camctl_cut import add_cut
from camtools.cli.camctl_params import FILES
from camtools.cli.camctl_rights import add_rights, add_rights_options
from camtools.link.manual_axes import AXES
from camtools.link.messages import NUMBERS
from camtools.link.parameters import MEMORY
from camtools.link.scope import DEFAULT_SIGNALS
from camtools.link.settings import N_TOOLS
from camtools.link.trigger import GRAMMAR

PLAIN = ("enable", "disable", "home", "manual", "start", "stop", "hold", "resume", "reset")
QUICK = {
    "speed": "spindle speed in r/min from the next start on; 0: the table's",
    "feed": "feed in mm per turn from the next start on; 0: the table's",
    "amplitude": "scale of U in %%, ramped",
    "phase": "turns the oval on the part, in degrees, ramped",
}
_WHAT = {
    "enable": "enable the drives and home",
    "disable": "drives off",
    "home": "find the index, anew when ready, and wait until ready; of an axis in manual: its home",
    "manual": "enable the drives without the spindle, to move axes by hand",
    "start": "cut a part: stays until it is cut, control-C stops it",
    "hold": "rest Z on a whole turn while U goes on",
    "resume": "end the hold",
    "stop": "end the cut: disengage; in manual: brake",
    "reset": "leave the fault state",
}
_EPILOG = """\
The bus: --interface, --channel and --bitrate of python-can, for example
  tools/camctl --interface socketcan --channel can0 status
or the environment: CAN_INTERFACE, CAN_CHANNEL, CAN_BITRATE. Without either it is that of the live
lathe, where tools/live runs.
Orders take command while they run, and give it back; reading and stop need none. Who has it is told
by `who`; --take-over takes it from him.
Exit status: 0 done, 1 refused by the controller or no answer, 2 wrong usage or bad input."""


def _count(text: str) -> int:
    value = whole(text)
    if not 1 <= value <= 1_000_000:
        raise argparse.ArgumentTypeError(f"{text}: give 1 .. 1000000")
    return value


def _add_record(one: argparse.ArgumentParser) -> None:
    one.add_argument("file", type=Path)
    one.add_argument("--seconds", type=positive, help="how long; default: until interrupted")
    one.add_argument("--cut", action="store_true", help="until the cut that runs is over")


def _add_pictures(one: argparse.ArgumentParser) -> None:
    one.add_argument("--raw", action="store_true", help="the controller's whole numbers, no units")
    one.add_argument("--plot", type=Path, metavar="PNG", help="draw signals over time")
    one.add_argument("--over-angle", type=Path, metavar="PNG", help="draw turns over each other")
    one.add_argument("--keep", action="store_true", help="leave it in the controller's memory")


def _add_scope(one: argparse.ArgumentParser) -> None:
    one.add_argument("file", type=Path, help="ends in .csv or .parquet")
    one.add_argument("--signals", default=",".join(DEFAULT_SIGNALS), help="A,B,..; see SCOPE.md")
    one.add_argument("--trigger", default="now", help=GRAMMAR.replace("%", "%%"))
    one.add_argument("--before", type=not_negative, default=0.0, help="seconds before the trigger")
    one.add_argument("--seconds", type=positive, help="in all; default: until memory is full")
    one.add_argument("--every", type=_count, help="only one tick of N", default=1)
    one.add_argument("--from-state", choices=tuple(NUMBERS["state"]), help="while the state is so")
    one.add_argument("--repeat", type=_count, default=1, help="recordings, into numbered files")
    one.add_argument("--again", action="store_true", help="read the recording that is there")
    _add_pictures(one)


def _add_blackbox(one: argparse.ArgumentParser) -> None:
    one.add_argument("file", type=Path, nargs="?", help="ends in .csv or .parquet")
    one.add_argument("--clear", action="store_true", help="drop the fault that it holds")
    _add_pictures(one)


def _add_excite(one: argparse.ArgumentParser) -> None:
    one.add_argument("wave", type=Path, help="CSV: u_nm, then nanometres, a line for each tick")
    one.add_argument("file", type=Path, help="CSV of what was recorded")
    one.add_argument("--periods", type=_count, default=5, help="of the wave in full; 5")
    one.add_argument("--fade-ticks", type=_count, default=2000, help="rise and fall; 2000")
    one.add_argument("--place-nm", type=whole, default=0, help="of U, about which it plays; 0")
    one.add_argument("--signals", default=",".join(DEFAULT_SIGNALS), help="to be recorded")


def _add_hand(commands: argparse._SubParsersAction[Parser]) -> None:
    one = commands.add_parser("jog", help="in manual: move an axis until control-C, or by a step")
    one.add_argument("axis", choices=tuple(AXES))
    one.add_argument("sense", nargs="?", choices=("+", "-"))
    one.add_argument("--speed", type=positive, help="mm/s; default: 1, or what the axis may")
    one.add_argument("--seconds", type=positive, help="how long; default: until interrupted")
    one.add_argument("--step", type=finite, metavar="MM", help="by this, at the highest speed")
    one = commands.add_parser("zero", help="say where the tool is; nothing moves")
    one.add_argument("axis", choices=("x", "z"))
    one.add_argument("--diameter", type=not_negative, metavar="MM", help="that the tip touches")
    one.add_argument("--height", type=finite, metavar="MM", help="of the drawing")
    one = commands.add_parser("tool", help="print the tools, choose one, set its offsets")
    one.add_argument("number", nargs="?", type=whole, choices=range(N_TOOLS + 1), metavar="N")
    one.add_argument("--x", type=finite, metavar="MM", help="tip farther from the axis by this")
    one.add_argument("--z", type=finite, metavar="MM", help="tip at a greater height by this")
    commands.add_parser("where", help="print where the axes are")


def _add_params(one: argparse.ArgumentParser) -> None:
    actions = one.add_subparsers(dest="action", required=True, metavar="ACTION")
    for name, what in FILES.items():
        action = actions.add_parser(name, help=what)
        action.add_argument("file", type=Path, help="TOML")
        if name == "load":
            action.add_argument("--keep", action="store_true", help="the controller keeps them")
    for name, (_, what) in MEMORY.items():
        actions.add_parser(name, help=what)


def make_parser() -> argparse.ArgumentParser:
    """Return the command line of camctl."""
    parser = Parser(
        prog="tools/camctl",
        description="Command and watch a camturn controller over CAN.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    add_bus_options(parser)
    add_rights_options(parser)
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name in PLAIN:
        one = commands.add_parser(name, help=_WHAT[name])
        if name == "home":
            one.add_argument("axis", nargs="?", choices=tuple(AXES))
        if name == "start":
            one.add_argument("--wait", action="store_true", help=argparse.SUPPRESS)  # as without
    for name, what in QUICK.items():
        commands.add_parser(name, help=what).add_argument("value", type=finite)
    _add_hand(commands)
    add_cut(commands)
    commands.add_parser("get", help="print parameters").add_argument("names", nargs="+")
    one = commands.add_parser("set", help="set a parameter")
    one.add_argument("name")
    one.add_argument("value", type=whole)
    one = commands.add_parser("list", help="print parameters with their ranges")
    one.add_argument("pattern", nargs="?", default="*", help="with * and ?")
    _add_params(commands.add_parser("params", help="all parameters: files, and what is kept"))
    add_rights(commands)
    commands.add_parser("status", help="print the status once")
    one = commands.add_parser("watch", help="live view: angle, U, following error, faults")
    one.add_argument("--seconds", type=positive, help="how long; default: until interrupted")
    one.add_argument("--every", type=positive, help="seconds between two pictures")
    _add_record(commands.add_parser("record", help="write the status into CSV"))
    _add_scope(commands.add_parser("scope", help="record signals of ticks, write and draw them"))
    _add_blackbox(commands.add_parser("blackbox", help="what was before the last fault"))
    _add_excite(commands.add_parser("excite", help="in ready: U plays a wave and is recorded"))
    one = commands.add_parser("learned", help="what was learned: print it, save it, bring it back")
    one.add_argument("action", nargs="?", choices=("save", "load"))
    one.add_argument("file", nargs="?", type=Path, help="TOML")
    table = commands.add_parser("table", help="the table in use, download of another")
    actions = table.add_subparsers(dest="table", required=True, metavar="ACTION")
    actions.add_parser("info", help="name, size, CRC-32, generation")
    one = actions.add_parser("next", help="download a table and take it into use, also in ready")
    one.add_argument("file", type=Path)
    one = actions.add_parser("download", help="bring a table beside the one in use, check it there")
    one.add_argument("file", type=Path)
    one.add_argument("--select", action="store_true", help="take it into use at once")
    commands.add_parser("select", help="take the downloaded table into use")
    return parser
