# SPDX-License-Identifier: Apache-2.0
"""What learning does where it must not go on: at the end of U's stroke, near a mode."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.tools.cases.camsim_cases import ROOT, camsim

MACHINES = ROOT / "tests" / "learn" / "machines"


def cut(table: Path, folder: Path, machine: str, *options: str) -> dict[str, Any]:
    """Return the summary of a cut at 3000 r/min."""
    summary = folder / "s.json"
    words: list[str | Path] = ["--machine", MACHINES / machine, "--summary", summary]
    done = camsim("run", table, *words, "--rpm=3000", "--tolerance-um=99", *options)
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(summary.read_text())
    return found


def test_corrections_stay_within_the_stroke(
    table_of: Callable[[str], Path], tmp_path: Path
) -> None:
    """A correction of the whole force would leave it, which was the fault `command`."""
    summary = cut(table_of("oval30"), tmp_path, "tight.toml", "--feed=0.3")
    assert summary["faults"] == []
    assert summary["learning"]["reason"] == "limited"


def test_another_speed_beside_a_mode(table_of: Callable[[str], Path], tmp_path: Path) -> None:
    """At 3300 r/min harmonic 15 is beside the mode of 800 Hz: it diverged to 36 um."""
    summary = cut(table_of("oval30"), tmp_path, "mode.toml", "--inject", "spindle-override@2:110")
    assert 15 in summary["learning"]["masked"]
    assert summary["form_error_um"]["max"] < 0.6
