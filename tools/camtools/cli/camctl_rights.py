# SPDX-License-Identifier: Apache-2.0
"""Commands of camctl about who commands, and how camctl takes and keeps command.

>>> RightsOptions(sender=7, take_over=True).sender
7
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from camtools.base.arguments import Option, whole_within
from camtools.base.command import Interrupted
from camtools.cli.camctl_control import Control
from camtools.link.controller import Link
from camtools.link.messages import Refused
from camtools.link.refusal_text import ask_done
from camtools.link.rights import CommandHeld, May, secret_of, sender_of
from camtools.link.rights_report import level_text, name_of, rights_report
from camtools.link.shared_session import SharedSession

SECRET = "CAMTURN_SECRET"  # of the environment: the file of the secret
_MOST_SENDER = 254
_KEY_S = 60.0  # within which the key is turned
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
    secret: Annotated[
        Path | None,
        Option(
            f"file of the secret that unlocks the controller (default: ${SECRET}, if set)", "FILE"
        ),
    ] = None

    @contextmanager
    def commanding(self, link: Link, node: int) -> Iterator[None]:
        """Let the orders of a block take command where they need it, and give it back after them.

        Raises
        ------
        CamtoolsError
            The secret cannot be read.
        Refused
            Another has command.
        """
        rights, given = link.rights, self.secret or os.environ.get(SECRET)
        rights.sender = sender_of("camctl") if self.sender is None else self.sender
        rights.may = May.TAKE_OVER if self.take_over else May.IF_FREE
        if given:
            rights.secret = secret_of(Path(given))
        shared = SharedSession(link.where, node, rights.sender)
        rights.joined = shared.read
        rights.on_change = lambda: shared.tell(rights.session)
        try:
            yield
        except CommandHeld as held:
            remedy = "wait until it is given back, or use --take-over"
            raise Refused(f"{held}; {remedy}") from held
        finally:
            rights.release()


def who(control: Control) -> None:
    """Show who has command, and whether the controller is unlocked and acknowledged."""
    for line in rights_report(control.link.listen().signals):
        control.say(line)


def _level(link: Link) -> str:
    """Return the level of a page of the status that is yet to come."""
    link.status.signals.pop("level", None)
    link.wait(lambda: "level" in link.status.signals, _SETTLE_S)
    return name_of(link.status.signals, "level")


def _await_key(link: Link, say: Callable[[str], None]) -> None:
    """Take command, and wait until somebody turns the key for it."""
    if link.ask("get_challenge").result == "lock_none":  # which takes command, too
        raise Refused(
            "unlock: the port has neither a secret nor a key switch; add one to its settings"
        )
    say(f"unlock: turn the key switch at the machine off and on, within {_KEY_S:.0f} s")
    end_s = time.monotonic() + _KEY_S
    while _level(link) == "locked":
        if time.monotonic() > end_s:
            remedy = f"give --secret FILE, or set {SECRET}, where the port has a secret"
            raise Refused(f"unlock: nobody turned the key switch; {remedy}")


def unlock(control: Control) -> None:
    """Unlock with the secret or the key switch, until control-C or `lock`.

    Raises
    ------
    Refused
        The controller refuses, command is lost, or nobody turns the key.
    """
    link, say = control.link, control.say
    if link.rights.secret is not None:
        link.rights.unlock()
        _level(link)
    else:
        _await_key(link, say)
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
