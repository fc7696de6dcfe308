"""Who looks at the panel, who of them commands, and the log of what was commanded.

The file of the log is its owner's alone. At 4 MB it gets the name FILE.1, that one FILE.2, and what
was before is gone.

>>> commander = Commander(CommandLog(None))
>>> first, second = Visitor("v1"), Visitor("v2")
>>> commander.take(first).is_done, commander.take_over(second).is_done
(True, True)
>>> commander.news(first)[:17]
'page v2 took over'
"""

import errno
import fcntl
import itertools
import json
import os
import threading
import time
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from io import FileIO
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

from camtools.base.errors import CamtoolsError
from camtools.panel.orders.order import Outcome

_numbers = itertools.count(1)


@dataclass(eq=False)
class Visitor:
    """An open page; the server makes it, no message of a browser can name another."""

    id: str  # short name, shown and logged; it opens nothing
    is_here: bool = True  # whether the page's connection stands
    was_connected: bool = False  # whether it has stood before
    n_losses: int = 0  # how often it was lost
    # When the connection stood again after a loss [s of time.monotonic]; what the browser had kept
    # back meanwhile arrives right after it.
    back_at_s: float = -1e9

    def __str__(self) -> str:
        return f"page {self.id}"


def new_visitor() -> Visitor:
    """Return the visitor of a page that was just opened."""
    return Visitor(f"v{next(_numbers)}")


KEPT = 200
MOST_BYTES = 4 << 20
_OWN = 0o600


def utc(seconds: float) -> str:
    """Return a time [s of time.time] as people read it."""
    return datetime.fromtimestamp(seconds, UTC).strftime("%Y-%m-%d %H:%M:%S UTC")


def _open(path: Path) -> FileIO:
    path.parent.mkdir(parents=True, exist_ok=True)
    stream = FileIO(os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, _OWN), "a")
    try:
        os.fchmod(stream.fileno(), _OWN)
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        stream.close()
        raise
    return stream


class CommandLog:
    """Lines of commands in a file and, the newest of them, in memory; from any thread.

    Raises CamtoolsError where the file cannot be written, or another panel writes it.
    """

    def __init__(self, path: Path | None, most_bytes: int = MOST_BYTES) -> None:
        self._path, self._most_bytes = path, most_bytes
        self._lock = threading.Lock()
        self._newest: deque[dict[str, Any]] = deque(maxlen=KEPT)
        self._stream: FileIO | None = None
        self.problem, self._is_broken = "", False
        if path is not None:
            try:
                self._stream = _open(path)
            except OSError as error:
                is_taken = isinstance(error, BlockingIOError)
                problem = "another panel writes it" if is_taken else error.strerror
                raise CamtoolsError([f"{path}: {problem}; give another --log"]) from error

    def add(
        self, visitor: Visitor, order: str, arguments: Mapping[str, Any], outcome: Outcome
    ) -> None:
        """Log an order and what came of it."""
        record = {
            "time": utc(time.time()),
            "visitor": visitor.id,
            "order": str(order)[:40],
            "arguments": dict(arguments),
            "is_done": outcome.is_done,
            "outcome": outcome.text,
        }
        with self._lock:
            self._newest.append(record)
            self._write(record)

    def newest(self, n: int) -> list[dict[str, Any]]:
        """Return the newest records, the newest first."""
        with self._lock:
            return list(self._newest)[: -n - 1 : -1]

    def close(self) -> None:
        """Close the file."""
        with self._lock:
            if self._stream is not None:
                self._stream.close()
                self._stream = None

    def _write(self, record: Mapping[str, Any]) -> None:
        """Append a line; a full disk stops no machine, but is reported."""
        if self._stream is None or self._path is None:
            return
        line = json.dumps(record).encode() + b"\n"
        try:
            if self._stream.tell() + len(line) > self._most_bytes:
                self._rotate(self._path)
            if self._is_broken:  # the half of a line stands alone
                line = b"\n" + line
            n_written = self._stream.write(line)
            self._is_broken = n_written != len(line) and (self._is_broken or n_written > 0)
            if n_written != len(line):
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            self.problem = ""
        except OSError as error:
            self.problem = f"{self._path}: {error.strerror}: commands are not logged"

    def _rotate(self, path: Path) -> None:
        first, second = (path.with_name(f"{path.name}.{i}") for i in (1, 2))
        if path.exists():  # not when it was moved before, and a new one could not be opened
            if first.exists():
                first.replace(second)
            path.replace(first)
        old, self._stream = self._stream, _open(path)
        self._is_broken = False
        if old is not None:
            old.close()


class Commander:
    """The right to command, which one visitor has or none; every change is logged.

    When the page of the commander goes, it is free again, and the page shows that nobody commands.
    The panel then gives command over the controller back, by which a cut ends (link_thread.py).
    """

    def __init__(self, log: CommandLog) -> None:
        self._log = log
        self._lock = threading.Lock()
        self.holder: Visitor | None = None  # who commands
        self.since_s = 0.0  # when the holder took the command [s of time.time]
        self._news: WeakKeyDictionary[Visitor, str] = WeakKeyDictionary()

    def news(self, visitor: Visitor) -> str:
        """Return who took the command from a visitor, and when; "" when nobody did."""
        return self._news.get(visitor, "")

    def take(self, visitor: Visitor) -> Outcome:
        """Take the command when nobody has it."""
        with self._lock:
            if self.holder in (None, visitor):
                outcome = self._give(visitor)
            else:
                why = f"{self.holder} commands; take over to command yourself"
                outcome = Outcome(False, why)
        return self._log_change("take", visitor, outcome)

    def take_over(self, visitor: Visitor) -> Outcome:
        """Take the command from whoever has it; the loser's page shows it."""
        with self._lock:
            loser = self.holder
            outcome = self._give(visitor)
            if loser is not None and loser is not visitor:
                at = utc(self.since_s)
                self._news[loser] = f"{visitor} took over command at {at}"
                outcome = Outcome(True, f"taken over from {loser}")
        return self._log_change("take_over", visitor, outcome)

    def _give(self, visitor: Visitor) -> Outcome:
        self.holder, self.since_s = visitor, time.time()
        self._news.pop(visitor, None)
        return Outcome(True, "you command")

    def release(self, visitor: Visitor) -> Outcome:
        """Give the command back."""
        with self._lock:
            is_held = self.holder is visitor
            if is_held:
                self.holder = None
        text = "nobody commands" if is_held else "you do not command"
        return self._log_change("release", visitor, Outcome(is_held, text))

    def lose(self, visitor: Visitor, why: str = "the page was closed") -> None:
        """Take note that a page is gone; if it commanded, nobody does, and it shows why."""
        with self._lock:
            if self.holder is not visitor:
                return
            self.holder = None
            self._news[visitor] = f"{why}: nobody commands ({utc(time.time())})"
        self._log_change("lose", visitor, Outcome(True, f"{why}: nobody commands"))

    def pass_on(self, before: Visitor, visitor: Visitor) -> None:
        """Give the command of a page that is gone to the one that was loaded in its place."""
        with self._lock:
            if self.holder is not before or before.is_here:
                return
            self.holder = visitor
        self._log_change("pass_on", visitor, Outcome(True, f"the page of {before} was loaded anew"))

    def lose_on_bus(self, why: str, sender: int) -> None:
        """Take note that the panel lost command over the controller; the holder's page shows it.

        Where nobody else has it, as when the panel was stopped for a second, the holder keeps it.
        """
        with self._lock:
            loser = self.holder
            if loser is None:
                return
            self.holder = None if sender else loser
            self._news[loser] = f"{why} ({utc(time.time())})"
        self._log_change("lose", loser, Outcome(True, why))

    def _log_change(self, what: str, visitor: Visitor, outcome: Outcome) -> Outcome:
        self._log.add(visitor, what, {}, outcome)
        return outcome
