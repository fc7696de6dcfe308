# SPDX-License-Identifier: Apache-2.0
"""What tests that cut parts share: the tables of these parts."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from camtools.cli.mktables import main as mktables
from tests.tools.cases.part_cases import ROOT

FOLDERS = (ROOT / "tools" / "parts", ROOT / "tests" / "learn" / "parts")


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
