"""Faults at many moments of a cut: a wrong encoder, an emergency stop with a slow drive."""

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.scenarios.cuts import Outcome

TableOf = Callable[[str], Path]
GOUGE_UM = 3.0
WRONG_TURNS = (2.03, 2.21, 2.37, 2.44, 2.71, 2.86)  # after the full amplitude is reached
STUCK = [
    *(("stuck", "perkins240", rpm) for rpm in (20, 110, 400, 3000)),
    ("stuck", "perkins240_equal_volume", 230),
]
RATES = [  # slower than 50 r/min the inertia allows what the index finds
    *((rate, "perkins240", rpm) for rate in ("rate:-50", "rate:100") for rpm in (50, 400, 3000)),
    *((dither, "perkins240", 110) for dither in ("dither:1", "dither:3", "dither:7")),
    ("rate:100", "perkins240_equal_volume", 230),
]
ESTOPS_S = [0.03 + 0.0137 * i for i in range(8)]
SLOW = """[machine]
name = "slow"
tick_hz = {}
[u]
bandwidth_hz = {}
damping = {}
friction_m_per_s2 = {}
stroke_mm = {}
"""


@pytest.mark.long
@pytest.mark.parametrize(("fault", "part", "rpm"), STUCK + RATES)
def test_wrong_encoder_costs_no_part(table_of: TableOf, fault: str, part: str, rpm: int) -> None:
    """The fault is latched, and the tool was nowhere deeper than 3 um below the drawing."""
    words = ("--rpm", str(rpm), "--feed", "1", "--set", "rehearse_turns=0", "--inject")
    kind, _, value = fault.partition(":")
    for turns in WRONG_TURNS:
        cut = Outcome(
            table_of(part), *words, f"encoder-{kind}@{turns * 60.0 / rpm}:{value}".rstrip(":")
        )
        assert cut.status == 1, cut.message
        assert {"spindle_stopped", "encoder_jump"} & set(cut.summary["first_faults"])
        assert cut.summary["cut"]["gouge_um"] <= GOUGE_UM


@pytest.mark.long
@pytest.mark.parametrize(("rpm", "deepest_um"), [(60, 115), (250, 65), (1000, 80), (3000, 80)])
def test_frozen_scale_lets_u_go(table_of: TableOf, rpm: int, deepest_um: float) -> None:
    """The force vanishes before U is far off; from there on it coasts."""
    force = Path(__file__).parent / "cases/machines/force.toml"
    words = ("--machine", force, "--rpm", str(rpm), "--feed", "1", "--inject")
    for turns in WRONG_TURNS:
        cut = Outcome(table_of("perkins240"), *words, f"u-scale-stuck@{turns * 60.0 / rpm}")
        assert cut.summary["first_faults"] == ["u_runaway"]
        assert cut.summary["cut"]["gouge_um"] <= deepest_um


@pytest.mark.long
@pytest.mark.parametrize("stroke_mm", [0.63, 1.0])
@pytest.mark.parametrize(
    "drive", [(10000, 85, 0.7, 1.0), (10000, 85, 1.0, 0.0), (4000, 120, 0.5, 1.0)]
)
def test_slow_drive_keeps_a_short_stroke(
    table_of: TableOf, tmp_path: Path, drive: tuple[float, ...], stroke_mm: float
) -> None:
    """A cut ends without a fault, and an emergency stop at any time without a second one."""
    machine = tmp_path / "slow.toml"
    machine.write_text(SLOW.format(*drive, stroke_mm), encoding="utf-8")
    words = ("--machine", machine, "--rpm", "300", "--feed", "4")
    for inject in ((), *(("--inject", f"estop@{at_s}") for at_s in ESTOPS_S)):
        cut = Outcome(table_of("perkins240"), *words, *inject)
        assert cut.status == len(inject) // 2, cut.message
        assert cut.summary["faults"] == ["estop"][: len(inject)]
