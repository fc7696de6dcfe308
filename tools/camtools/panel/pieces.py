"""Pieces of pages: cards, numbers, a file button, dialogs that never bar STOP.

They take no notice of Escape, which is the key of STOP in every place of the operator's page: who
presses it in need shall not have closed a dialog only. They leave the page beside them in use, so
that the button can be pressed as well. What was asked is withdrawn then.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from weakref import WeakKeyDictionary, WeakSet

from nicegui import Client, ui
from nicegui.events import UploadEventArguments

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


@contextmanager
def card(title: str, name: str, *, is_live: bool = False) -> Iterator[ui.element]:
    """Draw a card; what is made within the block is in it.

    Parameters
    ----------
    name : str
        of its place in the grid of operate.css, and of its mark
    is_live : bool
        it shows values of the controller: grey while the connection is lost
    """
    with ui.element("section").classes(f"op-card op-at-{name}") as box:
        box.props(f'aria-labelledby="op-title-{name}" data-testid="card-{name}"')
        heading = ui.element("h2").classes("op-title").props(f"id=op-title-{name}")
        with heading:
            ui.label(title)
        with ui.element("div").classes("op-body live" if is_live else "op-body"):
            yield box


class Figure:
    """A number: label, value in figures of equal width, unit."""

    def __init__(self, label: str, unit: str, name: str, *, size: str = "middle") -> None:
        with ui.element("div").classes(f"op-figure op-figure-{size}"):
            ui.label(label).classes("op-label")
            with ui.element("div").classes("op-value"):
                self._value = ui.label("").classes("op-number")
                self._value.props(f"data-testid=value-{name}").mark(f"value-{name}")
                ui.label(unit).classes("op-unit")

    def show(self, text: str) -> None:
        """Show a number."""
        self._value.set_text(text)


Take = Callable[[bytes, str], None]


def file_button(label: str, suffix: str, most_bytes: int, name: str, take: Take) -> None:
    """Draw it.

    Parameters
    ----------
    suffix : str
        of the files that are offered, with its dot
    name : str
        mark of the field that gets the file
    take : callable
        called with the bytes and the name of the file; both are of strangers
    """

    async def read(event: UploadEventArguments) -> None:
        take(await event.file.read(), event.file.name)
        upload.reset()

    def refuse() -> None:
        ui.notify(f"{label}: larger than {most_bytes >> 20} MB", type="negative")

    # Quasar's own field has buttons without names; it stays out of sight, this button opens it.
    upload = ui.upload(
        auto_upload=True, max_file_size=most_bytes, on_upload=read, on_rejected=refuse
    )
    upload.classes("op-hidden").props(f'accept="{suffix}" data-testid={name}')
    button = ui.button(label).props("no-caps outline").props(f"data-testid={name}-choose")
    button.on("click", js_handler=f'() => runMethod({upload.id}, "pickFiles", [])')
