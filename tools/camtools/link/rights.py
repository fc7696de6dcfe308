"""Command over a controller: one sender has it, his heartbeat keeps it, the others read.

What the controller demands stands in firmware/param/cam_param.h. A link reads without command.
Before its first order that needs command it takes it, if it may.

>>> sender_of("camctl") in range(1, 255), sender_of("camctl") != sender_of("panel")
(True, True)

While one camctl cuts a part, a second one of the same user may hold the feed: it is the same
sender, so it gives its orders in the same session. Another user, or another --sender, is another.

>>> import tempfile
>>> folder = Path(tempfile.mkdtemp())
>>> mine = SharedSession("virtual demo", 64, 12, folder)
>>> mine.write(7), mine.read(), SharedSession("virtual demo", 64, 13, folder).read()
(None, 7, 0)
>>> mine.write(0), mine.read()
(None, 0)
"""

from __future__ import annotations

import getpass
import json
import os
import socket
import time
import zlib
from collections.abc import Callable
from contextlib import suppress
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING

from camtools.link.live_lathes import runtime_folder, start_of
from camtools.link.messages import NOT_COMMANDER, OLDER, Answer, Refused

if TYPE_CHECKING:
    from camtools.link.controller import Link

BEAT_S, BEAT_ROWS = 0.25, 25  # between heartbeats, by the clock and by the controller's status
LOSS_S = 1.0  # after so long without one command is lost
_PROGRAMS = ("camctl", "panel")
_FREE = ("stop", "take_command")  # and reading: whoever asks
_BUSY_S = 0.1
_KEY_S = 0.5  # in which a key counts that is turned at the sight of a new commander


class CommandLost(Refused):
    """Command was taken over, or lost for want of heartbeats."""


class CommandHeld(Refused):
    """Another has command."""

    def __init__(self, text: str, holder: int) -> None:
        super().__init__(text)
        self.holder = holder


class May(Enum):
    """Whether command may be taken by the first order that needs it."""

    NEVER = "never"
    IF_FREE = "if nobody has it"
    TAKE_OVER = "also from another"


def sender_of(program: str) -> int:
    """Return the number by which a program of this user on this computer is known, 1 .. 254."""
    try:
        user = getpass.getuser()
    except (KeyError, OSError):  # a user without a name
        user = ""
    return zlib.crc32(f"{program} {user} {socket.gethostname()}".encode()) % 254 + 1


def sender_text(sender: int) -> str:
    """Return a sender for people; those of this user on this computer have a name."""
    own = {sender_of(program): program for program in _PROGRAMS}
    return f"sender {sender}" + (f" ({own[sender]} of this user)" if sender in own else "")


class Rights:
    """Whether this link commands, and how it keeps that.

    on_lost: called with why command was lost and who has it now, 0: nobody; by default CommandLost
    is raised from whatever waits. on_change: called whenever `session` has changed. joined: returns
    the session of another process of this sender; 0: there is none.
    """

    def __init__(self, link: Link, sender: int) -> None:
        self._link, self.sender = link, sender
        self.may = May.IF_FREE
        self.session = 0  # in which this link commands; 0: it does not
        self.on_lost: Callable[[str, int], None] = _raise_lost
        self.on_change: Callable[[], None] = lambda: None
        self.joined: Callable[[], int] = lambda: 0
        self.is_joined = self._was_joined = False  # whether the session is that of another process
        self._sent_s, self._sent_rows, self._n_heard = 0.0, 0, 0
        self._begun_s = 0.0

    def share(self, node: int) -> None:
        """Share the session at a node with other processes of this user and sender."""
        shared = SharedSession(self._link.where, node, self.sender)
        self.joined = shared.read
        self.on_change = lambda: shared.write(self.session)

    # Frames

    def stamp(self, command: str) -> dict[str, int]:
        """Return sender and session of a command that is about to be sent."""
        if not self.session:
            return {"sender": self.sender} if command == "take_command" else {}
        self._sent_s, self._sent_rows = time.monotonic(), self._link.status.n_rows
        return {"sender": self.sender, "session": self.session}

    def beat(self) -> None:
        """Send a heartbeat when one is due, by the clock or by the controller's own time."""
        if not self.session:
            return
        n_rows = self._link.status.n_rows - self._sent_rows
        if n_rows >= BEAT_ROWS or time.monotonic() - self._sent_s >= BEAT_S:
            self._link.send_command("heartbeat", parameter=self.session)

    def confirm(self) -> None:
        """Find out whether this link still commands, which frames kept back hide (CommandLost)."""
        if self.session:
            n_heard = self._n_heard
            self._link.send_command("heartbeat", parameter=self.session)
            self._link.wait(lambda: self._n_heard != n_heard, LOSS_S)

    def heard(self, answer: Answer) -> None:
        """Take note of the answer to a heartbeat; everybody on the bus hears those to others."""
        is_own = self.session != 0 and answer.parameter == self.session
        self._n_heard += is_own
        if answer.result == NOT_COMMANDER and is_own:
            self._lose(int(answer.value))

    # Orders

    def prepare(self, command: str) -> None:
        """Take command before an order that needs it, where this link may (else CommandHeld)."""
        is_free = command in _FREE or command.startswith(("get_", "read_"))
        if not is_free and not self.session and self.may is not May.NEVER:
            self._mend_command(0)

    def mend(self, answer: Answer) -> bool:
        """Take command, or wait for the key, where an order was refused for want of it.

        Returns whether to give the order again. Raises CommandHeld: another has command;
        CommandLost: this link had it.
        """
        if answer.result == NOT_COMMANDER:
            return self._mend_command(int(answer.value))
        return answer.result == "locked" and self._awaits_key()

    def _awaits_key(self) -> bool:
        """Wait a moment, in which somebody may turn the key for the session that has begun."""
        is_new = self.session != 0 and time.monotonic() < self._begun_s + _KEY_S
        if is_new and not self.is_joined:
            self._link.wait(lambda: False, _BUSY_S)
            return True
        return False

    def _mend_command(self, holder: int) -> bool:
        if self.session and holder == self.sender:
            return True  # the answer was another's; if not, the next heartbeat shows it
        if self.session and not self.is_joined:
            self._lose(holder)
            return False
        self.is_joined = False
        if not self.session and not self._was_joined and (session := self.joined()):
            self._begin(session, is_joined=True)
            self._was_joined = True
            return True
        self.session = 0
        if self.may is May.NEVER:
            return False
        self.take(over=self.may is May.TAKE_OVER)
        return True

    def take(self, *, over: bool = False) -> None:
        """Take command, or take it over from whoever has it; CommandHeld where another has it."""
        self.session = 0
        answer = self._own("take_command", is_take_over=int(over))
        if answer.result == NOT_COMMANDER:
            holder = int(answer.value)
            raise CommandHeld(f"{self._link.where}: {sender_text(holder)} commands", holder)
        if answer.result != "done":
            words = {"command": OLDER, "busy": "busy; try again"}.get(answer.result)
            raise Refused(f"take command: refused: {words or answer.result.replace('_', ' ')}")
        self._begin(int(answer.value))
        self._change()

    def release(self) -> None:
        """Give command back where this link took it; without heartbeats it is lost in any case."""
        if self.session and not self.is_joined:
            with suppress(Refused):
                self._own("release_command")
            self._end()

    def _own(self, command: str, **value: float) -> Answer:
        """Ask with the sender as the mark by which its own answer is known."""
        return self._link.ask_once(command, parameter=self.sender, echo=self.sender, **value)

    def _begin(self, session: int, *, is_joined: bool = False) -> None:
        self.session, self.is_joined = session, is_joined
        self._sent_s, self._sent_rows = time.monotonic(), self._link.status.n_rows
        self._begun_s = self._sent_s

    def _change(self) -> None:
        self._link.status.signals.pop("commander", None)  # the page of before
        self.on_change()

    def _end(self) -> None:
        """Forget the session; the end of one that was joined is reported by its owner."""
        is_own = self.session != 0 and not self.is_joined
        self.session, self.is_joined = 0, False
        if is_own:
            self._change()

    def _lose(self, holder: int) -> None:
        self._end()
        by = f"{sender_text(holder)} has taken it over; running motion continues"
        silent = (
            "the controller heard nothing from here in time, or somebody else took it and gave it "
            "back; nobody has it now, so a running cut ends"
        )
        self.on_lost(f"{self._link.where}: command is lost: {by if holder else silent}", holder)


def _raise_lost(text: str, _holder: int) -> None:
    raise CommandLost(text)


class SharedSession:
    """The file of the session of a sender at a controller.

    where: name of the bus in messages; folder: accessible to this user alone, by default that of
    the live lathes.
    """

    def __init__(self, where: str, node: int, sender: int, folder: Path | None = None) -> None:
        bus = zlib.crc32(where.encode())
        home = runtime_folder() if folder is None else folder
        self._path = home / f"command-{bus:08x}-{node}-{sender}.session"

    def write(self, session: int) -> None:
        """Write the session of this process; 0 removes what this process wrote."""
        own = {"session": session, "pid": os.getpid(), "start": start_of(os.getpid())}
        with suppress(OSError):  # without the file the others take command themselves
            if session:
                hidden = self._path.with_suffix(f".{os.getpid()}")
                hidden.write_text(json.dumps(own), "utf-8")
                hidden.replace(self._path)
            elif self._read().get("pid") == os.getpid():
                self._path.unlink()

    def read(self) -> int:
        """Return the session that a live process has written; 0: there is none."""
        facts = self._read()
        pid, session = facts.get("pid"), facts.get("session")
        if not isinstance(pid, int) or not isinstance(session, int):
            return 0
        if not facts.get("start") or start_of(pid) != facts["start"]:
            with suppress(OSError):
                self._path.unlink()  # its process was killed
            return 0
        return session if 0 < session < 256 else 0

    def _read(self) -> dict[str, object]:
        try:
            facts = json.loads(self._path.read_text("utf-8"))
        except (OSError, ValueError):
            return {}
        return facts if isinstance(facts, dict) else {}
