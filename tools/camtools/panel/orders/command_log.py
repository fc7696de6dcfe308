# SPDX-License-Identifier: Apache-2.0
"""The log of commands: JSON lines that tell when, who, what, and what came of it.

The file is its owner's alone. At 4 MB it gets the name FILE.1, that one FILE.2, and what was before
is gone.

>>> from camtools.panel.orders.visitor import Visitor
>>> log = CommandLog(None)
>>> log.add(Visitor("v1"), "start", {}, Outcome(False, "refused: state off"))
>>> log.newest(1)[0]["order"], log.newest(1)[0]["is_done"]
('start', False)
"""

from __future__ import annotations

import errno
import fcntl
import json
import os
import threading
import time
from collections import deque
from collections.abc import Mapping
from datetime import UTC, datetime
from io import FileIO
from pathlib import Path
from typing import Any

from camtools.base.errors import CamtoolsError
from camtools.panel.orders.order import Outcome
from camtools.panel.orders.visitor import Visitor

KEPT = 200
MOST_BYTES = 4 << 20
_OWN = 0o600


def utc(seconds: float) -> str:
    """Return a time [s of time.time] as people read it."""
    return datetime.fromtimestamp(seconds, UTC).strftime("%Y-%m-%d %H:%M:%S UTC")


def _open(path: Path) -> FileIO:
    """Open a log for this process alone."""
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

    Parameters
    ----------
    path : Path or None
        of the file; None: in memory only

    Raises
    ------
    CamtoolsError
        It cannot be written, or another panel writes it.
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
            except BlockingIOError as error:
                problem = "another panel writes it; give another --log"
                raise CamtoolsError([f"{path}: {problem}"]) from error
            except OSError as error:
                raise CamtoolsError([f"{path}: {error.strerror}; give another --log"]) from error

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
        """Append a line; a full disk stops no machine, but is told."""
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
