# SPDX-License-Identifier: Apache-2.0
"""A card with a heading, and a number with its label and unit, for all pieces of the page."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from nicegui import ui


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
