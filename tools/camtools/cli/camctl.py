"""Command line that commands and watches a controller over CAN.

The bus is any of python-can; what is not given comes from CAN_INTERFACE, CAN_CHANNEL, CAN_BITRATE
or its configuration files.
"""

from __future__ import annotations

import argparse
import csv
import fnmatch
import shutil
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, TextIO

from camtools.base.arguments import (
    Commands,
    Function,
    Group,
    Option,
    Word,
    finite,
    make_parser,
    positive,
    read_arguments,
    whole,
)
from camtools.base.command import run_command
from camtools.base.errors import CamtoolsError
from camtools.base.files import growing, path_errors
from camtools.cli import camctl_control, camctl_operate, camctl_values
from camtools.cli.bus import BusOptions
from camtools.cli.camctl_control import Control, RightsOptions, Seconds, refuse_fault
from camtools.cli.camctl_scope import blackbox, scope
from camtools.cli.camctl_values import excite, learned
from camtools.link.controller import Link, Status
from camtools.link.download import check_image, download, select_table
from camtools.link.messages import NUMBERS, Refused
from camtools.link.operator import AXES, set_quick
from camtools.link.status_text import (
    COLUMNS,
    IN_CUT,
    Dashboard,
    line,
    report,
    row,
    table_report,
)

REFUSED = 1
HOME_S = 60.0
_PLAIN = {
    "enable": "Enable the drives and home.",
    "disable": "Switch the drives off.",
    "manual": "Enable the drives without the spindle, to move axes by hand.",
    "stop": "End the cut and retract; in manual: brake the axes.",
    "hold": "Pause Z after a whole turn; U continues.",
    "resume": "Continue after a hold.",
    "reset": "Clear the faults.",
}
_QUICK = {
    "speed": "Set the spindle speed in r/min for the next start (0: the table's).",
    "feed": "Set the feed in mm per turn for the next start (0: the table's).",
    "amplitude": "Scale the stroke of U, in %%; ramped.",
    "phase": "Rotate the oval on the part, in degrees; ramped.",
}
_EPILOG = """\
Choose the CAN bus by options, for example
  tools/camctl --interface socketcan --channel can0 status
or by the environment: CAN_INTERFACE, CAN_CHANNEL, CAN_BITRATE. Without either, camctl uses the live
lathe of tools/live.
Each order takes command while it runs and then gives it back; reading and `stop` do not need it.
`who` shows who has command; --take-over takes it from that sender.
Exit status: 0 done, 1 refused by the controller or no answer, 2 wrong usage or bad input."""


def _order(control: Control, command: str) -> None:
    """Give an order without a value; the status that follows is that of after it."""
    control.ask(command)
    control.link.wait(lambda: False, 0.05)
    control.link.status.signals.pop("state", None)


def _plain(command: str, text: str) -> Callable[[Control], None]:
    def carry_out(control: Control) -> None:
        _order(control, command)
        control.say(f"{command}: {control.link.listen().state}")

    carry_out.__doc__ = text
    return carry_out


def _quick(command: str, text: str) -> Callable[..., None]:
    def carry_out(control: Control, value: Annotated[float, Word("", read=finite)]) -> None:
        control.say(set_quick(control.link, command, value))

    carry_out.__doc__ = text
    return carry_out


def home(
    control: Control,
    axis: Annotated[str | None, Word("only this axis", choices=tuple(AXES))] = None,
) -> None:
    """Find the spindle index and wait until ready; with an axis, in manual: home that axis."""
    if axis is not None:
        camctl_operate.home_axis(control, axis)
        return
    _order(control, "home")
    link, now = control.link, control.link.listen()
    if not link.wait(lambda: now.state in ("ready", "fault"), HOME_S):
        raise Refused(f"{link.where}: still {now.state} after {HOME_S:.0f} s")
    refuse_fault(link)
    control.say(f"home: {now.state}")


def start(control: Control, *, wait: Annotated[bool, Option(argparse.SUPPRESS)] = False) -> None:
    """Cut a part and wait for its end; control-C stops the cut."""
    _order(control, "start")
    control.say(camctl_operate.follow_cut(control.link, control.out))


def _index(name: str) -> int:
    if name not in NUMBERS["parameter"]:
        raise CamtoolsError([f"{name}: no such parameter; tools/camctl list prints all"])
    return NUMBERS["parameter"][name]


def get_parameters(
    control: Control, names: Annotated[tuple[str, ...], Word("parameters; `list` prints all")]
) -> None:
    """Print parameters."""
    for name, index in [(name, _index(name)) for name in names]:
        control.say(f"{name} = {control.ask('get_parameter', index).value:.0f}")


def set_parameter(
    control: Control,
    name: Annotated[str, Word("parameter; `list` prints all")],
    value: Annotated[int, Word("whole number, in the unit of the name", read=whole)],
) -> None:
    """Set a parameter."""
    index = _index(name)
    if not -(2**31) <= value < 2**31:  # what does not fit the message is out of range for sure
        low, high = (control.ask(f"get_{end}", index).value for end in ("minimum", "maximum"))
        what = f"set parameter = {value}"
        raise Refused(f"{what}: out of range; {name} is {low:.0f} .. {high:.0f}")
    answer = control.ask("set_parameter", index, value=value)
    control.say(f"{name} = {answer.value:.0f}")


def list_parameters(
    control: Control,
    pattern: Annotated[str, Word("only names that match, with * and ? (default: all)")] = "*",
) -> None:
    """Print parameters with their ranges."""
    names = [n for n in NUMBERS["parameter"] if fnmatch.fnmatch(n, pattern)]
    if not names:
        raise CamtoolsError([f"{pattern}: no parameter matches; tools/camctl list prints all"])
    for name in names:
        index = NUMBERS["parameter"][name]
        value, low, high = (
            control.ask(f"get_{what}", index).value for what in ("parameter", "minimum", "maximum")
        )
        control.say(f"{name:<34}{value:12.0f}   {low:.0f} .. {high:.0f}")


def status(control: Control) -> None:
    """Print the status."""
    control.say(*report(control.link.listen()))


def watch(
    control: Control,
    *,
    seconds: Seconds = None,
    every: Annotated[
        float | None,
        Option(
            "time between updates (default: 0.1 on a terminal, else 1)", "SECONDS", read=positive
        ),
    ] = None,
) -> None:
    """Live view: angle, U, following error, faults."""
    out = control.out
    is_drawn = out.isatty()
    board = Dashboard(shutil.get_terminal_size().columns)
    due_s, every_s = 0.0, every or (0.1 if is_drawn else 1.0)

    def show(now: Status, t_s: float) -> None:
        nonlocal due_s
        board.add(now)
        if t_s >= due_s:
            due_s = t_s + every_s
            out.write(board.page(now) if is_drawn else f"{line(now)}\n")
            out.flush()

    if is_drawn:
        out.write("\x1b[2J")
    control.follow(seconds, show)


def record(
    control: Control,
    file: Annotated[Path, Word("CSV file to write")],
    *,
    seconds: Seconds = None,
    cut: Annotated[bool, Option("stop at the end of the cut in progress")] = False,
) -> None:
    """Record the status to a CSV file, one row every 10 ms."""
    control.link.listen()  # before a file is touched
    n = 0

    def write(now: Status, t_s: float) -> None:
        nonlocal n
        if n == 0:
            writer.writerow(COLUMNS)
        n += 1
        writer.writerow(row(now, t_s))

    with path_errors(file), growing(file) as stream:
        writer = csv.writer(stream, lineterminator="\n")
        control.follow(seconds, write, lambda now: cut and now.state not in IN_CUT)
    control.say(f"{file}: {n} rows" if n else f"{file}: no rows, not written")
    if cut and control.link.status.faults:
        raise Refused(f"the cut ended in a fault: {', '.join(control.link.status.faults)}")


_TableFile = Annotated[Path, Word("table, NAME.camtab")]


def table_info(control: Control) -> None:
    """Print name, size, CRC-32 and generation of the active table."""
    control.say(*table_report(control.link.listen()))


def table_next(control: Control, file: _TableFile) -> None:
    """Download a table and activate it; also allowed in ready."""
    table_download(control, file, select=True)


def table_download(
    control: Control,
    file: _TableFile,
    *,
    select: Annotated[bool, Option("activate it after the download")] = False,
) -> None:
    """Download and check a table; the active one stays."""
    with path_errors(file):
        image = file.read_bytes()
    check_image(image, str(file))
    last_percent, out = -1, control.out

    def progress(stored: int, seconds: float) -> None:
        nonlocal last_percent
        percent = stored * 100 // len(image)
        if out.isatty() or percent // 10 > last_percent // 10 or stored == len(image):
            end = "\r" if out.isatty() and stored < len(image) else "\n"
            rate = stored / seconds / 1000 if seconds > 0 else 0.0
            out.write(f"{stored} of {len(image)} bytes, {percent} %, {rate:.1f} kB/s{end}")
            out.flush()
        last_percent = percent

    download(control.link, image, progress)
    control.say("downloaded and checked; select activates it")
    if select:
        select_downloaded(control)


def select_downloaded(control: Control) -> None:
    """Activate the downloaded table."""
    select_table(control.link)
    control.say(*table_report(control.link.status))


COMMANDS: Commands = {
    **{name: _plain(name, text) for name, text in _PLAIN.items()},
    "home": home,
    "start": start,
    **{name: _quick(name, text) for name, text in _QUICK.items()},
    "jog": camctl_operate.jog_axis,
    "zero": camctl_operate.zero,
    "tool": camctl_operate.tool,
    "where": camctl_operate.where,
    "override": camctl_operate.override,
    "trim": camctl_operate.trim,
    "parts": camctl_operate.parts,
    "get": get_parameters,
    "set": set_parameter,
    "list": list_parameters,
    "params": Group("save, load, compare or store all parameters", camctl_values.COMMANDS),
    "who": camctl_control.who,
    "unlock": camctl_control.unlock,
    "lock": camctl_control.lock,
    "status": status,
    "watch": watch,
    "record": record,
    "scope": scope,
    "blackbox": blackbox,
    "excite": excite,
    "learned": learned,
    "table": Group(
        "show the active table, or download another one",
        dict[str, Function | Group](info=table_info, next=table_next, download=table_download),
    ),
    "select": select_downloaded,
}


def camctl(bus: BusOptions, rights: RightsOptions) -> None:
    """Command and monitor a camturn controller over CAN."""


def main(argv: Sequence[str] | None = None, out: TextIO | None = None) -> int:
    """Run the command; 0 done, 1 refused or no answer, 2 wrong usage or bad input."""
    given = read_arguments(
        make_parser("tools/camctl", camctl, COMMANDS, epilog=_EPILOG), camctl, argv
    )
    to = sys.stdout if out is None else out

    def act() -> int:
        chosen, arguments = given["chosen"]
        bus, where, node = given["bus"].opened()
        try:
            control = Control(Link(bus, where, node), to)
            with given["rights"].commanding(control.link, node):
                chosen(control, **arguments)
        except Refused as refused:
            sys.stderr.write(f"camctl: {refused}\n")
            return REFUSED
        finally:
            bus.shutdown()
        return 0

    return run_command("camctl", act)


if __name__ == "__main__":
    sys.exit(main())
