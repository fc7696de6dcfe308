"""Cams against the worked numbers of MATHS.md (30), (31), (33) .. (39), and against each other."""

import numpy as np
import numpy.typing as npt
import pytest

from camtools.base.errors import GeometryError
from camtools.base.quantities import Floats
from camtools.lobe.contact import Contact, Follower, contact, follow, solved_at
from camtools.lobe.lift import Disc, LiftLaw, Listed, Poly345
from camtools.lobe.smooth_list import periodic_spline
from camtools.lobe.undercut import all_round, check_roller, check_wheel, shape_of
from tests.tools.cases.lobe_tables import DISC, POLY345, POLY345_WHEEL

BASE_MM, ROLLER_MM, WHEEL_MM, N0_RPM = 20.0, 10.0, 200.0, 60.0
DISC_LAW = Disc(35.0, 5.0)
POLY_LAW = Poly345(8.0, float(np.radians(70)))
DENSE = np.radians(np.linspace(-180, 180, 20_001))


def printed(value: float, like: str) -> str:
    """Return a value with as many decimals as a printed number, never "-0"."""
    text = f"{value:.{len(like.partition('.')[2])}f}"
    return text if float(text) != 0 or like.startswith("-") else text.lstrip("-")


def check_columns(lines: list[str], columns: list[Floats]) -> None:
    """Compare columns with a table, digit by digit."""
    for i, line in enumerate(lines):
        words = line.split()
        got = [printed(float(column[i]), word) for column, word in zip(columns, words, strict=True)]
        assert got == words


def angles_of(lines: list[str]) -> Floats:
    """Return the first column of a table in radians."""
    return np.radians([float(line.split()[0]) for line in lines])


def test_disc_to_the_printed_digits() -> None:
    """Golden A: lift, slope, wheel, cam angle, contact, way per angle and speed."""
    touch = contact(DISC_LAW, BASE_MM, ROLLER_MM, angles_of(DISC))
    path = follow(touch, WHEEL_MM)
    speed = N0_RPM * BASE_MM / path.ds_dphi
    columns = [np.degrees(touch.theta), touch.lift, touch.p1, path.lift, np.degrees(path.phi)]
    check_columns(DISC, [*columns, np.degrees(touch.alpha), touch.radius, path.ds_dphi, speed])


def test_poly345_to_the_printed_digits() -> None:
    """Golden B, with both roots of the roller's distance: plus is right, minus was printed."""
    touch = contact(POLY_LAW, BASE_MM, ROLLER_MM, angles_of(POLY345))
    path = follow(touch, WHEEL_MM)
    psi = touch.alpha - touch.theta
    root = np.sqrt(ROLLER_MM**2 - (touch.radius * np.sin(psi)) ** 2)
    plus, minus = touch.radius * np.cos(psi) + root, touch.radius * np.cos(psi) - root
    assert plus == pytest.approx(touch.p, abs=1e-12)
    columns = [np.degrees(touch.theta), touch.lift, np.degrees(touch.gamma), touch.radius]
    check_columns(POLY345, [*columns, np.degrees(touch.alpha), plus, minus])
    columns = [np.degrees(touch.theta), path.lift, np.degrees(path.phi), path.ds_dphi]
    check_columns(POLY345_WHEEL, [*columns, N0_RPM * BASE_MM / path.ds_dphi])


def test_poly345_extremes_are_the_printed_ones() -> None:
    """Largest swing and its place, sharpest curvature, range of ds/dphi and of the speed."""
    theta = np.radians(np.linspace(-90, 90, 360_001))
    touch = contact(POLY_LAW, BASE_MM, ROLLER_MM, theta)
    path, swing = follow(touch, WHEEL_MM), int(np.abs(touch.gamma).argmax())
    assert f"{abs(np.degrees(touch.gamma[swing])):.6f}" == "19.967381"
    assert f"{-abs(np.degrees(theta[swing])):.3f}" == "-36.936"
    assert f"{1 / touch.curvature.max():.6f}" == "10.679909"
    low, high = path.ds_dphi.min(), path.ds_dphi.max()
    assert f"{low:.5f}" == "11.51190"
    assert high == pytest.approx(177.34725, abs=1e-4)  # printed from a grid beside the peak
    assert f"{N0_RPM * BASE_MM / high:.4f} {N0_RPM * BASE_MM / low:.4f}" == "6.7664 104.2400"
    assert f"{path.phi1.min():.5f}" == "0.17120"


def test_disc_has_an_exact_solution() -> None:
    """Roller and wheel run on circles about the disc's centre; every contact lies on the disc."""
    touch = contact(DISC_LAW, BASE_MM, ROLLER_MM, DENSE)
    path = follow(touch, WHEEL_MM)
    roller = 5 * np.cos(DENSE) + np.sqrt(35**2 - 25 * np.sin(DENSE) ** 2)
    wheel = 5 * np.cos(path.phi) + np.sqrt(225**2 - 25 * np.sin(path.phi) ** 2)
    assert np.abs(touch.p - roller).max() < 1e-9
    assert np.abs(path.centre - wheel).max() < 1e-9
    assert np.abs(path.centre - (path.lift + BASE_MM + WHEEL_MM)).max() < 1e-12 * 250
    to_disc = np.abs(touch.radius * np.exp(1j * touch.alpha) - 5)
    assert np.abs(to_disc - 25).max() < 1e-9
    assert touch.curvature == pytest.approx(1 / 25, abs=1e-12)


@pytest.mark.parametrize("radius_mm", [ROLLER_MM, WHEEL_MM])
def test_followers_lie_on_the_envelope(radius_mm: float) -> None:
    """Find the follower's distance a second way: the farthest that any place pushes it."""
    theta = np.radians(np.linspace(-85, 85, 15))
    path = follow(contact(POLY_LAW, BASE_MM, ROLLER_MM, theta), radius_mm)
    profile = contact(POLY_LAW, BASE_MM, ROLLER_MM, np.radians(np.linspace(-180, 180, 720_001)))
    for phi, centre in zip(path.phi, path.centre, strict=True):
        off = profile.alpha - phi
        near = profile.radius * np.abs(np.sin(off)) < radius_mm
        near &= np.abs(off) < 0.5
        rho, off = profile.radius[near], off[near]
        reached = rho * np.cos(off) + np.sqrt(radius_mm**2 - (rho * np.sin(off)) ** 2)
        assert reached.max() == pytest.approx(centre, abs=2e-9)


@pytest.mark.parametrize("radius_mm", [ROLLER_MM, WHEEL_MM])
@pytest.mark.parametrize("law", [DISC_LAW, POLY_LAW])
def test_derivatives_are_those_of_the_path(law: LiftLaw, radius_mm: float) -> None:
    """Differences of lift and angle over the cam angle give the derivatives; ds/dphi too."""
    phi, h = np.radians(np.array([-66.0, -63, -50, -20, -3, 7, 31, 62.5, 120])), 1e-5

    def touch_at(theta_rad: Floats) -> tuple[Contact, Follower]:
        touch = contact(law, BASE_MM, ROLLER_MM, theta_rad)
        return touch, follow(touch, radius_mm)

    before, here, behind = (solved_at(touch_at, phi + k * h) for k in (-1, 0, 1))
    for name, derivative in (("lift", "d1"), ("d1", "d2"), ("angle", "angle1")):
        slope = (getattr(behind[1], name) - getattr(before[1], name)) / (2 * h)
        assert slope == pytest.approx(getattr(here[1], derivative), rel=1e-6, abs=1e-5)
    bend = (behind[1].angle1 - before[1].angle1) / (2 * h)
    assert bend == pytest.approx(here[1].angle2, rel=1e-6, abs=1e-5)
    way = np.abs(_place(behind[0]) - _place(before[0])) / (2 * h)
    assert way == pytest.approx(here[1].ds_dphi, rel=1e-6)
    assert here[1].phi == pytest.approx(phi, abs=1e-12)


def _place(touch: Contact) -> npt.NDArray[np.complex128]:
    """Return contacts in the plane."""
    return np.asarray(touch.radius * np.exp(1j * touch.alpha))


def test_effective_rake_is_constant_with_the_swing() -> None:
    """The tool swung by gamma stands along the contact's normal; unswung it is off by gamma."""
    touch = contact(POLY_LAW, BASE_MM, ROLLER_MM, DENSE)
    way = np.gradient(touch.radius * np.exp(1j * touch.alpha), DENSE)
    normal = np.angle(way) - np.pi / 2
    tool = touch.theta - touch.gamma
    off = np.degrees(np.angle(np.exp(1j * (normal - tool))))[1:-1]
    unswung = np.degrees(np.angle(np.exp(1j * (normal - touch.theta))))[1:-1]
    assert np.abs(off).max() < 1e-3
    assert np.abs(unswung).max() == pytest.approx(19.967, abs=1e-3)


def test_list_of_a_smooth_law_is_that_law() -> None:
    """The periodic quintic spline through 72 points of the disc is the disc to a nanometre."""
    angle_deg = np.arange(0, 360, 5.0)
    lift = DISC_LAW.evaluate(np.radians(angle_deg)).lift
    law = Listed(periodic_spline(angle_deg, lift))
    exact, got = DISC_LAW.evaluate(DENSE), law.evaluate(DENSE)
    assert np.abs(got.lift - exact.lift).max() < 1e-6
    assert np.abs(got.d1 - exact.d1).max() < 1e-5
    around = law.evaluate(np.array([-1e-9, 1e-9, 2 * np.pi - 1e-9]))
    for values in around:
        assert values[0] == pytest.approx(values[1], abs=1e-5)
        assert values[0] == pytest.approx(values[2], abs=1e-8)
    closed = Listed(periodic_spline(np.append(angle_deg, 360), np.append(lift, lift[0])))
    assert closed.evaluate(DENSE).lift == pytest.approx(got.lift, abs=1e-12)


def test_undercut_is_refused() -> None:
    """A lift that falls off within 20 degrees sharpens the nose below the roller's radius."""
    with pytest.raises(GeometryError, match=r"undercut at .* degrees.*smaller roller"):
        check_roller(all_round(Poly345(8.0, 0.35), BASE_MM, ROLLER_MM), "cam.lobe.0")
    check_roller(all_round(POLY_LAW, BASE_MM, ROLLER_MM), "cam.lobe.0")


def test_hollow_flank_is_for_small_wheels_only() -> None:
    """A steeper law is hollow: a wheel above the hollow's radius is refused, one below is not."""
    steep = Poly345(8.0, float(np.radians(60)))
    shape = shape_of(steep, BASE_MM, ROLLER_MM)
    assert 50 < shape.hollow_radius_mm < 1000
    touch = all_round(steep, BASE_MM, ROLLER_MM)
    with pytest.raises(GeometryError, match=r"is hollow with a radius of .* does not reach it"):
        check_wheel(touch, shape.hollow_radius_mm * 1.01, "cam.lobe.0")
    check_wheel(touch, shape.hollow_radius_mm * 0.5, "cam.lobe.0")
    assert shape_of(POLY_LAW, BASE_MM, ROLLER_MM).hollow_radius_mm == float("inf")
    check_wheel(all_round(POLY_LAW, BASE_MM, ROLLER_MM), WHEEL_MM, "cam.lobe.0")
