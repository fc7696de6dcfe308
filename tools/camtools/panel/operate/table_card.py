"""Tables: from a file or made of a part file, downloaded with progress, taken into use."""

import asyncio
import sys
import tempfile
from functools import partial
from pathlib import Path

from nicegui import ui

from camtools.base.project import ROOT
from camtools.panel.operate.order_buttons import Orders
from camtools.panel.orders.order import Outcome
from camtools.panel.orders.snapshot import Snapshot
from camtools.panel.pieces import card, file_button, outlined
from camtools.panel.views.wording import share_of

_PARTS = ROOT / "tools" / "parts"
_MOST_BYTES = 16 << 20
_BEGIN = b"CAMTAB"


async def made(part: Path) -> tuple[bytes, str]:
    """Return the table of a part file, made by a process of its own; or b"" and why not."""
    with tempfile.TemporaryDirectory(prefix="camturn-table.") as folder:
        process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-m", "camtools.cli.mktables", str(part), "-o", folder),
            stdout=asyncio.subprocess.DEVNULL,
            stderr=asyncio.subprocess.PIPE,
        )
        _, errors = await process.communicate()
        images = sorted(Path(folder).glob("*.camtab"))
        if process.returncode or not images:
            return b"", errors.decode("utf-8", "replace").strip()[-300:]
        return images[0].read_bytes(), images[0].name


class TableCard:
    """The image that was chosen, and what to do with it."""

    def __init__(self, orders: Orders) -> None:
        self._orders = orders
        self._image, self._name = b"", ""
        with card("Table", "table", is_live=True):
            self._now = ui.label("").classes("op-note").props("data-testid=table-now")
            self._draw_sources()
            self._chosen = ui.label("No table chosen yet.").classes("op-note")
            self._chosen.props("role=status data-testid=table-chosen")
            with ui.element("div").classes("op-row"):
                load = partial(self._give, "table_next", "download and use")
                both = ui.button("Download and use", on_click=load, color=None)
                both.props("no-caps unelevated data-testid=table-next").classes("op-button op-do")
                orders.guard(both, "table")
                load = partial(self._give, "download", "download")
                orders.small_button("Download only", "table-download", "table", load)
                use = partial(orders.give, "select", "use the downloaded table")
                orders.small_button("Use downloaded table", "table-select", "table", use)
            self._bar = ui.linear_progress(0.0, show_value=False).classes("op-progress")
            self._bar.props('aria-label="Progress of the download" data-testid=table-progress')
            self._work = ui.label("").classes("op-note").props("role=status")

    def _draw_sources(self) -> None:
        names = sorted(path.name for path in _PARTS.glob("*.toml"))
        with ui.element("div").classes("op-row"):
            self._part = ui.select(names, label="Part of tools/parts", with_input=False)
            self._part.classes("op-input op-wide").props("data-testid=table-part")
            outlined("Make its table", "table-make", self._make)
        with ui.element("div").classes("op-row"):
            file_button("Choose a table file", ".camtab", _MOST_BYTES, "table-file", self._take)

    def _take(self, image: bytes, name: str) -> None:
        if not image.startswith(_BEGIN):
            self._orders.refuse(name, "not a table; make one with tools/mktables, or choose a part")
            return
        self._image, self._name = image, name
        self._chosen.set_text(f"Chosen: {name}, {len(image)} bytes")

    async def _make(self) -> None:
        if not self._part.value:
            self._orders.refuse("make a table", "choose a part first")
            return
        self._chosen.set_text(f"Making the table of {self._part.value} ..")
        image, text = await made(_PARTS / str(self._part.value))
        if image:
            self._take(image, text)
        else:
            self._chosen.set_text("No table chosen yet.")
            self._orders.tell("make a table", Outcome(False, text))

    async def _give(self, name: str, words: str) -> None:
        if not self._image:
            self._orders.refuse(words, "choose a table first")
            return
        words = f"{words} {self._name}"
        await self._orders.give(name, words, image=self._image, name=self._name)

    def show(self, snapshot: Snapshot) -> None:
        """Show the table in use and how far a download is."""
        s = snapshot.signals
        size, crc = s.get("table_size", 0.0), int(s.get("table_crc", 0.0))
        now = f"Active: {snapshot.table_name}, {size:.0f} bytes, CRC-32 {crc:08x}"
        self._now.set_text(now if size else "No active table.")
        self._work.set_text(snapshot.work)
        self._bar.set_visibility(bool(snapshot.work))
        self._bar.set_value(share_of(snapshot.work))
