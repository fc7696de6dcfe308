"""Pictures and rows that only some parts have: corner, skirt in space, equal-volume turning."""

from pathlib import Path

import numpy as np
import pytest

from camtools.plots.style import drawing, png_of
from camtools.report.text import margins_of
from camtools.sim.results import CUTTING, CutTrace, GaugedSurface, Removal, read_removal
from camtools.skirt.geometry.composite import fold
from camtools.skirt.report.corner_plot import around_joint, draw_corner, lines_at
from camtools.skirt.report.equal_volume import limited_turns, uniform_twin
from camtools.skirt.report.equal_volume_plots import (
    draw_even,
    draw_ripple,
    ripple_by_turn,
    turn_near,
)
from camtools.skirt.report.outcome import Even, SkirtOutcome
from camtools.skirt.report.page import make_report
from camtools.skirt.report.shape_plot import draw_skirt, enlargement_of, radius_grid
from camtools.skirt.report.text import rows_of
from camtools.skirt.table.generate import GeneratedSkirt, generate
from tests.tools.cases.part_cases import ROOT, load_part
from tests.tools.cases.report_cases import made_up_summary, made_up_surface, made_up_trace

PARTS = ROOT / "tools" / "parts"


@pytest.fixture(scope="module")
def weichai() -> GeneratedSkirt:
    """Make the table of a part with a corner."""
    return generate(load_part(PARTS / "weichai3a.toml"))


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
    corner = weichai.geometry.corner
    assert corner is not None
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


def test_part_with_a_corner_gets_its_picture(weichai: GeneratedSkirt) -> None:
    """The report of such a part shows the corner; the picture differs when the cut does."""
    surface, trace = on_the_refit(weichai)
    outcome = SkirtOutcome(weichai, made_up_summary(), surface, trace)
    files = make_report(outcome)
    assert "cut_corner.png" in files
    rows = {row.name: row.value for row in rows_of(outcome)}
    assert (
        "(3, 3) points left out: deviates from the drawing by at most 16.3 µm"
        in rows["refit of the corner"]
    )
    assert "The corner" in files["report.html"].decode()
    off = surface._replace(error_um=surface.error_um + 5.0)
    with drawing():
        other = png_of(draw_corner(off, trace, weichai.geometry, 2500.0))
    assert other != files["cut_corner.png"]


def test_corner_without_any_cutting_is_drawn(weichai: GeneratedSkirt) -> None:
    """A trace that never cut leaves the lines of the drawing."""
    surface, trace = on_the_refit(weichai)
    idle = trace._replace(state=np.where(trace.state == CUTTING, 0.0, trace.state))
    with drawing():
        assert png_of(draw_corner(surface, idle, weichai.geometry, 800.0))[1:4] == b"PNG"


def test_skirt_in_space_is_enlarged_once(generated: GeneratedSkirt) -> None:
    """A real part is enlarged thirtyfold, one that is enlarged already not again."""
    assert (enlargement_of(1.0), enlargement_of(30.0), enlargement_of(100.0)) == (30, 1, 1)
    surface = made_up_surface(generated.geometry)
    heights, turns, radius = radius_grid(surface, generated.geometry)
    exact = generated.geometry.radius_mm(heights[:, None]) - (
        generated.geometry.delta(2 * np.pi * turns, heights[:, None]).delta
    )
    np.testing.assert_allclose(radius, exact, atol=2e-3)
    few = GaugedSurface(*(column[:50] for column in surface))
    with drawing():
        assert png_of(draw_skirt(few, generated.geometry, 1.0))[1:4] == b"PNG"


def test_ripple_is_that_of_each_turn() -> None:
    """(Largest - least) / mean, turn by turn, with the turn's height."""
    z_mm, ripple = ripple_by_turn(made_up_removal(0.3))
    assert z_mm.size == 62
    np.testing.assert_allclose(ripple, 0.3, rtol=2e-3)
    near = turn_near(made_up_removal(0.3), 27.0)
    assert near.turn.size == 120
    assert abs(float(near.z_mm.mean()) - 27.0) <= 0.5


def made_up_outcome(modulated: GeneratedSkirt, even: Even) -> SkirtOutcome:
    """Return a good cut with an even removal rate, beside uniform turning."""
    geometry = modulated.geometry
    one = {"needed": 499.0, "limit": 500.0, "margin": 1.0}
    summary = made_up_summary()
    summary["feasibility"]["spindle_acceleration_rad_s2"] = one
    surface, trace = made_up_surface(geometry), made_up_trace(geometry)
    return SkirtOutcome(modulated, summary, surface, trace, even=even)


@pytest.mark.usefixtures("undrawn")
def test_equal_volume_part_shows_both_ways_of_turning(modulated: GeneratedSkirt) -> None:
    """Two pictures, the rows of ripple and force, the spindle's margin."""
    outcome = made_up_outcome(modulated, made_up_even(0.04, 0.66))
    files = make_report(outcome)
    assert {"cut_even.png", "cut_ripple.png"} <= files.keys()
    rows = {row.name: row.value for row in rows_of(outcome)}
    assert "at mean 2500 r/min" in rows["cut"]
    assert "mean 4.0 %, max 4.0 %" in rows["ripple of the removal rate"]
    assert "no speed law changes it" in rows["ripple of the chip force"]
    assert "spindle acceleration" in {margin.name for margin in margins_of(outcome)}
    assert modulated.speed is not None
    with drawing():
        assert png_of(draw_even(made_up_even(0.0, 0.66), modulated.speed, 230.0))
        assert png_of(draw_ripple(made_up_even(0.0, 0.66), modulated.speed))


def test_removal_without_a_whole_turn_is_told(modulated: GeneratedSkirt) -> None:
    """What was not measured has a row that says so, not no row."""
    even = made_up_even(0.04, 0.66)
    even.summary["removal"] = {"turns": 0.0}
    rows = {row.name: row.value for row in rows_of(made_up_outcome(modulated, even))}
    told = "unknown: no whole turn at full feed was cut"
    assert rows["ripple of the removal rate"] == told
    assert "ripple of the chip force" not in rows


def test_uniform_parts_have_none_of_it(generated: GeneratedSkirt) -> None:
    """No rows, no margin of the spindle's acceleration."""
    geometry = generated.geometry
    outcome = SkirtOutcome(
        generated, made_up_summary(), made_up_surface(geometry), made_up_trace(geometry)
    )
    assert not [row for row in rows_of(outcome) if "ripple" in row.name]
    assert "spindle acceleration" not in {margin.name for margin in margins_of(outcome)}


def test_twin_is_the_same_part_at_constant_speed(modulated: GeneratedSkirt) -> None:
    """Only the speed channel goes."""
    twin = uniform_twin(modulated)
    assert twin.speed is None
    assert len(twin.table.channels) == 2
    assert twin.table.spindle_mrpm == modulated.table.spindle_mrpm
    assert limited_turns(2001.0) == ["--turns-limit", "2000"]


def test_slices_are_read_by_name(tmp_path: Path) -> None:
    """The table of slices may have its columns in any order."""
    path = tmp_path / "r.csv"
    path.write_text(
        "turn,t_s,z_mm,volume_mm3,rate_mm3_s,power_w,rate_force_n,chip_force_n\n1,2,3,4,5,6,7,8\n"
    )
    found = read_removal(path)
    assert (found.t_s[0], found.turn[0], found.chip_force_n[0]) == (2, 1, 8)
