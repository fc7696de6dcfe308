# SPDX-License-Identifier: Apache-2.0
"""What the tests of the emulated image share."""

from __future__ import annotations

from pathlib import Path

import pytest

from host import make_table


@pytest.fixture(scope="session")
def table_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the path of a good table."""
    path = tmp_path_factory.mktemp("table") / "short.camtab"
    make_table(path)
    return path


@pytest.fixture(scope="session")
def table(table_path: Path) -> bytes:
    """Return a good table."""
    return table_path.read_bytes()
