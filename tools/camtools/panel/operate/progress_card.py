# SPDX-License-Identifier: Apache-2.0
"""How far the part is, how long it takes still, parts, and how busy the interrupt is."""

from __future__ import annotations

from math import floor

from nicegui import ui

from camtools.link.progress import cut_progress, tick_load
from camtools.panel.operate.card import Figure, card
from camtools.panel.orders.snapshot import Snapshot
from camtools.panel.views import numbers


class ProgressCard:
    """A bar, two large numbers, and the load below."""

    def __init__(self) -> None:
        with card("Progress", "progress", is_live=True):
            with ui.element("div").classes("op-big-row"):
                self._percent = Figure("Done", "%", "progress", size="big")
                self._left = Figure("Time left", "min:s", "time-left", size="big")
                self._parts = Figure("Parts cut", "parts", "parts", size="big")
            self._bar = ui.linear_progress(0.0, show_value=False).classes("op-progress")
            self._bar.props('aria-label="Share of the pass that is done" data-testid=progress-bar')
            self._text = ui.label("").classes("op-note").props("data-testid=progress-text")
            ui.label("Interrupt").classes("op-label op-gap")
            self._load_bar = ui.linear_progress(0.0, show_value=False).classes("op-progress")
            self._load_bar.props('aria-label="Longest interrupt as a share of the tick"')
            self._load = ui.label("").classes("op-note").props("data-testid=load")

    def show(self, snapshot: Snapshot) -> None:
        """Show the newest."""
        s = snapshot.signals
        told = cut_progress(snapshot.state, s)
        share = told.fraction if snapshot.state != "ready" else None
        self._percent.show(numbers.plain(None if share is None else floor(100 * share), 0))
        self._left.show(numbers.clock(told.left_s))
        self._parts.show(numbers.PARTS.text(s))
        self._bar.set_value(round(share or 0.0, 3))
        self._text.set_text(told.text)
        load = tick_load(s)
        self._load_bar.set_value(round(min(load.share or 0.0, 1.0), 2))
        late = numbers.LATE_TICKS.text(s)
        self._load.set_text(f"{load.text}; {late} late ticks".replace(" us", " µs"))
