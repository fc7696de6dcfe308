# SPDX-License-Identifier: Apache-2.0
"""A rehearsal on the simulator: the true tip never comes near the blank, whatever the part."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.tools.cases.camsim_cases import ROOT, camsim, columns_of

# Part, words for camsim, and what the blank is thicker than the largest radius that is cut.
CASES: dict[str, tuple[str, tuple[str, ...], float]] = {
    "depth of cut": ("perkins240", (), 0.1),
    "no clearance of X": ("perkins240", ("--set", "x_clearance_nm=0"), 0.1),
    "u about its mean": ("skirt_passes", ("--set", "pass=1"), 0.3),
    "lobes": ("cam-flat", ("--machine", str(ROOT / "host_sim/machines/cam.toml")), 0.1),
}


@pytest.mark.parametrize("case", CASES)
def test_the_tip_stays_off_the_blank(
    table_of: Callable[[str], Path], tmp_path: Path, case: str
) -> None:
    """While U plays, the tip stays outside of the largest radius that is cut and its stock."""
    part, words, stock_mm = CASES[case]
    trace, summary = tmp_path / "t.csv", tmp_path / "s.json"
    files: list[str | Path] = ["run", table_of(part), *words]
    done = camsim(
        *(*files, "--set", "rehearse_turns=3"),
        *("--turns-limit", "3", "--trace", trace, "--summary", summary),
        *("--tolerance-um", "1000", "--trace-every", "11"),
    )
    assert summary.exists(), done.stderr
    columns = columns_of(trace)
    state, u_mm, x_mm = columns["state"], columns["in_u_nm"] * 1e-6, columns["in_x_nm"] * 1e-6
    tip_mm = x_mm - u_mm
    plays = (state == "rehearsing") & (u_mm > 0.1 * u_mm.max())
    blank_mm = tip_mm[state == "cutting"].max() + stock_mm
    assert u_mm[plays].max() > 0.9 * u_mm[state == "cutting"].max()
    assert tip_mm[plays].min() > blank_mm
    assert json.loads(summary.read_text())["faults"] == []
