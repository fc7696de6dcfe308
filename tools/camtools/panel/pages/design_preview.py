"""The preview beside the editor: charts, verdict, margins, size; the last good one stays."""

from collections.abc import Callable
from typing import Any

from nicegui import ui

from camtools.panel.design import charts
from camtools.panel.design.charts import margin_rows, table_words, verdict_words
from camtools.panel.pieces import Showing, columns_of, redraw

Answer = dict[str, Any]
_MAGNIFY = {0: "as seen well", 1: "true to scale"} | {n: f"{n} times" for n in (10, 100, 1000)}


class PreviewView:
    """Charts and numbers of a part.

    `on_height`: called with a height [mm] when another one is chosen.
    """

    def __init__(self, on_height: Callable[[float], None]) -> None:
        self._on_height = on_height
        self._curves: Answer = {}
        self._showing = Showing()
        with ui.column().classes("full-width q-gutter-xs"):
            with ui.row().classes("items-baseline q-gutter-md"):
                self._verdict = ui.label("").classes("verdict").props("data-testid=verdict")
                self._speed = ui.label("").props("data-testid=speed")
            self._size = ui.column().classes("tight").props("data-testid=table-size")
        with ui.row().classes("items-center full-width q-gutter-md"):
            self._state = ui.label("").props('role="status" data-testid=preview-state')
            ui.space()
            drawn = self._draw_section
            self._magnify = ui.select(_MAGNIFY, value=0, label="deviations", on_change=drawn)
            self._magnify.props("dense outlined options-dense data-testid=magnify")
            self._magnify.classes("magnify")
        with ui.row().classes("items-center full-width no-wrap"):
            self._height_label = ui.label("height").classes("height-label")
            moved = self._height_moved
            self._height = ui.slider(min=0, max=1, step=0.001, value=0.5, on_change=moved)
            self._height.props('aria-label="height of the section" data-testid=height')
        with ui.element("div").classes("preview-charts full-width"):
            self._section = _chart("section", "Section at the chosen height")
            self._profile = _chart("profile", "Diameters over the height")
            self._motion = _chart("motion", "U, velocity, acceleration and jerk over a turn")
        columns = columns_of((name, name) for name in ("limit", "needed", "of", "left"))
        self._margins = ui.table(columns=columns, rows=[], row_key="limit")
        self._margins.props("dense flat hide-pagination :rows-per-page-options='[0]'")
        self._margins.props("data-testid=margins").classes("full-width margins")
        self._numbers = (self._verdict, self._speed, self._size, self._margins)

    def take(self, answer: Answer) -> None:
        """Show an answer of the engine."""
        stage = answer["stage"]
        if stage == "curves":
            self._take_curves(answer)
        elif stage == "table":
            self._take_table(answer)
        elif stage in ("problems", "lost"):
            self._state.text = "the text has problems: this is the last good preview"
            _mark_old(self._state, *self._numbers, self._section, self._profile, self._motion)

    def _take_curves(self, answer: Answer) -> None:
        self._curves = answer
        low, high = answer["heights_mm"]
        with self._showing:
            # With the colon they are numbers; the slider fails at the text of one.
            self._height.props(f":min={low!r} :max={high!r} :step={(high - low) / 500!r}")
            self._height.value = answer["height_mm"]
        self._height_label.text = f"height {answer['height_mm']:.6g} mm"
        self._draw_section()
        _set(self._profile, charts.profile(answer))
        _set(self._motion, charts.motion(answer, answer["limits"]))
        self._state.text = "the table is being made"
        self._state.classes(remove="is-old")
        _mark_old(*self._numbers)

    def _take_table(self, answer: Answer) -> None:
        word, speed = verdict_words(answer)
        self._verdict.text, self._speed.text = word, speed
        marks = ("is-good", "is-bad") if answer["is_feasible"] else ("is-bad", "is-good")
        self._verdict.classes(add=marks[0], remove=marks[1])
        self._size.clear()
        with self._size:
            for line in table_words(answer):
                ui.label(line)
        self._margins.rows = margin_rows(answer)
        self._state.text = "preview of this text"
        for element in self._numbers:
            element.classes(remove="is-old")

    def _draw_section(self) -> None:
        if not self._curves:
            return
        _set(self._section, charts.section(self._curves, float(self._magnify.value) or None))

    def _height_moved(self) -> None:
        if not self._showing.is_on and self._curves:
            self._on_height(float(self._height.value))


def _mark_old(*elements: ui.element) -> None:
    for element in elements:
        element.classes(add="is-old")


def _chart(key: str, name: str) -> ui.echart:
    chart = ui.echart({"animation": False}).classes(f"camturn-chart {key}-chart")
    return chart.props(f'role="img" aria-label="{name}"').props(f"data-testid={key}-chart")


def _set(chart: ui.echart, options: Answer) -> None:
    """Give a chart other options; one that showed an old preview does no more."""
    chart.classes(remove="is-old")
    redraw(chart, options)
