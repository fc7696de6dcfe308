"""Worked numbers of the equations that no module's test asserts, each by a second method."""

import numpy as np
import pytest
import scipy
from scipy.interpolate import CubicSpline, make_interp_spline
from scipy.optimize import brentq

from camtools.base.quantities import Floats
from camtools.lobe.channels import N_GRID, SpindleLimits, surface_speed
from camtools.lobe.contact import contact, follow
from camtools.lobe.lift import Disc, LiftLaw, Poly345
from camtools.skirt.geometry.corner import CANDIDATES, Recipe, judge, kept_sites, sites_rad
from camtools.skirt.geometry.sections import Joint, double_ellipse, ellipse
from camtools.skirt.geometry.skirt_geometry import make_geometry
from camtools.table.channel import segment_coefficients
from tests.tools.cases.part_cases import PERKINS, load_part

A_MM, G_MM = 46.0, 0.2
JOINT_RAD = float(np.radians(48.0))
PAPER = Joint(90.929096914 / 2, 0.38, 0.4, JOINT_RAD)
OMEGA = 2 * np.pi * 800 / 60
T = np.linspace(0, 1, 2001)
TICK_S, BANDWIDTH = 1 / 20_000, 2 * np.pi * 200.0


def test_eccentric_anomaly_is_off_by_a_third_the_other_way() -> None:
    """MATHS.md (5): the spindle angle taken for the eccentric anomaly, -27.2 nm for 81.6 nm."""
    phi, b = np.radians(np.linspace(0, 90, 9001)), A_MM - G_MM / 2
    wrong = A_MM - np.hypot(A_MM * np.cos(phi), b * np.sin(phi))
    off_nm = 1e6 * (wrong - double_ellipse(phi, A_MM, G_MM).delta)
    assert f"{off_nm.min():.1f}" == "-27.2"
    assert off_nm.min() * 1e-6 == pytest.approx(-(G_MM**2) / (32 * A_MM), rel=2e-3)


def test_spline_passes_its_largest_node_by_two_picometres() -> None:
    """MATHS.md (6): largest half axis 2.03e-9 mm above the node at 20 mm, at 20.005 220 mm."""
    geometry = make_geometry(load_part(PERKINS))
    top = brentq(lambda z: float(geometry.radius_mm(z, 1)), 19.5, 20.5, xtol=1e-13)
    assert f"{top:.6f}" == "20.005220"
    assert float(geometry.radius_mm(top)) - 46 == pytest.approx(2.03e-9, rel=2e-3)


def test_contour_without_a_corner_needs_a_negative_trim() -> None:
    """MATHS.md (13): at the trim stated there the jump of the slope is of second order in G."""
    jumps = []
    for g_mm in (0.02, 0.01):
        trim_mm = -(g_mm / 2) * (1 - np.sin(JOINT_RAD)) ** 2
        jumps.append(float(Joint(45.0, g_mm, trim_mm, JOINT_RAD).corner_mm_rad()))
    assert jumps[0] / jumps[1] == pytest.approx(4, rel=1e-2)
    assert abs(jumps[0]) < 1e-4 * 0.02
    assert f"{float(PAPER.corner_mm_rad()):.6f}" == "1.081733"


def test_corner_on_a_uniform_grid() -> None:
    """A unit corner has the peak sqrt(3) by cubics, 1.4542 by quintics that decay by 0.4306."""
    x = np.arange(-40, 41.0)
    corner = np.maximum(x, 0)
    assert float(CubicSpline(x, corner)(0, 2)) == pytest.approx(np.sqrt(3), abs=1e-12)
    assert f"{float(make_interp_spline(x, corner, k=5)(0.0, 2)):.4f}" == "1.4542"
    decay = np.roots([1, 26, 66, 26, 1])
    assert f"{-decay[np.abs(decay) < 1].real.min():.4f}" == "0.4306"


def divided_peak(recipe: Recipe) -> float:
    """Return the bound of MATHS.md (17) in mm/s2."""
    x = sites_rad(JOINT_RAD, 48)[kept_sites(recipe, 48)]
    slopes = np.diff(PAPER.reduction(x).delta) / np.diff(x)
    change, width = 2 * np.diff(slopes), x[2:] - x[:-2]
    return float((change / width).max()) * OMEGA**2


@pytest.mark.parametrize(("ends", "bound"), [("as-paper", "59115"), ("mirror", "45999")])
def test_no_curve_through_the_points_is_flatter(ends: str, bound: str) -> None:
    """MATHS.md (17): every refit keeps it; J omega^2 / w is more than it and thus no bound."""
    assert f"{divided_peak(Recipe('quintic', 3, 3, ends)):.0f}" == bound
    for s2, s1 in CANDIDATES:
        for spline in ("cubic", "quintic"):
            recipe = Recipe(spline, s1, s2, ends)
            assert judge(PAPER, recipe, 800.0).acceleration_mm_s2 > divided_peak(recipe)


@pytest.mark.parametrize(
    ("left_deg", "mean", "too_much"), [(45, "56119", "62142"), (44, "49110", "54374")]
)
def test_smooth_blend_of_both_branches(left_deg: int, mean: str, too_much: str) -> None:
    """MATHS.md (17): its mean acceleration over the gap is below J omega^2 / w."""
    gap = np.radians([left_deg, 52.0])
    rise = np.diff(PAPER.reduction(gap).d1)[0]
    assert f"{rise / np.ptp(gap) * OMEGA**2:.0f}" == mean
    assert f"{float(PAPER.corner_mm_rad()) / np.ptp(gap) * OMEGA**2:.0f}" == too_much


def between_knots(knots: Floats) -> Floats:
    """Return value and two derivatives of one interval at T, by MATHS.md (46)."""
    c = segment_coefficients(knots, periodic=False)[0]
    return np.stack([np.polynomial.Polynomial(c).deriv(n)(T) for n in range(3)])


@pytest.mark.parametrize(("n_knots", "printed"), [(32, "0.0041"), (16, "0.24")])
def test_interpolation_of_the_ellipse(n_knots: int, printed: str) -> None:
    """MATHS.md (48): error of exact knots; the cosine form keeps the bounds of all three."""
    h, worst = 2 * np.pi / n_knots, 0.0
    bounds = 16 * G_MM * np.array([h**6 / 46080, np.sqrt(5) * h**5 / 30000, h**4 / 1920])
    for i in range(n_knots):
        for law in (ellipse, double_ellipse):
            ends = law(h * np.array([i, i + 1.0]), A_MM, G_MM)
            knots = np.stack([ends.delta, h * ends.d1, h**2 / 2 * ends.d2], axis=-1)
            exact = law(h * (i + T), A_MM, G_MM)
            off = [
                float(np.abs(got / h**n - exact[n]).max())
                for n, got in enumerate(between_knots(knots))
            ]
            if law is ellipse:
                worst = max(worst, off[0] * 1e6)
            else:
                assert (off <= bounds * (1 + 1e-6)).all()
    assert f"{worst:.{len(printed) - 2}f}" == printed


def test_rounding_of_knots() -> None:
    """MATHS.md (49): half the largest sum of the basis polynomials' magnitudes."""
    basis = [between_knots(one.reshape(2, 3)) for one in np.eye(6)]
    largest = np.abs(basis).sum(axis=0).max(axis=1) / 2
    assert largest[:2] == pytest.approx([11 / 16, 19 / 8], abs=1e-12)
    assert 9.05 < largest[2] <= 9.051


def test_balanced_slices_err_by_half() -> None:
    """MATHS.md (50): chords of a parabola, as they are and balanced; a kink between slices."""
    curvature, step = 3.0, 0.5
    arc = curvature / 2 * (T * step) ** 2
    chord = arc[-1] * T
    assert np.abs(chord - arc).max() == pytest.approx(curvature * step**2 / 8)
    moved = chord - curvature * step**2 / 16
    assert np.abs(moved - arc).max() == pytest.approx(curvature * step**2 / 16)
    weight, jump = 0.3, 2.0
    bent = jump * np.maximum(T - weight, 0) * step
    off = np.abs(bent[-1] * T - bent)
    assert off.max() == pytest.approx(jump * weight * (1 - weight) * step, rel=1e-3)


def test_largest_travel_of_the_contact() -> None:
    """MATHS.md (35): ds/dphi of the example cam is largest at 56.8295 degrees, 177.347 30."""
    theta = np.radians(np.linspace(56.8, 56.9, 200_001))
    travel = follow(
        contact(Poly345(8.0, float(np.radians(70.0))), 20.0, 10.0, theta), 200.0
    ).ds_dphi
    assert f"{travel.max():.5f} {np.degrees(theta[travel.argmax()]):.4f}" == "177.34730 56.8295"


def test_largest_speed_below_a_wanted_one() -> None:
    """MATHS.md (36): the two passes find the minimum over all places, here of a single dip."""
    phi = 2 * np.pi * np.arange(N_GRID) / N_GRID
    travel = np.where(np.abs(phi - np.pi) < 0.01, 120.0, 20.0)
    law = surface_speed(travel, 20.0, 6.0, SpindleLimits(3, 1e3))
    slope = 2 * 0.94 * 3
    exact = np.minimum(36, 1 + slope * np.maximum(np.abs(phi - np.pi) - 0.01, 0))
    assert np.abs(law**2 - exact).max() < 0.01


def test_poles_of_the_observer() -> None:
    """MATHS.md (52): a double pole to first order, apart by (w T)^1.5 to both sides."""
    w = BANDWIDTH * TICK_S
    poles = np.roots([1, 2 * w + w**2 - 2, 1 - 2 * w])
    assert sorted(poles) == pytest.approx([1 - w - w**1.5, 1 - w + w**1.5], abs=w**2)


@pytest.mark.parametrize(("hz", "within"), [(20, 0.01), (80, 0.01), (200, 0.01), (400, 0.032)])
def test_ripple_that_the_observer_misses(hz: float, within: float) -> None:
    """MATHS.md (53): its exact transfer function beside the formula."""
    w, back = BANDWIDTH * TICK_S, np.exp(-2j * np.pi * hz * TICK_S)
    gain = (w**2 / (1 - back) * back + 2 * w) / (1 - back)  # from the error to the position
    missed = abs((1 - 2 * w) / (1 - 2 * w + gain))
    assert missed == pytest.approx((1 - 2 * w) * hz**2 / (hz**2 + 200**2), rel=within)


def test_axes_are_read_ahead_of_an_accelerating_spindle() -> None:
    """MATHS.md (58): two equal poles bring the parabola back to its place, n ticks ahead."""
    n, lag, alpha, v = 7.0, 30.0, 1e-3, 0.2
    t = np.linspace(0, 2000, 20_001)
    said = v * (t + n + lag) + alpha * t**2 / 2 + alpha * t * (n + lag)
    said += alpha * (n**2 / 2 + n * lag + lag**2 / 4)
    drive = scipy.signal.lsim(([1], [lag**2 / 4, lag, 1]), said, t)[1]
    due = v * (t[-1] + n) + alpha * (t[-1] + n) ** 2 / 2
    assert drive[-1] == pytest.approx(due, abs=1e-3 * alpha * lag**2 / 4)


@pytest.mark.parametrize(
    ("law", "at_3"), [(Disc(35.0, 5.0), 1.046), (Poly345(8.0, float(np.radians(70.0))), 1.005)]
)
def test_envelope_adds_to_the_acceleration(law: LiftLaw, at_3: float) -> None:
    """MATHS.md (62): over three turns 4.6 % of a disc's, and a few places find the largest."""
    f, f1, f2 = (float(np.abs(one).max()) for one in law.evaluate(2 * np.pi * T)[:3])

    def needed(s: Floats, turns: int, n_set_points: int = 1) -> float:
        e, e1 = s**3 * (10 - 15 * s + 6 * s**2), 30 * s**2 * (1 - s) ** 2
        e2, per = np.abs(60 * s * (1 - s) * (1 - 2 * s)), 1 / (2 * np.pi * turns)
        return float((e * f2 + 2 * e1 * per * f1 + n_set_points * e2 * per**2 * f).max())

    assert needed(T, 3) / f2 == pytest.approx(at_3, abs=1e-3)
    places = np.array([0.7, 0.75, 0.8, 0.85, 0.9])
    for turns, n_set_points in ((1, 1), (2, 1), (1, 8), (2, 8), (1, 40)):
        found = max(needed(places, turns, n_set_points), f2)
        assert found > 0.99 * needed(T, turns, n_set_points)


def test_smooth_step_has_its_extremes() -> None:
    """MATHS.md (55): 15/8 in the middle, 10 / sqrt(3) at (3 - sqrt(3)) / 6."""
    s = (3 - np.sqrt(3)) / 6
    slope, bend = 30 * T**2 * (1 - T) ** 2, 60 * T * (1 - T) * (1 - 2 * T)
    assert slope.max() == pytest.approx(15 / 8)
    assert bend.max() == pytest.approx(10 / np.sqrt(3), rel=1e-6)
    assert 60 * s * (1 - s) * (1 - 2 * s) == pytest.approx(10 / np.sqrt(3))
