# SPDX-License-Identifier: Apache-2.0
"""STOP of the machine in the frame of the pages that are not the operator's.

The operator's page has a larger one beside the state. Escape does the same (static/panel.js) for
who commands, since he may look at any page when something goes wrong. For others it does not: who
closes a menu while he draws a part must not end somebody else's cut.

>>> machine_text("cutting", is_connected=True), machine_text("unknown", is_connected=False)
('machine: cutting', 'machine: no connection')
"""

from __future__ import annotations

from nicegui import ui

from camtools.panel.context import AppContext
from camtools.panel.dialogs import withdraw
from camtools.panel.orders.order import Order
from camtools.panel.orders.visitor import Visitor
from camtools.panel.views.availability import stop_order


def machine_text(state: str, *, is_connected: bool) -> str:
    """Return what the machine does, in the words of its controller."""
    return f"machine: {state}" if is_connected else "machine: no connection"


class FrameStop:
    """The machine's state and its STOP."""

    def __init__(self, context: AppContext, visitor: Visitor) -> None:
        self._context, self._visitor = context, visitor
        self._machine = ui.label().props("data-testid=machine")
        self._button = ui.button("STOP", on_click=self.stop, color=None).classes("panel-stop")
        self._button.props('no-caps unelevated aria-label="STOP: stops all motion"')
        self._button.props("data-testid=stop")
        ui.on("stop", self._stop_by_key)

    async def _stop_by_key(self) -> None:
        """Stop, where the visitor commands."""
        if self._context.commander.holder is self._visitor:
            await self.stop()

    async def stop(self) -> None:
        """End what moves, without a question, and tell what came of it."""
        withdraw(self._button.client)
        order = stop_order(self._context.service.snapshot().state)
        outcome = await self._context.service.do(Order(order, {}), self._visitor)
        with self._button:
            words = f"STOP of the machine: {outcome.text}"
            ui.notify(words, type="positive" if outcome.is_done else "negative")

    def show(self) -> None:
        """Show what the machine does now."""
        snapshot = self._context.service.snapshot()
        self._machine.text = machine_text(snapshot.state, is_connected=snapshot.is_connected)
