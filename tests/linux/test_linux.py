"""The firmware's process on a real kernel against the machine of camsim bus (README.md).

Times are asserted in virtual time only; figures are printed (tests/linux/run -s shows them).
"""

import csv
import re
import shlex
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.linux.kernel import InProcess, Kernel, Result
from tests.tools.cases.part_cases import ROOT, TableOf

pytest_plugins = ["tests.linux.linux_fixtures"]
pytestmark = pytest.mark.kernel

Play = Callable[..., Result]

PORT_FILES = ("tests/linux/test_linux_port.py", "tests/linux/test_linux_set_up.py")
TICK_S = 1e-3
COLUMNS, ROWS = 720, 256  # cells of camsim's map
# Form error of either way away from the ends; thus their surfaces differ by less than twice that.
BODY_NM, RMS_UM = 150, 0.08
# X leaves the part at its end; plans fall at other instants (firmware/README.md, "Two rates").
END_MM, END_NM = 0.5, 300
SAME_CELL_NM = 200
U_STROKE_UM = 150  # of the part
FAULT = 0x08, 0x4F  # state and mask of CiA 402


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
    fault_s = float(column(result, "t_s")[np.argmax(fault)])
    return round(fault_s - cut_at_s(result) - cause_s, 9)


def stop_s(result: Result, axis: str) -> float:
    """Return from the last SYNC to the axis' rest [s]."""
    t_s, syncs = column(result, "t_s"), column(result, "syncs")
    last_s = t_s[np.argmax(syncs == syncs[-1])]
    actual = column(result, f"{axis}_actual")
    still = 2.0 if axis != "spindle" else 100.0  # nm, r/min / 1000
    rest = 0.0 if axis == "spindle" else actual[-1]
    return float(t_s[np.flatnonzero(np.abs(actual - rest) > still)[-1]] + TICK_S - last_s)


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


@pytest.mark.long
def test_whole_cut_gives_the_surface_of_the_simulator(play: Play, in_process: InProcess) -> None:
    """Over bus and lines the same part comes out as in the simulator's own process."""
    result = play("cut_on")
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


@pytest.mark.long
@pytest.mark.parametrize(
    ("inject", "within_s"),
    [
        ("encoder-repeated@0.2:1", 0.003),
        ("encoder-swapped@0.2:1", 0.004),
        ("encoder-late@0.2:1700", 0.004),
    ],
)
def test_wrong_frames_of_the_encoder_end_in_its_fault(
    inject: str, within_s: float, kernel: Kernel, play: Play
) -> None:
    """The fault is latched in time, the tool leaves the work, the drives rest disabled."""
    result = play("cut_on", "--inject", inject, feed_mm=10)
    assert result.summary["end"] == "fault" and result.seen["state"] == "fault"
    assert "encoder_jump" in result.summary["faults"]
    after_s = fault_after_s(result, 0.2)
    print(f"{inject}: {result.summary['faults']} after {after_s * 1e3:.1f} ms")
    if "drive" not in result.summary["faults"]:  # else nothing can be retracted
        assert result.summary["cut"]["gouge_um"] < 1
    if kernel.is_own:
        assert 0 <= after_s <= within_s


@pytest.mark.long
def test_one_missing_or_slightly_late_frame_is_bridged(play: Play) -> None:
    """The angle goes on from the frames before; the cut goes on."""
    words = ("--inject", "encoder-missing@0.2:1", "--inject", "encoder-late@0.5:300")
    result = play("cut_on", *words, feed_mm=10)
    assert result.summary["end"] == "done" and result.summary["faults"] == []
    print(f"bridged: form error {result.summary['form_error_um']}")


@pytest.mark.long
def test_flood_of_foreign_frames_disturbs_nothing(play: Play) -> None:
    """A bus full of other people's frames: no fault, the same form."""
    result = play("flood", feed_mm=10)
    assert result.seen["n_foreign"] > 3000
    assert (result.seen["state"], result.seen["faults"]) == ("cutting", 0)
    assert result.summary["form_error_um"]["rms"] <= RMS_UM


@pytest.mark.long
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
        assert int(result.trace[-1][f"{axis}_status"], 0) & FAULT[1] == FAULT[0], axis
        print(f"SIGKILL: {axis} at rest {stop_s(result, axis) * 1e3:.0f} ms after the last SYNC")
        assert stop_s(result, axis) <= limit_s


@pytest.mark.long
def test_download_broken_off_anywhere_leaves_the_old_table(play: Play) -> None:
    """Killed after some of its blocks; then camctl brings the table whole and selects it."""
    result = play("download", other_part="perkins240_x30")
    assert result.seen["n_broken_off"] == 5 and result.seen["camctl"] == 0
    log = result.log("controller")
    assert log.count("table: perkins240 in use") == result.seen["n_broken_off"] + 1
    assert "table: perkins240_x30 in use" in log
    assert "perkins240_x30" in result.log("camctl")


def test_own_tests_of_the_port_pass_there(kernel: Kernel, tmp_path: Path) -> None:
    """Those of PORT_FILES need the lines and interfaces too; none is skipped there."""
    if not kernel.is_own:
        pytest.skip("their times are those of virtual time")
    report = tmp_path / "port.xml"
    words = ("-m", "pytest", "-p", "no:cacheprovider", "-c", "tools/pyproject.toml", "-q")
    # Not where those of a user outside may lie, whom root inside cannot pass over.
    what = (*PORT_FILES, f"--junitxml={report}", "--basetemp=/run/port-tests")
    process = kernel.start(tmp_path, sys.executable, *words, *what)
    said, _ = process.communicate()
    assert process.returncode == 0, said
    suite = next(ElementTree.parse(report).getroot().iter("testsuite"))
    assert int(suite.get("tests", "0")) > 0 and suite.get("skipped") == "0"


# Root needs no sudo; here vcan0 is there already, and programs are not built.
SHELL = f"""\
set -m
sudo() {{ "$@"; }}
modprobe() {{ ip link del vcan0; }}
tools/mktables() {{ :; }}
tools/camctl() {{ {shlex.quote(sys.executable)} -m camtools.cli.camctl "$@"; }}
"""


@pytest.mark.long
def test_first_steps_of_the_manual_cut(kernel: Kernel, table_of: TableOf, tmp_path: Path) -> None:
    """The commands of hal/linux/README.md, at the pace of people: a cut begins and is ended."""
    for name in ("tools", "tests", "build/linux"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).symlink_to(ROOT / name)
    shutil.copytree(table_of("perkins240").parent, tmp_path / "build" / "parts")
    desk = (ROOT / "hal/linux/desk.toml").read_text()
    (tmp_path / "hal/linux").mkdir(parents=True)  # a late tick would end the cut
    (tmp_path / "hal/linux/desk.toml").write_text(desk.replace("priority = 0 ", "priority = 50 "))
    section = (ROOT / "hal/linux/README.md").read_text().split("\n## First steps\n")[1]
    steps = re.findall(r"^    (.*)$", section.split("\n## ")[0], re.MULTILINE)
    steps.insert(-2, "tools/camctl status")
    script = tmp_path / "steps.sh"
    script.write_text(
        f"cd {shlex.quote(str(tmp_path))}\n{SHELL}"
        + "".join(f"{step}\nsleep 2\n" for step in steps)
    )
    process = kernel.start(tmp_path, "bash", str(script))
    said, _ = process.communicate()
    assert process.returncode == 0, said
    for words in (
        "speed = 300 r/min",
        "home: ready",
        "state             cutting",
        " 202 ",
        " 185 ",
    ):
        assert words in said, said
    assert "port: ended by a signal" in said.split("state             cutting")[1]


@pytest.mark.long
def test_drive_of_another_make_cuts_the_same_part(play: Play) -> None:
    """The U drive is made with the library canopen, which knows nothing of our code."""
    # Its dead time of a tick is not configured: U off the work, at 100 mm/s, lags by 0.1 mm.
    ideal = {"k1_ns": 0, "k2_us2": 0, "lead_ns": 0, "following_limit_nm": 300_000}
    result = play("canopen_drive", feed_mm=10, parameters=ideal)
    assert result.summary["end"] == "done" and result.summary["faults"] == []
    print(f"canopen drive: form error {result.summary['form_error_um']}")
    assert result.summary["form_error_um"]["rms"] <= 0.2
