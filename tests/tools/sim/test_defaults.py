"""Windows, limits and bandwidth that nobody set fit the machine, or are refused with numbers."""

from pathlib import Path

import numpy as np
import pytest

from tests.tools.cases.camsim_cases import cut, refusal, while_in
from tests.tools.cases.cut_cases import written_skirt
from tests.tools.cases.part_cases import oval_text

PROCESS = 'feed_mm = 0.1\nu_zero = "mean"\nform_error_um = 1'
STROKE = "[machine.limits]\nu_stroke_mm = 0.8\n"
OVAL = oval_text("oval", (30, 90), [0.3, 0.3], PROCESS, STROKE).replace("= 1500", "= 3000")
OVALITY_UM = 300.0
QUICK = ("--feed", "1", "--turns-limit", "4")


@pytest.fixture(scope="session")
def oval(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Make the table of an oval of the same ovality everywhere."""
    return written_skirt(OVAL, tmp_path_factory.mktemp("oval"))


def machine(tick_hz: int, counts: int, more: str = "") -> str:
    """Return a machine file."""
    return f"[machine]\ntick_hz = {tick_hz}\n[encoder]\ncounts_per_turn = {counts}\n{more}"


@pytest.mark.long
@pytest.mark.parametrize("counts", [4096, 10_000, 65_536, 1_000_000])
@pytest.mark.parametrize("tick_hz", [1000, 5000, 20_000])
def test_no_speed_is_taken_for_a_jump(oval: Path, tick_hz: int, counts: int) -> None:
    """Every encoder and tick cuts at every speed, with the usual and with slow observers."""
    lathe = machine(tick_hz, counts)
    for rpm in (500, 1500, 2000):
        for bandwidth in ((), ("--set", "observer_bandwidth_mHz=20000")):
            words = (*QUICK, "--rpm", rpm, "--tolerance-um", 50, *bandwidth)
            assert cut(oval, *words, machine=lathe).summary["faults"] == []


def blocked_s(table: Path, rpm: int, at_s: float) -> tuple[float, float]:
    """Block U in the cut; return [s] until the fault, and the largest following error [um]."""
    words = ("--rpm", rpm, "--inject", f"u-block@{at_s}")
    found = cut(table, *words, status=1, tables=["trace"])
    assert "fault following_error:" in found.message
    begin = while_in(found.trace, "cutting", "fault")["t_s"][0] + at_s
    first = while_in(found.trace, "fault")[0]
    off_um = (first["u_act_nm"] - first["u_due_nm"]) * 1e-3
    return float(first["t_s"] - begin), abs(float(off_um))


@pytest.mark.parametrize(
    "at_s",
    [
        0.1,
        pytest.param(0.1025, marks=pytest.mark.long),
        0.105,
        pytest.param(0.1075, marks=pytest.mark.long),
    ],
)
def test_blocked_u_is_seen_within_a_tenth_of_the_ovality_and_the_first_turn(
    oval: Path, table: Path, at_s: float
) -> None:
    """Wherever U stands: on an oval, and where the ovality is half of the part's largest."""
    for one in (oval, table):
        late_s, off_um = blocked_s(one, 2400, at_s)
        assert 0 <= late_s <= 60 / 2400
        assert off_um <= 0.1 * OVALITY_UM + 3.0  # and what U would have moved in its tick


@pytest.mark.parametrize("stroke_mm", [0.32, 0.5, 0.8, 1.2])
@pytest.mark.parametrize("tick_hz", [1000, 20_000])
def test_default_retract_fits_every_stroke(oval: Path, stroke_mm: float, tick_hz: int) -> None:
    """U stays in the stroke to the end, also at coarse ticks, where it overshot by 6 um."""
    lathe = machine(tick_hz, 10_000, f"[u]\nstroke_mm = {stroke_mm}\n")
    found = cut(oval, "--rpm", "1500", *QUICK, machine=lathe, tables=["trace"])
    assert np.abs(found.trace["u_set_nm"]).max() <= stroke_mm * 5e5


def test_retract_that_was_set_beyond_the_stroke_is_blamed_itself(oval: Path) -> None:
    """The line names the parameter and what would do; that is taken."""
    lathe = machine(20_000, 10_000, "[u]\nstroke_mm = 0.8\n")
    words = ("--rpm", "1500", *QUICK)
    line = refusal(oval, *words, "--set", "u_retract_nm=-450000", machine=lathe)
    assert line.startswith("--set u_retract_nm=-450000: infeasible: ")
    most = line.partition("give at least ")[2].partition(",")[0]
    cut(oval, *words, "--set", f"u_retract_nm={most}", machine=lathe)
