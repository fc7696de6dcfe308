# SPDX-License-Identifier: Apache-2.0
"""A button that chooses a file and hands its bytes over."""

from __future__ import annotations

from collections.abc import Callable

from nicegui import ui
from nicegui.events import UploadEventArguments

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
