# SPDX-License-Identifier: Apache-2.0
"""State in big letters, what is to be done first, and STOP: always in sight."""

from __future__ import annotations

from nicegui import ui

from camtools.panel.dialogs import withdraw
from camtools.panel.operate.order_buttons import Orders
from camtools.panel.orders.snapshot import Snapshot
from camtools.panel.views.availability import stop_order
from camtools.panel.views.missing import Way
from camtools.panel.views.state_style import look


class StateBar:
    """The bar at the top of the page; its STOP is at the bottom of a small one."""

    def __init__(self, orders: Orders) -> None:
        self._orders = orders
        self._state = "unknown"
        with ui.element("section").classes("op-top").props('aria-label="State and STOP"'):
            self._draw_state()
            self._draw_stop()

    def _draw_state(self) -> None:
        with ui.element("div").classes("op-state tone-silent live") as self._box:
            self._icon = ui.icon("link_off").classes("op-state-icon").props("aria-hidden=true")
            with ui.element("div").classes("op-state-words").props("role=status aria-live=polite"):
                self._word = ui.label("WAITING").classes("op-word")
                self._word.props("data-testid=state").mark("state")
                self._first = ui.label("").classes("op-first")
                self._first.props("data-testid=first").mark("first")
            self._where = ui.label("").classes("op-where").props("data-testid=where")

    def _draw_stop(self) -> None:
        stop = ui.button(on_click=self.stop, color=None).classes("op-stop")
        stop.props('no-caps unelevated aria-label="STOP: ends what moves. Key: Escape"')
        stop.props("data-testid=stop aria-keyshortcuts=Escape").mark("stop")
        with stop:
            ui.label("STOP").classes("op-stop-word")
            ui.label("Esc").classes("op-stop-key")

    async def stop(self) -> None:
        """End what moves, without a question."""
        withdraw(self._box.client)
        name = stop_order(self._state)
        await self._orders.give(name, "STOP" if name == "stop" else "STOP: drives off")

    def show(self, snapshot: Snapshot, way: Way) -> None:
        """Show the state."""
        self._state = snapshot.state
        one = look(snapshot.state, is_connected=snapshot.is_connected)
        if self._word.text != one.word:
            self._word.set_text(one.word)
            self._icon.props(f"name={one.icon}")
            self._box.classes(replace=f"op-state live tone-{one.tone}")
        self._first.set_text(way.sentence)
        self._where.set_text(snapshot.work or snapshot.table_name or "no table")
