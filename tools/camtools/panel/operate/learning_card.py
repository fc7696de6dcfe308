# SPDX-License-Identifier: Apache-2.0
"""How the error falls while the controller learns."""

from __future__ import annotations

from nicegui import ui

from camtools.link.convergence import Lessons
from camtools.panel.operate.card import card
from camtools.panel.orders.snapshot import Snapshot
from camtools.panel.views.convergence_chart import options, points_of, words


class LearningCard:
    """A small chart, sent when a lesson has come, and what is learned in words."""

    def __init__(self) -> None:
        self._told: list[list[float]] = []
        with card("Learning", "learning", is_live=True):
            self._words = ui.label("").classes("op-note").props("data-testid=learning")
            self._chart = ui.echart(options()).classes("op-chart op-chart-small")
            said = (
                "Error of U in the harmonics that are learned, over the turns of which was learned"
            )
            self._chart.props(f'role=img aria-label="{said}" data-testid=learning-chart')

    def show(self, snapshot: Snapshot, lessons: Lessons) -> None:
        """Show what was learned up to now."""
        self._words.set_text(words(snapshot.signals))
        points = points_of(lessons.turn.tolist(), lessons.error_um.tolist())
        if points != self._told:
            self._told = points
            series = {"id": "lessons", "data": points}
            self._chart.run_chart_method("setOption", {"series": [series]})
