"""The service: pages ask it for what the controller does, and give it orders.

`snapshot()`, `lessons()`, `parameters()` and `tuned()` never wait and may be called by every page
as often as it draws. `do()` judges each order by the visitor who gives it, whatever buttons his
page shows: the rights are here and nowhere else. Every order and its outcome is logged.

>>> _loggable({"image": b"123456789", "name": "a part"})
{'image': '9 bytes, CRC-32 cbf43926', 'name': "'a part'"}
"""

import asyncio
import time
import zlib
from collections.abc import Mapping
from typing import Any

from camtools.base.errors import CamtoolsError, shown
from camtools.panel.orders.commander import Commander, CommandLog, Visitor
from camtools.panel.orders.jog_press import Presses
from camtools.panel.orders.link_thread import Job, LinkThread, OpenLink
from camtools.panel.orders.loop_tuner import LoopTuner, Tuned
from camtools.panel.orders.order import ATTENDED, URGENT, Order, Outcome, checked

BACK_S = 0.5  # what comes so soon behind a lost connection may have been pressed long ago
NOT_YOU = "you do not command; take the command first"
BACK = "the connection was lost meanwhile; look, and press again"


class ControllerService:
    """What stands between pages and controller.

    `open_link` returns a Link with an open bus, or raises CamtoolsError, whose text the page shows;
    it is called again and again while no controller is heard.
    """

    def __init__(self, open_link: OpenLink, commander: Commander, log: CommandLog) -> None:
        self._commander, self._log = commander, log
        self._presses, self._tuner = Presses(), LoopTuner()
        thread = LinkThread(open_link, lambda: bool(commander.holder), commander.lose_on_bus)
        self._thread = thread
        self.snapshot, self.lessons = thread.snapshot, thread.lessons
        self.parameters = thread.parameters

    def tuned(self) -> Tuned | None:
        """Return what the newest measurement of U shows, None where there is none; never waits."""
        return self._tuner.newest

    async def do(self, order: Order, visitor: Visitor) -> Outcome:
        """Carry an order out and return what came of it; what is refused is logged, too.

        The outcome of `jog_begin` comes when the axis stands again. `jog_hold` and `jog_end` are
        answered at once and not logged: the outcome of `jog_begin` has how it ended.
        """
        if order.name in ("jog_hold", "jog_end"):
            return self._held(order, visitor)
        try:
            outcome = await self._done(order, visitor)
        except CamtoolsError as error:
            outcome = Outcome(False, str(error))
        self._log.add(visitor, order.name, _loggable(order.arguments), outcome)
        return outcome

    async def take_over(self, visitor: Visitor) -> Outcome:
        """Let a visitor command, here and over the controller, whoever has that now."""
        outcome = self._commander.take_over(visitor)
        if self.snapshot().has_command:
            return outcome
        taken = await self._give(Order("take_over"), {}, visitor)
        self._log.add(visitor, "take_over", {}, taken)
        return taken

    def page_connected(self, visitor: Visitor) -> None:
        """Take note that the connection of a page stands; what was held before it is over."""
        if visitor.was_connected:
            visitor.back_at_s = time.monotonic()
            self._presses.drop("the connection was lost", visitor)
        visitor.is_here = visitor.was_connected = True

    def page_clock(self, visitor: Visitor, sent_ms: float) -> None:
        """Take note of a page's clock: performance.now() as the page sent its message."""
        self._presses.is_late(visitor, sent_ms)

    def page_lost(self, visitor: Visitor) -> None:
        """End what the visitor holds; to be called when the connection of his page is lost."""
        visitor.is_here = False
        visitor.n_losses += 1
        self._presses.drop("the page was closed", visitor)

    def close(self) -> None:
        """End the thread and close the bus; what is held ends, too."""
        self._presses.drop("the panel has ended")
        self._thread.close()

    def _refusal(self, name: str, visitor: Visitor) -> str:
        """Return why a visitor may not give an order, "" when he may."""
        if name in URGENT:
            return ""
        if self._commander.holder is not visitor:
            return NOT_YOU
        is_back = time.monotonic() - visitor.back_at_s < BACK_S
        return BACK if is_back or not visitor.is_here else ""

    async def _done(self, order: Order, visitor: Visitor) -> Outcome:
        if refusal := self._refusal(order.name, visitor):
            return Outcome(False, refusal)
        arguments = checked(order)
        if order.name == "jog_begin":
            press = self._presses.begin(visitor, arguments["press"], arguments.get("sent_ms"))
            arguments["press"] = press
        if order.name in URGENT:
            self._presses.drop(f"{order.name} was ordered")
        if order.name in ("push_u", "measure_loop", "apply_loop"):
            arguments["tuner"] = self._tuner
        return await self._give(order, arguments, visitor)

    async def _give(self, order: Order, arguments: dict[str, Any], visitor: Visitor) -> Outcome:
        name = order.name
        marks = name in URGENT, lambda: self._refusal(name, visitor), name in ATTENDED
        job = Job(name, arguments, visitor, *marks)
        if job.is_attended:
            arguments["rests"] = job.leave
        self._thread.give(job)
        return await asyncio.shield(asyncio.wrap_future(job.outcome))

    def _held(self, order: Order, visitor: Visitor) -> Outcome:
        try:
            arguments = checked(order)
        except CamtoolsError as error:
            return Outcome(False, str(error))
        if order.name == "jog_end":
            self._presses.end(visitor, arguments["press"])
            return Outcome(True, "")
        if refusal := self._refusal(order.name, visitor):
            self._presses.drop(refusal, visitor)
            return Outcome(False, refusal)
        is_held = self._presses.hold(visitor, arguments["press"], arguments.get("sent_ms"))
        return Outcome(is_held, "" if is_held else "the press is over")


def _loggable(arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Return arguments for the log: of a file its size and checksum."""

    def text(value: object) -> object:
        if isinstance(value, bytes):
            return f"{len(value)} bytes, CRC-32 {zlib.crc32(value):08x}"
        return value if isinstance(value, int | float) else shown(value)

    return {str(name)[:40]: text(value) for name, value in list(arguments.items())[:8]}
