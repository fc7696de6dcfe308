"""What the operator's page shows: numbers, progress, what is missing, the log, STOP."""

from collections.abc import Mapping
from math import floor
from typing import Any

from nicegui import ui

from camtools.link.refusal_text import FAULTS
from camtools.link.status_text import cut_progress, tick_load
from camtools.panel.operate.order_buttons import Orders
from camtools.panel.orders.commander import CommandLog
from camtools.panel.orders.snapshot import Snapshot
from camtools.panel.pieces import Figure, card, withdraw
from camtools.panel.views import convergence_chart, wording
from camtools.panel.views.availability import NextSteps, stop_order
from camtools.panel.views.wording import READ_IT, Field, box_text, look

_BIG = (wording.SPEED, wording.FOLLOWING)
_ROWS = (wording.ANGLE, *wording.AXES)


class FiguresCard:
    """What moves, in numbers."""

    def __init__(self) -> None:
        self._figures: list[tuple[Field, Figure]] = []
        with card("Spindle and axes", "figures", is_live=True):
            with ui.element("div").classes("op-big-row"):
                for field in _BIG:
                    self._add(field, "big")
                self._draw_dial()
            with ui.element("div").classes("op-figures"):
                for field in _ROWS:
                    self._add(field, "middle")
            self._notes = ui.label("").classes("op-notes").props("data-testid=notes")

    def _draw_dial(self) -> None:
        """Draw the angle, counter-clockwise from the right as on the drawing."""
        dial = ui.element("div").classes("op-dial").props("role=img")
        with dial.props('aria-label="Angle of the drawing before the tool"'):
            for name in ("0°", "90°", "180°", "270°"):
                ui.label(name).classes(f"op-dial-mark op-dial-{name[:-1]}")
            self._needle = ui.element("div").classes("op-needle")

    def _add(self, field: Field, size: str) -> None:
        self._figures.append((field, Figure(field.label, field.unit, field.key, size=size)))

    def show(self, snapshot: Snapshot) -> None:
        """Show the numbers."""
        s = snapshot.signals
        for field, figure in self._figures:
            figure.show(field.text(s))
        angle_deg = s.get("angle") if s.get("is_synced") else None
        turned = f"transform: rotate({-(angle_deg or 0.0):.1f}deg); visibility: visible"
        self._needle.style("visibility: hidden" if angle_deg is None else turned)
        tool = f"tool {int(s['tool'])}" if s.get("tool") else "no tool chosen"
        parts = [wording.homed_text(s), tool, wording.pass_text(s)]
        self._notes.set_text("; ".join(part for part in parts if part) + ". X at U = 0.")


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
        progress = cut_progress(snapshot.state, s)
        share = progress.fraction if snapshot.state != "ready" else None
        self._percent.show(wording.plain(None if share is None else floor(100 * share), 0))
        self._left.show(wording.clock(progress.left_s))
        self._parts.show(wording.PARTS.text(s))
        self._bar.set_value(round(share or 0.0, 3))
        self._text.set_text(progress.text)
        load = tick_load(s)
        self._load_bar.set_value(round(min(load.share or 0.0, 1.0), 2))
        late = wording.LATE_TICKS.text(s)
        self._load.set_text(f"{load.text}; {late} late ticks".replace(" us", " µs"))


class LearningCard:
    """How the following error falls while the controller learns: a small chart, and words."""

    def __init__(self) -> None:
        self._shown: list[list[float]] = []
        with card("Learning", "learning", is_live=True):
            self._words = ui.label("").classes("op-note").props("data-testid=learning")
            self._chart = ui.echart(convergence_chart.options()).classes("op-chart")
            label = "Error of U in the learned harmonics, over the turns used for learning"
            self._chart.props(f'role=img aria-label="{label}" data-testid=learning-chart')

    def show(self, snapshot: Snapshot, lessons: list[tuple[int, float]]) -> None:
        """Show what was learned up to now; the chart is sent when a lesson has come."""
        self._words.set_text(convergence_chart.words(snapshot.signals))
        points = convergence_chart.points_of(lessons)
        if points != self._shown:
            self._shown = points
            series = {"id": "lessons", "data": points}  # ECharts' setOption takes what has changed
            self._chart.run_chart_method("setOption", {"series": [series]})


_SHOWN = 30


def line_of(record: Mapping[str, Any]) -> str:
    """Return a record of the log as a line.

    >>> line_of({"time": "12:00", "visitor": "v1", "order": "feed",
    ...          "arguments": {"percent": 90.0}, "is_done": True, "outcome": "feed = 90 %"})
    '12:00  v1  feed percent=90.0: done - feed = 90 %'
    """
    arguments = "".join(f" {name}={value}" for name, value in record["arguments"].items())
    mark = "done" if record["is_done"] else "not done"
    what = f"{record['order']}{arguments}: {mark} - {record['outcome']}"
    return f"{record['time']}  {record['visitor']}  {what}"


class LogCard:
    """A list that is drawn anew when it has changed."""

    def __init__(self, log: CommandLog) -> None:
        self._log = log
        self._newest: list[str] = []
        with card("Commands given", "log"):
            self._list = ui.element("ol").classes("op-log").props("data-testid=log tabindex=0")
            self._list.props('aria-label="Commands given, the newest first"').mark("log")

    def show(self) -> None:
        """Show the newest lines."""
        lines = [line_of(record) for record in self._log.newest(_SHOWN)]
        if lines == self._newest:
            return
        self._newest = lines
        self._list.clear()
        with self._list:
            for text in lines:
                with ui.element("li"):
                    ui.label(text)


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

    def show(self, snapshot: Snapshot, steps: NextSteps) -> None:
        """Show what has changed."""
        shown = (snapshot.faults, tuple(steps.sentences), snapshot.is_connected)
        self._meaning.set_text(look(snapshot.state, is_connected=snapshot.is_connected).meaning)
        box = box_text(snapshot.signals)
        self._box_text.set_text(box)
        self._box.set_visibility(bool(box))
        self._problem.set_text(snapshot.problem)
        if shown == self._shown:
            return
        self._shown = shown
        self._draw_faults(snapshot.faults)
        self._steps.clear()
        with self._steps:
            for i, sentence in enumerate(steps.sentences):
                is_last = i == len(steps.missing)
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
        stop.props('no-caps unelevated aria-label="STOP: stops all motion. Key: Escape"')
        stop.props("data-testid=stop aria-keyshortcuts=Escape").mark("stop")
        with stop:
            ui.label("STOP").classes("op-stop-word")
            ui.label("Esc").classes("op-stop-key")

    async def stop(self) -> None:
        """End what moves, without a question."""
        withdraw(self._box.client)
        name = stop_order(self._state)
        await self._orders.give(name, "STOP" if name == "stop" else "STOP: drives off")

    def show(self, snapshot: Snapshot, steps: NextSteps) -> None:
        """Show the state."""
        self._state = snapshot.state
        style = look(snapshot.state, is_connected=snapshot.is_connected)
        if self._word.text != style.word:
            self._word.set_text(style.word)
            self._icon.props(f"name={style.icon}")
            self._box.classes(replace=f"op-state live tone-{style.tone}")
        self._first.set_text(steps.sentence)
        self._where.set_text(snapshot.work or snapshot.table_name or "no table")
