# SPDX-License-Identifier: Apache-2.0
"""Subcommands of camctl about who commands, and how camctl takes and keeps command.

>>> parser = Parser(prog="tools/camctl")
>>> add_rights_options(parser)
>>> parser.parse_args(["--sender", "7", "--take-over"]).sender
7
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from camtools.base.command import Interrupted, Parser
from camtools.link.controller import Link
from camtools.link.messages import Refused
from camtools.link.refusal_text import ask_done
from camtools.link.rights import CommandHeld, May, secret_of, sender_of
from camtools.link.rights_report import level_text, name_of, rights_report
from camtools.link.shared_session import SharedSession

Say = Callable[[str], None]
SECRET = "CAMTURN_SECRET"  # of the environment: the file of the secret
_MOST_SENDER = 254
_KEY_S = 60.0  # within which the key is turned
_SETTLE_S = 0.5  # within which the status tells what an order about rights has done


def _sender(text: str) -> int:
    value = int(text)
    if not 1 <= value <= _MOST_SENDER:
        raise argparse.ArgumentTypeError(f"{text}: give 1 .. {_MOST_SENDER}")
    return value


def add_rights_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that tell as whom an order is given."""
    parser.add_argument(
        "--sender",
        type=_sender,
        metavar="N",
        help=f"sender number, 1 .. {_MOST_SENDER} (default: made from user and computer name)",
    )
    parser.add_argument(
        "--take-over",
        action="store_true",
        help="take command even if somebody else has it; that sender is notified",
    )
    parser.add_argument(
        "--secret",
        type=Path,
        metavar="FILE",
        help=f"file of the secret that unlocks the controller (default: ${SECRET}, if set)",
    )


def add_rights(commands: argparse._SubParsersAction[Parser]) -> None:
    """Add the subcommands to the command line."""
    commands.add_parser(
        "who", help="show who has command, and whether the controller is unlocked and acknowledged"
    )
    commands.add_parser(
        "unlock", help="unlock with the secret or the key switch, until control-C or `lock`"
    )
    commands.add_parser("lock", help="lock the controller again")


@contextmanager
def commanding(link: Link, node: int, arguments: argparse.Namespace) -> Iterator[None]:
    """Let the orders of a block take command where they need it, and give it back after them.

    Raises
    ------
    CamtoolsError
        The secret cannot be read.
    Refused
        Another has command.
    """
    rights, given = link.rights, arguments.secret or os.environ.get(SECRET)
    rights.sender = sender_of("camctl") if arguments.sender is None else arguments.sender
    rights.may = May.TAKE_OVER if arguments.take_over else May.IF_FREE
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


def who(link: Link, say: Say) -> None:
    """Print who commands, the level and acknowledge."""
    for line in rights_report(link.listen().signals):
        say(line)


def _level(link: Link) -> str:
    """Return the level of a page of the status that is yet to come."""
    link.status.signals.pop("level", None)
    link.wait(lambda: "level" in link.status.signals, _SETTLE_S)
    return name_of(link.status.signals, "level")


def _await_key(link: Link, say: Say) -> None:
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


def unlock(link: Link, say: Say) -> None:
    """Unlock the controller and keep it so, until control-C or until it is locked again.

    Raises
    ------
    Refused
        The controller refuses, command is lost, or nobody turns the key.
    """
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


def lock(link: Link, say: Say) -> None:
    """End the unlocked level."""
    ask_done(link, "lock")
    _level(link)
    say(f"lock: {name_of(link.status.signals, 'level')}")
