# SPDX-License-Identifier: Apache-2.0
"""Cams that turn slowly learn, too: MATHS.md (232) in whole cuts."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.tools.cases.camsim_cases import ROOT, camsim

MACHINE = ROOT / "host_sim" / "machines" / "cam.toml"


def cut(table: Path, folder: Path, rpm: float, *words: str) -> dict[str, Any]:
    """Return the summary of a cut with a drive of U that is believed 10 % slower."""
    machine, summary = folder / "m.toml", folder / "s.json"
    machine.write_text(MACHINE.read_text() + "\n[believed.u]\nbandwidth_hz = 270\n")
    options: list[str | Path] = ["--machine", machine, "--rpm", str(rpm), "--summary", summary]
    done = camsim("run", table, *options, "--tolerance-um", "99", *words)
    assert done.returncode == 0, done.stderr
    loaded: dict[str, Any] = json.loads(summary.read_text())
    return loaded


@pytest.mark.parametrize("rpm", [40, 72])
def test_a_slow_cam_is_learned(table_of: Callable[[str], Path], tmp_path: Path, rpm: float) -> None:
    """30 000 and 16 667 ticks a turn: from micrometres to a tenth within some turns."""
    found = cut(table_of("cam-345"), tmp_path, rpm, "--turns-limit", "40")
    errors = [e for e in found["error_per_turn_um"] if e is not None]
    assert len(errors) >= 35 and max(errors[15:35]) < 0.2
    learned = found["learning"]
    assert learned["reason"] == "all" and learned["turns"] > 30
    assert learned["k1_ns"] == pytest.approx(-82_500, rel=0.05)  # 1.4 / w of 300 and 270 Hz
