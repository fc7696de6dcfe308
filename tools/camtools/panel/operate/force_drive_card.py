# SPDX-License-Identifier: Apache-2.0
"""The drive of a U that takes forces: measured, its loop proposed, and set."""

from __future__ import annotations

from base64 import b64encode

from nicegui import ui

from camtools.panel.dialogs import asks, confirmed
from camtools.panel.operate.card import card
from camtools.panel.operate.order_buttons import Orders
from camtools.panel.orders.loop_tuner import Tuned
from camtools.panel.orders.parameter_set import ParameterSet
from camtools.panel.orders.snapshot import Snapshot
from camtools.panel.views.force_drive import has_force_drive, loop_text

_MOVES = "U moves to and fro for some seconds. Is the tool clear of the work, with the door shut?"
_SETS = "The drives go off, and what is proposed takes effect: enable and home again."
_MEANING = (
    "At the first power-up Pulse pushes U in both directions, for the sign of its force, its mass "
    "and its friction. Measure excites U in its loop as it is, finds mass, friction, delay and "
    "modes, and proposes a loop with margins of 6 dB and 30 degrees. Apply sets what is proposed. "
    "Measure again to see the result, then keep the parameters."
)


class ForceDriveCard:
    """Out of sight where U takes positions."""

    def __init__(self, orders: Orders) -> None:
        self._orders = orders
        self._service = orders.context.service
        self._shown: Tuned | None = None
        with card("Drive of U", "drive") as self._card:
            ui.label(_MEANING).classes("op-note")
            self._loop = ui.label("").classes("op-box").props("data-testid=drive-loop")
            with ui.element("div").classes("op-row"):
                self._force = ui.number("Force of the pulse", value=15.0, min=0.1, suffix="N")
                self._force.classes("op-input").props("data-testid=pulse-force")
                one = ui.button("Pulse", on_click=self._push)
                one.props("no-caps outline data-testid=do-push_u")
                orders.guard(one, "push_u")
                one = ui.button("Measure", on_click=self._measure)
                one.props("no-caps outline data-testid=do-measure_loop")
                orders.guard(one, "measure_loop")
                one = ui.button("Apply", on_click=self._apply)
                one.props("no-caps outline data-testid=do-apply_loop")
                orders.guard(one, "apply_loop", own_why=self._why_no_loop)
            self._work = ui.label("").classes("op-note").props("role=status")
            self._problem = ui.label("").classes("op-problem").props("data-testid=drive-problem")
            self._report = ui.label("").classes("op-report").props("data-testid=drive-report")
            self._picture = ui.element("img").classes("op-picture")
            self._picture.props('alt="Measured and proposed loop of U" data-testid=drive-picture')
            self._picture.set_visibility(False)
        self._card.set_visibility(False)
        asks("measure_loop", self._measure)

    def _why_no_loop(self) -> str:
        newest = self._service.tuned()
        return "" if newest is not None and newest.settings else "measure first"

    async def _push(self) -> None:
        if await confirmed("Push U?", _MOVES, "Push"):
            force_n = float(self._force.value or 0.0)
            await self._orders.give("push_u", f"push U by {force_n:g} N", force_n=force_n)

    async def _measure(self) -> None:
        if await confirmed("Measure U?", _MOVES, "Measure", "measure_loop"):
            await self._orders.give("measure_loop", "measure U")

    async def _apply(self) -> None:
        asked = self._service.tuned()
        if not await confirmed("Apply what is proposed?", _SETS, "Apply"):
            return
        if self._service.tuned() is not asked:
            self._orders.refuse("apply the loop", "U was measured again meanwhile; look, and apply")
            return
        await self._orders.give("apply_loop", "apply the loop")

    def show(self, snapshot: Snapshot, read: ParameterSet | None) -> None:
        """Show the loop in force, what runs, and what the newest measurement shows."""
        self._work.set_text(f"Busy with {snapshot.work}." if snapshot.work else "")
        if read is not None:
            self._card.set_visibility(has_force_drive(read.values))
            self._loop.set_text(loop_text(read.values))
        newest = self._service.tuned()
        if newest is self._shown:
            return
        self._shown = newest
        self._problem.set_text(newest.problem if newest else "")
        self._report.set_text(newest.text if newest else "")
        picture = newest.picture if newest else b""
        self._picture.set_visibility(bool(picture))
        if picture:
            data = b64encode(picture).decode("ascii")
            self._picture.props(f'src="data:image/png;base64,{data}"')
