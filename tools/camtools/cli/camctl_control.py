"""What the commands of camctl work with: the link, command over the controller, where they print.

>>> from unittest.mock import Mock
>>> import sys
>>> Control(Mock(), sys.stdout).say("ready")
ready
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Annotated, TextIO

from camtools.base.arguments import Option, positive, whole_within
from camtools.base.signals import Interrupted
from camtools.link.controller import Link, Status
from camtools.link.messages import Answer, Refused
from camtools.link.refusal_text import ask_done
from camtools.link.rights import CommandHeld, May, sender_of
from camtools.link.status_text import level_text, name_of, rights_report

Seconds = Annotated[float | None, Option("duration (default: until control-C)", read=positive)]


class Control:
    """A controller, and the output of a command."""

    def __init__(self, link: Link, out: TextIO) -> None:
        self.link, self.out = link, out

    def say(self, *lines: str) -> None:
        """Print lines, at once."""
        self.out.writelines(f"{line}\n" for line in lines)
        self.out.flush()

    def ask(self, command: str, parameter: int = 0, **value: float) -> Answer:
        """Send a command that must be accepted; return its answer."""
        return ask_done(self.link, command, parameter, **value)

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


_STANDING_RPM = 1.0
_OF_SENSE = {"reverse", "spindle_stopped"}  # the latter while homing


def refuse_fault(link: Link) -> None:
    """Raise Refused in the state fault; the status has the remedies."""
    if link.status.state == "fault":
        link.wait(lambda: bool(link.status.faults), 0.1)
        faults, rpm = link.status.faults, link.status.signals.get("speed", 0.0)
        cause = ""
        if rpm < -_STANDING_RPM and _OF_SENSE & set(faults):
            cause = f" (the spindle turns at {rpm:.0f} r/min, against the sense of cutting)"
        raise Refused(f"fault: {', '.join(faults)}{cause}; see status, then reset")


_MOST_SENDER = 254
_KEY_S = 60.0  # within which the key is turned
_NO_VALUE = 255  # no learned value has this number
_SETTLE_S = 0.5  # within which the status tells what an order about rights has done


@dataclass(frozen=True)
class RightsOptions:
    """As whom an order is given."""

    sender: Annotated[
        int | None,
        Option(
            f"sender number, 1 .. {_MOST_SENDER} (default: made from user and computer name)",
            "N",
            read=whole_within(1, _MOST_SENDER),
        ),
    ] = None
    take_over: Annotated[
        bool, Option("take command even if somebody else has it; that sender is notified")
    ] = False

    @contextmanager
    def commanding(self, link: Link, node: int) -> Iterator[None]:
        """Let the orders of a block take command where they need it; give it back after them."""
        rights = link.rights
        rights.sender = sender_of("camctl") if self.sender is None else self.sender
        rights.may = May.TAKE_OVER if self.take_over else May.IF_FREE
        rights.share(node)
        try:
            yield
        except CommandHeld as held:
            remedy = "wait until it is given back, or use --take-over"
            raise Refused(f"{held}; {remedy}") from held
        finally:
            rights.release()


def who(control: Control) -> None:
    """Show who has command, and whether the controller is unlocked and acknowledged."""
    control.say(*rights_report(control.link.listen().signals))


def _level(link: Link) -> str:
    link.await_anew("level", _SETTLE_S)
    return name_of(link.status.signals, "level")


def unlock(control: Control) -> None:
    """Take command, wait for the key switch, and stay unlocked until control-C or `lock`."""
    link, say = control.link, control.say
    # set_learned needs command and the unlocked level: it takes command, and its refusal shows
    # whether the port has a key switch.
    if link.ask("set_learned", parameter=_NO_VALUE).result == "lock_none":
        raise Refused("unlock: the port has no key switch; add one to its settings")
    say(f"unlock: turn the key switch at the machine off and on, within {_KEY_S:.0f} s")
    end_s = time.monotonic() + _KEY_S
    while _level(link) == "locked":
        if time.monotonic() > end_s:
            raise Refused("unlock: nobody turned the key switch")
    say(f"unlock: {level_text(link.listen().signals)}; control-C locks")
    try:
        while _level(link) != "locked":
            link.wait(lambda: False, _SETTLE_S)
    except Interrupted:
        ask_done(link, "lock")
    say("unlock: locked again")


def lock(control: Control) -> None:
    """Lock the controller again."""
    control.ask("lock")
    control.say(f"lock: {_level(control.link)}")
