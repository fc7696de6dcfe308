# SPDX-License-Identifier: Apache-2.0
"""The firmware's process on a real kernel against the machine of camsim bus (README.md).

Times are asserted in virtual time only; figures are printed (tests/linux/run -s shows them).
"""

import csv
from collections.abc import Callable, Iterator
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from cantools.database.can import Database
from numpy.typing import NDArray

from tests.linux.kernel import HERE, InProcess, Kernel, PortTests, Result
from tests.tools.cases.camsim_cases import first_difference

pytest_plugins = ["tests.linux.linux_fixtures"]

Play = Callable[..., Result]

TICK_S = 1e-3
NMT, SYNC, RPDO1, HEARTBEAT = 0x000, 0x080, 0x200, 0x700
CONTROLLER_NODE = 64
STATUS = ((0x1C0, 0.01), (HEARTBEAT + CONTROLLER_NODE, 0.05))  # identifier, period [s]
BUS, NO_ANSWER = -37, None  # cam_err_bus
COLUMNS, ROWS = 720, 256  # cells of camsim's map
# Form error of either way away from the ends; thus their surfaces differ by less than twice that.
BODY_NM, RMS_UM = 150, 0.08
# X leaves the part at its end; plans fall at other instants (firmware/README.md, "Two rates").
END_MM, END_NM = 0.5, 300
SAME_CELL_NM = 200
U_STROKE_UM = 150  # of the part
FOLLOWING, FAULT, DISABLED = 0x27, 0x08, 0x40


def column(result: Result, name: str) -> NDArray[np.float64]:
    """Return a column of the trace; words in hexadecimal become numbers."""
    return np.array([float(int(r[name], 0) if "x" in r[name] else r[name]) for r in result.trace])


def cut_at_s(result: Result) -> float:
    """Return when the cut began [s]."""
    return float(column(result, "t_s")[np.argmax(column(result, "in_cut"))])


def fault_after_s(result: Result, cause_s: float) -> float:
    """Return the time from a cause [s of cutting] to the fault output."""
    fault = column(result, "fault")
    assert fault.any(), "no fault"
    return float(column(result, "t_s")[np.argmax(fault)]) - cut_at_s(result) - cause_s


def is_drive_in(result: Result, axis: str, state: int) -> bool:
    """Return whether a drive ended in a state of CiA 402."""
    mask = 0x4F if state in (FAULT, DISABLED) else 0x6F
    return int(result.trace[-1][f"{axis}_status"], 0) & mask == state


def stop_s(result: Result, axis: str) -> float:
    """Return from the last SYNC to the axis' rest [s]."""
    t_s, syncs = column(result, "t_s"), column(result, "syncs")
    last_s = t_s[np.argmax(syncs == syncs[-1])]
    actual = column(result, f"{axis}_actual")
    still = 2.0 if axis != "spindle" else 100.0  # nm, r/min / 1000
    rest = 0.0 if axis == "spindle" else actual[-1]
    return float(t_s[np.flatnonzero(np.abs(actual - rest) > still)[-1]] + TICK_S - last_s)


def contains(whole: list[int], part: list[int]) -> bool:
    """Return whether the part stands in the whole, without gaps."""
    n = len(part)
    return any(whole[i : i + n] == part for i in range(len(whole) - n + 1))


def surface(path: Path) -> dict[tuple[int, int], float]:
    """Return the error [nm] of every cell of camsim's map away from the ends of the part."""
    with path.open() as file:
        rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    z_mm = [row["z_mm"] for row in rows]
    first, last = min(z_mm), max(z_mm)
    ends = max(abs(row["error_nm"]) for row in rows)
    assert ends <= END_NM
    return {
        (int(row["turn"] * COLUMNS), int((row["z_mm"] - first) / (last - first) * ROWS)): row[
            "error_nm"
        ]
        for row in rows
        if first + END_MM < row["z_mm"] < last - END_MM
    }


def test_whole_cut_gives_the_surface_of_the_simulator(play: Play, in_process: InProcess) -> None:
    """Over bus and lines the same part comes out as in the simulator's own process."""
    result = play("whole_cut")
    assert result.seen["machine_status"] == 0 and result.seen["controller_status"] == 0
    assert result.summary["end"] == "done" and result.summary["faults"] == []
    bus, process = surface(result.folder / "surface"), surface(in_process.surface)
    for cells in (bus, process):
        assert max(map(abs, cells.values())) <= BODY_NM
    both = bus.keys() & process.keys()
    assert len(both) > len(process) / 4
    apart_nm = max(abs(bus[cell] - process[cell]) for cell in both)
    print(f"whole cut: largest distance of the surfaces {apart_nm:.0f} nm in {len(both)} cells")
    for name, summary in (("bus", result.summary), ("in process", in_process.summary)):
        error = summary["form_error_um"]
        print(f"whole cut, {name}: form error max {error['max']:.3f} rms {error['rms']:.3f} um")
        assert error["rms"] <= RMS_UM
    assert apart_nm <= SAME_CELL_NM


def test_virtual_time_gives_the_same_bytes_twice(kernel: Kernel, play: Play) -> None:
    """Two runs leave the same trace, surface and summary."""
    if not kernel.is_own:
        pytest.skip("time is real on this computer's kernel; take away its vcan for tools/uml")
    first, second = (play("cut_on", folder=name, feed_mm=10) for name in ("first", "second"))
    for name in ("trace", "surface", "summary", "result.json", "controller.log"):
        assert first_difference(first.folder / name, second.folder / name) == "", name


def test_estop_reaches_the_outputs(kernel: Kernel, play: Play) -> None:
    """From the edge to the fault lamp at most a tick; enable falls when the tool is out."""
    reactions = play("estop", feed_mm=10).seen["reactions"]
    for phase, r in enumerate(reactions):
        print(f"e-stop at {0.2 * phase:.1f} tick: fault output after {r['fault_s'] * 1e3:.2f} ms, ")
        print(f"  enable low after {r['enable_low_s'] * 1e3:.1f} ms")
    if kernel.is_own:
        assert max(r["fault_s"] for r in reactions) <= 1.05 * TICK_S
        assert max(r["enable_low_s"] for r in reactions) <= 0.06


@pytest.mark.parametrize(
    ("inject", "faults", "within_s"),
    [
        ("heartbeat-lost@0.2:2", {"bus", "drive"}, 0.11),
        ("node-dead@0.2:1", {"bus"}, 0.01),
        ("node-dead@0.2:2", {"bus", "drive"}, 0.025),
        ("node-fault@0.2:3", {"drive"}, 0.003),
        ("drive@0.2", {"drive"}, 0.003),
        ("encoder-missing@0.2:10", {"bus"}, 0.01),
        ("encoder-repeated@0.2:1", {"encoder_jump"}, 0.003),
        ("encoder-swapped@0.2:1", {"encoder_jump"}, 0.004),
        ("encoder-late@0.2:1700", {"encoder_jump"}, 0.004),
    ],
)
def test_trouble_on_the_bus_ends_in_its_fault(
    inject: str, faults: set[str], within_s: float, kernel: Kernel, play: Play
) -> None:
    """The fault is latched in time, the tool leaves the work, the drives rest disabled."""
    result = play("cut_on", "--inject", inject, feed_mm=10)
    assert result.summary["end"] == "fault" and result.seen["state"] == "fault"
    assert set(result.summary["faults"]) & faults, result.summary["faults"]
    after_s = fault_after_s(result, 0.2)
    gouge_um = result.summary["cut"]["gouge_um"]
    print(f"{inject}: {result.summary['faults']} after {after_s * 1e3:.1f} ms")
    if "drive" not in result.summary["faults"]:  # else nothing can be retracted
        assert gouge_um < 1
    if kernel.is_own:
        assert 0 <= after_s <= within_s


def test_one_missing_or_slightly_late_frame_is_bridged(play: Play) -> None:
    """The angle goes on from the frames before; the cut goes on."""
    words = ("--inject", "encoder-missing@0.2:1", "--inject", "encoder-late@0.5:300")
    result = play("cut_on", *words, feed_mm=10)
    assert result.summary["end"] == "done" and result.summary["faults"] == []
    print(f"bridged: form error {result.summary['form_error_um']}")


def test_interface_down_stops_all_until_the_operator_resets(kernel: Kernel, play: Play) -> None:
    """Fault at once, drives stop on their own; nothing moves again without reset and enable."""
    result = play("link_down", feed_mm=10)
    seen = result.seen
    print(f"interface down: fault output after {seen['fault_s'] * 1e3:.2f} ms")
    if kernel.is_own:
        assert seen["fault_s"] <= 2 * TICK_S
    state, faults = seen["after"]
    assert state == "fault" and faults & 1 << 2
    assert seen["refused"] != 0 and seen["reset"] == 0 and seen["enable"] == 0
    assert "bus" in result.summary["faults"]


def test_flood_of_foreign_frames_disturbs_nothing(play: Play) -> None:
    """A bus full of other people's frames: no fault, the same form."""
    result = play("flood", feed_mm=10)
    assert result.seen["n_foreign"] > 3000
    assert (result.seen["state"], result.seen["faults"]) == ("cutting", 0)
    assert result.summary["form_error_um"]["rms"] <= RMS_UM


def test_busy_line_is_refused_at_the_start(play: Play) -> None:
    """The message names line and holder."""
    result = play("lines_busy")
    assert result.seen["controller_status"] == 2
    message = result.log("controller")
    assert "ENABLE" in message and "in use by gpioset" in message


def times_s(path: Path, can_id: int) -> list[float]:
    """Return when the frames of an identifier came that candump -L wrote down."""
    rows = (line.split() for line in path.read_text().splitlines())
    return [float(r[0].strip("()")) for r in rows if int(r[2].split("#")[0], 16) == can_id]


@pytest.mark.parametrize("node", [CONTROLLER_NODE, CONTROLLER_NODE + 1])
def test_second_controller_on_the_bus_is_silent(node: int, play: Play) -> None:
    """The cut goes on; the second says why it does nothing, and begins when the first has gone."""
    result = play("two_controllers", feed_mm=7, second_node=node)
    assert result.summary["end"] == "done" and result.summary["faults"] == []
    assert result.summary["form_error_um"]["rms"] <= RMS_UM
    assert "another controller sends" in result.log("second")
    assert "another controller sends" not in result.log("controller")
    assert result.seen["second_enable"] == (NO_ANSWER if node == CONTROLLER_NODE else BUS)
    during, after = result.folder / "candump.log", result.folder / "after.log"
    assert times_s(during, NMT) == []
    for can_id, period_s in ((SYNC, TICK_S), *((RPDO1 + n, TICK_S) for n in (2, 3, 4, 5)), *STATUS):
        steps_s = np.diff(times_s(during, can_id))
        assert len(steps_s) > 50 and steps_s.min() > period_s / 2, hex(can_id)
    assert node == CONTROLLER_NODE or times_s(during, HEARTBEAT + node) == []
    assert times_s(after, NMT) and times_s(after, SYNC)


def test_terminated_controller_retracts_first(play: Play) -> None:
    """SIGTERM in the cut: tool out, drives off, exit status 0; no drive had to stop on its own."""
    result = play("terminated", feed_mm=10)
    assert result.seen["controller_status"] == 0
    for axis in ("u", "x", "z", "spindle"):
        assert is_drive_in(result, axis, DISABLED), axis
    # The end of the stroke, less the room that the feed-forward needs there, MATHS.md (214).
    assert -500_000 < float(result.trace[-1]["u_actual"]) < -460_000


@pytest.mark.parametrize("after_s", [0.1, 0.135])  # a half of the oval apart
def test_killed_controller_is_outlived_by_the_guard_of_the_drives(
    after_s: float, play: Play
) -> None:
    """SIGKILL in the cut: the drives stop on their own, within their limits, and are in fault."""
    result = play("killed", feed_mm=10, killed_after_s=after_s)
    assert result.seen["controller_status"] == -9
    assert result.summary["end"] == "lost"
    gouge_um = result.summary["cut"]["gouge_um"]
    print(f"SIGKILL: {gouge_um:.0f} um cut too deep")
    assert gouge_um <= U_STROKE_UM
    for axis, limit_s in (("u", 0.025), ("x", 0.03), ("z", 0.06), ("spindle", 0.4)):
        assert is_drive_in(result, axis, FAULT), axis
        print(f"SIGKILL: {axis} at rest {stop_s(result, axis) * 1e3:.0f} ms after the last SYNC")
        assert stop_s(result, axis) <= limit_s


def test_drive_of_another_make_cuts_the_same_part(play: Play) -> None:
    """The U drive is made with the library canopen, which knows nothing of our code."""
    # Its dead time of a tick is not told, so that U off the work, at 100 mm/s, is 0.1 mm behind.
    ideal = {"k1_ns": 0, "k2_us2": 0, "lead_ns": 0, "following_limit_nm": 300_000}
    result = play("canopen_drive", feed_mm=10, parameters=ideal)
    assert result.summary["end"] == "done" and result.summary["faults"] == []
    print(f"canopen drive: form error {result.summary['form_error_um']}")
    assert result.summary["form_error_um"]["rms"] <= 0.2


def logged(path: Path) -> Iterator[tuple[int, bytes]]:
    """Return identifier and data of the frames that candump -L wrote down."""
    for line in path.read_text().splitlines():
        can_id, data = line.split()[2].split("#")
        yield int(can_id, 16), bytes.fromhex(data)


def test_what_candump_saw_is_what_the_trace_tells(play: Play) -> None:
    """Set-points decoded by cantools, from the standard's own description, equal the trace's."""
    result = play("recorded", feed_mm=10)
    database = Database()
    database.add_dbc_file(HERE / "drives.dbc")
    wanted: dict[str, list[int]] = {"u": [], "x": [], "z": []}
    told: dict[str, int] = {}
    for can_id, data in logged(result.folder / "candump.log"):
        if can_id == SYNC:
            for axis, targets in wanted.items():
                targets.append(told.get(axis, 0))
        elif can_id - RPDO1 in (2, 3, 4):
            frame = database.decode_message(can_id, data)
            assert isinstance(frame, dict)
            target = frame["target_position"]
            assert isinstance(target, int)
            told["uxz"[can_id - RPDO1 - 2]] = target
    for axis, targets in wanted.items():
        traced = column(result, f"{axis}_target").astype(int).tolist()
        assert len(set(targets)) > 50
        assert contains(traced, targets[2:-2]), axis


def test_download_broken_off_anywhere_leaves_the_old_table(play: Play) -> None:
    """Killed after some of its blocks; then camctl brings the table whole and selects it."""
    result = play("download", other_part="perkins240_x30")
    assert result.seen["n_broken_off"] == 5 and result.seen["camctl"] == 0
    log = result.log("controller")
    assert log.count("table: perkins240 in use") == result.seen["n_broken_off"] + 1
    assert "table: perkins240_x30 in use" in log
    assert "perkins240_x30" in result.log("camctl")


def test_own_tests_of_the_port_pass_there(port_tests: PortTests | None) -> None:
    """Those of PORT_FILES need the lines and interfaces too; none is skipped there."""
    if port_tests is None:
        pytest.skip("their times are those of virtual time")
    said = port_tests.wait()
    assert port_tests.process.returncode == 0, said
    suite = next(ElementTree.parse(port_tests.report).getroot().iter("testsuite"))
    assert int(suite.get("tests", "0")) > 0 and suite.get("skipped") == "0"
    print(f"tests of the port: {suite.get('tests')} passed")
