# SPDX-License-Identifier: Apache-2.0
"""The chip's force on the realistic machine: its feed ramps are as good as the middle."""

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.tools.cases.camsim_cases import ROOT, camsim

REAL = ROOT / "host_sim" / "machines" / "real.toml"


def errors_of(
    table: Path, folder: Path, machine: Path, feed: str
) -> tuple[np.ndarray, dict[str, Any]]:
    """Cut the Perkins skirt; return height [mm] and error [um] of its surface, and the summary."""
    surface, summary = folder / "surface.csv", folder / "summary.json"
    files: list[str | Path] = ["--surface", surface, "--summary", summary]
    done = camsim("run", table, "--machine", machine, "--feed", feed, *files, "--tolerance-um=99")
    assert done.returncode == 0, done.stderr
    with surface.open() as stream:
        rows = [(float(r["z_mm"]), float(r["error_nm"]) / 1e3) for r in csv.DictReader(stream)]
    return np.array(rows), json.loads(summary.read_text())


def largest_um(rows: np.ndarray, low_mm: float, high_mm: float) -> float:
    """Return the largest error between two heights."""
    inside = (rows[:, 0] >= low_mm) & (rows[:, 0] <= high_mm)
    return float(np.abs(rows[inside, 1]).max())


def test_first_turns_are_as_good_as_the_middle(
    table_of: Callable[[str], Path], tmp_path: Path
) -> None:
    """They had 0.6 um."""
    rows, _ = errors_of(table_of("perkins240"), tmp_path, REAL, "0.1")
    assert largest_um(rows, 0.0, 1.0) <= 0.3


def test_last_turns_at_a_large_feed(table_of: Callable[[str], Path], tmp_path: Path) -> None:
    """They had 2.3 um. Most of what is left is the tool, which bends beyond the scale."""
    rows, _ = errors_of(table_of("perkins240"), tmp_path, REAL, "0.5")
    assert largest_um(rows, 57.5, 62.0) <= 0.5
    assert largest_um(rows, 0.5, 62.0) <= 0.75


def test_spring_deflects_alike_by_the_mean(table_of: Callable[[str], Path], tmp_path: Path) -> None:
    """A position drive is a spring: both coefficients are its share of the force."""
    machine = ROOT / "tests" / "learn" / "machines" / "chip.toml"
    rows, summary = errors_of(table_of("perkins240"), tmp_path, machine, "0.5")
    assert largest_um(rows, 1.0, 62.0) <= 0.1
    learned = summary["learning"]
    expected = 700 * 0.3 / (1.5 * (2 * np.pi * 300) ** 2 * 1e-9)
    assert learned["chip_nm_per_mm2"] == pytest.approx(expected, rel=0.02)
    assert learned["chip_mean_nm_per_mm2"] == pytest.approx(expected, rel=0.02)


SLOTS = """\
slot_deg = 90
slot_width_deg = 40
slot_low_mm = 10
slot_high_mm = 35
slot_2_deg = 270
slot_2_width_deg = 40
slot_2_low_mm = 10
slot_2_high_mm = 35
"""


def slotted(machine: Path, folder: Path) -> Path:
    """Return a machine whose blank has two slots on the short axis, 25 mm high."""
    file = folder / "slotted.toml"
    file.write_text(machine.read_text().replace("[cut]\n", f"[cut]\n{SLOTS}"))
    return file


@pytest.mark.parametrize(("name", "most_um"), [("chip", 0.05), ("real", 0.31)])
def test_slots_do_not_harm_the_rest(
    table_of: Callable[[str], Path], tmp_path: Path, name: str, most_um: float
) -> None:
    """The rest of the surface is as good as without, after the first turns at either end."""
    machines = {"real": REAL, "chip": ROOT / "tests" / "learn" / "machines" / "chip.toml"}
    machine = slotted(machines[name], tmp_path)
    rows, summary = errors_of(table_of("perkins240"), tmp_path, machine, "0.1")
    assert summary["learning"]["masked"] == []
    for low_mm, high_mm in ((1, 9.9), (14, 34.9), (39, 61)):
        assert largest_um(rows, low_mm, high_mm) <= most_um, low_mm
    assert 0.5 < largest_um(rows, 9.9, 39) < 3  # the force steps by up to 4 N


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("slot_low_mm = -9\nslot_high_mm = 99",
         "not gauged: nothing was cut to full depth before the cut was done; check the slots in"),
        ("slot_low_mm = 35\nslot_high_mm = 10",
         "cut.slot_low_mm = 35: must be below slot_high_mm = 10; correct them"),
        ("slot_4_width_deg = 9", "cut.slot_low_mm = 0: must be below slot_high_mm = 0; correct"),
        ('slot = "90"', 'line 3: cut.slot = "90": unknown; see host_sim/machines/default.toml'),
    ],
)  # fmt: skip
def test_slots_that_leave_nothing_or_are_none(
    table_of: Callable[[str], Path], tmp_path: Path, keys: str, message: str
) -> None:
    """One line each: a slot all around the part, heights that are exchanged or none, no number."""
    machine = tmp_path / "machine.toml"
    machine.write_text(f"[cut]\nslot_width_deg = 360\n{keys}\n")
    done = camsim("run", table_of("perkins240"), "--machine", machine, "--feed", "2")
    assert done.returncode in (1, 2)
    assert message in done.stderr and "stop" not in done.stderr
    assert len(done.stderr.splitlines()) == 1


def test_slots_hold_no_metal(table_of: Callable[[str], Path], tmp_path: Path) -> None:
    """Two windows of 40 degrees and 25 of 62 mm, at the short axis, where the cut is deepest."""
    whole = ROOT / "tests" / "learn" / "machines" / "chip.toml"
    table = table_of("perkins240")
    cuts = [
        errors_of(table, tmp_path, machine, "0.5")[1]
        for machine in (whole, slotted(whole, tmp_path))
    ]
    removed, slotted_removed = (cut["cut"]["removed_mm3"] for cut in cuts)
    depth_mm, radius_mm = 0.21, 45.9  # mean of the windows
    missing_mm3 = 2 * np.radians(40) * radius_mm * 25 * depth_mm
    assert removed - slotted_removed == pytest.approx(missing_mm3, rel=0.1)
    volumes = [cut["removal"]["volume_mm3"] for cut in cuts]
    assert volumes[0] - volumes[1] == pytest.approx(missing_mm3, rel=0.1)


def test_what_is_learned_survives_slots_at_a_large_feed(
    table_of: Callable[[str], Path], tmp_path: Path
) -> None:
    """The steps of the force do not end in the coefficient: the last turns are good."""
    machine = slotted(REAL, tmp_path)
    rows, _ = errors_of(table_of("perkins240"), tmp_path, machine, "0.5")
    assert largest_um(rows, 57.5, 62.0) <= 0.8
