# SPDX-License-Identifier: Apache-2.0
"""The log of commands: JSON lines that tell when, who, what, and what came of it.

>>> from camtools.panel.visitor import Visitor
>>> log = CommandLog(None)
>>> log.add(Visitor("v1", "127.0.0.1"), "start", {}, Outcome(False, "commands need the token"))
>>> log.newest(1)[0]["order"], log.newest(1)[0]["is_done"]
('start', False)
"""

from __future__ import annotations

import json
import os
import threading
import time
from collections import deque
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from camtools.panel.order import Outcome
from camtools.panel.visitor import Visitor

KEPT = 200


def utc(seconds: float) -> str:
    """Return a time [s of time.time] as people read it."""
    return datetime.fromtimestamp(seconds, UTC).strftime("%Y-%m-%d %H:%M:%S UTC")


class CommandLog:
    """Lines of commands in a file and, the newest of them, in memory.

    Parameters
    ----------
    path : Path or None
        of the file; None: in memory only
    """

    def __init__(self, path: Path | None) -> None:
        self._path = path
        self._lock = threading.Lock()
        self._newest: deque[dict[str, Any]] = deque(maxlen=KEPT)

    def add(
        self, visitor: Visitor, order: str, arguments: Mapping[str, Any], outcome: Outcome
    ) -> None:
        """Log an order and what came of it."""
        record = {
            "time": utc(time.time()),
            "visitor": visitor.id,
            "address": visitor.address,
            "order": order,
            "arguments": dict(arguments),
            "is_done": outcome.is_done,
            "outcome": outcome.text,
        }
        with self._lock:
            self._newest.append(record)
            if self._path is not None:
                self._path.parent.mkdir(parents=True, exist_ok=True)
                handle = os.open(self._path, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o600)
                with os.fdopen(handle, "w", encoding="utf-8") as stream:
                    stream.write(json.dumps(record) + "\n")

    def newest(self, n: int) -> list[dict[str, Any]]:
        """Return the newest records, the newest first."""
        with self._lock:
            return list(self._newest)[: -n - 1 : -1]
