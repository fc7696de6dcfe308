# SPDX-License-Identifier: Apache-2.0
"""Drives that lag far after their command cut and retract within a short stroke."""

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.scenarios.cuts import Outcome

ESTOPS_S = [0.03 + 0.0137 * i for i in range(8)]
MACHINE = """[machine]
name = "slow"
tick_hz = {}
[u]
bandwidth_hz = {}
damping = {}
friction_m_per_s2 = {}
stroke_mm = {}
"""


@pytest.mark.parametrize("stroke_mm", [0.63, 0.75, 0.9, 1.0])
@pytest.mark.parametrize(
    "drive", [(10000, 85, 0.7, 1.0), (10000, 85, 1.0, 0.0), (4000, 120, 0.5, 1.0)]
)
def test_no_command_leaves_the_stroke(
    table_of: Callable[[str], Path], tmp_path: Path, drive: tuple[float, ...], stroke_mm: float
) -> None:
    """A cut ends without a fault, and an emergency stop at any time without a second one."""
    machine = tmp_path / "slow.toml"
    machine.write_text(MACHINE.format(*drive, stroke_mm), encoding="utf-8")
    words = ("--machine", machine, "--rpm", "300", "--feed", "4")
    for at_s in [None, *ESTOPS_S]:
        inject = () if at_s is None else ("--inject", f"estop@{at_s}")
        cut = Outcome(table_of("perkins240"), *words, *inject)
        assert cut.status == (0 if at_s is None else 1), cut.message
        assert cut.summary["faults"] == ([] if at_s is None else ["estop"])
