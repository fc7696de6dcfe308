"""The form beside the text: a card for each table, a field for each key, made from the model.

The field that was touched last has the dial on top: a slider around its value and two step buttons.
"""

from collections.abc import Callable
from typing import Any

from nicegui import ui

from camtools.panel.design.document import dial_of, is_short, shown_text, step_of, typed, within
from camtools.panel.pieces import Showing
from camtools.part.schema import Key, Table, plain
from camtools.pipeline.load import keys_of

OnEdit = Callable[[Key, Any], None]
_NO_DIAL = "select a number to adjust it here"


class FormView:
    """Fields of a part file.

    `on_edit`: called with a field and its new value; None removes it from the text.
    """

    def __init__(self, on_edit: OnEdit) -> None:
        self._on_edit = on_edit
        self._keys: dict[str, Key] = {}
        self._inputs: dict[str, Any] = {}
        self._shape: tuple[object, ...] = ()
        self._tables: list[Table] = []
        self._showing = Showing()
        self._touched = ""
        with ui.row().classes("items-center full-width no-wrap dial"):
            self._dial_name = ui.label(_NO_DIAL)
            self._step_button("remove", "down", -1)
            self._dial = ui.slider(min=0, max=1, step=0.01, value=0, on_change=self._turned)
            self._dial.props('aria-label="value of the last selected field" data-testid=dial')
            self._step_button("add", "up", 1)
        self._all = ui.switch("all keys, including those not in the text")
        self._all.props("data-testid=form-all")
        self._all.on_value_change(lambda: self._build(force=True))
        self._body = ui.column().classes("full-width q-gutter-sm").props("data-testid=form")
        self._dial.disable()

    def _step_button(self, icon: str, sense: str, sign: int) -> None:
        button = ui.button(icon=icon, on_click=lambda: self._step(sign))
        button.props(f'flat round dense aria-label="a step {sense}" data-testid=dial-{sense}')

    def show(self, kind: str, tree: dict[str, Any]) -> None:
        """Show the values of a text."""
        self._tables = keys_of(kind).tables(tree)
        self._keys = {key.dotted: key for table in self._tables for key in table.keys}
        self._build(force=False)
        with self._showing:
            for name, element in self._inputs.items():
                self._set(element, self._keys[name])
        self._show_dial()

    def problems(self, problems: list[dict[str, Any]]) -> None:
        """Show what is wrong beside the fields."""
        by_field = {problem["field"]: problem["text"] for problem in reversed(problems)}
        for name, element in self._inputs.items():
            text = by_field.get(name, "")
            if element.props.get("error-message", "") != text:
                _show_error(element, text)

    def _shown(self) -> list[tuple[Table, list[Key]]]:
        found = []
        for table in self._tables:
            keys = [
                key
                for key in table.keys
                if self._all.value or key.value is not None or (key.is_required and table.is_there)
            ]
            if keys and (table.is_there or self._all.value):
                found.append((table, keys))
        return found

    def _build(self, *, force: bool) -> None:
        """Make the fields anew where other ones are to be shown."""
        shown = self._shown()
        shape = tuple((key.dotted, key.sort) for _, keys in shown for key in keys)
        if shape == self._shape and not force:
            return
        self._shape = shape
        self._inputs.clear()
        self._body.clear()
        with self._body:
            for table, keys in shown:
                with ui.expansion(table.title, value=table.is_there).classes("full-width card"):
                    if table.meaning:
                        ui.label(plain(table.meaning)).classes("text-caption")
                    with ui.element("div").classes("form-grid"):
                        for key in keys:
                            self._inputs[key.dotted] = self._input(key)

    def _input(self, key: Key) -> Any:  # noqa: ANN401 (elements of several types)
        name, value, default = key.dotted, shown_text(key.value), shown_text(key.default)
        label = " / ".join(filter(None, (key.name, key.unit)))
        hint = plain(key.meaning)
        if key.sort in ("choice", "switch"):
            choices = [str(choice) for choice in key.choices] or ["true", "false"]
            options = {} if key.is_required else {"": f"({default})"}
            options |= {choice: choice for choice in [*choices, value] if choice}
            element: Any = ui.select(options, label=label, value=value)
        else:
            hint = "; ".join(filter(None, (key.range_text, hint)))
            element = ui.input(label=label, value=value).props("debounce=250")
            if default:
                element.props["placeholder"] = default
            if key.sort == "other" or not is_short(key.value):
                element.props("readonly")
        element.props["hint"] = hint
        element.props("dense outlined stack-label hide-bottom-space bottom-slots")
        element.on_value_change(lambda event, name=name: self._typed(name, event.value))
        element.on("focus", lambda _, name=name: self._touch(name), args=[])
        return element.props(f"data-testid=field-{name}").classes("full-width")

    def _set(self, element: Any, key: Key) -> None:  # noqa: ANN401 (as above)
        text = shown_text(key.value)
        if isinstance(element, ui.select) and text not in element.options:
            element.set_options(dict(element.options) | {text: text})
        if element.value == text:
            return
        try:
            same = typed(key, str(element.value or "")) == key.value
        except ValueError:
            same = False
        if not same:  # what is typed now, 2. for example, is not taken from under the fingers
            element.value = text

    def _typed(self, name: str, text: object) -> None:
        key = self._keys.get(name)
        if self._showing.is_on or key is None or not is_short(key.value):
            return
        try:
            value = typed(key, str(text if text is not None else ""))
        except ValueError as error:
            _show_error(self._inputs[name], str(error))
            return
        if repr(value) != repr(key.value):
            self._on_edit(key, value)

    def _touch(self, name: str) -> None:
        self._touched = name
        self._show_dial()

    def _number(self) -> tuple[Key, float] | None:
        key = self._keys.get(self._touched)
        if key is None or key.sort not in ("number", "whole", "numbers"):
            return None
        value = key.value if key.value is not None else key.default
        if isinstance(value, bool) or not isinstance(value, int | float):
            return None
        return key, value

    def _show_dial(self) -> None:
        found = self._number()
        if found is None:
            self._dial.disable()
            self._dial_name.text = _NO_DIAL
            return
        key, value = found
        low, high = dial_of(key, value)
        step = step_of(value) / 10 if key.sort != "whole" else 1
        if not low <= value <= high:
            return
        props = self._dial.props
        with self._showing:
            inside = props.get("min", 0) < value < props.get("max", 0)
            if self._dial_name.text != key.dotted or not inside:
                props["min"], props["max"], props["step"] = low, high, step
            self._dial.value = value
            self._dial.enable()
            self._dial_name.text = key.dotted

    def _turned(self) -> None:
        found = self._number()
        if self._showing.is_on or found is None:
            return
        self._give(found[0], float(self._dial.value))

    def _step(self, sign: int) -> None:
        found = self._number()
        if found is None:
            return
        key, value = found
        step = 1 if key.sort == "whole" else step_of(value)
        self._give(key, within(key, value + sign * step))

    def _give(self, key: Key, value: float) -> None:
        rounded: float | int = float(f"{value:.9g}")
        is_whole = key.sort == "whole" or isinstance(key.value, int)
        if is_whole and float(rounded).is_integer():
            rounded = int(rounded)
        if rounded != key.value:
            self._on_edit(key, rounded)


def _show_error(element: Any, text: str) -> None:  # noqa: ANN401 (elements of several types)
    element.props["error"], element.props["error-message"] = bool(text), text
    element.update()
