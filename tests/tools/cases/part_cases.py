"""Places and processes that several tests of the table generator use."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
PERKINS = ROOT / "tools" / "parts" / "perkins240.toml"

Mktables = Callable[..., subprocess.CompletedProcess[str]]


def environment() -> dict[str, str]:
    """Return the environment in which a child finds camtools."""
    return os.environ | {"PYTHONPATH": str(ROOT / "tools")}
