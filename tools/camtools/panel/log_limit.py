# SPDX-License-Identifier: Apache-2.0
"""What goes wrong with a message of a browser is told on the terminal, but not without end.

Whoever opens the page can send what no page of ours sends, and each such message would leave a page
of a stack on the terminal or in the journal of the computer.

>>> few = LogLimit(clock=lambda: 0.0)
>>> record = logging.makeLogRecord({"msg": "wrong"})
>>> sum(few.filter(record) for _ in range(100)) == MOST_RECORDS
True
"""

from __future__ import annotations

import logging
import time
from collections import deque
from collections.abc import Callable

MOST_RECORDS, WITHIN_S = 10, 60.0
_LOGGERS = ("nicegui", "engineio.server", "socketio.server")


class LogLimit(logging.Filter):
    """Lets MOST_RECORDS through within WITHIN_S; the last of them says that there may be more.

    Parameters
    ----------
    clock : callable
        [s]
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__()
        self._clock = clock
        self._told_s: deque[float] = deque(maxlen=MOST_RECORDS)

    def filter(self, record: logging.LogRecord) -> bool:
        """Return whether a record is told."""
        now_s = self._clock()
        if len(self._told_s) == MOST_RECORDS and now_s - self._told_s[0] < WITHIN_S:
            return False
        self._told_s.append(now_s)
        if len(self._told_s) == MOST_RECORDS and now_s - self._told_s[0] < WITHIN_S:
            record.msg = f"{record.msg} (more of this minute is left out)"
        return True


def keep_traces_few() -> None:
    """Bound what the libraries of the server tell of messages, all of them together."""
    few = LogLimit()
    for name in _LOGGERS:
        logging.getLogger(name).addFilter(few)
