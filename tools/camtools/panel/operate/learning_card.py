"""The following error over the turns of learning.

An update sends the series that has changed by ECharts' own setOption.
"""

from nicegui import ui

from camtools.link.lessons import Lessons
from camtools.panel.orders.snapshot import Snapshot
from camtools.panel.pieces import card
from camtools.panel.views.convergence_chart import options, points_of, words


class LearningCard:
    """A small chart, sent when a lesson has come, and what is learned in words."""

    def __init__(self) -> None:
        self._told: list[list[float]] = []
        with card("Learning", "learning", is_live=True):
            self._words = ui.label("").classes("op-note").props("data-testid=learning")
            self._chart = ui.echart(options()).classes("op-chart")
            said = "Error of U in the learned harmonics, over the turns used for learning"
            self._chart.props(f'role=img aria-label="{said}" data-testid=learning-chart')

    def show(self, snapshot: Snapshot, lessons: Lessons) -> None:
        """Show what was learned up to now."""
        self._words.set_text(words(snapshot.signals))
        points = points_of(lessons.turn.tolist(), lessons.error_um.tolist())
        if points != self._told:
            self._told = points
            series = {"id": "lessons", "data": points}
            self._chart.run_chart_method("setOption", {"series": [series]})
