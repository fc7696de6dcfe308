# SPDX-License-Identifier: Apache-2.0
"""Keys of the operator's page, and the dialog that tells them."""

from __future__ import annotations

from nicegui import ui

from camtools.panel.dialogs import titled_dialog

KEYS = {
    "Esc": "STOP: ends what moves, in every place of the page",
    "E": "Enable: drives on, and the index is searched",
    "S": "Start, after a question",
    "H": "Hold: Z rests on a whole turn",
    "R": "Resume",
    "D": "Disable: drives off",
    "T": "Reset behind a fault",
    "M": "By hand",
    "Space": "held on a jog button: the axis moves while it is held",
    "?": "this list",
}


class Help:
    """A dialog; STOP goes on to work while it is open."""

    def __init__(self) -> None:
        with titled_dialog("Keys", "help") as self._dialog:
            with ui.element("dl").classes("op-keys"):
                for key, meaning in KEYS.items():
                    with ui.element("dt"):
                        ui.label(key).classes("op-key-name")
                    with ui.element("dd"):
                        ui.label(meaning)
            self.are_keys_on = ui.switch("Letters give orders", value=True)
            self.are_keys_on.props("data-testid=keys-on")
            ui.label(
                "STOP is not the emergency stop: that is the red button at the machine, which "
                "works without this page."
            )
            close = ui.button("Close", on_click=self._dialog.close)
            close.props("no-caps outline autofocus data-testid=help-close")

    def toggle(self) -> None:
        """Open the dialog, or close it."""
        self._dialog.set_value(not self._dialog.value)
