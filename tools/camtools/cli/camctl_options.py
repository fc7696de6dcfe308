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
    "speed": "set the spindle speed in r/min for the next start (0: the table's)",
    "feed": "set the feed in mm per turn for the next start (0: the table's)",
    "amplitude": "scale the stroke of U, in %%; ramped",
    "phase": "rotate the oval on the part, in degrees; ramped",
}
_WHAT = {
    "enable": "enable the drives and home",
    "disable": "switch the drives off",
    "home": "find the spindle index and wait until ready; with an axis, in manual: home that axis",
    "manual": "enable the drives without the spindle, to move axes by hand",
    "start": "cut a part and wait for its end; control-C stops the cut",
    "hold": "pause Z after a whole turn; U continues",
    "resume": "continue after a hold",
    "stop": "end the cut and retract; in manual: brake the axes",
    "reset": "clear the faults",
}
_SECONDS = "duration (default: until control-C)"
_SIGNALS = "signals to record; tools/docs/SCOPE.md lists them (default: %(default)s)"
_EPILOG = """\
Choose the CAN bus by options, for example
  tools/camctl --interface socketcan --channel can0 status
or by the environment: CAN_INTERFACE, CAN_CHANNEL, CAN_BITRATE. Without either, camctl uses the live
lathe of tools/live.
Each order takes command while it runs and then gives it back; reading and `stop` do not need it.
`who` shows who has command; --take-over takes it from that sender.
Exit status: 0 done, 1 refused by the controller or no answer, 2 wrong usage or bad input."""


def _count(text: str) -> int:
    value = whole(text)
    if not 1 <= value <= 1_000_000:
        raise argparse.ArgumentTypeError(f"{text}: give 1 .. 1000000")
    return value


def _add_record(one: argparse.ArgumentParser) -> None:
    one.add_argument("file", type=Path, help="CSV file to write")
    one.add_argument("--seconds", type=positive, help=_SECONDS)
    one.add_argument("--cut", action="store_true", help="stop at the end of the cut in progress")


def _add_pictures(one: argparse.ArgumentParser) -> None:
    one.add_argument(
        "--raw",
        action="store_true",
        help="write the controller's integers instead of physical units",
    )
    one.add_argument(
        "--plot", type=Path, metavar="PNG", help="plot the signals over time into this file"
    )
    one.add_argument(
        "--over-angle",
        type=Path,
        metavar="PNG",
        help="plot the signals over the spindle angle into this file",
    )
    one.add_argument(
        "--keep", action="store_true", help="keep the recording in the controller's memory"
    )


def _add_scope(one: argparse.ArgumentParser) -> None:
    one.add_argument("file", type=Path, help="file to write, .csv or .parquet")
    one.add_argument(
        "--signals", default=",".join(DEFAULT_SIGNALS), metavar="A,B,..", help=_SIGNALS
    )
    one.add_argument(
        "--trigger", default="now", help=f"start of the recording: {GRAMMAR} (default: now)"
    )
    one.add_argument(
        "--before",
        type=not_negative,
        default=0.0,
        help="seconds kept before the trigger (default: 0)",
    )
    one.add_argument(
        "--seconds", type=positive, help="length in all (default: until memory is full)"
    )
    one.add_argument(
        "--every", type=_count, default=1, metavar="N", help="record one tick of N (default: 1)"
    )
    one.add_argument(
        "--from-state",
        choices=tuple(NUMBERS["state"]),
        help="record only in this state (default: in any)",
    )
    one.add_argument(
        "--repeat",
        type=_count,
        default=1,
        metavar="N",
        help="number of recordings, into numbered files (default: 1)",
    )
    one.add_argument("--again", action="store_true", help="read the recording already in memory")
    _add_pictures(one)


def _add_blackbox(one: argparse.ArgumentParser) -> None:
    one.add_argument(
        "file",
        type=Path,
        nargs="?",
        help="file to write, .csv or .parquet (default: only show what is held)",
    )
    one.add_argument(
        "--clear", action="store_true", help="discard the recorded fault and record again"
    )
    _add_pictures(one)


def _add_excite(one: argparse.ArgumentParser) -> None:
    one.add_argument(
        "wave",
        type=Path,
        help="CSV with the heading u_nm, then one position in nm per tick; or force_mn and forces",
    )
    one.add_argument("file", type=Path, help="CSV file to write")
    one.add_argument(
        "--periods",
        type=_count,
        default=5,
        metavar="N",
        help="periods at full amplitude (default: 5)",
    )
    one.add_argument(
        "--fade-ticks",
        type=_count,
        default=2000,
        metavar="N",
        help="ticks of fading in and out (default: 2000)",
    )
    one.add_argument(
        "--place-nm",
        type=whole,
        default=0,
        metavar="NM",
        help="mean position of U in nm (default: 0)",
    )
    one.add_argument(
        "--signals", default=",".join(DEFAULT_SIGNALS), metavar="A,B,..", help=_SIGNALS
    )


def _add_hand(commands: argparse._SubParsersAction[Parser]) -> None:
    one = commands.add_parser("jog", help="in manual: move an axis until control-C, or by one step")
    one.add_argument("axis", choices=tuple(AXES), help="axis to move")
    one.add_argument(
        "sense", nargs="?", choices=("+", "-"), help="direction; leave out with --step"
    )
    one.add_argument(
        "--speed", type=positive, help="speed in mm/s (default: 1, or the axis limit if lower)"
    )
    one.add_argument("--seconds", type=positive, help=_SECONDS)
    one.add_argument(
        "--step",
        type=finite,
        metavar="MM",
        help="signed distance in mm, moved at the highest jog speed",
    )
    one = commands.add_parser(
        "zero", help="set the position of an axis to a known value; nothing moves"
    )
    one.add_argument("axis", choices=("x", "z"), help="axis to set")
    one.add_argument(
        "--diameter",
        type=not_negative,
        metavar="MM",
        help="diameter that the tool tip touches, for x",
    )
    one.add_argument(
        "--height",
        type=finite,
        metavar="MM",
        help="height on the drawing that the tip touches, for z",
    )
    one = commands.add_parser("tool", help="print the tool offsets, select a tool, set its offsets")
    one.add_argument(
        "number",
        nargs="?",
        type=whole,
        choices=range(N_TOOLS + 1),
        metavar="N",
        help=f"tool 1 .. {N_TOOLS}, 0 for none (default: print all)",
    )
    one.add_argument(
        "--x",
        type=finite,
        metavar="MM",
        help="X offset of the tip in mm, away from the spindle axis",
    )
    one.add_argument(
        "--z", type=finite, metavar="MM", help="Z offset of the tip in mm, towards greater heights"
    )
    commands.add_parser("where", help="print the axis positions")


def _add_params(one: argparse.ArgumentParser) -> None:
    actions = one.add_subparsers(dest="action", required=True, metavar="ACTION")
    for name, what in FILES.items():
        action = actions.add_parser(name, help=what)
        action.add_argument("file", type=Path, help="TOML file")
        if name == "load":
            action.add_argument(
                "--keep",
                action="store_true",
                help="also store them in the controller, for its next start",
            )
    for name, (_, what) in MEMORY.items():
        actions.add_parser(name, help=what)


def make_parser() -> argparse.ArgumentParser:
    """Return the command line of camctl."""
    parser = Parser(
        prog="tools/camctl",
        description="Command and monitor a camturn controller over CAN.",
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
            one.add_argument("axis", nargs="?", choices=tuple(AXES), help="only this axis")
        if name == "start":
            one.add_argument("--wait", action="store_true", help=argparse.SUPPRESS)  # as without
    for name, what in QUICK.items():
        commands.add_parser(name, help=what).add_argument("value", type=finite)
    _add_hand(commands)
    add_cut(commands)
    commands.add_parser("get", help="print parameters").add_argument(
        "names", nargs="+", help="parameters; `list` prints all"
    )
    one = commands.add_parser("set", help="set a parameter")
    one.add_argument("name", help="parameter; `list` prints all")
    one.add_argument("value", type=whole, help="whole number, in the unit of the name")
    one = commands.add_parser("list", help="print parameters with their ranges")
    one.add_argument(
        "pattern", nargs="?", default="*", help="only names that match, with * and ? (default: all)"
    )
    _add_params(commands.add_parser("params", help="save, load, compare or store all parameters"))
    add_rights(commands)
    commands.add_parser("status", help="print the status")
    one = commands.add_parser("watch", help="live view: angle, U, following error, faults")
    one.add_argument("--seconds", type=positive, help=_SECONDS)
    one.add_argument(
        "--every",
        type=positive,
        metavar="SECONDS",
        help="time between updates (default: 0.1 on a terminal, else 1)",
    )
    _add_record(
        commands.add_parser("record", help="record the status to a CSV file, one row every 10 ms")
    )
    _add_scope(
        commands.add_parser("scope", help="record signals tick by tick, write and plot them")
    )
    _add_blackbox(
        commands.add_parser(
            "blackbox", help="show or read the recording from before the last fault"
        )
    )
    _add_excite(commands.add_parser("excite", help="in ready: move U along a wave and record it"))
    one = commands.add_parser("learned", help="print, save or load the learned correction")
    one.add_argument("action", nargs="?", choices=("save", "load"), help="default: print")
    one.add_argument("file", nargs="?", type=Path, help="TOML file, with save and load")
    table = commands.add_parser("table", help="show the active table, or download another one")
    actions = table.add_subparsers(dest="table", required=True, metavar="ACTION")
    actions.add_parser("info", help="print name, size, CRC-32 and generation of the active table")
    one = actions.add_parser("next", help="download a table and activate it; also allowed in ready")
    one.add_argument("file", type=Path, help="table, NAME.camtab")
    one = actions.add_parser("download", help="download and check a table; the active one stays")
    one.add_argument("file", type=Path, help="table, NAME.camtab")
    one.add_argument("--select", action="store_true", help="activate it after the download")
    commands.add_parser("select", help="activate the downloaded table")
    return parser
