# SPDX-License-Identifier: Apache-2.0
"""What all tests share: the tables of parts that they cut, and how long each test takes.

`--quick S` leaves out the tests that took longer when they last ran without it, in this clone.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from pathlib import Path

import pytest

from camtools.cli.mktables import main as mktables
from tests.tools.cases.part_cases import ROOT

FOLDERS = (ROOT / "tools" / "parts", ROOT / "tests" / "learn" / "parts")
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


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out what took longer."""
    longest_s = config.getoption("--quick")
    if longest_s is None:
        return
    took_s = config.cache.get(_TIMES, {}) if config.cache else {}
    left_out = [item for item in items if took_s.get(item.nodeid, 0.0) > longest_s]
    items[:] = [item for item in items if item not in left_out]
    config.hook.pytest_deselected(items=left_out)


class _Clock:
    """Remembers how long tests take, the set-up of what they share included."""

    def __init__(self, config: pytest.Config) -> None:
        self._config = config
        self._took_s: dict[str, float] = defaultdict(float)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Add a phase of a test."""
        self._took_s[report.nodeid] += report.duration

    def pytest_sessionfinish(self) -> None:
        """Keep times of all tests, or with --quick of those that have none yet."""
        assert self._config.cache
        known = self._config.cache.get(_TIMES, {})
        is_quick = self._config.getoption("--quick") is not None
        merged = self._took_s | known if is_quick else known | self._took_s
        self._config.cache.set(_TIMES, merged)


def pytest_configure(config: pytest.Config) -> None:
    """Time the tests in the process that hears of all."""
    if not hasattr(config, "workerinput") and config.cache:
        config.pluginmanager.register(_Clock(config))
