# SPDX-License-Identifier: Apache-2.0
"""What all scenarios share: the table of the Perkins skirt."""

from __future__ import annotations

from pathlib import Path

import pytest

from camtools.mktables import main as mktables
from part_cases import PERKINS


@pytest.fixture(scope="session")
def table(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Path of a freshly made table of the Perkins skirt, its design beside it."""
    folder = tmp_path_factory.mktemp("table")
    assert mktables([str(PERKINS), "-o", str(folder)]) == 0
    return folder / "perkins240.camtab"
