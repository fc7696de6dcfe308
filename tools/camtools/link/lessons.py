"""The following error over the turns of learning, from the status messages.

>>> seen = Convergence()
>>> seen.add({"learn_turns": 8.0, "learn_error": 0.5})
>>> seen.lessons()
[(8, 0.5)]
"""

import threading
from collections import deque
from collections.abc import Mapping

MOST_LESSONS = 2000


class Convergence:
    """Collects error over turns; a new rehearsal clears it.

    Turns and error come in two pages, one of which may be a lesson old: the newest pair of a turn
    wins. Lessons that come faster than the pages are left out. most: lessons that are kept.
    """

    def __init__(self, most: int = MOST_LESSONS) -> None:
        self._lock = threading.Lock()
        self._rows: deque[tuple[int, float]] = deque(maxlen=most)

    def add(self, signals: Mapping[str, float]) -> None:
        """Take the newest signals of the status, as often as they come."""
        if not {"learn_turns", "learn_error"} <= signals.keys():
            return
        turn = int(signals["learn_turns"])
        with self._lock:
            last = self._rows[-1][0] if self._rows else 0
            if turn < last:
                self._rows.clear()
            elif turn == last and self._rows:
                self._rows.pop()
            if turn > 0:
                self._rows.append((turn, signals["learn_error"]))

    def lessons(self) -> list[tuple[int, float]]:
        """Return the lessons, the oldest first; from any thread.

        Each is its turn, counted from the begin of the rehearsal or the cut, and the rms [um] of
        that turn in the harmonics that are learned.
        """
        with self._lock:
            return list(self._rows)
