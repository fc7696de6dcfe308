"""Run every scenario of cases/ and judge it; README.md explains their keys."""

import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camtools.sim.binding import Rows
from camtools.sim.results import CUTTING, FAULT, STATES
from tests.scenarios.cuts import Outcome
from tests.tools.cases.camsim_cases import ROOT

CASES = Path(__file__).parent / "cases"
FOLDERS = {"{machines}": CASES / "machines", "{host_sim}": ROOT / "host_sim"}
TICK_S = 50e-6
ENABLE, FAULT_LAMP, IN_CUT = 1, 2, 4
# Limits of U as camsim sets them for the default machine, with the 1/16 that the guard allows for
# encoder noise and the rounding of the set-points.
U_SPEED_NM_PER_TICK = 400e6 * TICK_S * 17 / 16 + 4
U_ACCELERATION_NM_PER_TICK2 = 250e9 * TICK_S**2 * 17 / 16 + 4
RETRACT_NM, CLEARANCE_NM = -500_000, 1_000_000
OUT_NM = 100_000  # off the drawn surface the tip is out of the work

Expect = dict[str, Any]


def cases() -> Iterator[Any]:
    """Yield table or part, words of the command line and expectation of each run."""
    for path in sorted(CASES.glob("*.toml")):
        scenario = tomllib.loads(path.read_text("utf-8"))
        for run in scenario.get("runs", [{}]):
            words = [*scenario["arguments"], *run.pop("arguments", [])]
            words += ["--inject", run.pop("inject")] if "inject" in run else []
            for short, folder in FOLDERS.items():
                words = [word.replace(short, str(folder)) for word in words]
            name = f"{path.stem}-{words[-1]}" if "runs" in scenario else path.stem
            yield pytest.param(scenario, words, scenario["expect"] | run, id=name)


def damaged(table: Path, at: int, folder: Path) -> Path:
    """Return a copy of the table with one bit of byte `at` flipped."""
    image = bytearray(table.read_bytes())
    image[at] ^= 1
    copy = folder / table.name
    copy.write_bytes(image)
    return copy


def check_steps(positions_nm: Rows) -> None:
    """Check that positions of U, one per tick, stay within its speed and acceleration."""
    steps_nm = np.diff(positions_nm)
    assert np.abs(steps_nm).max(initial=0) <= U_SPEED_NM_PER_TICK
    assert np.abs(np.diff(steps_nm)).max(initial=0) <= U_ACCELERATION_NM_PER_TICK2


def check_u_limits(trace: Rows) -> None:
    """Check the set-points of U from homing on, and from before a fault on its commands."""
    start = int(np.argmax(trace["state"] == FAULT)) if np.any(trace["state"] == FAULT) else None
    check_steps(trace["u_set_nm"][:start][trace["state"][:start] != STATES.index("off")])
    if start is not None:
        check_steps(trace["out_u_nm"][start - 2 :])


def check_outputs(trace: Rows) -> None:
    """Check that the in-cut output shows the state cutting, and enable is low while off."""
    outputs = trace["out_outputs"].astype(int)
    assert np.array_equal((outputs & IN_CUT) != 0, trace["state"] == CUTTING)
    assert not np.any(outputs[trace["state"] == STATES.index("off")] & ENABLE)


def check_fault_reaction(trace: Rows, expect: Expect) -> None:
    """Check from the first tick of a fault on: spindle 0, tool out, enable down, latched."""
    start = int(np.argmax(trace["state"] == FAULT))
    after = trace[start:]
    assert np.all(after["state"] == FAULT), "the fault stays latched"
    outputs = after["out_outputs"].astype(int)
    assert np.all(outputs & FAULT_LAMP)
    assert not np.any(after["out_spindle_mrpm"])
    retract_nm = expect.get("u_retract_nm", RETRACT_NM)
    clearance_nm = expect.get("x_clearance_nm", CLEARANCE_NM)
    assert after["u_set_nm"][-1] == retract_nm
    assert after["out_x_nm"][-1] - after["out_x_nm"][0] == pytest.approx(clearance_nm, abs=2)
    assert after["out_z_nm"][-1] == after["out_z_nm"][-2]
    enabled = (outputs & ENABLE) != 0
    assert not enabled[-1], "enable drops in the end"
    n_enabled = int(np.argmin(enabled))
    if "let_go_s" in expect:
        assert expect.get("held_s", 0) <= n_enabled * TICK_S <= expect["let_go_s"]
        assert not enabled[n_enabled:].any()
        return
    assert enabled[:n_enabled].all() and not enabled[n_enabled:].any()
    at_rest = after["u_set_nm"][~enabled]
    assert np.all(at_rest == retract_nm), "enable holds until the tool is out"
    if "cutting" in expect["states"] and expect["first_fault"] != "u_force":  # still pushed
        assert after["error_nm"][-1] >= OUT_NM, "the tip leaves the work"


def check_fault_time(trace: Rows, words: list[str], within_s: float) -> None:
    """Check that the fault is latched within its promised time after its cause."""
    cause_s = float(words[words.index("--inject") + 1].partition("@")[2].partition(":")[0])
    cut_s, fault_s = (trace["t_s"][np.argmax(trace["state"] == one)] for one in (CUTTING, FAULT))
    assert 0 <= round(fault_s - cut_s - cause_s, 9) <= within_s


def states_of(trace: Rows) -> list[str]:
    """Return the states in the order in which they were passed."""
    states = trace["state"].astype(int)
    return [STATES[one] for one in [states[0], *states[1:][np.diff(states) != 0]]]


@pytest.mark.parametrize(("scenario", "words", "expect"), list(cases()))
def test_scenario(
    table_of: Callable[[str], Path],
    tmp_path: Path,
    scenario: dict[str, Any],
    words: list[str],
    expect: Expect,
) -> None:
    """The scenario happens as its prose describes."""
    table = table_of(scenario.get("part", "perkins240"))
    if "flip_table_byte" in scenario:
        table = damaged(table, scenario["flip_table_byte"], tmp_path)
    outcome = Outcome(table, *words, is_traced=True)
    assert outcome.status == expect["exit"], outcome.message
    assert expect.get("message", "") in outcome.message
    if len(outcome.trace) == 0:
        return
    if "is_uneven" not in expect:
        check_u_limits(outcome.trace)
    check_outputs(outcome.trace)
    assert states_of(outcome.trace) == expect["states"]
    if "first_fault" in expect:
        assert expect["first_fault"] in outcome.summary["first_faults"]
        check_fault_reaction(outcome.trace, expect)
    else:
        assert outcome.summary["faults"] == []
    if "within_s" in expect:
        check_fault_time(outcome.trace, words, expect["within_s"])
    if "gouge_um" in expect:
        assert outcome.summary["cut"]["gouge_um"] <= expect["gouge_um"]
    if "form_error_um" in expect:
        assert outcome.summary["form_error_um"]["max"] <= expect["form_error_um"]


def test_every_fault_has_a_scenario() -> None:
    """Each fault that a machine can cause is the first fault of some scenario."""
    shown = {case.values[2].get("first_fault") for case in cases()}
    # Set-point faults have no cause outside: tests/unit/firmware/test_cam_guard*.c cause them.
    machine_faults = {
        "estop", "drive", "bus", "late_tick", "encoder_jump", "lost_counts", "index_missing",
        "reverse", "spindle_stopped", "overspeed", "following_error", "z_range", "table",
        "u_travel", "u_runaway", "u_force",
    }  # fmt: skip
    assert machine_faults <= shown
