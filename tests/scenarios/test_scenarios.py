# SPDX-License-Identifier: Apache-2.0
"""Run every scenario of cases/ and judge it; README.md tells what a scenario says."""

import json
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from pyarrow import csv

from tests.tools.cases.camsim_cases import ROOT, camsim

CASES = Path(__file__).parent / "cases"
HOST_SIM = str(ROOT / "host_sim")
SCENARIOS = sorted(CASES.glob("*.toml"))
TICK_S = 50e-6
ENABLE, FAULT_LAMP, IN_CUT = 1, 2, 4
# Limits of U as camsim sets them for the default machine, with the 1/16 that the guard allows for
# encoder noise and the rounding of the set-points.
U_SPEED_NM_PER_TICK = 400e6 * TICK_S * 17 / 16 + 4
U_ACCELERATION_NM_PER_TICK2 = 250e9 * TICK_S**2 * 17 / 16 + 4
RETRACT_NM, CLEARANCE_NM = -500_000, 1_000_000

Columns = dict[str, NDArray[Any]]


@dataclass
class Outcome:
    """What a run left behind; the trace is empty when the cut was refused."""

    status: int
    message: str
    trace: Columns
    summary: dict[str, Any]


LET_GO = ("drive", "u_runaway", "u_travel")  # faults that drop the enable at once


def read_trace(path: Path) -> Columns:
    """Return the columns of a trace; `state` stays text, and `faults`, which is hexadecimal."""
    table = csv.read_csv(path)
    return {name: table[name].to_numpy() for name in table.column_names}


def damaged(table: Path, at: int, folder: Path) -> Path:
    """Return a copy of the table with one bit of byte `at` flipped."""
    image = bytearray(table.read_bytes())
    image[at] ^= 1
    copy = folder / table.name
    copy.write_bytes(image)
    return copy


def run(table: Path, scenario: dict[str, Any], folder: Path) -> Outcome:
    """Cut as the scenario says."""
    if "flip_table_byte" in scenario:
        table = damaged(table, scenario["flip_table_byte"], folder)
    trace, summary = folder / "trace.csv", folder / "summary.json"
    arguments = [
        word.replace("{machines}", str(CASES / "machines")).replace("{host_sim}", HOST_SIM)
        for word in scenario["arguments"]
    ]
    outputs: list[str | Path] = ["--trace", trace, "--summary", summary]
    done = camsim("run", table, *arguments, *outputs)
    if done.returncode == 2:
        assert not trace.exists() and not summary.exists(), "a refused cut leaves no files"
        return Outcome(2, done.stderr, {}, {})
    return Outcome(done.returncode, done.stderr, read_trace(trace), json.loads(summary.read_text()))


def check_u_limits(trace: Columns) -> None:
    """Check that from homing on U set-points stay within speed and acceleration of the axis."""
    u_nm = trace["u_set_nm"][trace["state"] != "off"]
    steps_nm = np.diff(u_nm)
    assert np.abs(steps_nm).max() <= U_SPEED_NM_PER_TICK
    assert np.abs(np.diff(steps_nm)).max() <= U_ACCELERATION_NM_PER_TICK2


def check_outputs(trace: Columns) -> None:
    """Check that the in-cut output tells the state cutting, and enable is low while off."""
    outputs = trace["out_outputs"].astype(int)
    assert np.array_equal((outputs & IN_CUT) != 0, trace["state"] == "cutting")
    assert not np.any(outputs[trace["state"] == "off"] & ENABLE)


def check_fault_reaction(trace: Columns, expect: dict[str, Any]) -> None:
    """Check from the first tick of a fault on: spindle 0, tool out, enable down, latched."""
    fault = trace["state"] == "fault"
    start = int(np.argmax(fault))
    assert fault[start:].all(), "the fault stays latched"
    outputs = trace["out_outputs"][start:].astype(int)
    assert np.all(outputs & FAULT_LAMP)
    assert not np.any(trace["out_spindle_mrpm"][start:])
    retract_nm = expect.get("u_retract_nm", RETRACT_NM)
    clearance_nm = expect.get("x_clearance_nm", CLEARANCE_NM)
    assert trace["u_set_nm"][-1] == retract_nm
    assert trace["out_x_nm"][-1] - trace["out_x_nm"][start] == pytest.approx(clearance_nm, abs=2)
    assert trace["out_z_nm"][-1] == trace["out_z_nm"][-2]
    enabled = (outputs & ENABLE) != 0
    assert not enabled[-1], "enable drops in the end"
    if expect["first_fault"] in LET_GO:
        assert not enabled.any(), "a drive that failed or ran away is let go at once"
    else:
        assert (
            enabled[: int(np.argmin(enabled))].all()
            and not enabled[int(np.argmin(enabled)) :].any()
        )
        at_rest = trace["u_set_nm"][start:][~enabled]
        assert np.all(at_rest == retract_nm), "enable holds until the tool is out"


def check_fault_time(trace: Columns, expect: dict[str, Any]) -> None:
    """Check that the fault is latched within its promised time after its cause."""
    cut_s = trace["t_s"][int(np.argmax(trace["state"] == "cutting"))]
    fault_s = trace["t_s"][int(np.argmax(trace["state"] == "fault"))]
    after_s = fault_s - cut_s - expect["fault_after_s"]
    assert 0 <= after_s <= expect["within_s"]


def states_of(trace: Columns) -> list[str]:
    """Return the states in the order in which they were passed."""
    states = trace["state"]
    changes = np.flatnonzero(states[1:] != states[:-1]) + 1
    return [str(states[0]), *(str(state) for state in states[changes])]


@pytest.mark.parametrize("path", [pytest.param(path, id=path.stem) for path in SCENARIOS])
def test_scenario(path: Path, table_of: Callable[[str], Path], tmp_path: Path) -> None:
    """The scenario happens as its prose tells."""
    scenario = tomllib.loads(path.read_text())
    expect = scenario["expect"]
    outcome = run(table_of(scenario.get("part", "perkins240")), scenario, tmp_path)
    assert outcome.status == expect["exit"], outcome.message
    assert expect.get("message", "") in outcome.message
    if outcome.status == 2:
        return
    check_u_limits(outcome.trace)
    check_outputs(outcome.trace)
    assert states_of(outcome.trace) == expect["states"]
    if "first_fault" in expect:
        assert expect["first_fault"] in outcome.summary["first_faults"]
        check_fault_reaction(outcome.trace, expect)
    else:
        assert outcome.summary["faults"] == []
    if "within_s" in expect:
        check_fault_time(outcome.trace, expect)
    if "gouge_um" in expect:
        assert outcome.summary["cut"]["gouge_um"] <= expect["gouge_um"]
    if "form_error_um" in expect:
        assert outcome.summary["form_error_um"]["max"] <= expect["form_error_um"]


def test_every_fault_has_a_scenario() -> None:
    """Each fault that a machine can cause is the first fault of some scenario."""
    shown = {tomllib.loads(p.read_text())["expect"].get("first_fault") for p in SCENARIOS}
    # Set-point faults have no cause outside: tests/unit/firmware/test_cam_guard*.c cause them.
    machine_faults = {
        "estop", "drive", "bus", "late_tick", "encoder_jump", "lost_counts", "index_missing",
        "reverse", "spindle_stopped", "overspeed", "following_error", "z_range", "table",
        "u_travel", "u_runaway", "u_force",
    }  # fmt: skip
    assert machine_faults <= shown
