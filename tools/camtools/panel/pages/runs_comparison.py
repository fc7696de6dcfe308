"""Runs side by side: what differs, figures, errors as curves and maps, reports.

>>> MOST_COMPARED
4
"""

from collections.abc import Callable, Sequence

from nicegui import run as background
from nicegui import ui
from nicegui.events import ValueChangeEventArguments

from camtools.base.quantities import Floats
from camtools.panel.pieces import columns_of, redraw
from camtools.panel.runs import compare as charts
from camtools.panel.runs.compare import (
    DiffLine,
    ErrorCurves,
    differing,
    error_curves,
    figures_of,
    heights_of,
    machine_text_of,
    part_text,
    section_error,
    settings_rows,
)
from camtools.panel.runs.store import Run
from camtools.panel.views.echart import Options

MOST_COMPARED = 4
_BANDS = 60  # of the height, for a section
_DIFF_CLASS = {"+": "diff-add", "-": "diff-del", "@": "text-italic"}


class ComparisonView:
    """Runs that were picked, compared with the first one."""

    def __init__(self, runs: Sequence[Run], report_address: Callable[[str], str]) -> None:
        self._runs, self._report_address = list(runs), report_address
        self._names = [run.name for run in runs]
        self._curves: list[tuple[str, ErrorCurves | None]] = []
        self._ends_mm = (0.0, 1.0)
        self._sections: list[tuple[str, tuple[Floats, Floats]]] = []

    def read(self) -> None:
        """Read what the runs left; it takes a second or so, and touches no element."""
        heights_mm = [height for run in self._runs for height in heights_of(run.folder)]
        if heights_mm:
            self._ends_mm = min(heights_mm), max(heights_mm)
        self._curves = [(run.name, error_curves(run.folder, self._ends_mm)) for run in self._runs]
        self._read_sections(sum(self._ends_mm) / 2)

    def _read_sections(self, z_mm: float) -> None:
        band_mm = (self._ends_mm[1] - self._ends_mm[0]) / _BANDS
        found = [(run.name, section_error(run.folder, z_mm, band_mm)) for run in self._runs]
        self._sections = [(name, section) for name, section in found if section is not None]

    def show(self) -> None:
        """Make the elements."""
        ui.label(" and ".join(self._names)).classes("text-h6")
        self._show_rows()
        if len(self._runs) > 1:
            self._show_differences()
        self._show_curves()
        self._show_maps()
        self._show_reports()

    def _show_rows(self) -> None:
        with ui.element("div").classes("compare-pair"):
            rows = [
                {"what": name} | {f"r{i}": text for i, text in enumerate(texts)}
                for name, texts in settings_rows(self._runs)
            ]
            _table("what they were cut with", self._names, rows, []).props("data-testid=settings")
            figures = figures_of(self._runs)
            several = range(1, len(self._runs))
            numbers = [
                {"what": f"{figure.name} / {figure.unit}" if figure.unit else figure.name}
                | {f"r{i}": figure.text(i) for i in range(len(self._runs))}
                | {f"d{i}": figure.difference(i) for i in several}
                for figure in figures
            ]
            more = [(f"d{i}", "difference" if i == 1 else f"difference {i + 1}") for i in several]
            _table("figures", self._names, numbers, more).props("data-testid=figures")

    def _show_differences(self) -> None:
        first = self._runs[0]
        for run in self._runs[1:]:
            names = f"{first.name} to {run.name}"
            parts = differing(part_text(first), part_text(run))
            _diff(f"part file: {names}", parts).props("data-testid=diff-part")
            machines = differing(machine_text_of(first), machine_text_of(run))
            # Two machines may differ in every line.
            box = _diff(f"machine: {names}", machines, is_open=False)
            box.props("data-testid=diff-machine")

    def _show_curves(self) -> None:
        with ui.element("div").classes("compare-pair"):
            gauged = [(name, curves) for name, curves in self._curves if curves is not None]
            _chart(charts.over_height(gauged), "over-height")
            _chart(charts.over_angle(gauged), "over-angle")
        low, high = self._ends_mm
        middle = (low + high) / 2
        slider = ui.slider(min=low, max=high, step=(high - low) / _BANDS, value=middle)
        slider.props('aria-label="height of the section" label data-testid=section-height')
        chart = _chart(charts.sections(self._sections, middle), "section-error")

        async def moved() -> None:
            z_mm = float(slider.value)
            await background.io_bound(self._read_sections, z_mm)
            redraw(chart, charts.sections(self._sections, z_mm))

        slider.on("change", moved, args=[])

    def _show_maps(self) -> None:
        there = [curves.map_um for _, curves in self._curves if curves is not None]
        if not there:
            return
        scale_um = charts.scale_of(there)
        with ui.element("div").classes("compare-pair"):
            for i, (name, curves) in enumerate(self._curves):
                if curves is None:
                    ui.label(f"{name}: not gauged")
                else:
                    _chart(charts.error_map(name, curves, scale_um), f"error-map-{i}")

    def _show_reports(self) -> None:
        """Offer the reports, one at a time: each has a plotting library and all its pictures."""
        for run in self._runs:
            if not run.has_report:
                ui.label(f"{run.name}: no report; {run.told}")
        there = {run.key: f"Report of {run.name}" for run in self._runs if run.has_report}

        def chosen(event: ValueChangeEventArguments[str | None]) -> None:
            frame.set_visibility(bool(event.value))
            frame.props["src"] = self._report_address(event.value) if event.value else ""

        ui.toggle(there, clearable=True, on_change=chosen).props("no-caps data-testid=reports")
        frame = ui.element("iframe").classes("report-frame").props("data-testid=report")
        frame.props('sandbox="allow-scripts" title="report"').set_visibility(False)


def _table(
    title: str, names: Sequence[str], rows: list[dict[str, str]], more: list[tuple[str, str]]
) -> ui.table:
    labels = [("what", ""), *((f"r{i}", name) for i, name in enumerate(names)), *more]
    table = ui.table(columns=columns_of(labels), rows=rows, row_key="what", title=title)
    return table.props("dense flat wrap-cells hide-pagination :rows-per-page-options='[0]'")


def _diff(title: str, lines: list[DiffLine], *, is_open: bool = True) -> ui.expansion:
    """Show lines that differ; their text is data."""
    heading = f"{title}: {len(lines)} lines" if lines else f"{title}: identical"
    box = ui.expansion(heading, value=bool(lines) and is_open).classes("full-width")
    with box, ui.column().classes("q-gutter-none diff-lines"):
        for kind, text in lines:
            shown = ui.label(f"{kind} {text}" if kind != "@" else text).classes("diff")
            shown.classes(_DIFF_CLASS.get(kind, ""))
    return box


def _chart(options: Options, key: str) -> ui.echart:
    chart = ui.echart(options).classes("camturn-chart compare-chart")
    name = key.replace("-", " ")
    return chart.props(f'role="img" aria-label="{name}" data-testid={key}')
