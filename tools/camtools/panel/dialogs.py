# SPDX-License-Identifier: Apache-2.0
"""Dialogs that never bar STOP.

They take no notice of Escape, which is the key of STOP in every place of the operator's page: who
presses it in need shall not have closed a dialog only. They leave the page beside them in use, so
that the button can be pressed as well. What was asked is withdrawn then.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from weakref import WeakKeyDictionary, WeakSet

from nicegui import Client, ui

Ask = Callable[[], Awaitable[object]]
_open: WeakKeyDictionary[Client, WeakSet[ui.dialog]] = WeakKeyDictionary()
_asks: WeakKeyDictionary[Client, dict[str, Ask]] = WeakKeyDictionary()


@contextmanager
def titled_dialog(title: str, name: str) -> Iterator[ui.dialog]:
    """Make a dialog; what is made within the block is in it."""
    dialog = ui.dialog().props(f"seamless no-esc-dismiss aria-labelledby=op-title-{name}")
    _open.setdefault(dialog.client, WeakSet()).add(dialog)
    with dialog, ui.card().classes("op-dialog").props(f"data-testid={name}"):
        heading = ui.label(title).classes("op-dialog-title")
        heading.props(f"id=op-title-{name} role=heading aria-level=2")
        yield dialog


def withdraw(client: Client) -> None:
    """Close what a page asks; nothing was agreed to."""
    for dialog in list(_open.get(client, ())):
        if dialog.value:
            dialog.submit(None)


def cancel_button(dialog: ui.dialog, name: str) -> None:
    """Draw the button that gives up; it has the focus."""
    cancel = ui.button("Cancel", on_click=lambda: dialog.submit(None))
    cancel.props(f"no-caps outline autofocus data-testid={name}-cancel")


def asks(name: str, ask: Ask) -> None:
    """Let a question of this page be asked again after the page was loaded anew."""
    _asks.setdefault(ui.context.client, {})[name] = ask


async def ask_again(client: Client, name: str) -> None:
    """Ask a question whose page was loaded anew before it was answered."""
    if (ask := _asks.get(client, {}).get(name)) is not None:
        await ask()


async def confirmed(title: str, text: str, yes: str, name: str = "") -> bool:
    """Ask once before an order that is dangerous, and return whether the answer was yes.

    Parameters
    ----------
    title, text : str
        what would be done, and what that means
    yes : str
        words of the button that agrees
    name : str
        that of asks(), where the question needs nothing but its page
    """
    with titled_dialog(title, "question") as dialog:
        ui.label(text).props(f"data-asks={name}" if name else "")
        with ui.row().classes("op-dialog-buttons"):
            cancel_button(dialog, "question")
            agree = ui.button(yes, on_click=lambda: dialog.submit(True), color=None)
            agree.classes("op-do").props("no-caps unelevated data-testid=question-yes")
    answer = await dialog
    if not dialog.is_deleted:  # as with its page
        dialog.delete()
    return bool(answer)
