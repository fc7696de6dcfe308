"""The report of a skirt: what is read, drawn and said, on cuts made up for the test."""

import re
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camtools.base.errors import InputError
from camtools.plots.style import drawing, nice_floor, nice_limit, png_of
from camtools.report import motion as report_motion
from camtools.report.kind_report import make_report, rows_of
from camtools.report.page import trace_text
from camtools.report.surface import cells_of, map_rows
from camtools.report.text import (
    clear_after_s,
    fault_facts,
    fault_story,
    margins_of,
    page_text,
    plain,
    verdict_of,
)
from camtools.report.views import draw_variants
from camtools.sim.binding import Column
from camtools.sim.results import (
    CUTTING,
    FAULT,
    STATES,
    CutTrace,
    CutVariant,
    GaugedSurface,
    Removal,
    read_surface,
    read_trace,
)
from camtools.sim.table_file import ParquetFile
from camtools.skirt.geometry.sections import fold
from camtools.skirt.report.outcome import Even, SkirtOutcome, limited_turns, uniform_twin
from camtools.skirt.report.report import (
    REPORT,
    around_joint,
    draw_corner,
    draw_even,
    draw_ripple,
    hardest_turn,
    lines_at,
    ripple_by_turn,
    turn_near,
)
from camtools.skirt.table.generate import GeneratedSkirt
from tests.tools.cases.cut_cases import skirt_of
from tests.tools.cases.part_cases import ROOT, sure
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


def made_up_outcome(generated: GeneratedSkirt, even: Even | None = None) -> SkirtOutcome:
    """Return a good cut of a part, beside uniform turning where its removal rate is even."""
    geometry = generated.geometry
    surface, trace = made_up_surface(geometry), made_up_trace(geometry)
    return SkirtOutcome(generated, made_up_summary(), surface, trace, even=even)


@pytest.fixture(scope="module")
def good(generated: GeneratedSkirt) -> SkirtOutcome:
    """Return a cut without anything wrong."""
    variants = (CutVariant("complete", 0.04, 0.02), CutVariant("without <lead>", 4.0, 2.0))
    return replace(made_up_outcome(generated), variants=variants)


@pytest.fixture(scope="module")
def faulty(generated: GeneratedSkirt) -> SkirtOutcome:
    """Return a cut that an emergency stop ended."""
    trace, summary = made_up_trace(generated.geometry, fault_at=6000), made_up_summary(**FAULTY)
    return replace(made_up_outcome(generated), summary=summary, trace=trace)


def test_files_are_read_by_the_names_of_their_columns(tmp_path: Path) -> None:
    """Columns may stand in any order among others; states become numbers.

    A header alone, as after a fault before the cut, is no error; a missing column is named.
    """
    named = (
        "tick:0,t_s:1,turn:2,z_mm:0,u_set_nm:0,u_act_nm:0,state:s,faults:x4,u_due_nm:0,"
        "error_nm:0,speed_q32:0,in_x_nm:0"
    )
    columns = [Column(*one.split(":")) for one in named.split(",")]
    rows = [
        [0, 5, 125, 10, 100, 90, CUTTING, 0, 110, -7, 2147483648, 46000000],
        [1, 6, 175, 10, 100, 90, FAULT, 1, 110, -7, 2147483648, 46000000],
    ]
    with ParquetFile(tmp_path / "trace.parquet", columns) as file:
        file.write(np.array(rows))
    trace = read_trace(tmp_path / "trace.parquet")
    assert trace.state.tolist() == [CUTTING, FAULT]
    assert trace.following_um.tolist() == [-0.02, -0.02]
    assert trace.turns_per_tick.tolist() == [0.5, 0.5]
    assert trace.speed_rpm == pytest.approx([300, 300])
    assert trace.x_nm.tolist() == [46e6, 46e6]
    path = tmp_path / "surface.csv"
    path.write_text("turn,z_mm,radius_mm,error_nm\n")
    assert read_surface(path).turn.size == 0
    path.write_text("turn,z_mm\n0,0\n")
    with pytest.raises(InputError, match=r"surface\.csv: has no column radius_mm; build"):
        read_surface(path)


@pytest.mark.parametrize("value", [1e-9, 0.03, 0.9999, 1.0, 1.0001, 2, 4.9, 5, 99, 1e6])
def test_round_limits_enclose(value: float) -> None:
    """Limits of scales are round and never cut anything off."""
    assert nice_floor(value) <= value <= nice_limit(value) * (1 + 1e-9)
    assert nice_limit(value) <= 2.5 * value + 1e-12
    assert f"{nice_limit(value):e}"[0] in "125"


def test_map_shows_the_worst_point_of_each_cell(good: SkirtOutcome) -> None:
    """Of several points in a cell the largest magnitude wins, whatever the order."""
    surface = GaugedSurface(*np.array([[0.5, 0.5, 0.5], [1, 1, 1], [46, 46, 46], [0.1, -0.3, 0.2]]))
    grid = cells_of(surface, (0.0, 62.0), 64).error_um
    assert grid[1, 180] == -0.3
    assert np.isnan(grid).sum() == grid.size - 1
    grid = cells_of(good.surface, (0.0, 62.0), map_rows(62, 0.1)).error_um
    assert not np.isnan(grid).any()  # the simulator's cells and those of the map fit together


def test_data_of_pictures_are_those_of_the_cut(good: SkirtOutcome) -> None:
    """Following error, the hardest turn, states over time."""
    degrees, least, most, mean = report_motion.following_by_angle(good.trace)
    assert degrees.size == 360
    for curve in (least, most, mean):
        assert curve == pytest.approx(0.02)
    rows = hardest_turn(good.trace, good.generated.geometry, (0.0, 62.0))
    turns = good.trace.turn[rows]
    assert np.ptp(turns) == pytest.approx(1, abs=2 * TURNS_PER_TICK)
    assert np.floor(turns[0]) == np.floor(LAST_CUT * TURNS_PER_TICK) - 1
    spans = report_motion.state_spans(good.trace)
    assert [STATES[number] for _, _, number in spans] == [
        "homing",
        "engaging",
        "cutting",
        "disengaging",
    ]
    assert all(before[1] == after[0] for before, after in pairwise(spans))


@pytest.mark.usefixtures("undrawn")
def test_good_report_has_every_picture(good: SkirtOutcome) -> None:
    """A whole cut gives all pictures, embedded, and a page that needs nothing from outside."""
    files = make_report(REPORT, good)
    assert sorted(files) == ["cut_compare.png", "cut_sequence.png", "report.html"]
    page = without_scripts(files["report.html"].decode())
    assert page.count('src="data:image/png;base64,') == 2
    assert not re.search(r'(src|href)="(?!data:)|url\(|@import|https?://', page)
    assert "WITHIN TOLERANCE" in page
    assert "Invented" not in page


@pytest.mark.usefixtures("undrawn")
def test_faulty_report_tells_what_happened(faulty: SkirtOutcome) -> None:
    """A fault gets its picture and its story: what, when, reaction, remedy."""
    files = make_report(REPORT, faulty)
    assert "cut_fault.png" in files
    page = files["report.html"].decode()
    for words in (
        *("FAULT: ESTOP", "emergency-stop chain is open", "0.3000 s after the start", "drive"),
        *("The drives were disabled after 45.5 ms", "Simulated disturbances", "angle 90.0°"),
    ):
        assert words in page


def test_reaction_to_a_fault(faulty: SkirtOutcome) -> None:
    """0.2 mm at 10 um per tick take 21 ticks; no retract is claimed where there was none."""
    assert clear_after_s(faulty) == pytest.approx(21 * TICK_S)
    trace = faulty.trace._replace(error_nm=np.full(faulty.trace.t_s.size, 2e6))
    assert "already out of the work" in dict(fault_story(replace(faulty, trace=trace)))["reaction"]
    for fault in ("drive", "u_travel", "u_runaway"):
        summary = faulty.summary | {"first_faults": [fault], "faults": [fault]}
        assert "cannot retract" in dict(fault_story(replace(faulty, summary=summary)))["reaction"]


@pytest.mark.usefixtures("undrawn")
def test_cut_without_surface_and_trace_still_reports(faulty: SkirtOutcome) -> None:
    """A fault before the first chip leaves a page without pictures of the surface."""
    nothing = {"max": None, "rms": None, "tolerance": 5.0}
    summary = faulty.summary | {"form_error_um": nothing, "following_error_um": nothing}
    surface = GaugedSurface(*np.empty((4, 0)))
    trace = CutTrace(*np.empty((10, 0)))
    files = make_report(REPORT, SkirtOutcome(faulty.generated, summary, surface, trace))
    assert sorted(files) == ["report.html"]
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
    verdict = verdict_of(replace(good, summary=made_up_summary(**changes)))
    assert (verdict.kind, verdict.title) == (kind, title)


def test_text_of_a_good_cut(good: SkirtOutcome) -> None:
    """Margins are shares, the table is aligned ASCII, a trace of the first turns named."""
    margins = margins_of(good)
    assert [one.percent for one in margins] == [pytest.approx(9.825)] * 4
    assert margins[2].needed == "0.0393 m/s²"
    lines = page_text(good, rows_of(REPORT, good), "out", 4.0).splitlines()
    assert lines[0] == "perkins240: within tolerance"
    starts = {re.match(r"  \S.*?  +", line).end() for line in lines[1:]}  # type: ignore[union-attr]
    assert len(starts) == 1
    assert all(line.isascii() for line in lines)
    assert len(lines) == len(rows_of(REPORT, good)) + 6
    assert plain("µ²°±").isascii()
    assert "holds all" in trace_text(good)
    assert "first 0.5 s only" in trace_text(replace(good, is_trace_complete=False))


def test_every_fault_of_the_firmware_has_its_facts() -> None:
    """The manual's table has a line for each fault of cam_state.h."""
    header = (ROOT / "firmware" / "base" / "cam_state.h").read_text()
    names = re.findall(r"^    X\((\w+), ", header, re.MULTILINE)
    assert len(names) >= 15
    assert set(names) == set(fault_facts())


def test_bars_of_cuts_without_error() -> None:
    """An error of exactly 0 does not break the logarithmic scale."""
    with drawing():
        png = png_of(draw_variants((CutVariant("a", 0.0, 0.0), CutVariant("b", 1.0, 1.0)), 5.0))
    assert png.startswith(b"\x89PNG")


@pytest.fixture(scope="module")
def weichai() -> GeneratedSkirt:
    """Return the table of a part with a corner."""
    return skirt_of("weichai3a")


def made_up_removal(ripple: float) -> Removal:
    """Return slices of 62 turns, 120 each, with a rate that goes twice per turn."""
    turn = np.arange(62 * 120) / 120 + 1 / 240
    rate = 20 * (1 - ripple / 2 * np.cos(4 * np.pi * turn))
    force = 10 - 3 * np.cos(4 * np.pi * turn)
    return Removal(turn * 0.25, turn, turn, rate, 0.7 * rate, 16 * rate, force)


def made_up_even(ours: float, theirs: float) -> Even:
    """Return both ways of turning with given ripples."""

    def summary(ripple: float) -> dict[str, object]:
        spread = {"mean": ripple, "min": ripple, "max": ripple}
        chip = {"mean": 0.6, "min": 0.6, "max": 0.6}
        removal = {"rate_ripple": spread, "chip_force_ripple": chip}
        return {"removal": removal, "form_error_um": {"max": 0.05, "rms": 0.01}}

    removals = made_up_removal(ours), made_up_removal(theirs)
    return Even(summary(ours), summary(theirs), *removals)


def test_joint_is_seen_from_all_quadrants() -> None:
    """The four corners of a section fold onto one."""
    turn = np.array([47, 133, 227, 313]) / 360
    np.testing.assert_allclose(around_joint(turn, 48.0), -1, atol=1e-9)
    assert float(np.degrees(fold(np.radians(227.0))[0])) == pytest.approx(47)


def test_lines_show_what_the_refit_costs(weichai: GeneratedSkirt) -> None:
    """Drawing and refit are apart by the deviation that mktables tells, at the joint."""
    corner = sure(weichai.geometry.corner)
    lines = lines_at(weichai.geometry, corner, corner.worst_mm, 800.0)
    off_um = lines.refit_um - lines.drawn_um
    told = next(one for one in corner.candidates if (one.s1, one.s2) == (3, 3))
    assert float(np.abs(off_um).max()) == pytest.approx(told.deviation_um, rel=1e-3)
    assert lines.deg[int(np.argmax(off_um))] == pytest.approx(48, abs=0.05)
    peak = float(lines.acceleration_m_s2.max()) * 1000
    assert peak == pytest.approx(told.acceleration_mm_s2, rel=1e-4)


def on_the_refit(generated: GeneratedSkirt) -> tuple[GaugedSurface, CutTrace]:
    """Return a surface and a trace made up on a part's own geometry."""
    geometry = generated.geometry
    z_mm, turn = np.meshgrid(np.linspace(0, 80, 100), (np.arange(720) + 0.5) / 720, indexing="ij")
    z, phi = z_mm.ravel(), turn.ravel()
    exact = geometry.radius_mm(z) - geometry.delta(2 * np.pi * phi, z).delta
    surface = GaugedSurface(phi, z, exact, np.zeros(z.size))
    return surface, made_up_trace(geometry)


def test_picture_of_a_corner(weichai: GeneratedSkirt) -> None:
    """It differs when the cut does; a trace that never cut leaves the lines of the drawing."""
    surface, trace = on_the_refit(weichai)
    off = surface._replace(error_um=surface.error_um + 5.0)
    idle = trace._replace(state=np.where(trace.state == CUTTING, 0.0, trace.state))
    with drawing():
        one, other, bare = (
            png_of(draw_corner(*cut, weichai.geometry, 800.0))
            for cut in ((surface, trace), (off, trace), (surface, idle))
        )
    assert one != other
    assert bare[1:4] == b"PNG"


@pytest.mark.usefixtures("undrawn")
def test_part_with_a_corner_gets_its_picture(weichai: GeneratedSkirt) -> None:
    """The report of such a part shows the corner."""
    surface, trace = on_the_refit(weichai)
    outcome = SkirtOutcome(weichai, made_up_summary(), surface, trace)
    files = make_report(REPORT, outcome)
    assert "cut_corner.png" in files
    rows = {row.name: row.value for row in rows_of(REPORT, outcome)}
    assert (
        "(3, 3) points left out: deviates from the drawing by at most 16.3 µm"
        in rows["refit of the corner"]
    )
    assert "The corner" in files["report.html"].decode()


def test_ripple_is_that_of_each_turn() -> None:
    """(Largest - least) / mean, turn by turn, with the turn's height."""
    z_mm, ripple = ripple_by_turn(made_up_removal(0.3))
    assert z_mm.size == 62
    np.testing.assert_allclose(ripple, 0.3, rtol=2e-3)
    near = turn_near(made_up_removal(0.3), 27.0)
    assert near.turn.size == 120
    assert abs(float(near.z_mm.mean()) - 27.0) <= 0.5


@pytest.mark.long
@pytest.mark.usefixtures("undrawn")
def test_equal_volume_part_shows_both_ways_of_turning(modulated: GeneratedSkirt) -> None:
    """Two pictures, the rows of ripple and force, the spindle's margin."""
    outcome = made_up_outcome(modulated, made_up_even(0.04, 0.66))
    one = {"needed": 499.0, "limit": 500.0, "margin": 1.0}
    outcome.summary["feasibility"]["spindle_acceleration_rad_s2"] = one
    files = make_report(REPORT, outcome)
    assert {"cut_even.png", "cut_ripple.png"} <= files.keys()
    rows = {row.name: row.value for row in rows_of(REPORT, outcome)}
    assert "at mean 2500 r/min" in rows["cut"]
    assert "mean 4.0 %, max 4.0 %" in rows["ripple of the removal rate"]
    assert "no speed law changes it" in rows["ripple of the chip force"]
    assert "spindle acceleration" in {margin.name for margin in margins_of(outcome)}
    level, speed = made_up_even(0.0, 0.66), sure(modulated.speed)
    with drawing():
        assert png_of(draw_even(level, speed, 230.0))
        assert png_of(draw_ripple(level, speed))


def test_ripple_that_is_unknown_or_does_not_apply(
    modulated: GeneratedSkirt, generated: GeneratedSkirt
) -> None:
    """What was not measured has a row that says so; uniform parts have no rows of it, no margin."""
    even = made_up_even(0.04, 0.66)
    even.summary["removal"] = {"turns": 0.0}
    rows = {row.name: row.value for row in rows_of(REPORT, made_up_outcome(modulated, even))}
    told = "unknown: no whole turn at full feed was cut"
    assert rows["ripple of the removal rate"] == told
    assert "ripple of the chip force" not in rows
    outcome = made_up_outcome(generated)
    assert not [row for row in rows_of(REPORT, outcome) if "ripple" in row.name]
    assert "spindle acceleration" not in {margin.name for margin in margins_of(outcome)}


def test_twin_is_the_same_part_at_constant_speed(modulated: GeneratedSkirt) -> None:
    """Only the speed channel goes."""
    twin = uniform_twin(modulated)
    assert twin.speed is None
    assert len(twin.table.channels) == 2
    assert twin.table.spindle_mrpm == modulated.table.spindle_mrpm
    assert (limited_turns(620.0), limited_turns(2001.0)) == ([], ["--turns-limit", "2000"])
