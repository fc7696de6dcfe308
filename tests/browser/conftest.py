# SPDX-License-Identifier: Apache-2.0
"""What the tests in the browser share: Chromium, a panel, a report, and what is kept of a failure.

An error in the console, an exception that nobody caught or a request that would leave this computer
fails the test in whose window it came.
"""

import signal
from collections.abc import Generator, Iterator
from contextlib import ExitStack
from pathlib import Path
from types import FrameType
from typing import Any

import pytest
from playwright.sync_api import Page

from camtools.cli.run import main as run
from camtools.link.bus import open_bus
from tests.browser.gallery import FOLDER, Gallery
from tests.browser.overheard import Overheard
from tests.browser.panel_session import PanelSession, panel_session
from tests.browser.windows import Chromium, OpenWindow, Window, chromium

# No cut ends by itself while a slow computer looks at it: 3000 turns, 75 s of the lathe's time.
LONG_CUT = ("--", "--set", "feed_nm=20000")
_HAS_FAILED = pytest.StashKey[bool]()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item,
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Let fixtures know how their test ended."""
    report = yield
    item.stash[_HAS_FAILED] = item.stash.get(_HAS_FAILED, False) or report.failed
    return report


@pytest.fixture(scope="session")
def browser() -> Iterator[Chromium]:
    """Run Chromium; nothing may have wanted to leave this computer."""
    with chromium() as one:
        yield one
        assert one.trap.caught == []


@pytest.fixture(scope="session")
def gallery() -> Iterator[Gallery]:
    """Keep pictures for people to look at."""
    one = Gallery()
    yield one
    one.write_index()


def _keep_failure(name: str, windows: list[Window]) -> None:
    """Write what the windows of a failed test show and said."""
    folder = FOLDER / "failed"
    folder.mkdir(parents=True, exist_ok=True)
    for i, window in enumerate(windows):
        (folder / f"{name}-{i}.log").write_text("\n".join(window.console), "utf-8")
        for k, page in enumerate(window.page.context.pages):
            page.screenshot(path=folder / f"{name}-{i}-{k}.png")


def _give_back(page: Page) -> None:
    """Give the command back, which else is lost some seconds behind the page only."""
    if not page.is_closed():
        button = page.get_by_role("button", name="Give command back")
        if button.is_visible():
            button.click(force=True)


@pytest.fixture
def open_window(
    request: pytest.FixtureRequest, browser: Chromium, gallery: Gallery
) -> Iterator[OpenWindow]:
    """Open windows with Playwright's options of a context; they close with the test."""
    windows: list[Window] = []
    with ExitStack() as stack:

        def open_one(**options: Any) -> Window:  # noqa: ANN401 - those of Playwright
            windows.append(stack.enter_context(browser.window(**options)))
            return windows[-1]

        yield open_one
        for window in windows:
            _give_back(window.page)
        problems = [problem for window in windows for problem in window.problems()]
        if problems or request.node.stash.get(_HAS_FAILED, False):
            _keep_failure(request.node.name, windows)
            if "session" in request.fixturenames:
                said = request.getfixturevalue("session").text()
                (FOLDER / "failed" / f"{request.node.name}.log").write_text(said, "utf-8")
    assert not problems


@pytest.fixture(scope="session")
def report_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Cut the Perkins 240 skirt; return the folder of its report."""
    folder = tmp_path_factory.mktemp("report")
    assert run(["-o", str(folder), "--csv"]) == 0
    return folder


@pytest.fixture(scope="session")
def session(tmp_path_factory: pytest.TempPathFactory) -> Iterator[PanelSession]:
    """Run a live lathe and the panel of its controller."""
    before = signal.signal(signal.SIGTERM, _end)
    with panel_session(tmp_path_factory.mktemp("panel"), LONG_CUT) as one:
        yield one
    signal.signal(signal.SIGTERM, before)


@pytest.fixture
def overheard(session: PanelSession) -> Iterator[Overheard]:
    """Hear the controller on its bus; the test begins and ends in off."""
    session.calm()
    one = Overheard(*open_bus(session.live.bus), session.live.node)
    yield one
    one.close()
    session.calm()


def _end(number: int, _frame: FrameType | None) -> None:
    """End by a signal as by control-C, so that no process is left behind."""
    raise KeyboardInterrupt(signal.Signals(number).name)
