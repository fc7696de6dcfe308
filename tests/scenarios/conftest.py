# SPDX-License-Identifier: Apache-2.0
"""What all scenarios share: the simulator and the table of the Perkins skirt."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from camtools.mktables import main as mktables

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def camsim() -> Path:
    """Path of the built simulator."""
    path = ROOT / os.environ.get("CAMTURN_BUILD", "build/host") / "host_sim" / "camsim"
    assert path.exists(), f"{path} is missing: build the preset host, or let tools/test do it"
    return path


@pytest.fixture(scope="session")
def table(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Path of a freshly made table of the Perkins skirt, its design beside it."""
    folder = tmp_path_factory.mktemp("table")
    part = ROOT / "tools" / "parts" / "perkins240.toml"
    assert mktables([str(part), "-o", str(folder)]) == 0
    return folder / "perkins240.camtab"
