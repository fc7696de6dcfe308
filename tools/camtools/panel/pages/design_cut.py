"""Cut it: machine, speed, feed, learning and seed; progress, time left, and the report beside.

>>> time_left_text(12.3, 30.0)
'12 s so far, about 18 s left'
"""

import time
from collections.abc import Awaitable, Callable
from dataclasses import asdict

from nicegui import ui

from camtools.base.errors import CamtoolsError
from camtools.base.text import duration_text
from camtools.panel.design.part_library import checked_name
from camtools.panel.design_service import DesignService
from camtools.panel.orders.commander import Visitor
from camtools.panel.pieces import file_button, refusals_shown
from camtools.panel.runs.store import DONE, OF_THE_PART, OWN, RUNNING, WAITING, RunOptions

_SHOW_S = 0.25
_MAX_MACHINE_BYTES = 100_000


def time_left_text(gone_s: float, whole_s: float | None) -> str:
    """Return how long a run has taken, and how much longer it will take where that is known."""
    gone = f"{gone_s:.0f} s so far"
    if whole_s is None:
        return gone
    return f"{gone}, about {duration_text(max(1.0, round(whole_s - gone_s)))} left"


class CutView:
    """The card that cuts the part of the editor; `cut` starts a run and returns its name."""

    def __init__(
        self, designs: DesignService, visitor: Visitor, cut: Callable[[RunOptions], Awaitable[str]]
    ) -> None:
        self._designs, self._visitor, self._cut = designs, visitor, cut
        self._mine = ""
        self._shown_report = ""
        with ui.row().classes("items-center q-gutter-sm"):
            self._choices()
            start = ui.button("Cut it", icon="play_arrow", on_click=self._start)
            start.props("data-testid=cut")
            self._stop = ui.button("End the simulation", icon="cancel", on_click=self._stop_run)
            self._stop.props("data-testid=cut-stop")
        self._bar = ui.linear_progress(value=0, show_value=False)
        self._bar.props('aria-label="progress of the cut" data-testid=cut-progress')
        self._state = ui.label("").props('role="status" data-testid=cut-state')
        self._frame = ui.element("iframe").classes("report-frame").props("data-testid=cut-report")
        self._frame.props('sandbox="allow-scripts" title="report of the cut" loading="lazy"')
        self._frame.set_visibility(False)
        ui.timer(_SHOW_S, self.show)
        self.show()

    def _choices(self) -> None:
        self._machine = ui.select(self._machines(), value=OF_THE_PART, label="machine")
        self._machine.props("dense outlined options-dense data-testid=cut-machine")
        self._machine.classes("cut-field")
        self._rpm = ui.number("speed / r/min", min=0, placeholder="of the part")
        self._feed = ui.number("feed / mm/turn", min=0, placeholder="of the part")
        self._seed = ui.number("seed", value=1, min=0, precision=0)
        for name, field in {"rpm": self._rpm, "feed": self._feed, "seed": self._seed}.items():
            field.props(f"dense outlined stack-label data-testid=cut-{name}").classes("cut-field")
        self._learns = ui.switch("learning", value=True).props("data-testid=cut-learns")
        with self._learns:
            ui.tooltip("off: the controller does not learn, even if it measures U")
        with ui.row():
            name, take = "cut-machine-upload", self._take_machine
            file_button("Machine file", ".toml", _MAX_MACHINE_BYTES, name, take)

    def _machines(self) -> dict[str, str]:
        names = self._designs.machine_names()
        return {OF_THE_PART: "limits of the part"} | {name: name for name in names}

    def _take_machine(self, data: bytes, file: str) -> None:
        with refusals_shown():
            name = checked_name(file.removesuffix(".toml"))
            self._designs.keep_machine(name, data)
            self._machine.set_options(self._machines(), value=name)
            self._designs.note(self._visitor, "machine upload", {"name": name}, "kept")

    def _options(self) -> RunOptions:
        rpm, feed = self._rpm.value, self._feed.value
        return RunOptions(
            machine=str(self._machine.value),
            rpm=None if rpm is None else float(rpm),
            feed_mm=None if feed is None else float(feed),
            learns=bool(self._learns.value),
            seed=int(self._seed.value or 0),
        )

    async def _start(self) -> None:
        try:
            options = self._options()
            self._mine = await self._cut(options)
        except CamtoolsError as error:
            for line in error.lines[:5]:
                ui.notify(line, type="negative", timeout=10_000)
            return
        self._designs.note(self._visitor, "cut", asdict(options) | {"run": self._mine}, "queued")
        self.show()

    def _stop_run(self) -> None:
        self._designs.stop_runs(self._visitor, [self._mine])

    def show(self) -> None:
        """Bring progress and report up to date."""
        queue = self._designs.queue
        self._stop.set_visibility(queue.running is not None)
        if queue.running is not None:
            self._show_progress()
            return
        self._bar.value = 0
        self._show_end()

    def _show_progress(self) -> None:
        queue = self._designs.queue
        assert queue.running is not None
        progress, gone_s = queue.progress, time.time() - queue.begun_s
        whole_s = self._designs.last_took_s(queue.running)
        if progress.left_s is not None:
            whole_s = gone_s + progress.left_s
        share = progress.share
        if share is None and whole_s:
            share = min(0.99, gone_s / whole_s)
        self._bar.value = share or 0.0
        waits = f"; {len(queue.waiting)} waiting" if queue.waiting else ""
        left = time_left_text(gone_s, whole_s)
        self._state.text = f"{queue.running.name}: {progress.text}; {left}{waits}"

    def _show_end(self) -> None:
        if not self._mine or self._mine == self._shown_report:
            return
        try:
            run = self._designs.store.run(f"{OWN}/{self._mine}")
        except CamtoolsError as error:
            self._state.text, self._shown_report = str(error), self._mine
            return
        if run.status in (WAITING, RUNNING):
            return
        if run.status == DONE:
            self._state.text = f"{run.name}: {run.verdict}, {run.options.text()}"
            self._frame.props["src"] = self._designs.report_address(run.key)
            self._frame.update()
            self._frame.set_visibility(run.has_report)
        else:
            self._state.text = f"{run.name}: {run.status}; {run.told}"
        self._shown_report = self._mine
