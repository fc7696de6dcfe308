# SPDX-License-Identifier: Apache-2.0
"""The reports of runs, for frames without rights of their own (camtools.panel.access.auth_gate)."""

from __future__ import annotations

from fastapi import HTTPException
from fastapi.responses import FileResponse
from nicegui import app

from camtools.base.errors import CamtoolsError
from camtools.panel.design_service import DesignService
from camtools.panel.runs.store import REPORT


def add_reports(designs: DesignService) -> None:
    """Serve the report of every run, and no other file of its folder."""

    @app.get("/reports/{place}/{name}/report.html")
    def report(place: str, name: str) -> FileResponse:
        try:
            path = designs.store.run(f"{place}/{name}").folder / REPORT
        except CamtoolsError as error:
            raise HTTPException(404, "no such run") from error
        if path.is_symlink() or not path.is_file():
            raise HTTPException(404, "this run has no report")
        return FileResponse(path, media_type="text/html; charset=utf-8")
