# SPDX-License-Identifier: Apache-2.0
r"""NiceGUI's page with a nonce in its own script elements, so that no other one runs.

The template is changed, not the page: what a page was filled with gets no nonce.

>>> with_nonces('<script type="module">x</script>')
'<script nonce="{{ request.scope[\'camturn.nonce\'] }}" type="module">x</script>'
"""

from __future__ import annotations

import re
from collections.abc import Callable

from jinja2 import BaseLoader, Environment, TemplateNotFound
from nicegui import client

from camtools.panel.access.auth_gate import NONCE

_SCRIPT = re.compile(r"<script\b")


def with_nonces(source: str) -> str:
    """Return a template whose script elements carry the nonce of the request."""
    return _SCRIPT.sub(f"<script nonce=\"{{{{ request.scope['{NONCE}'] }}}}\"", source)


class _Loader(BaseLoader):
    """The templates of another loader, with nonces."""

    def __init__(self, inner: BaseLoader) -> None:
        self._inner = inner

    def get_source(
        self, environment: Environment, template: str
    ) -> tuple[str, str | None, Callable[[], bool] | None]:
        source, name, is_fresh = self._inner.get_source(environment, template)
        return with_nonces(source), name, is_fresh


def use_nonces() -> None:
    """Have all pages made from the changed template."""
    environment = client.templates.env
    if environment.loader is None:
        raise TemplateNotFound("index.html")
    if not isinstance(environment.loader, _Loader):
        environment.loader = _Loader(environment.loader)
