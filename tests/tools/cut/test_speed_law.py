"""Removal, the speed law of least ripple and the spindle that plays it: MATHS.md (20) .. (29)."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline

from camtools.base.quantities import Floats
from camtools.cut.removal import (
    ChipForce,
    SectionCut,
    equal_volume_angles,
    harmonics_mm,
    mean_rpm_for,
    motion_at,
    parts_of,
    parts_range,
    rates_of,
    speed_peaks,
    steps_of,
)
from camtools.cut.speed_law import (
    N_GRID,
    InfeasibleError,
    Load,
    SpeedLimits,
    excess,
    full,
    full_mean_rad_s,
    grid_rad,
    largest_partial,
    optimise,
    periodic_quintic,
    uniform,
)
from camtools.cut.spindle_loop import SpindleLoop, _PlayedSpindle, played_ripple
from camtools.skirt.geometry.sections import Law, double_ellipse, ellipse
from camtools.skirt.geometry.skirt_geometry import Geometry, section_cut
from tests.tools.cases.maths_tables import MEAN_SPEEDS, SPINDLE_LIMITS, TABLE_1, TABLE_4


def papers(law: Law) -> SectionCut:
    """Return the papers' section: a = 46, b = 45.9, depth 0.1 at the long axis."""
    return SectionCut(lambda phi: law(phi, 46.0, 0.2), 46.0, 46.1)


EXACT, COSINE = papers(ellipse), papers(double_ellipse)
PEAKS = speed_peaks(EXACT)
MEAN_RPM = 2500 / PEAKS.ratio_max


def ellipse_area(theta: float) -> float:
    """Return the closed form of MATHS.md (21)."""
    a, b, blank = 46.0, 45.9, 46.1
    sector = a * b / 2 * np.arctan2(a * np.sin(theta), b * np.cos(theta))
    return float(blank**2 * theta / 2 - sector)


def test_total_areas_and_number_of_parts() -> None:
    """All printed digits, closed forms; 0.04 mm3 need 28 parts, 50 us of cycle allow 179."""
    assert f"{EXACT.total_mm2:.12f}" == "10.846348636519"
    assert f"{COSINE.total_mm2:.12f}" == "10.843403393406"
    assert EXACT.total_mm2 == pytest.approx(np.pi / 4 * (46.1**2 - 46 * 45.9), rel=1e-12)
    assert f"{EXACT.total_mm2 / 30:.12f} {COSINE.total_mm2 / 30:.12f}" == (
        "0.361544954551 0.361446779780"
    )
    assert parts_range(EXACT, 0.1, MEAN_RPM, 0.04, 50e-6) == (28, 179)
    assert f"{60_000 / MEAN_RPM / 120:.5f}" == "0.29989"


@settings(max_examples=20)
@given(st.floats(0, np.pi / 2))
def test_area_is_the_closed_form(theta: float) -> None:
    """The quadrature agrees with annulus plus sector minus ellipse sector, and inverts."""
    area = float(EXACT.area_mm2(np.array([theta]))[0])
    assert area == pytest.approx(ellipse_area(theta), abs=1e-11)
    assert float(EXACT.angle_rad(np.array([area]))[0]) == pytest.approx(theta, abs=1e-12)


def test_table_1() -> None:
    """Depth, its change and area in steps of 3 degrees."""
    exact, cosine = (steps_of(one, np.radians(3.0)) for one in (EXACT, COSINE))
    for i, row in enumerate(TABLE_1):
        found = [f"{3 * i}"]
        for steps in (exact, cosine):
            found += [f"{steps.depth_mm[i]:.6f}", f"{steps.change_mm[i]:.9f}"]
            found += [f"{steps.area_mm2[i]:.6f}"]
        assert " ".join(found) == row


def test_table_4() -> None:
    """The 30 equal parts: angles, widths, depths, changes, speed ratios."""
    parts = parts_of(EXACT, 30), parts_of(COSINE, 30)
    for i, row in enumerate(TABLE_4):
        found = [f"{i + 1}"]
        for one in parts:
            found += [f"{np.degrees(one.phi_rad[i]):.6f}", f"{np.degrees(one.width_rad[i]):.6f}"]
            found += [f"{one.depth_mm[i]:.7f}", f"{one.change_mm[i]:.7f}"]
            found += [f"{one.speed_ratio[i]:.6f}"] if one is parts[0] else []
        assert " ".join(found) == row


def test_law_of_constant_rate() -> None:
    """Ratios, spindle acceleration, speed and acceleration of U with their places."""
    assert f"{PEAKS.ratio_max:.9f} {PEAKS.ratio_min:.9f}" == "1.499457112 0.750543478"
    assert f"{PEAKS.alpha:.9f} {np.degrees(PEAKS.alpha_rad):.4f}" == "1.056453557 23.2942"
    assert f"{PEAKS.u1_mm:.9f}" == "0.106123891"
    assert f"{np.degrees(PEAKS.u1_rad):.6f}" == "35.194213"
    assert f"{PEAKS.u2_max_mm:.9f} {PEAKS.u2_min_mm:.9f}" == "0.451144917 -0.112298815"
    assert f"{np.degrees(PEAKS.u2_min_rad):.3f}" == "85.645"
    square = PEAKS.ratio_max**2 * float(EXACT.delta(np.zeros(1)).d2[0])
    assert pytest.approx(square) == PEAKS.u2_max_mm


def test_mean_speeds() -> None:
    """What constant removal needs at several mean speeds, and the highest of several spindles."""
    for row in MEAN_SPEEDS:
        rpm = MEAN_RPM if row.startswith("1667.27") else float(row.split()[0])
        omega = 2 * np.pi * rpm / 60
        assert row == (
            f"{rpm:.2f} {rpm * PEAKS.ratio_max:.2f} {rpm * PEAKS.ratio_min:.2f} "
            f"{PEAKS.alpha * omega**2:.1f} {PEAKS.u1_mm * omega:.4f} "
            f"{PEAKS.u2_max_mm * omega**2:.2f} {PEAKS.u2_min_mm * omega**2:.2f} "
            f"{60_000 / rpm / 120:.5f}"
        )
    for row in SPINDLE_LIMITS:
        alpha = float(row.split()[0])
        rpm = mean_rpm_for(PEAKS, alpha)
        assert f"{alpha:.0f} {rpm:.3f} {rpm * PEAKS.ratio_max:.3f}" == row


def test_law_takes_the_time_of_a_turn() -> None:
    """The mean of 1 / r over the angle is 1; alpha is the slope of omega squared / 2."""
    phi = np.linspace(0, np.pi / 2, 200_001)
    ratio, product, _, _ = motion_at(EXACT, phi)
    assert float(np.trapezoid(1 / ratio, phi)) == pytest.approx(np.pi / 2, rel=1e-9)
    slope = np.gradient(ratio**2 / 2, phi)
    np.testing.assert_allclose(slope[1:-1], product[1:-1], atol=1e-8)


def test_waves_of_u_in_time() -> None:
    """Cosine amplitudes of 2, 4, 6, 8 per turn at constant rate."""
    waves = harmonics_mm(EXACT, 8)
    assert [f"{mm:.5f}" for mm in waves[2::2]] == ["-0.04792", "-0.00775", "-0.00188", "-0.00054"]
    np.testing.assert_allclose(waves[1::2], 0, atol=1e-12)


def test_forces_and_rates() -> None:
    """Ripples, rate and power of MATHS.md (29); the chip's force goes from 7 to 14 N."""
    rates = rates_of(EXACT, steps_of(EXACT, np.radians(3.0)), 0.1, MEAN_RPM, 700.0)
    assert f"{rates.largest_to_least:.6f} {rates.ripple:.6f}" == "1.997828 0.665460"
    assert f"{rates.steps_largest_to_least:.6f} {rates.steps_ripple:.6f}" == "1.995095 0.664244"
    assert f"{rates.rate_mm3_s:.6f} {rates.power_w:.3f}" == "120.558618 84.391"
    chip = 700 * 0.1 * EXACT.depth_mm(np.array([0.0, np.pi / 2]))
    assert [f"{n:.1f}" for n in chip] == ["7.0", "14.0"]


def test_angles_of_a_turn_are_symmetric() -> None:
    """120 slices a turn; the second quadrant is the mirror image of the first."""
    angles = np.degrees(equal_volume_angles(EXACT, 30, 2))
    assert angles.size == 241
    np.testing.assert_allclose(angles[30:61], 180 - angles[30::-1], atol=1e-9)
    np.testing.assert_allclose(angles[60:121] - 180, angles[:61], atol=1e-9)
    assert (np.diff(angles) > 0).all()
    assert angles[-1] == pytest.approx(720)


def test_section_of_a_part_knows_its_blank(geometry: Geometry) -> None:
    """The blank is a cylinder above the largest diameter; lower sections are cut deeper."""
    cut = section_cut(geometry, 0.1, 20.0)
    assert cut.n_patterns == 4
    assert f"{cut.total_mm2:.6f}" == "10.846349"
    top = section_cut(geometry, 0.1, 62.0)
    assert top.blank_mm == cut.blank_mm
    assert float(top.depth_mm(np.zeros(1))[0]) == pytest.approx(46.1 - 91.737 / 2, abs=1e-6)


def test_sections_without_symmetry_take_the_whole_turn() -> None:
    """A section with three waves is cut into parts of the whole turn."""
    cut = SectionCut(
        lambda phi: double_ellipse(phi + np.cos(phi) / 10, 46.0, 0.2),
        46.0,
        46.1,
        2 * np.pi,
    )
    parts = parts_of(cut, 50)
    areas = np.diff(cut.area_mm2(np.append(0.0, parts.phi_rad)))
    np.testing.assert_allclose(areas, cut.total_mm2 / 50, rtol=1e-11)
    assert equal_volume_angles(cut, 50, 3).size == 151


def test_size_effect_is_that_of_kienzle() -> None:
    """By hand: 700 x 0.1 x 0.1^0.75 N; with a nose of 0.8 mm an arc of 0.8 acos(0.875) mm."""
    depth = np.array([0.1, 0.1])
    assert ChipForce(700.0).chip_n(depth, 0.1)[0] == pytest.approx(7.0)
    square = ChipForce(700.0, 0.25).chip_n(depth, 0.1)[0]
    assert square == pytest.approx(12.447956, rel=1e-6)
    arc_mm = 0.8 * np.arccos(0.875)
    nosed = ChipForce(700.0, 0.25, 0.8).chip_n(depth, 0.1)[0]
    assert nosed == pytest.approx(700 * (0.01 / arc_mm) ** -0.25 * 0.01, rel=1e-9)
    assert nosed == pytest.approx(17.651063, rel=1e-6)
    deep = ChipForce(700.0, 0.25, 0.8).chip_n(np.array([2.0]), 0.1)[0]
    assert deep == pytest.approx(700 * (0.2 / (0.8 * np.pi / 2 + 1.2)) ** -0.25 * 0.2, rel=1e-9)


RPM = np.pi / 30


def load_of(g_mm: float = 0.2, depth_mm: float = 0.1, a_mm: float = 46.0) -> Load:
    """Return the papers' section, or one like it."""
    u = ellipse(np.pi * np.arange(N_GRID) / N_GRID, a_mm, g_mm)
    blank = a_mm + depth_mm
    return Load((blank**2 - (a_mm - u.delta) ** 2) / 2, u.d1, u.d2, np.pi)


PAPERS = load_of()
LATHE = SpeedLimits(500.0, 3000 * RPM, 400.0, 250_000.0)
WIDE = SpeedLimits(1e9, 1e6, 1e9, 1e12)


def test_full_modulation_has_the_worked_numbers() -> None:
    """Ratios and peaks of MATHS.md (24) and (25); ripple of uniform turning."""
    law = full(PAPERS)
    assert (
        f"{float(law.ratio(0.0)):.8f} {float(law.ratio(np.pi / 2)):.8f}" == "1.49945711 0.75054348"
    )
    alpha, ratio, speed, motion = law.peaks
    assert alpha == pytest.approx(1.056453557, rel=2e-5)
    assert ratio == pytest.approx(1.499457112, abs=1e-8)
    assert speed == pytest.approx(0.106123891, rel=1e-5)
    assert motion == pytest.approx(0.451144917, rel=1e-8)
    assert law.ripple == pytest.approx(0, abs=1e-12)
    assert f"{uniform(PAPERS).ripple:.6f}" == "0.665460"


def test_highest_speed_of_full_modulation() -> None:
    """Mean speeds that the spindle's acceleration allows, to the grid's error of 1e-5."""
    for row in SPINDLE_LIMITS:
        alpha, rpm, _ = map(float, row.split())
        found = full_mean_rad_s(PAPERS, SpeedLimits(alpha, 1e6, 1e9, 1e12)) / RPM
        assert found == pytest.approx(rpm, rel=1e-5)


def test_laws_at_the_ends_of_what_a_machine_can_do() -> None:
    """Full, uniform, refused with numbers, and as steep as a table holds."""
    assert optimise(PAPERS, WIDE, 2500 * RPM).share == 1
    weak = SpeedLimits(1e-3, 3000 * RPM, 400.0, 250_000.0)
    law = optimise(PAPERS, weak, 1000 * RPM)
    np.testing.assert_allclose(law.ratio(grid_rad(PAPERS)), 1, atol=1e-5)
    slow_u = SpeedLimits(500.0, 3000 * RPM, 1.0, 250_000.0)
    with pytest.raises(InfeasibleError, match=r"u_speed_mm_s: needs 10.47 times .* 1000 r/min"):
        optimise(PAPERS, slow_u, 1000 * RPM)
    law = optimise(load_of(0.3, 0.01), LATHE, 60 * RPM)
    assert 9 < law.peaks[0] < 10


@pytest.mark.parametrize(("rpm", "blended", "best"), [(250, 0.139, 0.064), (600, 0.544, 0.484)])
def test_optimised_law_beats_partial_modulation(rpm: float, blended: float, best: float) -> None:
    """What README tells of the papers' section on a lathe of 500 rad/s2."""
    assert largest_partial(PAPERS, LATHE, rpm * RPM).ripple == pytest.approx(blended, abs=0.003)
    assert optimise(PAPERS, LATHE, rpm * RPM).ripple == pytest.approx(best, abs=0.003)


@pytest.mark.parametrize("n", [64, 511, 512])
def test_spline_of_a_law_is_that_of_a_general_solver(n: int) -> None:
    """Value and three derivatives through random ratios, over several turns."""
    y = 1 + 0.3 * np.random.default_rng(n).random(n)
    found, x = periodic_quintic(y, 3.1), 3.1 * np.arange(n + 1) / n
    wanted = make_interp_spline(x, np.append(y, y[0]), k=5, bc_type="periodic")
    phi = np.linspace(-5, 9, 1000)
    for nu in range(4):
        error = np.abs(found(phi, nu=nu) - wanted(phi, nu=nu)).max()
        assert error < 1e-12 * np.abs(wanted(phi, nu=nu)).max()


@settings(max_examples=6)
@given(
    st.floats(0.05, 0.5),
    st.floats(0.05, 0.5),
    st.floats(50, 2000),
    st.floats(100, 5000),
    st.floats(20, 400),
)
def test_laws_keep_every_limit(
    g_mm: float, depth_mm: float, rpm: float, alpha: float, u_speed: float
) -> None:
    """Never beyond a limit, never worse than partial modulation, mean speed exact."""
    load, limits = load_of(g_mm, depth_mm), SpeedLimits(alpha, 2500 * RPM, u_speed, 100_000.0)
    try:
        blended = largest_partial(load, limits, rpm * RPM)
    except InfeasibleError as error:
        assert "machine.limits." in error.lines[0]
        return
    law = optimise(load, limits, rpm * RPM)
    assert law.ripple <= blended.ripple + 1e-9
    dense = np.linspace(0, np.pi, 8 * N_GRID, endpoint=False)
    for one in (law, blended):
        assert max(excess(one, limits, rpm * RPM).values()) <= 1
        assert float(np.mean(1 / one.ratio(dense))) == pytest.approx(1, abs=1e-8)
        slope = one.ratio(dense) * one.ratio(dense, 1) * (rpm * RPM) ** 2
        assert float(np.abs(slope).max()) <= limits.alpha_rad_s2


def test_law_is_as_symmetric_as_its_section() -> None:
    """A mirrored section has a mirrored law; three waves run over the whole turn."""
    law = optimise(PAPERS, LATHE, 300 * RPM)
    phi = np.linspace(0, np.pi / 2, 200)
    np.testing.assert_allclose(law.ratio(np.pi - phi), law.ratio(phi), atol=1e-9)
    np.testing.assert_allclose(law.ratio(np.pi + phi), law.ratio(phi), atol=1e-12)
    phi = 2 * np.pi * np.arange(N_GRID) / N_GRID
    area = 5 + np.cos(2 * phi) + 0.3 * np.sin(3 * phi)
    load = Load(area, 0.1 * np.sin(2 * phi), 0.2 * np.cos(2 * phi), 2 * np.pi)
    law, blended = (solve(load, LATHE, 250 * RPM) for solve in (optimise, largest_partial))
    assert law.ripple <= blended.ripple < uniform(load).ripple
    assert max(excess(law, LATHE, 250 * RPM).values()) <= 1


FAST = SpindleLoop(1000.0, 1e6, 1e4, 0.0)


def oval_load(swing: float = 0.33) -> Load:
    """Return a section whose area swings about its mean twice per turn."""
    phi = np.pi * np.arange(N_GRID) / N_GRID
    return Load(5 * (1 - swing * np.cos(2 * phi)), np.sin(2 * phi) / 10, np.cos(2 * phi) / 5, np.pi)


@pytest.mark.parametrize(
    ("alpha", "told"), [(1e9, 90.0), (400.0, 90.0), (400.0, 20.0), (50.0, 80.0)]
)
def test_step_solves_the_spindle(alpha: float, told: float) -> None:
    """Speed and angle with and without torque to spare, up and down."""
    loop = SpindleLoop(40.0, alpha, 1e3, 0.0)
    spindle = _PlayedSpindle(1, 60.0, loop)
    spindle.step(np.array([told]), 0.05)

    def slope(_t: float, y: Floats) -> list[float]:
        return [float(np.clip(40.0 * (told - y[0]), -alpha, alpha)), float(y[0])]

    exact = solve_ivp(slope, (0, 0.05), [60.0, 0.0], rtol=1e-10, atol=1e-12, max_step=1e-4)
    assert spindle.omega[0] == pytest.approx(exact.y[0, -1], abs=1e-4)
    assert spindle.phi[0] == pytest.approx(exact.y[1, -1], abs=1e-5)


def test_played_ripple() -> None:
    """By the area and the spindle's own, by the hold, by a loop or a torque that is too weak."""
    law = uniform(oval_load())
    assert played_ripple([law], 25.0, FAST)[0] == pytest.approx(0.66, abs=1e-3)
    noisy = FAST._replace(ripple=0.002)
    assert played_ripple([law], 25.0, noisy)[0] == pytest.approx(0.664, abs=1e-3)
    law = full(oval_load())
    assert law.ripple < 1e-9
    assert played_ripple([law], 25.0, FAST)[0] < 0.003
    law = full(oval_load())
    assert law.fall * 62.8 > 40
    assert played_ripple([law], 62.8, SpindleLoop(40.0, 1e6, 1e4, 0.0))[0] > 0.05
    law = full(oval_load())
    needed = law.peaks[0] * 25.0**2
    assert played_ripple([law], 25.0, SpindleLoop(1000.0, needed / 2, 1e4, 0.0))[0] > 0.05


def test_set_points_are_those_of_the_inverse() -> None:
    """They are r + c r r' on the grid."""
    law = full(oval_load())
    phi = grid_rad(law.load)
    told = law.set_points(0.5)
    step = 1e-5
    slope = (law.ratio(phi + step) - law.ratio(phi - step)) / (2 * step)
    np.testing.assert_allclose(told, law.ratio(phi) * (1 + 0.5 * slope), rtol=1e-6)
