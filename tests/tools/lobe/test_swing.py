# SPDX-License-Identifier: Apache-2.0
"""The tool's swing of a turned cam: the firmware's set-points, the drive, faults, limits.

The table of cam-345 is cut on the machine of host_sim/machines/cam.toml without its design, so
that the simulator compares U with the table itself; what is judged here is the swing, from the
trace of every tick.
"""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.tools.cases.camsim_cases import ROOT, camsim, columns_of, only_error

MACHINE = ROOT / "host_sim" / "machines" / "cam.toml"
TICK_S = 50e-6
LAG_S = 100e-6 + 2 * 0.7 / (2 * np.pi * 200) + TICK_S / 2  # of the default drive of the swing
SPEED_DEG_S, ACCELERATION_DEG_S2 = 1000.0, 100_000.0
LIFT_MM = 8.0
OUT_NM = -(1.25 * LIFT_MM + 0.5) * 1e6  # of U beyond the highest point, largest amplitude
FAST = ("--feed", "4", "--set", "engage_turns=2", "--set", "disengage_turns=2")

Columns = dict[str, NDArray[Any]]


@pytest.fixture(scope="module")
def cam(table_of: Callable[[str], Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the table of cam-345 alone."""
    return Path(shutil.copy(table_of("cam-345"), tmp_path_factory.mktemp("cam")))


def read(path: Path) -> Columns:
    """Return what is needed of a trace."""
    found = columns_of(path)
    columns: Columns = {"state": found["state"].astype(str)}
    for name in (
        *("t_s", "turn", "z_mm", "true_turn", "speed_q32", "error_nm", "out_outputs", "out_x_nm"),
        *("u_set_nm", "swing_set_deg", "swing_act_deg"),
    ):
        columns[name] = found[name].astype(float)
    return columns


def cut(cam: Path, folder: Path, *words: str, status: int = 0) -> Columns:
    """Cut with a coarse feed, engaging fast; return the trace."""
    trace = folder / "trace.csv"
    done = camsim("run", cam, "--machine", MACHINE, *FAST, "--trace", trace, *words)
    assert done.returncode == status, done.stderr
    return read(trace)


@pytest.fixture(scope="module")
def whole(cam: Path, tmp_path_factory: pytest.TempPathFactory) -> Columns:
    """Return the trace of a whole cut at 60 r/min."""
    return cut(cam, tmp_path_factory.mktemp("whole"))


def swing_of_table(cam: Path, turn: NDArray[Any], z_mm: NDArray[Any]) -> NDArray[Any]:
    """Return the firmware's own evaluation of the swing [degrees]."""
    points = "".join(f"{t % 1:.10f},{z:.6f}\n" for t, z in zip(turn, z_mm, strict=True))
    done = camsim("eval", cam, stdin="turn,z_mm\n" + points)
    names = done.stdout.splitlines()[0].split(",")
    column = names.index("swing_deg")
    return np.array([float(line.split(",")[column]) for line in done.stdout.splitlines()[1:]])


def test_set_point_is_the_table_at_the_angle_of_the_lag(cam: Path, whole: Columns) -> None:
    """Between set-points too: below half a thousandth of a degree, index edges included."""
    in_cut = whole["state"] == "cutting"
    ahead = whole["speed_q32"][in_cut] / 2**32 * LAG_S / TICK_S
    wanted = swing_of_table(cam, whole["turn"][in_cut] + ahead, whole["z_mm"][in_cut])
    error_deg = whole["swing_set_deg"][in_cut] - wanted
    assert 1e-4 < np.abs(error_deg).max() < 6e-4
    assert np.sqrt(np.mean(error_deg**2)) < 1.2e-4


def test_tool_swings_as_the_true_angle_wants(cam: Path, whole: Columns) -> None:
    """Drive, observer and encoder included: 5 thousandths where the acceleration jumps."""
    in_cut = whole["state"] == "cutting"
    wanted = swing_of_table(cam, whole["true_turn"][in_cut], whole["z_mm"][in_cut])
    error_deg = whole["swing_act_deg"][in_cut] - wanted
    assert np.abs(error_deg).max() < 6e-3
    assert np.sqrt(np.mean(error_deg**2)) < 5e-4


def test_swing_rises_and_falls_with_the_envelope(whole: Columns) -> None:
    """From 0 and back to rest at 0; in the cut the pressure angle of the cam to either side."""
    swing_deg = whole["swing_set_deg"]
    assert np.all(np.abs(swing_deg[whole["state"] == "homing"]) < 1e-6)
    most = np.abs(swing_deg[whole["state"] == "cutting"]).max()
    assert most == pytest.approx(19.967381, abs=1e-3)
    assert np.abs(swing_deg).max() <= most + 1e-5
    rest = swing_deg[-8:]
    assert np.all(np.abs(rest) < 1e-5)
    assert np.ptp(rest) == 0


def test_nothing_is_cut_below_the_cam_while_engaging(whole: Columns) -> None:
    """The clearance of X contains the lift: the roller's centre comes from outside everywhere."""
    in_work = np.isin(whole["state"], ["engaging", "cutting", "disengaging"])
    assert whole["error_nm"][in_work].min() > -200


def check_set_points(trace: Columns) -> None:
    """Check speed and acceleration of the set-point, over the distance of two of them."""
    speed_deg_s = np.diff(trace["swing_set_deg"]) / TICK_S
    assert np.abs(speed_deg_s).max() <= 1.001 * SPEED_DEG_S
    change = np.abs(speed_deg_s[8:] - speed_deg_s[:-8]) / (8 * TICK_S)
    assert change.max() <= 1.05 * ACCELERATION_DEG_S2


@pytest.mark.parametrize("at_s", ["0.82", "1.0"])
def test_emergency_stop_brings_the_swing_back(cam: Path, tmp_path: Path, at_s: str) -> None:
    """Within its limits, and enable holds until it rests at 0; U and X leave beyond the lift."""
    trace = cut(cam, tmp_path, "--inject", f"estop@{at_s}", status=1)
    check_set_points(trace)
    fault = trace["state"] == "fault"
    enabled = trace["out_outputs"][fault].astype(int) & 1
    held = trace["swing_set_deg"][fault][enabled == 0]
    assert len(held) > 0
    assert np.all(np.abs(held) < 1e-4)
    assert trace["u_set_nm"][-1] == pytest.approx(OUT_NM, abs=2)
    off_mm = (trace["out_x_nm"][-1] - trace["out_x_nm"][fault][0]) * 1e-6
    assert off_mm == pytest.approx(1.25 * LIFT_MM + 1, abs=1e-3)


def test_stop_of_the_operator_ends_at_rest(cam: Path, tmp_path: Path) -> None:
    """By the envelope, as any cut."""
    trace = cut(cam, tmp_path, "--inject", "stop@0.3")
    check_set_points(trace)
    assert abs(trace["swing_set_deg"][-1]) < 1e-5


def test_blocked_swing_is_a_fault(cam: Path, tmp_path: Path) -> None:
    """It is detected a plan after it is off by its limit of a degree; the tool leaves the work."""
    trace = cut(cam, tmp_path, "--inject", "swing-block@0.85", status=1)
    cut_s = trace["t_s"][int(np.argmax(trace["state"] == "cutting"))]
    start = int(np.argmax(trace["state"] == "fault"))
    assert 0 < trace["t_s"][start] - cut_s - 0.85 < 0.02
    behind = np.abs(trace["swing_set_deg"] - trace["swing_act_deg"])
    assert 1 < behind[start] < 4
    assert trace["u_set_nm"][-1] == pytest.approx(OUT_NM, abs=2)


REFUSED = {
    "swing_speed_mdeg_per_s=0": "swings the tool, for which there is no axis: needs 1",
    "swing_range_mdeg=15000": "swing farther than it can: needs 19.968 degrees, limit 15",
    "swing_speed_mdeg_per_s=100000": "swing faster than it can: needs 347",
    "swing_acceleration_deg_per_s2=5000": "have to accelerate more than it can: needs 2",
}


@pytest.mark.parametrize("name", REFUSED)
def test_infeasible_swing_is_refused_before_motion(cam: Path, tmp_path: Path, name: str) -> None:
    """With the numbers, and the highest speed where one helps, which then passes."""
    line = only_error(camsim("run", cam, "--machine", MACHINE, *FAST, "--set", name))
    assert REFUSED[name] in line
    if "give at most --rpm" in line:
        rpm = line.rsplit(" ", 1)[1]
        words = ("--set", name, "--rpm", rpm, "--turns-limit", "0.1")
        done = camsim("run", cam, "--machine", MACHINE, *FAST, *words)
        assert done.returncode == 0, done.stderr
    else:
        assert "no speed helps" in line


def test_machine_without_the_axis_refuses(cam: Path, tmp_path: Path) -> None:
    """A speed of 0 in the machine file says that there is none; a skirt does not ask for it."""
    machine = tmp_path / "m.toml"
    machine.write_text(MACHINE.read_text() + "\n[swing]\nspeed_deg_per_s = 0\n")
    line = only_error(camsim("run", cam, "--machine", machine))
    assert "for which there is no axis" in line


def test_trace_of_a_skirt_has_no_swing(table_of: Callable[[str], Path], tmp_path: Path) -> None:
    """Its columns are those that they were."""
    trace = tmp_path / "t.csv"
    done = camsim("run", table_of("perkins240"), "--feed", "2", "--trace", trace)
    assert done.returncode == 0, done.stderr
    assert "swing" not in trace.read_text().splitlines()[0]
