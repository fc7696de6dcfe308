# SPDX-License-Identifier: Apache-2.0
"""The reports of runs, for frames without rights of their own."""

from __future__ import annotations

from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import FileResponse
from starlette.routing import Route

from camtools.base.errors import CamtoolsError
from camtools.panel.design_service import DesignService
from camtools.panel.runs.store import REPORT

# Scripts run, but in no origin: they reach neither the panel nor a network.
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'self'; sandbox allow-scripts"
)


def reports(designs: DesignService) -> Starlette:
    """Return an application that serves the report of every run, and no other file of its folder.

    It is not mounted below the token, which the scripts of a report must not see in their address.
    """

    def report(request: Request) -> FileResponse:
        place, name = request.path_params["place"], request.path_params["name"]
        try:
            path = designs.store.run(f"{place}/{name}").folder / REPORT
        except CamtoolsError as error:
            raise HTTPException(404, "no such run") from error
        if path.is_symlink() or not path.is_file():
            raise HTTPException(404, "this run has no report")
        return FileResponse(path, headers={"content-security-policy": _POLICY})

    return Starlette(routes=[Route(f"/{{place}}/{{name}}/{REPORT}", report)])
