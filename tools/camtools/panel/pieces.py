"""Pieces of pages: cards, numbers, a file button, dialogs that never bar STOP.

They take no notice of Escape, which is the key of STOP in every place of the operator's page: who
presses it in need shall not have closed a dialog only. They leave the page beside them in use, so
that the button can be pressed as well. What was asked is withdrawn then.
"""

from collections.abc import Awaitable, Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any
from weakref import WeakKeyDictionary, WeakSet

from nicegui import Client, ui
from nicegui.events import UploadEventArguments

from camtools.base.errors import CamtoolsError

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


def outlined(
    label: str, name: str, press: Callable[[], object] | None = None, icon: str | None = None
) -> ui.button:
    """Draw a button of a row; `name` is its mark."""
    button = ui.button(label, icon=icon, on_click=press)
    return button.props(f"no-caps outline data-testid={name}")


def answer_buttons(
    dialog: ui.dialog, name: str, yes: str, yes_name: str, answer: Callable[[], object]
) -> None:
    """Draw the button that gives up, which has the focus, and the one that submits an answer."""
    with ui.row().classes("op-dialog-buttons"):
        outlined("Cancel", f"{name}-cancel", lambda: dialog.submit(None)).props("autofocus")
        agree = ui.button(yes, on_click=lambda: dialog.submit(answer()), color=None)
        agree.classes("op-do").props(f"no-caps unelevated data-testid={yes_name}")


async def answer_of(dialog: ui.dialog) -> object:
    """Wait for the answer to a dialog, and take that away."""
    answer = await dialog
    if not dialog.is_deleted:  # as with its page
        dialog.delete()
    return answer


def asks(name: str, ask: Ask) -> None:
    """Let a question of this page be asked again after the page was loaded anew."""
    _asks.setdefault(ui.context.client, {})[name] = ask


async def ask_again(client: Client, name: str) -> None:
    """Ask a question whose page was loaded anew before it was answered."""
    if (ask := _asks.get(client, {}).get(name)) is not None:
        await ask()


async def confirmed(title: str, text: str, yes: str, name: str = "") -> bool:
    """Ask once before an order that is dangerous, and return whether the answer was yes.

    The name is that of asks(), where the question needs nothing but its page.
    """
    with titled_dialog(title, "question") as dialog:
        ui.label(text).props(f"data-asks={name}" if name else "")
        answer_buttons(dialog, "question", yes, "question-yes", lambda: True)
    return bool(await answer_of(dialog))


@contextmanager
def card(title: str, name: str, *, is_live: bool = False) -> Iterator[ui.element]:
    """Draw a card; what is made within the block is in it.

    The name is that of its place in operate.css, and of its mark; a live card shows values of the
    controller and is grey while the connection is lost.
    """
    with ui.element("section").classes(f"op-card op-at-{name}") as box:
        box.props(f'aria-labelledby="op-title-{name}" data-testid="card-{name}"')
        heading = ui.element("h2").classes("op-title").props(f"id=op-title-{name}")
        with heading:
            ui.label(title)
        with ui.element("div").classes("op-body live" if is_live else "op-body"):
            yield box


def columns_of(
    labels: Iterable[tuple[str, str]], *numbers: str, is_sortable: bool = False
) -> list[dict[str, Any]]:
    """Return the columns of a table by their keys and labels; those of numbers stand right."""
    return [
        {"name": key, "field": key, "label": label, "sortable": is_sortable}
        | {"align": "right" if key in numbers else "left"}
        for key, label in labels
    ]


def redraw(chart: ui.echart, options: dict[str, Any]) -> None:
    """Give a chart other options."""
    chart.options.clear()
    chart.options.update(options)
    chart.update()


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


@contextmanager
def refusals_shown() -> Iterator[None]:
    """Show why what is done within the block was refused, and continue after it."""
    try:
        yield
    except (CamtoolsError, UnicodeDecodeError) as error:
        ui.notify(str(error), type="negative")


class Showing:
    """A block in which the server sets values of fields: their events are not a visitor's."""

    def __init__(self) -> None:
        self.is_on = False

    def __enter__(self) -> None:
        self.is_on = True

    def __exit__(self, *_error: object) -> None:
        self.is_on = False


Take = Callable[[bytes, str], None]


def file_button(label: str, suffix: str, most_bytes: int, name: str, take: Take) -> None:
    """Draw a button for files of a suffix; `take` gets bytes and name, both of strangers."""

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
    button = outlined(label, f"{name}-choose")
    button.on("click", js_handler=f'() => runMethod({upload.id}, "pickFiles", [])')
