# SPDX-License-Identifier: Apache-2.0
"""Drives that lag far behind their command cut and retract within a short stroke."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.tools.cases.camsim_cases import camsim

ESTOPS_S = [0.03 + 0.0137 * i for i in range(8)]
MACHINE = """[machine]
name = "slow"
tick_hz = {tick_hz}
[u]
bandwidth_hz = {bandwidth_hz}
damping = {damping}
friction_m_per_s2 = {friction}
stroke_mm = {stroke_mm}
"""


@pytest.mark.parametrize("stroke_mm", [0.63, 0.75, 0.9, 1.0])
@pytest.mark.parametrize(
    ("tick_hz", "bandwidth_hz", "damping", "friction"),
    [(10000, 85, 0.7, 1.0), (10000, 85, 1.0, 0.0), (4000, 120, 0.5, 1.0)],
)
def test_no_command_leaves_the_stroke(
    table_of: Callable[[str], Path],
    tmp_path: Path,
    tick_hz: int,
    bandwidth_hz: float,
    damping: float,
    friction: float,
    stroke_mm: float,
) -> None:
    """A cut ends without a fault, and an emergency stop at any time without a second one."""
    machine, summary = tmp_path / "slow.toml", tmp_path / "summary.json"
    machine.write_text(
        MACHINE.format(
            tick_hz=tick_hz,
            bandwidth_hz=bandwidth_hz,
            damping=damping,
            friction=friction,
            stroke_mm=stroke_mm,
        ),
        encoding="utf-8",
    )
    words = ("--machine", machine, "--rpm", "300", "--feed", "4", "--summary", summary)
    for at_s in [None, *ESTOPS_S]:
        inject = () if at_s is None else ("--inject", f"estop@{at_s}")
        done = camsim("run", table_of("perkins240"), *words, *inject)
        assert done.returncode == (0 if at_s is None else 1), done.stderr
        faults = json.loads(summary.read_text("utf-8"))["faults"]
        assert faults == ([] if at_s is None else ["estop"])
