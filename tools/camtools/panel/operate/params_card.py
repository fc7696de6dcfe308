"""All parameters: searched, edited, kept, compared; and the loop of a U that takes forces."""

from base64 import b64encode
from collections.abc import Mapping
from functools import partial
from typing import Any

from nicegui import ui
from nicegui.events import GenericEventArguments

from camtools.base.errors import CamtoolsError
from camtools.link.status_text import level_text
from camtools.panel.operate.order_buttons import Orders
from camtools.panel.orders.loop_tuner import Tuned
from camtools.panel.orders.order import Outcome
from camtools.panel.orders.snapshot import ParameterSet, Snapshot
from camtools.panel.pieces import (
    answer_buttons,
    answer_of,
    asks,
    card,
    columns_of,
    confirmed,
    file_button,
    outlined,
    titled_dialog,
)
from camtools.panel.views.parameter_rows import has_force_drive, judged, loop_text, rows

_MOST_BYTES = 1 << 20
_DEFAULTS = "All parameters are set to the controller's defaults, including those of the machine."
_LABELS = (
    *(("name", "Parameter"), ("value", "Value"), ("unit", "Unit"), ("range", "Range")),
    *(("group", "Group"), ("meaning", "Meaning")),
)
_CLASSES = {name: f"op-param-{name}" for name, _ in _LABELS} | {"value": "op-number"}
_COLUMNS = [
    column | dict.fromkeys(("classes", "headerClasses"), _CLASSES[column["name"]])
    for column in columns_of(_LABELS, "value", is_sortable=True)
]


class ParamsCard:
    """The table, and what is done with all parameters at once."""

    def __init__(self, orders: Orders) -> None:
        self._orders = orders
        self._read: ParameterSet | None = None
        self._text, self._name = b"", ""
        with card("Parameters", "params"):
            self._state = ui.label("").classes("op-note").props("data-testid=params-state")
            search = ui.input("Search name, group or meaning").classes("op-input op-wide")
            search.props("clearable dense data-testid=params-search")
            self._table = ui.table(rows=[], columns=_COLUMNS, row_key="name", pagination=12)
            self._table.classes("op-params").props("dense flat data-testid=params")
            self._table.bind_filter_from(search, "value", lambda text: text or "")
            self._table.on("rowClick", self._edit)
            ui.label("Select a row to change its value.").classes("op-notes")
            self._draw_level()
            self._draw_file()
            with ui.element("div").classes("op-row"):
                keep = partial(orders.give, "keep", "keep the parameters")
                orders.small_button("Keep for the next start", "params-keep", "keep", keep)
                revert = partial(orders.give, "revert", "revert the parameters")
                label = "Revert to the kept parameters"
                orders.small_button(label, "params-revert", "revert", revert)
                orders.small_button("Defaults", "params-defaults", "defaults", self._defaults)

    def _draw_file(self) -> None:
        with ui.element("div").classes("op-row"):
            file_button("Choose a file", ".toml", _MOST_BYTES, "params-file", self._take)
            outlined("Save as file", "params-save", self._save)
            load = "Load the chosen file"
            self._orders.small_button(load, "params-load", "params", self._load)
            outlined("Compare with the chosen file", "params-diff", self._compare)
        self._differs = ui.element("ul").classes("op-log").props("data-testid=params-differences")
        self._differs.set_visibility(False)

    def _draw_level(self) -> None:
        with ui.element("div").classes("op-row"):
            self._level = ui.label("").classes("op-note").props("data-testid=level")
            press = partial(self._orders.give, "lock")
            self._orders.small_button("Lock", "do-lock", "lock", press)

    async def _edit(self, event: GenericEventArguments) -> None:
        row: dict[str, Any] = event.args[1]
        text = await self._asked(row)
        if text is None:
            return
        name = str(row["name"])
        value = judged(name, text)
        if isinstance(value, str):
            self._orders.refuse(f"{name} = {text}", value)
        else:
            await self._orders.give("set", f"{name} = {value}", name=name, value=value)

    async def _asked(self, row: dict[str, Any]) -> str | None:
        """Ask for a new value; None: it stays."""
        name = str(row["name"])
        with titled_dialog(name, "param") as dialog:
            ui.label(str(row["meaning"]))
            ui.label(f"{row['range']} {row['unit']}, default {row['default']}")
            field = ui.input("Value", value=str(row["value"]))
            field.props("data-testid=param-value inputmode=numeric")
            problem = ui.label("").classes("op-problem").props("role=alert")

            def look() -> None:
                result = judged(name, str(field.value))
                problem.set_text(result if isinstance(result, str) else "")

            field.on_value_change(look)
            answer_buttons(dialog, "param", "Set", "param-set", lambda: field.value)
        answer = await answer_of(dialog)
        return None if answer is None else str(answer)

    def _save(self) -> None:
        outcome = Outcome(False, "not read from the controller yet; wait a moment")
        if self._read is not None:
            ui.download.content(self._read.text(), "parameters.toml")
            outcome = Outcome(True, "sent to the browser as a file")
        self._orders.tell("save the parameters", outcome)

    def _take(self, text: bytes, name: str) -> None:
        self._text, self._name = text, name
        self._compare()

    def _compare(self) -> None:
        words = f"compare with {self._name}" if self._name else "compare"
        if self._read is None or not self._text:
            why = "choose a file first" if not self._text else "not read from the controller yet"
            self._orders.refuse(words, why)
            return
        try:
            differences = self._read.differences(self._text, self._name)
        except CamtoolsError as error:
            self._orders.refuse(words, str(error))
            return
        self._differs.set_visibility(bool(differences))
        self._differs.clear()
        with self._differs:
            for name, (there, here) in differences.items():
                with ui.element("li"):
                    ui.label(f"{name}: file {there}, controller {here}")
        self._orders.tell(words, Outcome(True, f"{len(differences)} parameters differ"))

    async def _load(self) -> None:
        if not self._text:
            self._orders.refuse("load parameters", "choose a file first")
            return
        text = f"The parameters of {self._name} take effect at once, all or none."
        if await confirmed("Load parameters?", text, "Load"):
            words = f"load {self._name}"
            await self._orders.give("params_load", words, text=self._text, name=self._name)

    async def _defaults(self) -> None:
        if await confirmed("Defaults?", _DEFAULTS, "Defaults"):
            await self._orders.give("defaults", "defaults of all parameters")

    def show(self, signals: Mapping[str, float], read: ParameterSet | None) -> None:
        """Show the parameters when they were read anew, and whether they may be changed."""
        text = f"The controller is {level_text(signals)}." if "level" in signals else ""
        if self._level.text != text:
            self._level.set_text(text)
        if read is None:
            self._state.set_text("Reading the parameters ..")
        if read is None or read is self._read:
            return
        self._read = read
        self._state.set_text(f"Version {read.version}, checksum {read.checksum:08x}; {read.kept}.")
        self._table.update_rows(rows(read.values), clear_selection=False)


_MOVES = "U moves to and fro for some seconds. Is the tool clear of the work, with the door shut?"
_SETS = "The drives go off, and what is proposed takes effect: enable and home again."
_MEANING = (
    "At the first power-up Pulse pushes U in both directions, for the sign of its force, its mass "
    "and its friction. Measure excites U in its loop as it is, finds mass, friction, delay and "
    "modes, and proposes a loop with margins of 6 dB and 30 degrees. Apply sets what is proposed. "
    "Measure again to see the result, then keep the parameters."
)


class ForceDriveCard:
    """Out of sight where U takes positions."""

    def __init__(self, orders: Orders) -> None:
        self._orders = orders
        self._service = orders.context.service
        self._shown: Tuned | None = None
        with card("Drive of U", "drive") as self._card:
            ui.label(_MEANING).classes("op-note")
            self._loop = ui.label("").classes("op-box").props("data-testid=drive-loop")
            with ui.element("div").classes("op-row"):
                self._force = ui.number("Force of the pulse", value=15.0, min=0.1, suffix="N")
                self._force.classes("op-input").props("data-testid=pulse-force")
                orders.small_button("Pulse", "do-push_u", "push_u", self._push)
                orders.small_button("Measure", "do-measure_loop", "measure_loop", self._measure)
                own = self._why_no_loop
                orders.small_button("Apply", "do-apply_loop", "apply_loop", self._apply, own)
            self._work = ui.label("").classes("op-note").props("role=status")
            self._problem = ui.label("").classes("op-problem").props("data-testid=drive-problem")
            self._report = ui.label("").classes("op-report").props("data-testid=drive-report")
            self._picture = ui.element("img").classes("op-picture")
            self._picture.props('alt="Measured and proposed loop of U" data-testid=drive-picture')
            self._picture.set_visibility(False)
        self._card.set_visibility(False)
        asks("measure_loop", self._measure)

    def _why_no_loop(self) -> str:
        newest = self._service.tuned()
        return "" if newest is not None and newest.settings else "measure first"

    async def _push(self) -> None:
        if await confirmed("Push U?", _MOVES, "Push"):
            force_n = float(self._force.value or 0.0)
            await self._orders.give("push_u", f"push U by {force_n:g} N", force_n=force_n)

    async def _measure(self) -> None:
        if await confirmed("Measure U?", _MOVES, "Measure", "measure_loop"):
            await self._orders.give("measure_loop", "measure U")

    async def _apply(self) -> None:
        asked = self._service.tuned()
        if not await confirmed("Apply what is proposed?", _SETS, "Apply"):
            return
        if self._service.tuned() is not asked:
            self._orders.refuse("apply the loop", "U was measured again meanwhile; look, and apply")
            return
        await self._orders.give("apply_loop", "apply the loop")

    def show(self, snapshot: Snapshot, read: ParameterSet | None) -> None:
        """Show the loop in force, what runs, and what the newest measurement shows."""
        self._work.set_text(f"Busy with {snapshot.work}." if snapshot.work else "")
        if read is not None:
            self._card.set_visibility(has_force_drive(read.values))
            self._loop.set_text(loop_text(read.values))
        newest = self._service.tuned()
        if newest is self._shown:
            return
        self._shown = newest
        self._problem.set_text(newest.problem if newest else "")
        self._report.set_text(newest.text if newest else "")
        picture = newest.picture if newest else b""
        self._picture.set_visibility(bool(picture))
        if picture:
            data = b64encode(picture).decode("ascii")
            self._picture.props(f'src="data:image/png;base64,{data}"')
