"""Chromium, its windows, and what goes wrong in them.

A window is a browser's context of its own with one page: nothing of another visitor is in it. It
notes errors of the page and every address on another computer that is asked for; the browser's
proxy does not exist, so that nothing leaves this computer.
"""

import os
import re
import shutil
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from playwright.sync_api import (
    Browser,
    ConsoleMessage,
    Page,
    ViewportSize,
    expect,
    sync_playwright,
)

from checks.patience import limit_s

PATIENCE_MS = 1e3 * limit_s()
expect.set_options(timeout=PATIENCE_MS)
_WITHOUT_NETWORK = ("about", "blob", "data", "file")
_HERE = ("127.0.0.1", "localhost", "::1")
_SWITCHES = (
    *("--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking"),
    *("--disable-component-update", "--disable-sync", "--proxy-server=127.0.0.1:9"),
)
# Without a graphics card a part in space takes seconds.
NO_3D = """const original = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
    return kind.startsWith("webgl") ? null : original.call(this, kind, ...more);
};"""
DESK: ViewportSize = {"width": 1280, "height": 800}
PHONE: ViewportSize = {"width": 390, "height": 844}


def chromium_path() -> str:
    """Return Debian's Chromium, or raise FileNotFoundError."""
    if (path := shutil.which("chromium")) is None:
        raise FileNotFoundError("chromium is missing: apt-get install chromium")
    return path


def is_here(url: str) -> bool:
    """Return whether an address is on this computer.

    >>> is_here("http://127.0.0.1:8080/a"), is_here("data:,a"), is_here("http://127.0.0.1.nip.io/")
    (True, True, False)
    """
    parts = urlsplit(url)
    return parts.scheme in _WITHOUT_NETWORK or parts.hostname in _HERE


@dataclass
class Window:
    """A visitor's window."""

    page: Page
    console: list[str] = field(default_factory=list)  # all that the page wrote, for people
    errors: list[str] = field(default_factory=list)  # also exceptions that nobody caught
    outside: list[str] = field(default_factory=list)  # addresses on other computers

    def __post_init__(self) -> None:
        """Listen to the page, and to those that it opens."""
        context = self.page.context
        context.on("console", self._take_console)
        context.on("weberror", lambda error: self.errors.append(f"exception: {error.error}"))
        context.on("request", lambda request: self._take_url(request.url))
        self.page.on("websocket", lambda socket: self._take_url(socket.url))

    def _take_console(self, message: ConsoleMessage) -> None:
        line = f"{message.type}: {message.text} ({message.location.get('url', '')})"
        self.console.append(line)
        if message.type == "error":
            self.errors.append(line)

    def _take_url(self, url: str) -> None:
        if not is_here(url):
            self.outside.append(url)

    def problems(self) -> list[str]:
        """Return what must not have happened."""
        return self.errors + [f"asked for {url}" for url in self.outside]


OpenWindow = Callable[..., Window]  # with Playwright's options of a context


class Chromium:
    """The browser; each window is a visitor."""

    def __init__(self, browser: Browser) -> None:
        self._browser = browser
        self.version = browser.version

    @contextmanager
    def window(self, **options: Any) -> Iterator[Window]:  # noqa: ANN401 - those of Playwright
        """Open a window; options are those of Playwright's new_context()."""
        given = {"viewport": DESK, "reduced_motion": "reduce", "service_workers": "block"} | options
        context = self._browser.new_context(**given)
        context.set_default_timeout(PATIENCE_MS)
        try:
            yield Window(context.new_page())
        finally:
            context.close()


@contextmanager
def chromium(more: Sequence[str] = ()) -> Iterator[Chromium]:
    """Run Chromium, with more switches, and a profile that is gone afterwards."""
    with ExitStack() as stack:
        home = stack.enter_context(tempfile.TemporaryDirectory(prefix="camturn-browser."))
        own = {f"XDG_{kind}_HOME": str(Path(home) / kind) for kind in ("CONFIG", "CACHE")}
        playwright = stack.enter_context(sync_playwright())
        browser = playwright.chromium.launch(
            executable_path=chromium_path(),
            args=[*_SWITCHES, *more],
            chromium_sandbox=os.geteuid() != 0,  # root has none
            timeout=PATIENCE_MS,
            env={**os.environ, **own, "HOME": home},
        )
        stack.callback(browser.close)
        yield Chromium(browser)


def picture_name(text: str) -> str:
    """Return a caption as the name of a file.

    >>> picture_name("Report of a skirt, dark")
    'report-of-a-skirt-dark'
    """
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")
