"""A service of the panel with visitors, over a bus within this process."""

import asyncio
from typing import Any

import can

from camtools.base.errors import CamtoolsError
from camtools.link.controller import Link
from camtools.panel.orders.commander import Commander, CommandLog, Visitor
from camtools.panel.orders.controller_service import ControllerService
from camtools.panel.orders.order import Order, Outcome
from checks.patience import until


class Seat:
    """A service of the panel, a visitor who commands, and another."""

    def __init__(self, channel: str) -> None:
        self.channel, self.is_bus_there = channel, True
        self.log = CommandLog(None)
        self.commander = Commander(self.log)
        self.boss = Visitor("boss")
        self.other = Visitor("other")
        self.commander.take(self.boss)
        self.service = ControllerService(self._open, self.commander, self.log)

    def _open(self) -> Link:
        if not self.is_bus_there:
            raise CamtoolsError(["no bus: start tools/live"])
        self._link = Link(can.Bus(interface="virtual", channel=self.channel), "the bench")
        return self._link

    def connect(self) -> None:
        """Wait for the status."""
        until(lambda: self.service.snapshot().is_connected, "a connection")

    @property
    def state(self) -> str:
        """State of the controller."""
        return self.service.snapshot().state

    def wait_for(self, *states: str) -> None:
        """Wait for one of some states."""
        until(lambda: self.state in states, f"{self.state}, not {states}")

    async def order(self, name: str, visitor: Visitor | None = None, /, **words: Any) -> Outcome:  # noqa: ANN401
        """Give an order, of the boss by default."""
        return await self.service.do(Order(name, words), visitor or self.boss)

    def ask(self, name: str, visitor: Visitor | None = None, /, **words: Any) -> Outcome:  # noqa: ANN401
        """Give an order and wait for its outcome."""
        return asyncio.run(self.order(name, visitor, **words))

    def do(self, name: str, /, **words: Any) -> str:  # noqa: ANN401
        """Give an order of the boss that must be accepted; return its text."""
        outcome = self.ask(name, **words)
        assert outcome.is_done, outcome.text
        return outcome.text

    def refused(self, name: str, visitor: Visitor | None = None, /, **words: Any) -> str:  # noqa: ANN401
        """Give an order that must be refused; return why."""
        outcome = self.ask(name, visitor, **words)
        assert not outcome.is_done, outcome.text
        return outcome.text

    def place(self, axis: str = "x") -> float:
        """Return where an axis is, by a status that is yet to come."""
        name = {"u": "u_actual"}.get(axis, axis)
        status = self._link.status
        n_rows = status.n_rows + 40  # its page comes every 25 rows
        until(lambda: status.n_rows >= n_rows, "a page of axes")
        return self.service.snapshot().signals[name]
