# SPDX-License-Identifier: Apache-2.0
"""What learning does where it must not go on: at the end of U's stroke, near a mode."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

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


# U reaches 1 mm to one side, so the stroke leaves 10 um, 50 um, and 10 um that do not suffice.
JUST = """\
[machine]
tick_hz = 10000
[spindle]
limit_rpm = 3500
[encoder]
counts_per_turn = 65536
[u]
speed_mm_per_s = 800
acceleration_mm_per_s2 = 500000
stroke_mm = {stroke_mm}
bandwidth_hz = {hz}
damping = {damping}
friction_m_per_s2 = 15
[believed.u]
bandwidth_hz = {believed_hz}
damping = {believed_damping}
"""
SMALL = {"stroke_mm": 2.02, "hz": 190, "damping": 0.52, "believed_hz": 232, "believed_damping": 0.6}
MIDDLE = SMALL | {"stroke_mm": 2.1}
TOO_SMALL = SMALL | {"hz": 178, "damping": 0.64, "believed_hz": 213, "believed_damping": 0.64}


def just(folder: Path, stroke: dict[str, float]) -> Path:
    """Return a machine whose stroke just suffices, or not."""
    machine = folder / "just.toml"
    machine.write_text(JUST.format(**stroke))
    return machine


@pytest.mark.parametrize(("stroke", "most_um"), [(SMALL, 0.3), (MIDDLE, 0.3)])
def test_stroke_that_just_suffices(
    table_of: Callable[[str], Path], tmp_path: Path, stroke: dict[str, float], most_um: float
) -> None:
    """A hundredth or a twentieth of the motion is left for friction and corrections."""
    summary = cut(table_of("oval30"), tmp_path, str(just(tmp_path, stroke)))
    assert summary["end"] == "done"
    assert summary["form_error_um"]["max"] < most_um


def test_stroke_that_just_does_not_suffice(table_of: Callable[[str], Path], tmp_path: Path) -> None:
    """The rehearsal ends with one fault, which names the command of U, and nothing is cut."""
    summary_path = tmp_path / "s.json"
    words: list[str | Path] = ["--machine", just(tmp_path, TOO_SMALL), "--summary", summary_path]
    done = camsim("run", table_of("oval30"), *words, "--rpm=3000", "--tolerance-um=99")
    assert done.returncode == 1
    lines = done.stderr.splitlines()
    assert len(lines) == 1, lines
    assert "fault command: an axis command exceeds its limits" in lines[0]
    assert ", rehearsing at " in lines[0]
    summary = json.loads(summary_path.read_text())
    assert summary["faults"] == ["command"]
    assert summary["form_error_um"]["max"] is None  # no point of the part was cut


def test_missing_stroke_is_named_in_advance(
    table_of: Callable[[str], Path], tmp_path: Path
) -> None:
    """The configured feed-forward alone needs 2.4 um more: one refusal with both and a remedy."""
    drive = {"hz": 160, "damping": 0.7, "believed_hz": 192, "believed_damping": 0.8}
    machine = just(tmp_path, MIDDLE | drive)
    done = camsim("run", table_of("oval30"), "--machine", machine, "--rpm=3000")
    assert done.returncode == 2
    assert done.stderr == (
        "camsim: --rpm 3000: infeasible: the feed-forward would command U beyond its stroke: "
        "needs 1.05243 mm, limit 1.05 mm; give at most --rpm 2945.823\n"
    )
