"""The following error over the turns of learning, from the status messages.

>>> seen = Convergence()
>>> seen.add({"learn_turns": 8.0, "learn_error": 0.5, "learn_phase": 5.0})
>>> seen.lessons().turn, seen.lessons().phase
(array([8]), ('shape',))
"""

import threading
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from camtools.link.messages import NAMES

MOST_LESSONS = 2000


@dataclass(frozen=True, eq=False)
class Lessons:
    """Lessons, the oldest first; all arrays have the same length."""

    turn: npt.NDArray[np.int64]  # counted from the begin of the rehearsal or the cut
    error_um: npt.NDArray[np.float64]  # rms of that turn in the harmonics that are learned
    phase: tuple[str, ...]  # what is learned, as in NAMES["learn_phase"]
    begin_error_um: float | None  # before anything was learned; None: not reported


class Convergence:
    """Collects error over turns; a new rehearsal clears it.

    Turns and error come in two pages, one of which may be a lesson old: the newest pair of a turn
    wins. Lessons that come faster than the pages are left out. most: lessons that are kept.
    """

    def __init__(self, most: int = MOST_LESSONS) -> None:
        self._lock = threading.Lock()
        self._rows: deque[tuple[int, float, str]] = deque(maxlen=most)
        self._begin_um: float | None = None

    def add(self, signals: Mapping[str, float]) -> None:
        """Take the newest signals of the status, as often as they come."""
        if not {"learn_turns", "learn_error"} <= signals.keys():
            return
        turn = int(signals["learn_turns"])
        phase = NAMES["learn_phase"].get(int(signals.get("learn_phase", -1)), "unknown")
        with self._lock:
            last = self._rows[-1][0] if self._rows else 0
            if turn < last:
                self._rows.clear()
            elif turn == last and self._rows:
                self._rows.pop()
            self._begin_um = signals.get("learn_begin_error")
            if turn > 0:
                self._rows.append((turn, signals["learn_error"], phase))

    def lessons(self) -> Lessons:
        """Return what was collected; from any thread."""
        with self._lock:
            rows, begin_um = list(self._rows), self._begin_um
        return Lessons(
            turn=np.array([turn for turn, _, _ in rows], np.int64),
            error_um=np.array([error for _, error, _ in rows], np.float64),
            phase=tuple(phase for _, _, phase in rows),
            begin_error_um=begin_um,
        )
