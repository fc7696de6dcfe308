"""The following error, live: over the angle, and how it falls while the controller learns.

An update sends the series that have changed by ECharts' own setOption; nothing is sent to a page
that is hidden.
"""

from contextlib import suppress

from nicegui import ui

from camtools.link import strobe
from camtools.link.strobe import Lessons
from camtools.panel.orders.snapshot import Snapshot
from camtools.panel.pieces import Figure, card
from camtools.panel.views.convergence_chart import options, points_of, words
from camtools.panel.views.error_chart import (
    POLAR,
    UNROLLED,
    Scale,
    Ticks,
    Trail,
    change,
    mean_by_angle,
    recent,
    statistics,
    whole,
)
from camtools.panel.views.wording import plain

_LEAST_UM, _LIMIT_UM, _MOST_UM = 0.02, 2.0, 1000.0
_TAKEN_S = 5.0  # longest time for which a page is waited for that does not say it has an update
_SAID = "Following error of U over one turn, the last 50 turns over each other, "


def _known(seen: strobe.Samples) -> Ticks:
    is_known = seen.is_synced
    return Ticks(seen.turn[is_known], seen.angle_turn[is_known], seen.error_um[is_known])


class ErrorCard:
    """Both charts with one scale, their statistics, and the tolerance that is drawn."""

    def __init__(self) -> None:
        self._trail, self._scale = Trail(), Scale(_LEAST_UM)
        self._full_um = _LEAST_UM
        self._limit_um, self._limit_told_um = _LIMIT_UM, _LIMIT_UM
        with card("Following error over the angle", "error", is_live=True):
            self._draw_statistics()
            with ui.element("div").classes("op-charts"):
                self._charts = {kind: self._draw(kind) for kind in (UNROLLED, POLAR)}
            self._beyond = ui.label("").classes("op-note")
            ui.label(
                "Dots: single ticks of the last 50 turns, older ones fainter. Solid line: their "
                "mean. Dashed lines: tolerance. "
                "Angle in the direction of cutting, seen from the headstock; with M3 the drawing's."
            ).classes("op-notes")

    def _draw_statistics(self) -> None:
        with ui.element("div").classes("op-stats"):
            self._max = Figure("Largest", "µm", "error-max")
            self._rms = Figure("RMS", "µm", "error-rms")
            self._turns = Figure("Seen", "turns", "error-turns")
            self._outside = ui.label("").classes("op-outside").props("role=status")
            limit = ui.number("Tolerance ±", value=_LIMIT_UM, min=0.01, max=_MOST_UM, step=0.5)
            limit.on_value_change(lambda event: self._set_limit(event.value))
            limit.classes("op-tolerance").props('dense suffix="µm" data-testid=tolerance')

    def _draw(self, kind: str) -> ui.echart:
        chart = ui.echart(whole(kind, _LEAST_UM, _LIMIT_UM)).classes(f"op-chart op-chart-{kind}")
        chart.props(f'role=img aria-label="{_SAID}{kind}" data-testid=error-{kind}')
        return chart.mark(f"error-{kind}")

    def _set_limit(self, value: float | None) -> None:
        if value is not None and 0 < value <= _MOST_UM:
            self._limit_um = float(value)

    def forget(self) -> None:
        """Tell everything anew with the next update, as behind a page that was hidden."""
        self._trail = Trail()

    async def show(self, seen: strobe.Samples) -> None:
        """Show the samples that are there, and wait until the page has taken them.

        A browser that cannot keep up thus gets fewer updates and not older ones: what is sent
        without waiting would queue up before it, by seconds.
        """
        shown = recent(_known(seen))
        told = statistics(shown)
        self._max.show(plain(told.max_um, 3))
        self._rms.show(plain(told.rms_um, 3))
        self._turns.show(plain(told.turns, 0))
        self._outside.set_text("outside of the tolerance" if told.max_um > self._limit_um else "")
        beyond = f"The tolerance of ±{self._limit_um:g} µm is outside the scale."
        self._beyond.set_text(beyond if self._limit_um > self._full_um else "")
        changes = self._trail.changes(shown)
        full_um = self._scale.follow(told.max_um)
        is_new = full_um != self._full_um
        is_limit_new = self._limit_um != self._limit_told_um
        if not (changes or is_new or is_limit_new):
            return
        self._full_um, self._limit_told_um = full_um, self._limit_um
        means = mean_by_angle(shown) if told.samples else []
        scale_um = (full_um, self._limit_um) if is_new or is_limit_new else None
        options = {kind: change(kind, changes, means, scale_um) for kind in self._charts}
        self._charts[UNROLLED].run_chart_method("setOption", options[UNROLLED])
        with suppress(TimeoutError):  # the page takes them in order: the last stands for both
            last = self._charts[POLAR]
            await last.run_chart_method("setOption", options[POLAR], timeout=_TAKEN_S)


class LearningCard:
    """A small chart, sent when a lesson has come, and what is learned in words."""

    def __init__(self) -> None:
        self._told: list[list[float]] = []
        with card("Learning", "learning", is_live=True):
            self._words = ui.label("").classes("op-note").props("data-testid=learning")
            self._chart = ui.echart(options()).classes("op-chart op-chart-small")
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
