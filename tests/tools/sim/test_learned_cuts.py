"""Whole cuts with learning: its table, its limits, slow cams, the chip's force, the steady start.

The table is that of tests/learn/README.md: each machine keeps its form error once it has learned.
MATHS.md (230) is the steady start, (232) the learning of slow cams.
"""

import re
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from tests.tools.cases.camsim_cases import ROOT, cut, refusal, while_in
from tests.tools.cases.cut_cases import written_skirt
from tests.tools.cases.part_cases import PERKINS, TableOf

LEARN = ROOT / "tests" / "learn"
MACHINES = LEARN / "machines"
REAL = ROOT / "host_sim" / "machines" / "real.toml"

PARTS = {"oval30", "oval_doubles", "perkins240", "twist80"}


class Row(NamedTuple):
    """A line of the table."""

    machine: str
    part: str
    rpm: str
    feed: str
    most_um: float


def rows() -> list[Row]:
    """Return the lines of the table; a line without a feed has that of its part."""
    found = []
    for line in (LEARN / "README.md").read_text().splitlines():
        cells = [cell.strip() for cell in line.split("|")[1:-1]]
        if len(cells) == 4 and cells[3].endswith(" um"):
            machine = re.sub(r"\[(\w+)\].*", r"\1", cells[0])
            part = re.sub(r"^\[?(\w+).*", r"\1", cells[2])
            rpm = re.search(r"(\d+) r/min", cells[2])
            feed = re.search(r"feed ([\d.]+) mm", cells[2])
            most_um = float(cells[3][:-3])
            rpm_text, feed_text = rpm[1] if rpm else "3000", feed[1] if feed else ""
            found.append(Row(machine, part, rpm_text, feed_text, most_um))
    return found


def test_every_machine_has_its_row() -> None:
    """The folder and the table have the same machines; bends is for the gauged part."""
    files = {path.stem for path in MACHINES.glob("*.toml")}
    assert files == {row.machine for row in rows()} | {"bends"}
    assert {row.part for row in rows()} == PARTS


SLOW_ROWS = {("friction", "200"), ("sticks", "1500")}  # long cuts; others have friction, too


def row_case(row: Row) -> Any:  # noqa: ANN401
    """Return a line as parameter of a test."""
    marks = [pytest.mark.long] if (row.machine, row.rpm) in SLOW_ROWS else []
    return pytest.param(row, id=f"{row.machine}-{row.rpm}", marks=marks)


@pytest.mark.parametrize("row", [row_case(row) for row in rows()])
def test_what_is_learned_keeps_the_form_error(table_of: TableOf, row: Row) -> None:
    """The whole cut is gauged, also while the force of the chip rises and falls."""
    words: list[str | Path] = ["--machine", MACHINES / f"{row.machine}.toml", "--rpm", row.rpm]
    words += ["--feed", row.feed] if row.feed else []
    found = cut(table_of(row.part), *words, "--tolerance-um", row.most_um)
    assert found.summary["form_error_um"]["max"] <= row.most_um


def cut_30(table_of: TableOf, machine: str, *more: str) -> dict[str, Any]:
    """Return the summary of a cut of the oval with 1 mm of tool motion at 3000 r/min."""
    words = ("--rpm=3000", "--tolerance-um=99", *more)
    return cut(table_of("oval30"), *words, machine=machine).summary


def of(machine: str) -> str:
    """Return a machine file of the table."""
    return (MACHINES / f"{machine}.toml").read_text()


def test_corrections_stay_within_the_stroke(table_of: TableOf) -> None:
    """A correction of the whole force would leave it, which was the fault `command`."""
    summary = cut_30(table_of, of("tight"), "--feed=0.3")
    assert summary["faults"] == []
    assert summary["learning"]["reason"] == "limited"


def test_another_speed_beside_a_mode(table_of: TableOf) -> None:
    """At 3300 r/min harmonic 15 is beside the mode of 800 Hz: it diverged to 36 um."""
    summary = cut_30(table_of, of("mode"), "--inject", "spindle-override@2:110")
    assert 15 in summary["learning"]["masked"]
    assert summary["form_error_um"]["max"] < 0.6


# U reaches 1 mm to one side, so the stroke leaves 10 um, 50 um, and 10 um that do not suffice.
JUST = """\
[machine]
tick_hz = 10000
[spindle]
limit_rpm = 3500
[encoder]
counts_per_turn = 65536
[u]
speed_mm_per_s = 800
acceleration_mm_per_s2 = 500000
stroke_mm = {stroke_mm}
bandwidth_hz = {hz}
damping = {damping}
friction_m_per_s2 = 15
[believed.u]
bandwidth_hz = {believed_hz}
damping = {believed_damping}
"""
SMALL = {"stroke_mm": 2.02, "hz": 190, "damping": 0.52, "believed_hz": 232, "believed_damping": 0.6}
MIDDLE = SMALL | {"stroke_mm": 2.1}
TOO_SMALL = SMALL | {"hz": 178, "damping": 0.64, "believed_hz": 213, "believed_damping": 0.64}


@pytest.mark.parametrize("stroke", [SMALL, MIDDLE])
def test_stroke_that_just_suffices(table_of: TableOf, stroke: dict[str, float]) -> None:
    """A hundredth or a twentieth of the motion is left for friction and corrections."""
    summary = cut_30(table_of, JUST.format(**stroke))
    assert summary["end"] == "done"
    assert summary["form_error_um"]["max"] < 0.3


def test_stroke_that_just_does_not_suffice(table_of: TableOf) -> None:
    """The rehearsal ends with one fault, which names the command of U, and nothing is cut."""
    words, lathe = ("--rpm=3000", "--tolerance-um=99"), JUST.format(**TOO_SMALL)
    found = cut(table_of("oval30"), *words, status=1, machine=lathe)
    assert "fault command: an axis command exceeds its limits" in found.message
    assert ", rehearsing at " in found.message
    summary = found.summary
    assert summary["faults"] == ["command"]
    assert summary["form_error_um"]["max"] is None  # no point of the part was cut


def test_missing_stroke_is_named_in_advance(table_of: TableOf) -> None:
    """The configured feed-forward alone needs 2.4 um more: one refusal with both and a remedy."""
    drive = {"hz": 160, "damping": 0.7, "believed_hz": 192, "believed_damping": 0.8}
    line = refusal(table_of("oval30"), "--rpm=3000", machine=JUST.format(**MIDDLE | drive))
    assert line == (
        "--rpm 3000: infeasible: the feed-forward would command U beyond its stroke: "
        "needs 1.052429 mm, limit 1.05 mm; give at most --rpm 2945.818"
    )


@pytest.mark.long
@pytest.mark.parametrize(("rpm", "turns"), [(40, 22), pytest.param(72, 40, marks=pytest.mark.long)])
def test_a_slow_cam_is_learned(table_of: TableOf, rpm: float, turns: int) -> None:
    """30 000 and 16 667 ticks a turn: from micrometres to a tenth within some turns."""
    machine = f"{REAL.with_name('cam.toml').read_text()}\n[believed.u]\nbandwidth_hz = 270\n"
    words = ("--rpm", rpm, "--tolerance-um", 99, "--turns-limit", turns)
    found = cut(table_of("cam-345"), *words, machine=machine).summary
    errors = [e for e in found["error_per_turn_um"] if e is not None]
    assert len(errors) >= turns - 5 and max(errors[15 : turns - 5]) < 0.2
    learned = found["learning"]
    assert learned["reason"] == "all" and learned["turns"] > turns - 10
    assert learned["k1_ns"] == pytest.approx(-82_500, rel=0.05)  # 1.4 / w of 300 and 270 Hz


def errors_in(table: Path, machine: str, feed: str) -> tuple[np.ndarray, dict[str, Any]]:
    """Cut a part; return height [mm] and error [um] of its surface, and the summary."""
    found = cut(table, "--feed", feed, "--tolerance-um=99", machine=machine)
    rows = np.column_stack([found.surface["z_mm"], found.surface["error_nm"] / 1e3])
    return rows, found.summary


def largest_um(rows: np.ndarray, low_mm: float, high_mm: float) -> float:
    """Return the largest error between two heights."""
    inside = (rows[:, 0] >= low_mm) & (rows[:, 0] <= high_mm)
    return float(np.abs(rows[inside, 1]).max())


def test_first_turns_are_as_good_as_the_middle(table: Path) -> None:
    """They had 0.6 um."""
    rows, _ = errors_in(table, REAL.read_text(), "0.1")
    assert largest_um(rows, 0.0, 1.0) <= 0.3


def test_last_turns_at_a_large_feed(table: Path) -> None:
    """They had 2.3 um. Most of what is left is the tool, which bends beyond the scale."""
    rows, _ = errors_in(table, REAL.read_text(), "0.5")
    assert largest_um(rows, 57.5, 62.0) <= 0.5
    assert largest_um(rows, 0.5, 62.0) <= 0.75


def test_spring_deflects_alike_by_the_mean(table: Path) -> None:
    """A position drive is a spring: both coefficients are its share of the force."""
    rows, summary = errors_in(table, of("chip"), "0.5")
    assert largest_um(rows, 1.0, 62.0) <= 0.1
    learned = summary["learning"]
    expected = 700 * 0.3 / (1.5 * (2 * np.pi * 300) ** 2 * 1e-9)
    assert learned["chip_nm_per_mm2"] == pytest.approx(expected, rel=0.02)
    assert learned["chip_mean_nm_per_mm2"] == pytest.approx(expected, rel=0.02)


WINDOWS = """\
[[piston.window]]
angle_deg = 90
width_deg = 40
from_mm = 10
to_mm = 35
margin_mm = 0
both_sides = true

[process]
"""


@pytest.fixture(scope="module")
def windowed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the table of a Perkins skirt with two windows on the short axis, 25 mm high."""
    text = PERKINS.read_text().replace("[process]\n", WINDOWS)
    return written_skirt(text, tmp_path_factory.mktemp("windows"))


@pytest.mark.parametrize(("name", "most_um"), [("chip", 0.05), ("real", 0.31)])
def test_windows_do_not_harm_the_rest(windowed: Path, name: str, most_um: float) -> None:
    """The rest of the surface is as good as without, after the first turns at either end."""
    machine = REAL.read_text() if name == "real" else of(name)
    rows, summary = errors_in(windowed, machine, "0.1")
    assert summary["learning"]["masked"] == []
    for low_mm, high_mm in ((1, 9.9), (14, 34.9), (39, 61)):
        assert largest_um(rows, low_mm, high_mm) <= most_um, low_mm
    assert 0.5 < largest_um(rows, 9.9, 39) < 3  # the force steps by up to 4 N


def test_window_that_leaves_nothing(tmp_path: Path) -> None:
    """A window all around the part: nothing is gauged, and the message names the key."""
    box = WINDOWS.replace("= 40", "= 360").replace("10", "-9").replace("35", "99")
    box = box.replace("both_sides = true\n", "")
    table = written_skirt(PERKINS.read_text().replace("[process]\n", box), tmp_path)
    line = cut(table, "--feed", 2, status=1).message
    assert "not gauged: nothing was cut to full depth" in line
    assert "check [[piston.window]] of the part file" in line and "stop" not in line


def test_what_is_learned_survives_windows_at_a_large_feed(windowed: Path) -> None:
    """The steps of the force do not end in the coefficient: the last turns are good."""
    rows, _ = errors_in(windowed, REAL.read_text(), "0.5")
    assert largest_um(rows, 57.5, 62.0) <= 0.8


LOOSE = ("--machine", MACHINES / "loose.toml", "--rpm", "3000", "--turns-limit", "30")


def test_first_turns_are_right_while_the_spindle_settles(table_of: TableOf) -> None:
    """Without a rehearsal: 1.89 um where the cut began in the spindle's run-up."""
    words = ("--tolerance-um", "1", "--set", "rehearse_turns=0")
    summary = cut(table_of("oval30"), *LOOSE, *words).summary
    first = [e for e in summary["error_per_turn_um"][:8] if e is not None]
    assert len(first) >= 7 and max(first) < 0.13


@pytest.mark.parametrize("rpm", ["500", "1000"])
def test_first_turns_without_rehearsal_have_the_ripple(table_of: TableOf, rpm: str) -> None:
    """A learned ripple of 1 % is never worse: it left 0.44 and 0.6 um instead of 0.14 and 0.39."""
    place = ("--machine", MACHINES / "ripple.toml", "--rpm", rpm, "--turns-limit", "20")
    options = ("--set", "rehearse_turns=0", "--tolerance-um", "9")
    largest_um = [
        cut(table_of("oval30"), *place, *options, *words).summary["form_error_um"]["max"]
        for words in ([], ["--set", "ripple_turns=0", "--set", "observer_bandwidth_mHz=200000"])
    ]
    assert largest_um[0] < min(largest_um[1], 0.15)


def test_a_spindle_that_never_settles_ends_the_start(table_of: TableOf) -> None:
    """15 rad/s2 up to 3000 r/min last 21 s; the patience ends after 10 s without a fault."""
    lathe = of("loose").replace("bandwidth_rad_per_s = 5", "torque_Nm = 1.5")
    words = ("--rpm", "3000", "--turns-limit", "30")
    found = cut(table_of("oval30"), *words, status=1, machine=lathe)
    assert "ended the start after 1" in found.message and "do not agree" in found.message
    summary = found.summary
    assert summary["end"] == "unsteady" and summary["state"] == "ready"
    assert summary["faults"] == []


# Part, words for camsim, and what the blank is thicker than the largest radius that is cut.
CASES: dict[str, tuple[str, tuple[str, ...], float]] = {
    "depth of cut": ("perkins240", (), 0.1),
    "no clearance of X": ("perkins240", ("--set", "x_clearance_nm=0"), 0.1),
    "u about its mean": ("skirt_passes", ("--set", "pass=1"), 0.3),
    "lobes": ("cam-345", ("--machine", str(ROOT / "host_sim/machines/cam.toml")), 0.1),
}


@pytest.mark.long
@pytest.mark.parametrize("case", CASES)
def test_the_tip_stays_off_the_blank(table_of: TableOf, case: str) -> None:
    """While U plays, the tip stays outside of the largest radius that is cut and its stock."""
    part, words, stock_mm = CASES[case]
    words += ("--set", "rehearse_turns=3", "--turns-limit", "3", "--trace-every", "11")
    words += ("--tolerance-um", "1000")
    status = int(part == "skirt_passes")  # whose first pass was not cut to its full depth
    found = cut(table_of(part), *words, status=status, tables=["trace"])
    in_cut, plays = (while_in(found.trace, state) for state in ("cutting", "rehearsing"))
    plays = plays[plays["in_u_nm"] > 0.1 * found.trace["in_u_nm"].max()]
    blank_nm = (in_cut["in_x_nm"] - in_cut["in_u_nm"]).max() + 1e6 * stock_mm
    assert plays["in_u_nm"].max() > 0.9 * in_cut["in_u_nm"].max()
    assert (plays["in_x_nm"] - plays["in_u_nm"]).min() > blank_nm
    assert found.summary["faults"] == []
