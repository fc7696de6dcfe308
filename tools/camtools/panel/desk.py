# SPDX-License-Identifier: Apache-2.0
"""The desk: it owns the link to the controller, in a thread of its own.

Pages ask it for a snapshot, which never waits, and give it orders, which the thread carries out one
after the other.
"""

from __future__ import annotations

import asyncio
import queue
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import replace

from camtools.base.errors import CamtoolsError
from camtools.link.controller import SILENT_S, Link, Refused
from camtools.link.refusal import ask_done
from camtools.panel.command_log import CommandLog
from camtools.panel.commander import Commander
from camtools.panel.order import Order, Outcome
from camtools.panel.snapshot import NO_STROBE, SILENT, Snapshot, StrobeView, snapshot_of
from camtools.panel.visitor import Visitor

_LOOK_S = 0.02
_SHOW_S = 0.05
_AGAIN_S = 1.0
_PLAIN = ("enable", "disable", "home", "manual", "start", "hold", "resume", "stop", "reset")

OpenLink = Callable[[], Link]


class Desk:
    """Owner of the link.

    Parameters
    ----------
    open_link : callable
        returns a Link with an open bus, or raises CamtoolsError, whose text the page shows; it is
        called again and again while no controller is heard
    commander : Commander
        who may give orders
    log : CommandLog
        of orders
    """

    def __init__(self, open_link: OpenLink, commander: Commander, log: CommandLog) -> None:
        self._open_link, self._commander, self._log = open_link, commander, log
        self._snapshot = SILENT
        self._orders: queue.SimpleQueue[tuple[Order, Future[Outcome]]] = queue.SimpleQueue()
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._run, name="desk", daemon=True)
        self._thread.start()

    def snapshot(self) -> Snapshot:
        """Return the newest status; never waits."""
        return self._snapshot

    def strobe(self) -> StrobeView:
        """Return the following error over angle of the last turns; never waits.

        The controller sends it only while somebody asks at least every two seconds.
        """
        return NO_STROBE

    async def do(self, order: Order, visitor: Visitor) -> Outcome:
        """Carry an order out and return what came of it; what is refused is logged, too."""
        if not visitor.has_token:
            outcome = Outcome(False, "commands need the token")
        elif order.name != "stop" and self._commander.holder is not visitor:
            outcome = Outcome(False, "you do not command; take the command first")
        else:
            told: Future[Outcome] = Future()
            self._orders.put((order, told))
            outcome = await asyncio.wrap_future(told)
        self._log.add(visitor, order.name, order.arguments, outcome)
        return outcome

    def close(self) -> None:
        """End the thread and close the bus."""
        self._is_over.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._is_over.is_set():
            try:
                link = self._open_link()
            except CamtoolsError as error:
                self._snapshot = replace(SILENT, problem=str(error))
                self._is_over.wait(_AGAIN_S)
                continue
            try:
                self._serve(link)
            except (Refused, CamtoolsError) as error:
                self._snapshot = replace(SILENT, problem=str(error))
            finally:
                link.bus.shutdown()

    def _serve(self, link: Link) -> None:
        due_s = 0.0
        link.listen()
        while not self._is_over.is_set():
            link.pump(_LOOK_S)
            now_s = time.monotonic()
            if now_s - link.status.at_s > SILENT_S:
                raise Refused(f"{link.where}: the controller is silent")
            if now_s > due_s:
                due_s = now_s + _SHOW_S
                self._snapshot = snapshot_of(link.status, link.where, "")
            while not self._orders.empty():
                order, told = self._orders.get()
                told.set_result(self._carry_out(link, order))

    def _carry_out(self, link: Link, order: Order) -> Outcome:
        if order.name not in _PLAIN:
            return Outcome(False, f"{order.name}: no such order yet")
        try:
            ask_done(link, order.name)
        except (Refused, CamtoolsError) as error:
            return Outcome(False, str(error))
        return Outcome(True, order.name)
