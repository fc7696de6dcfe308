# SPDX-License-Identifier: Apache-2.0
"""Command line that commands and watches a controller over CAN.

The bus is any of python-can; what is not given comes from CAN_INTERFACE, CAN_CHANNEL, CAN_BITRATE
or its configuration files.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import fnmatch
import shutil
import sys
import time
from collections.abc import Callable, Sequence
from typing import TextIO

from camtools.base.command import Interrupted, run_command
from camtools.base.errors import CamtoolsError
from camtools.base.output import growing
from camtools.cli import camctl_cut, camctl_hand, camctl_rights
from camtools.cli.bus import open_controller
from camtools.cli.camctl_excite import excite, learned
from camtools.cli.camctl_options import PLAIN, QUICK, make_parser
from camtools.cli.camctl_params import params
from camtools.cli.camctl_scope import blackbox, scope_ticks
from camtools.link.controller import Link, Status
from camtools.link.download import check_image, download, select_table
from camtools.link.messages import NUMBERS, Answer, Refused
from camtools.link.refusal_text import ask_done
from camtools.link.settings import set_quick
from camtools.link.status_text import COLUMNS, Dashboard, line, report, row, table_report

REFUSED = 1
HOME_S = 60.0
IN_WORK = ("rehearsing", "engaging", "cutting", "holding", "disengaging")


class Control:
    """What the subcommands do, over one link."""

    def __init__(self, link: Link, out: TextIO) -> None:
        self.link, self.out = link, out

    def say(self, text: str) -> None:
        """Print a line, at once."""
        self.out.write(f"{text}\n")
        self.out.flush()

    def ask(self, command: str, parameter: int = 0, **value: float) -> Answer:
        """Send a command that must be accepted.

        Raises
        ------
        Refused
            It is not.
        CamtoolsError
            The value is outside the range of its signal.
        """
        return ask_done(self.link, command, parameter, **value)

    def wait_state(self, wanted: Sequence[str], timeout_s: float) -> str:
        """Wait for one of some states; a fault is refused."""
        status = self.link.status
        self.link.listen()
        if not self.link.wait(lambda: status.state in (*wanted, "fault"), timeout_s):
            raise Refused(f"{self.link.where}: still {status.state} after {timeout_s:.0f} s")
        if status.state == "fault":
            self.link.wait(lambda: bool(status.faults), 0.1)
            raise Refused(f"fault: {', '.join(status.faults)}; see status, then reset")
        return status.state

    # Subcommands

    def plain(self, arguments: argparse.Namespace) -> None:
        """Carry out a command without a value."""
        command: str = arguments.command
        if command == "home" and arguments.axis:
            camctl_hand.home_axis(self.link, arguments.axis, self.say)
            return
        self.ask(command)
        # The state of before is in the status until the next tick's.
        self.link.wait(lambda: False, 0.05)
        self.link.status.signals.pop("state", None)
        if command == "home":
            self.wait_state(["ready"], HOME_S)
        elif command == "start":
            self.say(camctl_cut.follow_cut(self.link, self.out))
            return
        self.say(f"{command}: {self.link.listen().state}")

    def quick(self, arguments: argparse.Namespace) -> None:
        """Set speed, feed, amplitude or phase."""
        self.say(set_quick(self.link, arguments.command, arguments.value))

    def _index(self, name: str) -> int:
        if name not in NUMBERS["parameter"]:
            raise CamtoolsError([f"{name}: no such parameter; tools/camctl list prints all"])
        return NUMBERS["parameter"][name]

    def get(self, arguments: argparse.Namespace) -> None:
        """Print parameters."""
        indices = [self._index(name) for name in arguments.names]
        for name, index in zip(arguments.names, indices, strict=True):
            self.say(f"{name} = {self.ask('get_parameter', index).value:.0f}")

    def set(self, arguments: argparse.Namespace) -> None:
        """Set a parameter; what does not fit the message is out of range for sure."""
        index = self._index(arguments.name)
        if not -(2**31) <= arguments.value < 2**31:
            low, high = (self.ask(f"get_{end}", index).value for end in ("minimum", "maximum"))
            what = f"set parameter = {arguments.value}"
            raise Refused(f"{what}: out of range; {arguments.name} is {low:.0f} .. {high:.0f}")
        answer = self.ask("set_parameter", index, value=arguments.value)
        self.say(f"{arguments.name} = {answer.value:.0f}")

    def list(self, arguments: argparse.Namespace) -> None:
        """Print parameters with their ranges."""
        names = [n for n in NUMBERS["parameter"] if fnmatch.fnmatch(n, arguments.pattern)]
        if not names:
            raise CamtoolsError(
                [f"{arguments.pattern}: no parameter matches; tools/camctl list prints all"]
            )
        for name in names:
            index = NUMBERS["parameter"][name]
            value, low, high = (
                self.ask(f"get_{what}", index).value for what in ("parameter", "minimum", "maximum")
            )
            self.say(f"{name:<34}{value:12.0f}   {low:.0f} .. {high:.0f}")

    def status(self, _arguments: argparse.Namespace) -> None:
        """Print all of the status."""
        for text in report(self.link.listen()):
            self.say(text)

    def _follow(
        self,
        seconds: float | None,
        on_row: Callable[[Status, float], None],
        is_over: Callable[[Status], bool] = lambda status: False,
    ) -> None:
        """Call for every row of status, until it is over, time is up or the user interrupts."""
        start_s = time.monotonic()
        self.link.listen()
        self.link.on_row = lambda status: on_row(status, time.monotonic() - start_s)
        with contextlib.suppress(Interrupted):
            while not is_over(self.link.status) and (
                seconds is None or time.monotonic() - start_s < seconds
            ):
                if not self.link.next_row(2.0):
                    raise Refused(f"{self.link.where}: the status stopped; is the controller on?")

    def watch(self, arguments: argparse.Namespace) -> None:
        """Draw the dashboard, or print lines where the output is no terminal."""
        is_drawn = self.out.isatty()
        board = Dashboard(shutil.get_terminal_size().columns)
        due_s, every_s = 0.0, arguments.every or (0.1 if is_drawn else 1.0)

        def show(status: Status, t_s: float) -> None:
            nonlocal due_s
            board.add(status)
            if t_s >= due_s:
                due_s = t_s + every_s
                self.out.write(board.page(status) if is_drawn else f"{line(status)}\n")
                self.out.flush()

        if is_drawn:
            self.out.write("\x1b[2J")
        self._follow(arguments.seconds, show)

    def record(self, arguments: argparse.Namespace) -> None:
        """Write the status into a CSV file, a row every 10 ms."""
        self.link.listen()  # before a file is touched
        n = 0

        def write(status: Status, t_s: float) -> None:
            nonlocal n
            if n == 0:
                writer.writerow(COLUMNS)
            n += 1
            writer.writerow(row(status, t_s))

        def is_over(status: Status) -> bool:
            return arguments.cut and status.state not in IN_WORK

        try:
            with growing(arguments.file) as file:
                writer = csv.writer(file, lineterminator="\n")
                self._follow(arguments.seconds, write, is_over)
        except OSError as error:
            raise CamtoolsError([f"{arguments.file}: {error.strerror}; check the path"]) from error
        self.say(f"{arguments.file}: {n} rows" if n else f"{arguments.file}: no rows, not written")
        if arguments.cut and self.link.status.faults:
            raise Refused(f"the cut ended in a fault: {', '.join(self.link.status.faults)}")

    def table(self, arguments: argparse.Namespace) -> None:
        """Print what is known about the table in use, or download another one."""
        if arguments.table == "info":
            for text in table_report(self.link.listen()):
                self.say(text)
            return
        try:
            image = arguments.file.read_bytes()
        except OSError as error:
            raise CamtoolsError([f"{arguments.file}: {error.strerror}; check the path"]) from error
        check_image(image, str(arguments.file))
        self._download(image)
        if arguments.table == "next" or arguments.select:
            self.select(arguments)

    def _download(self, image: bytes) -> None:
        last_percent = -1

        def progress(stored: int, seconds: float) -> None:
            nonlocal last_percent
            percent = stored * 100 // len(image)
            if self.out.isatty() or percent // 10 > last_percent // 10 or stored == len(image):
                end = "\r" if self.out.isatty() and stored < len(image) else "\n"
                rate = stored / seconds / 1000 if seconds > 0 else 0.0
                self.out.write(f"{stored} of {len(image)} bytes, {percent} %, {rate:.1f} kB/s{end}")
                self.out.flush()
            last_percent = percent

        download(self.link, image, progress)
        self.say("downloaded and checked; select activates it")

    def select(self, _arguments: argparse.Namespace) -> None:
        """Take the downloaded table into use, or check the one in its place anew."""
        select_table(self.link)
        for text in table_report(self.link.status):
            self.say(text)

    def override(self, arguments: argparse.Namespace) -> None:
        """Set or print an override."""
        camctl_cut.override(self.link, arguments, self.say)

    def trim(self, arguments: argparse.Namespace) -> None:
        """Set or print the trim of X."""
        camctl_cut.trim(self.link, arguments, self.say)

    def parts(self, arguments: argparse.Namespace) -> None:
        """Set or print the number of parts."""
        camctl_cut.parts(self.link, arguments, self.say)

    def jog(self, arguments: argparse.Namespace) -> None:
        """Move an axis by hand."""
        camctl_hand.jog_axis(self.link, arguments, self.say)

    def zero(self, arguments: argparse.Namespace) -> None:
        """Say where the tool is."""
        camctl_hand.zero(self.link, arguments, self.say)

    def tool(self, arguments: argparse.Namespace) -> None:
        """Print, set or choose tools."""
        camctl_hand.tool(self.link, arguments, self.say)

    def where(self, _arguments: argparse.Namespace) -> None:
        """Print where the axes are."""
        camctl_hand.where(self.link, self.say)

    def excite(self, arguments: argparse.Namespace) -> None:
        """Let U play a wave and write what was recorded."""
        excite(self.link, arguments, self.say)

    def scope(self, arguments: argparse.Namespace) -> None:
        """Record signals of ticks, write and draw them."""
        scope_ticks(self.link, arguments, self.say)

    def blackbox(self, arguments: argparse.Namespace) -> None:
        """Tell, read or clear what was recorded before a fault."""
        blackbox(self.link, arguments, self.say)

    def params(self, arguments: argparse.Namespace) -> None:
        """Save, load or compare all parameters, or change what the controller keeps."""
        params(self.link, arguments, self.say)

    def who(self, _arguments: argparse.Namespace) -> None:
        """Print who commands."""
        camctl_rights.who(self.link, self.say)

    def unlock(self, _arguments: argparse.Namespace) -> None:
        """Unlock the controller, and stay."""
        camctl_rights.unlock(self.link, self.say)

    def lock(self, _arguments: argparse.Namespace) -> None:
        """Lock the controller."""
        camctl_rights.lock(self.link, self.say)

    def learned(self, arguments: argparse.Namespace) -> None:
        """Print, save or bring back what the controller has learned."""
        learned(self.link, arguments, self.say)


def _run(arguments: argparse.Namespace, out: TextIO) -> int:
    bus, where, node = open_controller(arguments)
    try:
        control = Control(Link(bus, where, node), out)
        command: str = arguments.command
        group = "plain" if command in PLAIN else "quick" if command in QUICK else command
        with camctl_rights.commanding(control.link, node, arguments):
            getattr(control, group)(arguments)
    except Refused as refused:
        sys.stderr.write(f"camctl: {refused}\n")
        return REFUSED
    finally:
        bus.shutdown()
    return 0


def main(argv: Sequence[str] | None = None, out: TextIO | None = None) -> int:
    """Run the command; 0 done, 1 refused or no answer, 2 wrong usage or bad input."""
    arguments = make_parser().parse_args(argv)
    to = sys.stdout if out is None else out
    return run_command("camctl", lambda: _run(arguments, to))


if __name__ == "__main__":
    sys.exit(main())
