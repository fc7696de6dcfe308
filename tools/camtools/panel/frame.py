# SPDX-License-Identifier: Apache-2.0
"""The frame of every page: navigation, who commands, theme, and the page's visitor.

Classes: those of Quasar (row, column, q-pa-md, full-width, ..) and of panel.css; Tailwind is off,
since it watches every change of the page in the browser.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from nicegui import ui

from camtools.panel.context import AppContext
from camtools.panel.visitor import Visitor, new_visitor

PAGES = {"/": "Operate", "/design": "Design", "/runs": "Runs"}
_PRIMARY = "#1a5a96"  # white on it has a contrast of 7, where 4.5 is needed (WCAG 2.2, 1.4.3)
# Quasar's bar of a request that runs has no name for those who do not see it.
_STYLE = ".q-loading-bar { display: none; }"


@contextmanager
def framed(context: AppContext, path: str) -> Iterator[Visitor]:
    """Make the frame of a page; what is made within the block is its content.

    Parameters
    ----------
    path : str
        of the page, one of PAGES

    Yields
    ------
    Visitor
        of this page, for desk.do() and the commander
    """
    client = ui.context.client
    visitor = new_visitor(client.ip)
    client.on_delete(lambda: context.commander.lose(visitor))
    ui.colors(primary=_PRIMARY)
    ui.add_css(_STYLE)
    with ui.header().classes("row items-center q-gutter-md"):
        for target, name in PAGES.items():
            ui.link(name, target).classes("text-white" + (" text-bold" if target == path else ""))
        ui.label("").bind_text_from(
            context.commander, "holder", lambda who: f"{who} commands" if who else "nobody commands"
        )
    with ui.column().classes("full-width q-pa-md"):
        yield visitor
