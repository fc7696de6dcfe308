# SPDX-License-Identifier: Apache-2.0
"""The page / of the panel."""

from __future__ import annotations

from nicegui import ui

from camtools.panel.context import AppContext
from camtools.panel.frame import framed


def add(context: AppContext) -> None:
    """Register the page."""

    @ui.page("/", title="camturn: operate")
    def operate() -> None:
        with framed(context, "/"):
            ui.label("Operate")
