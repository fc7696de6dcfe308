# SPDX-License-Identifier: Apache-2.0
"""The form beside the text: a card for each table, a field for each key, made from the model.

The field that was touched last has the dial on top: a slider around its value and two step buttons.

Marks of elements: form, form-all, dial, dial-down, dial-up, and field-NAME of each field, where
NAME is its dotted name.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nicegui import ui

from camtools.panel.design.fields import FormField, FormTable, dial_of, form_of, step_of, typed
from camtools.pipeline.registry import kinds

OnEdit = Callable[[FormField, Any], None]


def shown_text(value: object) -> str:
    """Return a value as somebody would type it.

    >>> shown_text([0, 1.5]), shown_text(None), shown_text(True)
    ('0, 1.5', '', 'true')
    """
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return ", ".join(str(one) for one in value)
    return str(value)


class FormView:
    """Fields of a part file.

    Parameters
    ----------
    on_edit : callable
        Called with a field and its new value; None removes it from the text.
    """

    def __init__(self, on_edit: OnEdit) -> None:
        self._on_edit = on_edit
        self._fields: dict[str, FormField] = {}
        self._inputs: dict[str, Any] = {}
        self._shape: tuple[object, ...] = ()
        self._tables: tuple[FormTable, ...] = ()
        self._is_showing = False
        self._touched = ""
        with ui.row().classes("items-center full-width no-wrap dial"):
            self._dial_name = ui.label("select a number to adjust it here")
            ui.button(icon="remove", on_click=lambda: self._step(-1)).props(
                'flat round dense aria-label="a step down"'
            ).props("data-testid=dial-down")
            self._dial = (
                ui.slider(min=0, max=1, step=0.01, value=0, on_change=self._turned)
                .props('aria-label="value of the last selected field"')
                .props("data-testid=dial")
            )
            ui.button(icon="add", on_click=lambda: self._step(1)).props(
                'flat round dense aria-label="a step up"'
            ).props("data-testid=dial-up")
        self._all = ui.switch("all keys, including those not in the text").props(
            'data-testid="form-all"'
        )
        self._all.on_value_change(lambda: self._build(force=True))
        self._body = ui.column().classes("full-width q-gutter-sm").props("data-testid=form")
        self._dial.disable()

    def show(self, kind_name: str, values: dict[str, Any]) -> None:
        """Show the values of a text."""
        kind = next((one for one in kinds() if one.name == kind_name), kinds()[0])
        self._tables = form_of(kind.name, kind.model, values)
        self._fields = {field.dotted: field for one in self._tables for field in one.fields}
        self._build(force=False)
        self._is_showing = True
        for name, element in self._inputs.items():
            self._set(element, self._fields[name])
        self._is_showing = False
        self._show_dial()

    def problems(self, told: list[dict[str, Any]]) -> None:
        """Show what is wrong beside the fields."""
        by_field = {one["field"]: one["text"] for one in reversed(told)}
        for name, element in self._inputs.items():
            text = by_field.get(name, "")
            if element.props.get("error-message", "") != text:
                element.props["error"] = bool(text)
                element.props["error-message"] = text
                element.update()

    def _shown(self) -> list[tuple[FormTable, list[FormField]]]:
        """Return the tables and fields that are shown."""
        found = []
        for table in self._tables:
            fields = [
                field
                for field in table.fields
                if self._all.value
                or field.value is not None
                or (field.is_required and table.is_there)
            ]
            if fields and (table.is_there or self._all.value):
                found.append((table, fields))
        return found

    def _build(self, *, force: bool) -> None:
        """Make the fields anew where other ones are to be shown."""
        shown = self._shown()
        shape = tuple((field.dotted, field.sort) for _, fields in shown for field in fields)
        if shape == self._shape and not force:
            return
        self._shape = shape
        self._inputs.clear()
        self._body.clear()
        with self._body:
            for table, fields in shown:
                with ui.expansion(table.title, value=table.is_there).classes("full-width card"):
                    if table.meaning:
                        ui.label(table.meaning).classes("text-caption")
                    with ui.element("div").classes("form-grid"):
                        for field in fields:
                            self._inputs[field.dotted] = self._input(field)

    def _input(self, field: FormField) -> Any:  # noqa: ANN401 (elements of several types)
        name = field.dotted
        unit = f" / {field.unit}" if field.unit else ""
        label = f"{field.name}{unit}"
        hint = "; ".join(filter(None, (field.range_text, field.meaning)))
        if field.sort == "choice":
            choices = {"": f"({shown_text(field.default)})"} if not field.is_required else {}
            choices |= {str(one): str(one) for one in field.choices}
            element: Any = ui.select(choices, label=label, value=shown_text(field.value))
            if field.value is not None and str(field.value) not in choices:
                element.options[str(field.value)] = str(field.value)
        elif field.sort == "switch":
            choices = {"": f"({shown_text(field.default)})", "true": "true", "false": "false"}
            element = ui.select(choices, label=label, value=shown_text(field.value))
        else:
            element = ui.input(label=label, value=shown_text(field.value))
            element.props("debounce=250")
            default = shown_text(field.default)
            if default:
                element.props["placeholder"] = default
            if field.sort == "other":
                element.props("readonly")
        element.props["hint"] = hint
        element.props("dense outlined stack-label hide-bottom-space bottom-slots")
        element.on_value_change(lambda event, name=name: self._typed(name, event.value))
        element.on("focus", lambda _, name=name: self._touch(name), args=[])
        return element.props(f"data-testid=field-{name}").classes("full-width")

    def _set(self, element: Any, field: FormField) -> None:  # noqa: ANN401 (as above)
        text = shown_text(field.value)
        if isinstance(element, ui.select) and text not in element.options:
            element.set_options(dict(element.options) | {text: text})
        if element.value == text:
            return
        try:
            same = typed(field, str(element.value or "")) == field.value
        except ValueError:
            same = False
        if not same:  # what is typed now, 2. for example, is not taken from under the fingers
            element.value = text

    def _typed(self, name: str, text: object) -> None:
        if self._is_showing or name not in self._fields:
            return
        field = self._fields[name]
        try:
            value = typed(field, str(text if text is not None else ""))
        except ValueError as error:
            element = self._inputs[name]
            element.props["error"], element.props["error-message"] = True, str(error)
            element.update()
            return
        if repr(value) != repr(field.value):
            self._on_edit(field, value)

    def _touch(self, name: str) -> None:
        self._touched = name
        self._show_dial()

    def _number(self) -> tuple[FormField, float] | None:
        field = self._fields.get(self._touched)
        if field is None or field.sort not in ("number", "whole", "numbers"):
            return None
        value = field.value if field.value is not None else field.default
        if isinstance(value, bool) or not isinstance(value, int | float):
            return None
        return field, value

    def _show_dial(self) -> None:
        found = self._number()
        if found is None:
            self._dial.disable()
            self._dial_name.text = "select a number to adjust it here"
            return
        field, value = found
        low, high = dial_of(field, value)
        step = step_of(value) / 10 if field.sort != "whole" else 1
        if not low <= value <= high:
            return
        self._is_showing = True
        inside = self._dial.props.get("min", 0) < value < self._dial.props.get("max", 0)
        if self._dial_name.text != field.dotted or not inside:
            self._dial.props["min"], self._dial.props["max"] = low, high
            self._dial.props["step"] = step
        self._dial.value = value
        self._dial.enable()
        self._dial_name.text = field.dotted
        self._is_showing = False

    def _turned(self) -> None:
        found = self._number()
        if self._is_showing or found is None:
            return
        self._give(found[0], float(self._dial.value))

    def _step(self, sign: int) -> None:
        found = self._number()
        if found is None:
            return
        field, value = found
        step = 1 if field.sort == "whole" else step_of(value)
        wanted = value + sign * step
        low = wanted if field.low is None else max(wanted, field.low)
        self._give(field, low if field.high is None else min(low, field.high))

    def _give(self, field: FormField, value: float) -> None:
        rounded: float | int = float(f"{value:.9g}")
        is_whole = field.sort == "whole" or isinstance(field.value, int)
        if is_whole and float(rounded).is_integer():
            rounded = int(rounded)
        if rounded != field.value:
            self._on_edit(field, rounded)
