"""Area, equal parts, speed law and forces against MATHS.md (20) .. (29)."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

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
from camtools.skirt.geometry.blank import section_cut
from camtools.skirt.geometry.sections import DoubleEllipse, Ellipse, Section
from camtools.skirt.geometry.skirt_geometry import Geometry
from tests.tools.cases.maths_tables import MEAN_SPEEDS, SPINDLE_LIMITS, TABLE_1, TABLE_4


def papers(law: Section) -> SectionCut:
    """Return the papers' section: a = 46, b = 45.9, depth 0.1 at the long axis."""
    return SectionCut(lambda phi: law.evaluate(phi, 46.0, 0.2), 46.0, 46.1)


EXACT, COSINE = papers(Ellipse()), papers(DoubleEllipse())
PEAKS = speed_peaks(EXACT)
MEAN_RPM = 2500 / PEAKS.ratio_max


def ellipse_area(theta: float) -> float:
    """Return the closed form of MATHS.md (21)."""
    a, b, blank = 46.0, 45.9, 46.1
    sector = a * b / 2 * np.arctan2(a * np.sin(theta), b * np.cos(theta))
    return float(blank**2 * theta / 2 - sector)


def test_total_areas() -> None:
    """Both forms, all printed digits, and the closed forms."""
    assert f"{EXACT.total_mm2:.12f}" == "10.846348636519"
    assert f"{COSINE.total_mm2:.12f}" == "10.843403393406"
    assert EXACT.total_mm2 == pytest.approx(np.pi / 4 * (46.1**2 - 46 * 45.9), rel=1e-12)
    assert f"{EXACT.total_mm2 / 30:.12f} {COSINE.total_mm2 / 30:.12f}" == (
        "0.361544954551 0.361446779780"
    )


@settings(max_examples=50)
@given(st.floats(0, np.pi / 2))
def test_area_is_the_closed_form(theta: float) -> None:
    """The quadrature agrees with annulus plus sector minus ellipse sector, and inverts."""
    area = float(EXACT.area_mm2(np.array([theta]))[0])
    assert area == pytest.approx(ellipse_area(theta), abs=1e-11)
    assert float(EXACT.angle_rad(np.array([area]))[0]) == pytest.approx(theta, abs=1e-12)


@pytest.mark.parametrize("i", range(31))
def test_table_1(i: int) -> None:
    """Depth, its change and area in steps of 3 degrees."""
    found = [f"{3 * i}"]
    for cut in (EXACT, COSINE):
        steps = steps_of(cut, np.radians(3.0))
        found += [
            f"{steps.depth_mm[i]:.6f}",
            f"{steps.change_mm[i]:.9f}",
            f"{steps.area_mm2[i]:.6f}",
        ]
    assert " ".join(found) == TABLE_1[i]


@pytest.mark.parametrize("i", range(30))
def test_table_4(i: int) -> None:
    """The 30 equal parts: angles, widths, depths, changes, speed ratios."""
    parts = parts_of(EXACT, 30), parts_of(COSINE, 30)
    found = [f"{i + 1}"]
    for one in parts:
        found += [f"{np.degrees(one.phi_rad[i]):.6f}", f"{np.degrees(one.width_rad[i]):.6f}"]
        found += [f"{one.depth_mm[i]:.7f}", f"{one.change_mm[i]:.7f}"]
        found += [f"{one.speed_ratio[i]:.6f}"] if one is parts[0] else []
    assert " ".join(found) == TABLE_4[i]


def test_claims_of_the_papers() -> None:
    """Depth and area rise, widths fall; the largest change is in part 9, near 35 degrees."""
    steps, parts = steps_of(EXACT, np.radians(3.0)), parts_of(EXACT, 30)
    assert (np.diff(steps.depth_mm) > 0).all()
    assert (np.diff(steps.area_mm2[1:]) > 0).all()
    assert int(np.argmax(steps.change_mm)) == 15
    assert (np.diff(parts.width_rad) < 0).all()
    assert int(np.argmax(parts.change_mm)) + 1 == 9
    phi = np.radians(np.linspace(30, 40, 100_001))
    slope = EXACT.delta(phi).d1 / EXACT.area_rate_mm2(phi)
    assert f"{np.degrees(phi[int(np.argmax(slope))]):.3f}" == "35.194"


def test_number_of_parts_is_bounded_on_both_sides() -> None:
    """0.04 mm3 and 0.1 mm feed need 28 parts; 50 us of cycle allow 179 at 1667 r/min."""
    assert parts_range(EXACT, 0.1, MEAN_RPM, 0.04, 50e-6) == (28, 179)
    assert f"{60_000 / MEAN_RPM / 120:.5f}" == "0.29989"


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


@pytest.mark.parametrize("row", MEAN_SPEEDS)
def test_mean_speeds(row: str) -> None:
    """What constant removal needs at several mean speeds."""
    rpm = MEAN_RPM if row.startswith("1667.27") else float(row.split()[0])
    omega = 2 * np.pi * rpm / 60
    found = (
        f"{rpm:.2f} {rpm * PEAKS.ratio_max:.2f} {rpm * PEAKS.ratio_min:.2f} "
        f"{PEAKS.alpha * omega**2:.1f} {PEAKS.u1_mm * omega:.4f} {PEAKS.u2_max_mm * omega**2:.2f} "
        f"{PEAKS.u2_min_mm * omega**2:.2f} {60_000 / rpm / 120:.5f}"
    )
    assert found == row


@pytest.mark.parametrize("row", SPINDLE_LIMITS)
def test_spindle_limits(row: str) -> None:
    """The highest mean speed that a spindle's acceleration allows."""
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
        lambda phi: DoubleEllipse().evaluate(phi + np.cos(phi) / 10, 46.0, 0.2),
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
