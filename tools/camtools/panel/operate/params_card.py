# SPDX-License-Identifier: Apache-2.0
"""All parameters: searched, edited one by one; saved, loaded, compared; kept and reverted."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nicegui import ui
from nicegui.events import GenericEventArguments

from camtools.base.errors import CamtoolsError
from camtools.link.rights_report import level_text
from camtools.panel.dialogs import cancel_button, confirmed, titled_dialog
from camtools.panel.operate.card import card
from camtools.panel.operate.file_button import file_button
from camtools.panel.operate.order_buttons import Orders
from camtools.panel.orders.order import Outcome
from camtools.panel.orders.parameter_set import ParameterSet
from camtools.panel.views.parameter_rows import judged, rows

_MOST_BYTES = 1 << 20
_COLUMNS = [
    {
        "name": name,
        "label": label,
        "field": name,
        "align": align,
        "sortable": True,
        "classes": kind,
        "headerClasses": kind,
    }
    for name, label, align, kind in (
        ("name", "Parameter", "left", "op-param-name"),
        ("value", "Value", "right", "op-number"),
        ("unit", "Unit", "left", "op-param-unit"),
        ("range", "Range", "left", "op-param-range"),
        ("group", "Group", "left", "op-param-group"),
        ("meaning", "Meaning", "left", "op-param-meaning"),
    )
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
            ui.label("Choose a row to change its value.").classes("op-notes")
            self._draw_level()
            self._draw_file()
            self._draw_memory()

    def _draw_file(self) -> None:
        with ui.element("div").classes("op-row"):
            file_button("Choose a file", ".toml", _MOST_BYTES, "params-file", self._take)
            save = ui.button("Save as file", on_click=self._save)
            save.props("no-caps outline data-testid=params-save")
            one = ui.button("Load the chosen file", on_click=self._load)
            self._orders.guard(one.props("no-caps outline data-testid=params-load"), "params")
            diff = ui.button("Compare with it", on_click=self._compare)
            diff.props("no-caps outline data-testid=params-diff")
        self._differs = ui.element("ul").classes("op-log").props("data-testid=params-differences")
        self._differs.set_visibility(False)

    def _draw_memory(self) -> None:
        with ui.element("div").classes("op-row"):
            one = ui.button("Keep over a restart", on_click=self._keep)
            self._orders.guard(one.props("no-caps outline data-testid=params-keep"), "keep")
            one = ui.button("Revert to the kept ones", on_click=self._revert)
            self._orders.guard(one.props("no-caps outline data-testid=params-revert"), "revert")
            one = ui.button("Defaults", on_click=self._defaults)
            self._orders.guard(one.props("no-caps outline data-testid=params-defaults"), "defaults")

    def _draw_level(self) -> None:
        with ui.element("div").classes("op-row"):
            self._level = ui.label("").classes("op-note").props("data-testid=level")
            one = ui.button("Unlock", on_click=self._unlock)
            self._orders.guard(one.props("no-caps outline data-testid=do-unlock"), "unlock")
            one = ui.button("Lock", on_click=self._lock)
            self._orders.guard(one.props("no-caps outline data-testid=do-lock"), "lock")

    async def _unlock(self) -> None:
        await self._orders.give("unlock")

    async def _lock(self) -> None:
        await self._orders.give("lock")

    def show_level(self, signals: Mapping[str, float]) -> None:
        """Show whether limits and constants may be changed, and how they can be."""
        text = f"The controller is {level_text(signals)}." if "level" in signals else ""
        if self._level.text != text:
            self._level.set_text(text)

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
                told = judged(name, str(field.value))
                problem.set_text(told if isinstance(told, str) else "")

            field.on_value_change(look)
            with ui.row().classes("op-dialog-buttons"):
                cancel_button(dialog, "param")
                agree = ui.button("Set", on_click=lambda: dialog.submit(field.value), color=None)
                agree.classes("op-do").props("no-caps unelevated data-testid=param-set")
        answer = await dialog
        if not dialog.is_deleted:  # as with its page
            dialog.delete()
        return None if answer is None else str(answer)

    def _save(self) -> None:
        if self._read is None:
            self._orders.refuse("save the parameters", "they are not read yet; wait a moment")
            return
        ui.download.content(self._read.text(), "parameters.toml")
        self._orders.tell("save the parameters", Outcome(True, "the browser has the file"))

    def _take(self, text: bytes, name: str) -> None:
        self._text, self._name = text, name
        self._compare()

    def _compare(self) -> None:
        words = f"compare with {self._name}" if self._name else "compare"
        if self._read is None or not self._text:
            why = "choose a file first" if not self._text else "they are not read yet"
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
        text = f"Those of {self._name} come into force at once, all or none."
        if await confirmed("Load parameters?", text, "Load"):
            words = f"load {self._name}"
            await self._orders.give("params_load", words, text=self._text, name=self._name)

    async def _keep(self) -> None:
        await self._orders.give("keep", "keep the parameters")

    async def _revert(self) -> None:
        await self._orders.give("revert", "revert the parameters")

    async def _defaults(self) -> None:
        text = "All parameters come to the defaults of the controller, those of the machine too."
        if await confirmed("Defaults?", text, "Defaults"):
            await self._orders.give("defaults", "defaults of all parameters")

    def show(self, read: ParameterSet | None) -> None:
        """Show the parameters when they were read anew."""
        if read is None:
            self._state.set_text("The parameters are being read ..")
        if read is None or read is self._read:
            return
        self._read = read
        self._state.set_text(f"Version {read.version}, checksum {read.checksum:08x}; {read.kept}.")
        self._table.update_rows(rows(read.values), clear_selection=False)
