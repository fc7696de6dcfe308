"""The page /runs of the panel: all runs in a table, their reports, and what differs."""

import asyncio
from datetime import UTC, datetime
from typing import Any

from nicegui import ui
from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import FileResponse
from starlette.routing import Route

from camtools.base.errors import CamtoolsError
from camtools.panel.context import AppContext
from camtools.panel.design_service import DesignService, design_service_of
from camtools.panel.orders.commander import Visitor
from camtools.panel.page_frame import framed
from camtools.panel.pages.design import STYLE
from camtools.panel.pages.runs_comparison import MOST_COMPARED, ComparisonView
from camtools.panel.pieces import columns_of, confirmed, refusals_shown
from camtools.panel.runs.store import OWN, REPORT, Run

_BOX = '<q-checkbox dense v-model="props.selected" {name} />'
_SHOW_S = 0.5
_COLUMNS = (
    *(("at", "date (UTC)"), ("name", "run"), ("part", "part"), ("machine", "machine")),
    *(("settings", "settings"), ("status", "status"), ("verdict", "verdict")),
    *(("form", "form error / µm"), ("following", "following error / µm"), ("took", "time / s")),
)
_NOTHING = "No runs yet. Open Design, choose a part and press Cut it; the run then appears here."
_NUMBERS = ("form", "following", "took")


def row_of(run: Run) -> dict[str, Any]:
    """Return a run as a row of the table; numbers stay numbers, so that they sort."""
    day = "%Y-%m-%d".replace("-", "\N{NON-BREAKING HYPHEN}")
    at = datetime.fromtimestamp(run.at_s, UTC).strftime(f"{day} %H:%M:%S")
    return {
        "key": run.key,
        "at": at,
        "name": run.name if run.place == OWN else f"{run.name} (tools/run)",
        "part": run.part,
        "machine": run.machine or run.options.machine,
        "settings": run.options.text() if run.place == OWN else "",
        "status": run.status + (f": {run.told[:120]}" if run.told else ""),
        "verdict": run.verdict,
        "form": run.form_um and round(run.form_um, 4),
        "following": run.following_um and round(run.following_um, 4),
        "took": run.took_s and round(run.took_s, 1),
    }


class RunsPage:
    """What one visitor looks at."""

    def __init__(self, designs: DesignService, visitor: Visitor) -> None:
        self._designs, self._visitor = designs, visitor
        self._version: tuple[int, int] | None = None
        columns = columns_of(_COLUMNS, *_NUMBERS, is_sortable=True)
        with ui.row().classes("items-center q-gutter-sm"):
            for label, icon, name, press in (
                ("Compare", "compare_arrows", "compare", self._compare),
                ("End the simulation", "cancel", "stop-run", self._stop),
                ("Remove", "delete", "remove-runs", self._remove),
            ):
                ui.button(label, icon=icon, on_click=press).props(f"data-testid={name}")
            self._state = ui.label("").props('role="status"')
        self._table = ui.table(
            columns=columns, rows=[], row_key="key", selection="multiple", pagination=12
        )
        self._table.props(f'dense flat aria-label="runs" no-data-label="{_NOTHING}"')
        self._table.props("data-testid=runs-table").classes("full-width")
        # Quasar's own boxes have no names for those who do not see them.
        self._table.add_slot("header-selection", _BOX.format(name='aria-label="all runs"'))
        self._table.add_slot("body-selection", _BOX.format(name=':aria-label="props.key"'))
        self._comparison = ui.column().classes("full-width").props("data-testid=comparison")
        ui.timer(_SHOW_S, self._show)
        self._show()

    def _show(self) -> None:
        queue = self._designs.queue
        running = queue.running
        self._state.text = "" if running is None else f"{running.name}: {queue.progress.text}"
        version = self._designs.store.version()
        if version == self._version:
            return
        self._version = version
        rows = [row_of(run) for run in self._designs.store.runs()]
        keys = {row["key"] for row in rows}
        self._table.rows = rows
        self._table.selected = [row for row in self._table.selected if row["key"] in keys]
        self._table.update()

    def _picked(self) -> list[str]:
        return [str(row["key"]) for row in self._table.selected]

    async def _compare(self) -> None:
        """Show the runs that are picked beside each other, the oldest first."""
        try:
            runs = [self._designs.store.run(key) for key in self._picked()]
        except CamtoolsError as error:
            ui.notify(str(error), type="negative")
            return
        if not 1 <= len(runs) <= MOST_COMPARED:
            ui.notify(f"pick 1 to {MOST_COMPARED} runs in the table", type="warning")
            return
        runs.sort(key=lambda run: run.at_s)
        self._comparison.clear()
        with self._comparison:
            waits = ui.spinner(size="lg")
        view = ComparisonView(runs, self._designs.report_address)
        await asyncio.to_thread(view.read)
        waits.delete()
        with self._comparison:
            view.show()

    def _stop(self) -> None:
        picked = [key.removeprefix(f"{OWN}/") for key in self._picked()]
        self._designs.stop_runs(self._visitor, picked)

    async def _remove(self) -> None:
        keys = self._picked()
        if not keys:
            ui.notify("pick the runs in the table", type="warning")
            return
        runs = "this run" if len(keys) == 1 else f"these {len(keys)} runs"
        if not await confirmed(f"Remove {runs}?", "All files of it are gone then.", "Remove"):
            return
        for key in keys:
            with refusals_shown():
                self._designs.store.remove(key)
                self._designs.note(self._visitor, "remove runs", {"run": key}, "removed")
        self._table.selected = []


def add(context: AppContext) -> None:
    """Register the page."""
    designs = design_service_of(context)

    @ui.page("/runs", title="camturn: runs")
    def runs() -> None:
        with framed(context, "/runs") as visitor:
            ui.add_head_html(STYLE)
            RunsPage(designs, visitor)


# Scripts run, but in no origin: they reach neither the panel nor a network.
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'self'; sandbox allow-scripts"
)


def reports(designs: DesignService) -> Starlette:
    """Return an application that serves the report of every run, and no other file of its folder.

    It is not mounted below the token, which the scripts of a report must not see in their address.
    """

    def report(request: Request) -> FileResponse:
        place, name = request.path_params["place"], request.path_params["name"]
        try:
            path = designs.store.run(f"{place}/{name}").folder / REPORT
        except CamtoolsError as error:
            raise HTTPException(404, "no such run") from error
        if path.is_symlink() or not path.is_file():
            raise HTTPException(404, "this run has no report")
        return FileResponse(path, headers={"content-security-policy": _POLICY})

    return Starlette(routes=[Route(f"/{{place}}/{{name}}/{REPORT}", report)])
