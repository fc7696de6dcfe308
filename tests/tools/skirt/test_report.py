"""The report: what is read, what is drawn, what is said, on cuts made up for the test."""

import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camtools.base.errors import InputError
from camtools.plots.style import drawing, nice_floor, nice_limit, png_of
from camtools.report import motion as report_motion
from camtools.report.compare import draw_variants
from camtools.report.map_cells import map_rows
from camtools.report.page import trace_text
from camtools.report.text import (
    clear_after_s,
    fault_facts,
    fault_story,
    margins_of,
    page_text,
    plain,
    verdict_of,
)
from camtools.sim.results import (
    CUTTING,
    FAULT,
    STATES,
    CutTrace,
    CutVariant,
    GaugedSurface,
    read_surface,
    read_trace,
)
from camtools.skirt.report import surface_plots
from camtools.skirt.report.motion_plot import hardest_turn
from camtools.skirt.report.outcome import SkirtOutcome
from camtools.skirt.report.page import make_report
from camtools.skirt.report.text import rows_of
from camtools.skirt.table.generate import GeneratedSkirt
from tests.tools.cases.part_cases import ROOT
from tests.tools.cases.report_cases import (
    LAST_CUT,
    TICK_S,
    TURNS_PER_TICK,
    made_up_summary,
    made_up_surface,
    made_up_trace,
    without_scripts,
)

FAULTY = {
    "end": "fault",
    "is_good": False,
    "faults": ["estop", "drive"],
    "first_faults": ["estop"],
    "fault": {
        "time_s": 0.3,
        "time_of_cutting_s": 0.25,
        "retract_s": 0.0455,
        "turn": 0.25,
        "z_mm": 20.0,
        "state": "cutting",
    },
    "injected": [{"kind": "estop", "at_s": 0.25, "value": 0, "happened": True}],
}


@pytest.fixture(scope="module")
def good(generated: GeneratedSkirt) -> SkirtOutcome:
    """Return a cut without anything wrong."""
    geometry = generated.geometry
    variants = (CutVariant("complete", 0.04, 0.02), CutVariant("without <lead>", 4.0, 2.0))
    trace = made_up_trace(geometry)
    surface = made_up_surface(geometry)
    return SkirtOutcome(generated, made_up_summary(), surface, trace, variants=variants)


@pytest.fixture(scope="module")
def good_files(good: SkirtOutcome) -> dict[str, bytes]:
    """Draw its report."""
    return make_report(good)


@pytest.fixture(scope="module")
def faulty(generated: GeneratedSkirt) -> SkirtOutcome:
    """Return a cut that an emergency stop ended."""
    trace = made_up_trace(generated.geometry, fault_at=6000)
    surface = made_up_surface(generated.geometry)
    return SkirtOutcome(generated, made_up_summary(**FAULTY), surface, trace)


def test_trace_is_read_by_the_names_of_its_columns(tmp_path: Path) -> None:
    """Columns may stand in any order among others; states become numbers."""
    path = tmp_path / "trace.csv"
    path.write_text(
        "tick,t_s,turn,z_mm,u_set_nm,u_act_nm,state,faults,u_due_nm,error_nm,speed_q32,in_x_nm\n"
        "0,0.5,1.25,10,100,90,cutting,0x0000,110,-7,2147483648,46000000\n"
        "1,0.6,1.75,10,100,90,fault,0x0001,110,-7,2147483648,46000000\n"
    )
    trace = read_trace(path)
    assert trace.state.tolist() == [CUTTING, FAULT]
    assert trace.following_um.tolist() == [-0.02, -0.02]
    assert trace.turns_per_tick.tolist() == [0.5, 0.5]
    assert trace.speed_rpm == pytest.approx([300, 300])
    assert trace.x_nm.tolist() == [46e6, 46e6]


def test_files_without_rows_are_empty_arrays(tmp_path: Path) -> None:
    """A header alone, as after a fault before the cut, is no error."""
    path = tmp_path / "surface.csv"
    path.write_text("turn,z_mm,radius_mm,error_nm\n")
    assert read_surface(path).turn.size == 0


def test_missing_column_is_named(tmp_path: Path) -> None:
    """A file of another version is refused in one line."""
    path = tmp_path / "surface.csv"
    path.write_text("turn,z_mm\n0,0\n")
    with pytest.raises(InputError, match=r"surface\.csv: has no column radius_mm; build"):
        read_surface(path)


@pytest.mark.parametrize("value", [1e-9, 0.03, 0.9999, 1.0, 1.0001, 2, 4.9, 5, 99, 1e6])
def test_round_limits_enclose(value: float) -> None:
    """Limits of scales are round and never cut anything off."""
    assert nice_floor(value) <= value <= nice_limit(value) * (1 + 1e-9)
    assert nice_limit(value) <= 2.5 * value + 1e-12
    assert f"{nice_limit(value):e}"[0] in "125"


def test_map_shows_the_worst_point_of_each_cell() -> None:
    """Of several points in a cell the largest magnitude wins, whatever the order."""
    surface = GaugedSurface(*np.array([[0.5, 0.5, 0.5], [1, 1, 1], [46, 46, 46], [0.1, -0.3, 0.2]]))
    grid = surface_plots.error_grid(surface, (0.0, 62.0), 64)
    assert grid[1, 180] == -0.3
    assert np.isnan(grid).sum() == grid.size - 1


def test_map_of_a_whole_cut_has_no_gaps(good: SkirtOutcome) -> None:
    """The simulator's cells and those of the map fit together."""
    grid = surface_plots.error_grid(good.surface, (0.0, 62.0), map_rows(62, 0.1))
    assert not np.isnan(grid).any()


def test_section_is_that_of_the_height(good: SkirtOutcome) -> None:
    """A section holds the worst point of each direction within its band, by rising angle."""
    near = surface_plots.section_at(good.surface, 31.0, 0.4)
    assert near.turn.size == surface_plots.N_BINS
    assert (np.diff(near.turn) > 0).all()
    assert np.abs(near.z_mm - 31).max() <= 0.4
    assert surface_plots.closed(near).turn[-1] == near.turn[0] + 1


def test_bands_by_height_enclose_the_error(good: SkirtOutcome) -> None:
    """Range and rms of four sine lobes are those of a sine."""
    z_mm, least, most, rms = surface_plots.bands_by_height(good.surface, (0.0, 62.0))
    assert z_mm[0] == pytest.approx(0.25)
    assert most == pytest.approx(0.04, rel=1e-3)
    assert least == pytest.approx(-0.04, rel=1e-3)
    assert rms == pytest.approx(0.04 / np.sqrt(2), rel=1e-3)


def test_following_error_is_of_the_cut_only(good: SkirtOutcome) -> None:
    """The constant 20 nm of the made-up trace come back at every angle."""
    degrees, least, most, mean = report_motion.following_by_angle(good.trace)
    assert degrees.size == 360
    for curve in (least, most, mean):
        assert curve == pytest.approx(0.02)


def test_hardest_turn_is_whole_and_last(good: SkirtOutcome) -> None:
    """Ovality rises with height, so the last whole turn of cutting is shown."""
    rows = hardest_turn(good.trace, good.generated.geometry)
    turns = good.trace.turn[rows]
    assert np.ptp(turns) == pytest.approx(1, abs=2 * TURNS_PER_TICK)
    assert np.floor(turns[0]) == np.floor(LAST_CUT * TURNS_PER_TICK) - 1


def test_states_over_time(good: SkirtOutcome) -> None:
    """Stretches of one state follow each other without gap."""
    spans = report_motion.state_spans(good.trace)
    assert [STATES[number] for _, _, number in spans] == [
        "homing",
        "engaging",
        "cutting",
        "disengaging",
    ]
    assert all(before[1] == after[0] for before, after in pairwise(spans))


def test_good_report_has_every_picture(good_files: dict[str, bytes]) -> None:
    """A whole cut gives all pictures, embedded, and a page that needs nothing from outside."""
    files = good_files
    assert sorted(files) == [
        *(f"cut_{key}.png" for key in ("compare", "following", "height", "map", "motion")),
        *("cut_overview.png", "cut_sections.png", "cut_sequence.png", "cut_skirt.png"),
        "report.html",
    ]
    page = without_scripts(files["report.html"].decode())
    assert page.count('src="data:image/png;base64,') == 8
    assert not re.search(r'(src|href)="(?!data:)|url\(|@import|https?://', page)
    assert "WITHIN TOLERANCE" in page
    assert "Invented" not in page


@pytest.mark.usefixtures("undrawn")
def test_faulty_report_tells_what_happened(faulty: SkirtOutcome) -> None:
    """A fault gets its picture and its story: what, when, reaction, remedy."""
    files = make_report(faulty)
    assert "cut_fault.png" in files
    page = files["report.html"].decode()
    for words in ("FAULT: ESTOP", "emergency-stop chain is open", "0.3000 s after the start"):
        assert words in page
    for words in (
        "The drives were disabled after 45.5 ms",
        "drive",
        "Simulated disturbances",
        "angle 90.0°",
    ):
        assert words in page


def test_time_to_clear_comes_from_the_trace(faulty: SkirtOutcome) -> None:
    """0.2 mm at 10 um per tick are 20 ticks and the one after."""
    assert clear_after_s(faulty) == pytest.approx(21 * TICK_S)


def test_tool_that_was_out_already_is_told_so(faulty: SkirtOutcome) -> None:
    """A fault far from the work claims no retract time."""
    trace = faulty.trace._replace(error_nm=np.full(faulty.trace.t_s.size, 2e6))
    outcome = SkirtOutcome(faulty.generated, faulty.summary, faulty.surface, trace)
    assert "already out of the work" in dict(fault_story(outcome))["reaction"]


@pytest.mark.parametrize("fault", ["drive", "u_travel", "u_runaway"])
def test_drive_fault_claims_no_retract(faulty: SkirtOutcome, fault: str) -> None:
    """What cannot be retracted is not told as retracted."""
    summary = faulty.summary | {"first_faults": [fault], "faults": [fault]}
    outcome = SkirtOutcome(faulty.generated, summary, faulty.surface, faulty.trace)
    assert "cannot retract" in dict(fault_story(outcome))["reaction"]


def test_cut_without_surface_and_trace_still_reports(faulty: SkirtOutcome) -> None:
    """A fault before the first chip leaves a page without pictures of the surface."""
    nothing = {"max": None, "rms": None, "tolerance": 5.0}
    summary = faulty.summary | {"form_error_um": nothing, "following_error_um": nothing}
    surface = GaugedSurface(*np.empty((4, 0)))
    files = make_report(
        SkirtOutcome(faulty.generated, summary, surface, CutTrace(*np.empty((10, 0))))
    )
    assert sorted(files) == ["cut_motion.png", "report.html"]
    assert b"nothing was cut to full depth" in files["report.html"]


@pytest.mark.parametrize(
    ("changes", "kind", "title"),
    [
        ({}, "good", "within tolerance"),
        ({"form_error_um": {"max": 5.1, "rms": 1.0, "tolerance": 5.0}}, "poor", "out of tolerance"),
        ({"end": "stopped"}, "poor", "incomplete: stopped"),
        ({"end": "timeout"}, "poor", "incomplete: timeout"),
        ({"is_good": False}, "poor", "not gauged"),
        (FAULTY, "fault", "fault: estop"),
    ],
)
def test_verdict(good: SkirtOutcome, changes: dict[str, Any], kind: str, title: str) -> None:
    """The headline says what the summary says."""
    summary = made_up_summary(**changes)
    verdict = verdict_of(SkirtOutcome(good.generated, summary, good.surface, good.trace))
    assert (verdict.kind, verdict.title) == (kind, title)


def test_margins_are_shares_of_the_limit(good: SkirtOutcome) -> None:
    """39.3 of 400 are 9.8 percent, and accelerations are shown in m/s2."""
    margins = margins_of(good)
    assert [one.percent for one in margins] == [pytest.approx(9.825)] * 4
    assert margins[2].needed == "0.0393 m/s²"


def test_terminal_table_is_aligned_ascii(good: SkirtOutcome) -> None:
    """All values start in one column, and every terminal can show them."""
    lines = page_text(good, rows_of(good), "out", 4.0).splitlines()
    assert lines[0] == "perkins240: within tolerance"
    starts = {re.match(r"  \S.*?  +", line).end() for line in lines[1:]}  # type: ignore[union-attr]
    assert len(starts) == 1
    assert all(line.isascii() for line in lines)
    assert len(lines) == len(rows_of(good)) + 6
    assert plain("µ²°±").isascii()


def test_every_fault_of_the_firmware_has_its_facts() -> None:
    """The manual's table has a line for each fault of cam_state.h."""
    header = (ROOT / "firmware" / "base" / "cam_state.h").read_text()
    names = re.findall(r"^    X\((\w+), ", header, re.MULTILINE)
    assert len(names) >= 15
    assert set(names) == set(fault_facts())


def test_windowed_trace_is_said_so(good: SkirtOutcome) -> None:
    """The report tells when the trace holds the first turns only."""
    whole = trace_text(good)
    part = trace_text(SkirtOutcome(good.generated, good.summary, good.surface, good.trace, False))
    assert "holds all" in whole
    assert "first 0.5 s only" in part


def test_bars_of_cuts_without_error() -> None:
    """An error of exactly 0 does not break the logarithmic scale."""
    with drawing():
        png = png_of(draw_variants((CutVariant("a", 0.0, 0.0), CutVariant("b", 1.0, 1.0)), 5.0))
    assert png.startswith(b"\x89PNG")
