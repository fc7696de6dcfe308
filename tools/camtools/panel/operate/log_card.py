# SPDX-License-Identifier: Apache-2.0
"""The newest lines of the log of commands: time, who, what, and what came of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nicegui import ui

from camtools.panel.operate.card import card
from camtools.panel.orders.command_log import CommandLog

_SHOWN = 30


def line_of(record: Mapping[str, Any]) -> str:
    """Return a record of the log as a line.

    >>> line_of({"time": "12:00", "visitor": "v1", "order": "feed",
    ...          "arguments": {"percent": 90.0}, "is_done": True, "outcome": "feed = 90 %"})
    '12:00  v1  feed percent=90.0: done - feed = 90 %'
    """
    told = "".join(f" {name}={value}" for name, value in record["arguments"].items())
    mark = "done" if record["is_done"] else "not done"
    what = f"{record['order']}{told}: {mark} - {record['outcome']}"
    return f"{record['time']}  {record['visitor']}  {what}"


class LogCard:
    """A list that is drawn anew when it has changed."""

    def __init__(self, log: CommandLog) -> None:
        self._log = log
        self._newest: list[str] = []
        with card("Commands given", "log"):
            self._list = ui.element("ol").classes("op-log").props("data-testid=log tabindex=0")
            self._list.props('aria-label="Commands given, the newest first"').mark("log")

    def show(self) -> None:
        """Show the newest lines."""
        lines = [line_of(record) for record in self._log.newest(_SHOWN)]
        if lines == self._newest:
            return
        self._newest = lines
        self._list.clear()
        with self._list:
            for text in lines:
                with ui.element("li"):
                    ui.label(text)
