"""What a retract costs, as FAULTS.md states it: emergency stops at 24 angles."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from camtools.sim.results import STATES
from camtools.sim.simulate import simulate
from tests.tools.cases.camsim_cases import ROOT
from tests.tools.cases.part_cases import TableOf, sure

STEP_LIMIT_NM = 20_000  # 400 mm/s at 20 kHz
RETRACT_NM = -500_000


def retract(table: Path, at: str, feed_mm: float = 0.1, state: str = "") -> dict[str, float]:
    """Stop a cut, in a state if one is given, and follow U from the tick before the fault on."""
    options = ["--no-learning", "--inject", f"estop@{at}"]
    cut = simulate(table, rpm=2500, feed=feed_mm, trace=True, options=options)
    assert cut.status == 1
    first = int(np.argmax(cut.trace["state"] == STATES.index("fault"))) - 2
    assert state in ("", STATES[int(cut.trace["state"][first])])
    names = ("u_set_nm", "u_act_nm", "out_u_nm", "out_outputs")
    u, actual, command, outputs = (cut.trace[name][first:] for name in names)
    enabled = outputs.astype(int) & 1
    return {
        "deeper": command.max() - command[1],
        "actual": actual[2:].max() - actual[1],
        "away": int(np.argmax(actual < u[1] - 100_000)) - 2,
        "out": int(np.argmax(u == RETRACT_NM)) - 2,
        "off": int(np.argmin(enabled)) - 2,
        "step": np.abs(np.diff(command)).max(),
        "change": np.abs(np.diff(command, 2)).max(),
    }


@pytest.mark.parametrize(
    ("rpm", "at_s", "jerk", "k2_us2"),
    [(60, 0.793, 10**6, None), (500, 0.76, 2 * 10**9, 1000), (500, 1.424, 10**6, 0)],
)
def test_slow_tick_retracts_within_the_stroke_by_single_steps(
    table_of: TableOf, rpm: int, at_s: float, jerk: int, k2_us2: int | None
) -> None:
    """With a window of one tick U brakes in the coarsest steps, and no second fault is raised."""
    settings = {"u_jerk_m_per_s3": jerk} | ({} if k2_us2 is None else {"k2_us2": k2_us2})
    slow, options = {"machine": {"tick_hz": 1000}}, ["--inject", f"bus@{at_s}"]
    found = simulate(table_of("perkins240"), slow, rpm=rpm, set=settings, options=options)
    assert found.status == 1
    assert found.summary["faults"] == ["bus"]


@pytest.mark.long
def test_retract_costs_what_the_manual_states(table: Path) -> None:
    """No step of the command is beyond U's speed; way and time are those of FAULTS.md."""
    stops = [retract(table, f"{2.0 + i * 0.0005:.4f}") for i in range(24)]
    worst = {key: max(stop[key] for stop in stops) for key in stops[0]}
    assert worst["step"] <= STEP_LIMIT_NM
    ms = 1e3 / 20_000
    figures = [
        f"{worst['deeper'] / 1e3:.1f} um",
        f"{worst['actual'] / 1e3:.1f} um",
        f"{worst['away'] * ms:.2f} ms",
        f"{worst['out'] * ms:.1f} ms",
        f"{worst['off'] * ms:.0f} ms",
        f"{worst['step'] / 1e3:.1f} um",
        f"{worst['change'] / 1e3:.1f} um",
    ]
    manual = (ROOT / "firmware" / "FAULTS.md").read_text()
    rows = manual.split("| worst of 24 stops | |")[1].splitlines()[2:9]
    assert [row.split("|")[2].strip() for row in rows] == figures


def test_enable_drops_latest_in_the_approach(table: Path) -> None:
    """The manual rounds up to whole ms, because a relay that opens earlier takes U's hold."""
    stops = {
        "homing": [("t0.1", 0.1)],
        "engaging": [(f"t{at_s:.3f}", 0.1) for at_s in np.arange(0.304, 0.324, 0.001)],
        "cutting": [("t1.0", 0.1), *((f"t{at_s}", 2.0) for at_s in (0.94, 1.24, 1.6))],
        "disengaging": [(f"t{at_s}", 2.0) for at_s in (1.69, 1.8, 1.89)],
    }
    off_ms = {
        state: max(retract(table, at, feed_mm, state)["off"] / 20 for at, feed_mm in cases)
        for state, cases in stops.items()
    }
    manual = (ROOT / "firmware" / "FAULTS.md").read_text()
    latest = sure(re.search(r"\*\*(\d+) ms\*\* in `engaging`, against (\d+) ms", manual))
    assert math.ceil(off_ms.pop("engaging")) == int(latest[1])
    assert math.ceil(max(off_ms.values())) == int(latest[2])
