# SPDX-License-Identifier: Apache-2.0
"""Who commands: one visitor at most, or nobody.

>>> from camtools.panel.orders.command_log import CommandLog
>>> commander = Commander(CommandLog(None))
>>> one, other = Visitor("v1"), Visitor("v2")
>>> commander.take(one).is_done, commander.take(other).is_done, commander.holder is one
(True, False, True)
>>> commander.take_over(other).is_done, commander.holder is other
(True, True)
>>> commander.news(one)[:17]
'page v2 took over'
"""

from __future__ import annotations

import threading
import time
from weakref import WeakKeyDictionary

from camtools.panel.orders.command_log import CommandLog, utc
from camtools.panel.orders.order import Outcome
from camtools.panel.orders.visitor import Visitor


class Commander:
    """The right to command, which one visitor has or none; every change is logged.

    When the page of the commander goes, it is free again, and the page shows that nobody commands.
    The panel then gives command over the controller back, by which a cut ends (link_thread.py).
    """

    def __init__(self, log: CommandLog) -> None:
        self._log = log
        self._lock = threading.Lock()
        self._holder: Visitor | None = None
        self._since_s = 0.0
        self._news: WeakKeyDictionary[Visitor, str] = WeakKeyDictionary()

    @property
    def holder(self) -> Visitor | None:
        """The visitor who commands; None: nobody."""
        return self._holder

    @property
    def since_s(self) -> float:
        """When the holder took the command [s of time.time]."""
        return self._since_s

    def news(self, visitor: Visitor) -> str:
        """Return who took the command from a visitor, and when; "" when nobody did."""
        return self._news.get(visitor, "")

    def take(self, visitor: Visitor) -> Outcome:
        """Take the command when nobody has it."""
        with self._lock:
            holder = self._holder
            if holder is not None and holder is not visitor:
                outcome = Outcome(False, f"{holder} commands; take over to command yourself")
            else:
                outcome = self._give(visitor)
        return self._told("take", visitor, outcome)

    def take_over(self, visitor: Visitor) -> Outcome:
        """Take the command from whoever has it, who is told."""
        with self._lock:
            loser = self._holder
            outcome = self._give(visitor)
            if loser is not None and loser is not visitor:
                at = utc(self._since_s)
                self._news[loser] = f"{visitor} took over command at {at}"
                outcome = Outcome(True, f"taken over from {loser}")
        return self._told("take_over", visitor, outcome)

    def _give(self, visitor: Visitor) -> Outcome:
        self._holder, self._since_s = visitor, time.time()
        self._news.pop(visitor, None)
        return Outcome(True, "you command")

    def release(self, visitor: Visitor) -> Outcome:
        """Give the command back."""
        with self._lock:
            is_held = self._holder is visitor
            if is_held:
                self._holder = None
        text = "nobody commands" if is_held else "you do not command"
        return self._told("release", visitor, Outcome(is_held, text))

    def lose(self, visitor: Visitor, why: str = "the page was closed") -> None:
        """Take note that a page is gone; if it commanded, nobody does, and it shows why."""
        with self._lock:
            if self._holder is not visitor:
                return
            self._holder = None
            self._news[visitor] = f"{why}: nobody commands ({utc(time.time())})"
        self._told("lose", visitor, Outcome(True, f"{why}: nobody commands"))

    def pass_on(self, before: Visitor, visitor: Visitor) -> None:
        """Give the command of a page that is gone to the one that was loaded in its place."""
        with self._lock:
            if self._holder is not before or before.is_here:
                return
            self._holder = visitor
        self._told("pass_on", visitor, Outcome(True, f"the page of {before} was loaded anew"))

    def lose_on_bus(self, why: str, sender: int) -> None:
        """Take note that the panel has lost command over the controller; who commanded is told.

        Where nobody else has it, as when the panel was stopped for a second, he commands on.
        """
        with self._lock:
            loser = self._holder
            if loser is None:
                return
            self._holder = None if sender else loser
            self._news[loser] = f"{why} ({utc(time.time())})"
        self._told("lose", loser, Outcome(True, why))

    def _told(self, what: str, visitor: Visitor, outcome: Outcome) -> Outcome:
        self._log.add(visitor, what, {}, outcome)
        return outcome
