"""What all tests share: the tables of parts that they cut, and how long each test takes.

`--quick S` leaves out the tests that took longer when they last ran without it, in this clone.
"""

from collections import defaultdict
from collections.abc import Callable
from pathlib import Path

import pytest

from camtools.cli.mktables import main as mktables
from tests.tools.cases.part_cases import ROOT

pytest_plugins = ["tests.hang"]
FOLDERS = (
    ROOT / "tools" / "parts",
    ROOT / "tests" / "learn" / "parts",
    ROOT / "tests" / "scenarios" / "cases" / "parts",
)
_TIMES = "camturn/times_s"


@pytest.fixture(scope="session")
def table_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Make the table of a part of the repository once, its design beside it; return its path."""
    folder = tmp_path_factory.mktemp("tables")

    def make(part: str) -> Path:
        path = folder / f"{part}.camtab"
        if not path.exists():
            [source] = [file for one in FOLDERS if (file := one / f"{part}.toml").exists()]
            assert mktables([str(source), "-o", str(folder)]) == 0
        return path

    return make


def pytest_addoption(parser: pytest.Parser) -> None:
    """Take --quick."""
    parser.addoption("--quick", type=float, metavar="S", help="only tests that last took S or less")


class _Times:
    """Remembers how long tests take, the set-up of what they share included."""

    def __init__(self, config: pytest.Config, cache: pytest.Cache) -> None:
        self._longest_s: float | None = config.getoption("--quick")
        self._cache = cache
        self._known_s: dict[str, float] = cache.get(_TIMES, {})
        self._took_s: dict[str, float] = defaultdict(float)
        self._hears_all = not hasattr(config, "workerinput")

    def pytest_collection_modifyitems(
        self, config: pytest.Config, items: list[pytest.Item]
    ) -> None:
        """Leave out what took longer."""
        if self._longest_s is not None:
            longest_s = self._longest_s
            left_out = [one for one in items if self._known_s.get(one.nodeid, 0.0) > longest_s]
            items[:] = [one for one in items if self._known_s.get(one.nodeid, 0.0) <= longest_s]
            config.hook.pytest_deselected(items=left_out)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Add a phase of a test."""
        self._took_s[report.nodeid] += report.duration

    def pytest_sessionfinish(self) -> None:
        """Keep times of all tests, or with --quick of those that have none yet."""
        if self._hears_all and self._longest_s is None:
            self._cache.set(_TIMES, self._known_s | self._took_s)
        elif self._hears_all:
            self._cache.set(_TIMES, self._took_s | self._known_s)


def pytest_configure(config: pytest.Config) -> None:
    """Time the tests, unless pytest runs without its cache."""
    if config.pluginmanager.hasplugin("cacheprovider") and config.cache:
        config.pluginmanager.register(_Times(config, config.cache))
