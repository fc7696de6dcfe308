"""A jog button that is held: it lives while its heartbeats come, and never comes back to life.

The browser says every 100 ms that the button is still down. Silence of 250 ms, a button that was
let go, a page that is gone or no longer commands: each ends the press for good, so that heartbeats
which were kept back on the way and come in one heap move nothing. What was under way for longer
than 250 ms is known by the browser's own clock, and counts as nothing.

>>> now_s = 0.0
>>> press = Presses(clock=lambda: now_s).begin(Visitor("v1"), 1, 5000.0)
>>> press.is_alive(), press.end("released"), press.is_alive()
(True, None, False)
"""

import threading
import time
from collections.abc import Callable
from weakref import WeakKeyDictionary

from camtools.base.errors import CamtoolsError
from camtools.panel.orders.commander import Visitor

SILENT_S = 0.25
LATE_S = 0.25
_DRIFT = 2e-4  # by which two clocks may differ; those of computers do by less than 1e-4
_SILENT = "nothing was heard from the page for 250 ms"


class Press:
    """One press of one button."""

    def __init__(self, visitor: Visitor, number: int, clock: Callable[[], float]) -> None:
        self.visitor, self.number = visitor, number
        self.ending = ""  # why it is dead
        self._clock, self._heard_s = clock, clock()
        self._lock = threading.Lock()

    def is_alive(self) -> bool:
        """Return whether the button is held, as far as is known; once dead, dead for good."""
        with self._lock:
            if not self.ending and self._clock() - self._heard_s > SILENT_S:
                self.ending = _SILENT
            return not self.ending

    def hear(self) -> bool:
        """Take note of a heartbeat; return whether the press still lives."""
        is_alive = self.is_alive()
        with self._lock:
            if is_alive:
                self._heard_s = self._clock()
        return is_alive

    def end(self, why: str) -> None:
        """End it for good."""
        self.is_alive()
        with self._lock:
            self.ending = self.ending or why


class _Clock:
    """How far a browser's clock is behind ours, by the message that came fastest."""

    def __init__(self) -> None:
        self._least_s, self._at_s, self._since_s = float("inf"), 0.0, -1e9

    def late_s(self, now_s: float, sent_s: float, since_s: float) -> float:
        """Return how much longer a message was under way than the fastest since a time."""
        if since_s != self._since_s:
            self._least_s, self._since_s = float("inf"), since_s
        grown_s = self._least_s + _DRIFT * (now_s - self._at_s)
        self._least_s, self._at_s = min(now_s - sent_s, grown_s), now_s
        return now_s - sent_s - self._least_s


class Presses:
    """The press that lives, and the numbers of those that were."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._live: Press | None = None
        self._last: WeakKeyDictionary[Visitor, int] = WeakKeyDictionary()
        self._clocks: WeakKeyDictionary[Visitor, _Clock] = WeakKeyDictionary()

    def is_late(self, visitor: Visitor, sent_ms: float | None) -> bool:
        """Take note of a page's clock; return whether its message was under way for too long."""
        if sent_ms is None:
            return False
        clock = self._clocks.setdefault(visitor, _Clock())
        return clock.late_s(self._clock(), sent_ms / 1000, visitor.back_at_s) > LATE_S

    def begin(self, visitor: Visitor, number: int, sent_ms: float | None = None) -> Press:
        """Return a press that has just begun; raise CamtoolsError where it does not count."""
        is_late = self.is_late(visitor, sent_ms)
        if number <= self._last.get(visitor, -1):
            raise CamtoolsError([f"jog: press {number} is over; press again"])
        self._last[visitor] = number
        if is_late:
            raise CamtoolsError(["jog: the message took too long to arrive; reload the page"])
        if self._live is not None and self._live.is_alive():
            raise CamtoolsError(["jog: another button is held; release it first"])
        self._live = Press(visitor, number, self._clock)
        return self._live

    def _mine(self, visitor: Visitor, number: int) -> Press | None:
        press = self._live
        is_mine = press is not None and press.visitor is visitor and press.number == number
        return press if is_mine else None

    def hold(self, visitor: Visitor, number: int, sent_ms: float | None = None) -> bool:
        """Keep a press alive; return whether it is."""
        is_late = self.is_late(visitor, sent_ms)
        press = self._mine(visitor, number)
        return press is not None and not is_late and press.hear()

    def end(self, visitor: Visitor, number: int) -> None:
        """End a press for good."""
        if press := self._mine(visitor, number):
            press.end("released")

    def drop(self, why: str, visitor: Visitor | None = None) -> None:
        """End the press of a visitor, of any by default, for good."""
        if self._live is not None and visitor in (None, self._live.visitor):
            self._live.end(why)
