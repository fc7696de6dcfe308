"""Shared by the tests in the browser: Chromium, a panel, a report, and pictures of the pages.

An error in the console, an exception that nobody caught or a request that would leave this computer
fails the test in whose window it came.
"""

import signal
from collections.abc import Callable, Generator, Iterator
from contextlib import ExitStack
from pathlib import Path
from types import FrameType
from typing import Any

import pytest
from playwright.sync_api import Page

from camtools.cli.run import main as run
from tests.browser.panel_session import PanelSession, panel_session
from tests.browser.windows import Chromium, OpenWindow, Window, chromium, picture_name
from tests.tools.cases.part_cases import ROOT

PICTURES = ROOT / "build" / "reports" / "browser"
# No cut ends by itself while a slow computer looks at it: 3000 turns, 75 s of the lathe's time.
LONG_CUT = ("--", "--set", "feed_nm=20000")
Keep = Callable[..., None]
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
    """Run Chromium."""
    with chromium() as one:
        yield one


@pytest.fixture(scope="session")
def keep() -> Keep:
    """Return a function that keeps a picture of a page for people to look at."""
    PICTURES.mkdir(parents=True, exist_ok=True)

    def picture(page: Page, text: str, *, is_whole: bool = False) -> None:
        if is_whole:
            page.evaluate("scrollTo(0, 0)")  # else what stays in sight lies over the middle
        path = PICTURES / f"{picture_name(text)}.png"
        page.screenshot(path=path, full_page=is_whole, animations="disabled")

    return picture


def _give_back(page: Page) -> None:
    """Give command back, which else is lost some seconds after the page only."""
    if not page.is_closed():
        button = page.get_by_role("button", name="Give command back")
        if button.is_visible():
            button.click(force=True)


@pytest.fixture
def open_window(request: pytest.FixtureRequest, browser: Chromium) -> Iterator[OpenWindow]:
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
            said = [line for window in windows for line in window.console]
            if "session" in request.fixturenames:
                said.append(request.getfixturevalue("session").text())
            print("\n".join(said))
            for i, page in enumerate(p for w in windows for p in w.page.context.pages):
                name = picture_name(f"failed {request.node.name} {i}")
                page.screenshot(path=PICTURES / f"{name}.png")
    assert not problems


@pytest.fixture(scope="session")
def report_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Cut the Perkins 240 skirt; return the folder of its report."""
    folder = tmp_path_factory.mktemp("report")
    assert run(["-o", str(folder), "--csv"]) == 0
    return folder


def _end(number: int, _frame: FrameType | None) -> None:
    """End by a signal as by control-C, so that no process remains."""
    raise KeyboardInterrupt(signal.Signals(number).name)


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[PanelSession]:
    """Run a live lathe and the panel of its controller for the tests of a file."""
    before = signal.signal(signal.SIGTERM, _end)
    with panel_session(tmp_path_factory.mktemp("panel"), LONG_CUT) as one:
        yield one
    signal.signal(signal.SIGTERM, before)


@pytest.fixture
def session(running: PanelSession) -> Iterator[PanelSession]:
    """Return lathe and panel; the test begins and ends in off."""
    running.calm()
    yield running
    running.calm()
