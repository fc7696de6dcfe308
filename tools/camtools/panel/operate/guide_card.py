# SPDX-License-Identifier: Apache-2.0
"""What is missing to go on, faults with cause and remedy, and the black box that waits."""

from __future__ import annotations

from nicegui import ui

from camtools.link.faults import FAULTS
from camtools.panel.operate.card import card
from camtools.panel.orders.snapshot import Snapshot
from camtools.panel.views.black_box import READ_IT, box_text
from camtools.panel.views.missing import Way
from camtools.panel.views.state_style import look


class GuideCard:
    """A list in the order in which it must be done; faults above it."""

    def __init__(self) -> None:
        self._shown: tuple[object, ...] = ()
        with card("What to do", "guide", is_live=True):
            self._meaning = ui.label("").classes("op-meaning")
            self._faults = ui.element("div").props("role=alert data-testid=faults").mark("faults")
            with ui.element("div").classes("op-box") as self._box:
                self._box_text = ui.label("").props("data-testid=black-box")
                ui.label(READ_IT).classes("op-code")
            self._steps = ui.element("ol").classes("op-steps").props("data-testid=missing")
            self._steps.mark("missing")
            self._problem = ui.label("").classes("op-problem").props("data-testid=problem")

    def show(self, snapshot: Snapshot, way: Way) -> None:
        """Show what has changed."""
        told = (snapshot.faults, tuple(way.sentences), snapshot.is_connected)
        self._meaning.set_text(look(snapshot.state, is_connected=snapshot.is_connected).meaning)
        box = box_text(snapshot.signals)
        self._box_text.set_text(box)
        self._box.set_visibility(bool(box))
        self._problem.set_text(snapshot.problem)
        if told == self._shown:
            return
        self._shown = told
        self._draw_faults(snapshot.faults)
        self._steps.clear()
        with self._steps:
            for i, sentence in enumerate(way.sentences):
                is_last = i == len(way.missing)
                with ui.element("li").classes("op-then" if is_last else "op-missing"):
                    ui.label(sentence)

    def _draw_faults(self, names: tuple[str, ...]) -> None:
        self._faults.clear()
        with self._faults:
            for name in names:
                text = FAULTS[name]
                with ui.element("div").classes("op-fault").props(f"data-fault={name}"):
                    with ui.element("div").classes("op-fault-title"):
                        ui.icon("report").props("aria-hidden=true")
                        ui.label(f"{text.title} ({name})")
                    ui.label(f"Cause: {text.cause}")
                    ui.label(f"Remedy: {text.remedy}")
