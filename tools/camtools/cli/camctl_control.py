# SPDX-License-Identifier: Apache-2.0
"""What the commands of camctl work with: the link to a controller, and where they print.

>>> from unittest.mock import Mock
>>> import sys
>>> Control(Mock(), sys.stdout).say("ready")
ready
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Sequence
from typing import TextIO

from camtools.base.command import Interrupted
from camtools.link.controller import Link, Status
from camtools.link.messages import Answer, Refused
from camtools.link.refusal_text import ask_done

SECONDS_HELP = "duration (default: until control-C)"


class Control:
    """A controller, and the output of a command."""

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

    def follow(
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
