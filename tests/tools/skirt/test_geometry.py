"""Profile, ovality and motion against the worked numbers of MATHS.md (6) .. (9)."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from camtools.base.errors import GeometryError
from camtools.skirt.geometry.profile import ovality_spline, profile_spline
from camtools.skirt.geometry.sections import DoubleEllipse, Ellipse, Section
from camtools.skirt.geometry.skirt_geometry import Geometry, OvalSurface, make_geometry
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.part.profile_keys import Ovality, Profile
from camtools.skirt.tool.turning import turning_at
from tests.tools.cases.part_cases import PERKINS, load_part

HEIGHTS = [5.0, 15.0, 25.0, 35.0, 45.0, 56.0]
MOMENTS = (
    "-1.436120e-04 -1.518917e-04 -1.488211e-04 -1.528239e-04 "
    "-1.398831e-04 -1.576435e-04 -1.429044e-04"
)
V240_HEIGHT = [0.0, 20, 50, 80, 110, 140, 170, 190, 210]
V240_DIAMETER = [239.30, 239.36, 239.42, 239.44, 239.42, 239.36, 239.25, 239.15, 239.03]
V240_OVALITY = [0.30, 0.30, 0.32, 0.34, 0.39, 0.44, 0.51, 0.56, 0.60]
V240_SPLINES = [
    (20, "239.360000", "0.300000"),
    (65, "239.435104", "0.327837"),
    (125, "239.395657", "0.414238"),
    (190, "239.150000", "0.560000"),
]
# n, G, f Hz, v, acc, jerk of the cosine form; v, acc at 0, acc at 90 of the ellipse (a = 46)
PEAKS = """
650 0.2 21.6667 6.80678 926.646 126150 6.80680 929.677 -923.627
650 0.3 21.6667 10.21018 1389.969 189224 10.21023 1396.798 -1383.178
650 0.38 21.6667 12.93289 1760.628 239684 12.93300 1771.596 -1749.735
800 0.2 26.6667 8.37758 1403.677 235188 8.37760 1408.268 -1399.103
800 0.3 26.6667 12.56637 2105.516 352783 12.56644 2115.859 -2095.228
800 0.38 26.6667 15.91740 2666.986 446858 15.91754 2683.602 -2650.485
1500 0.2 50.0000 15.70796 4934.802 1.55031e+06 15.70800 4950.941 -4918.722
1500 0.3 50.0000 23.56194 7402.203 2.32547e+06 23.56207 7438.568 -7366.036
1500 0.38 50.0000 29.84513 9376.124 2.9456e+06 29.84539 9434.537 -9318.113
2500 0.2 83.3333 26.17994 13707.784 7.17738e+06 26.18000 13752.613 -13663.117
2500 0.3 83.3333 39.26991 20561.676 1.07661e+07 39.27012 20662.688 -20461.212
2500 0.38 83.3333 49.74188 26044.789 1.3637e+07 49.74231 26207.047 -25883.647
""".strip().splitlines()


def test_spline_values_are_golden(geometry: Geometry) -> None:
    """a(z) between the nodes has the printed values."""
    printed = "45.983096898 45.998129455 45.998135281 45.983079419 45.953359542 45.903454932"
    assert [f"{mm:.9f}" for mm in geometry.radius_mm(HEIGHTS)] == printed.split()


def test_spline_slopes_are_golden(geometry: Geometry) -> None:
    """a'(z) has the printed values, and the end slopes are the part's."""
    printed = "0.002253450 0.000748721 -0.000748332 -0.002255392 -0.003692600 -0.005382370"
    assert [f"{slope:.9f}" for slope in geometry.radius_mm(HEIGHTS, 1)] == printed.split()
    ends = geometry.radius_mm([0.0, 62.0], 1)
    np.testing.assert_allclose(ends, [0.0029818594, -0.0062619048], atol=1e-15)


def test_spline_moments_are_golden(geometry: Geometry, perkins: SkirtPart) -> None:
    """a''(z) at the nodes has the printed values; the part's slopes are rounded ones."""
    z = np.asarray(perkins.piston.profile.height_mm, dtype=float)
    curve = (91.737 - 92.0) / 2 / (62 - 20) ** 2  # of the parabola about height 20
    tree = perkins.piston.profile.model_dump()
    unrounded = Profile.model_validate(tree | {"end_slopes": [-40 * curve, 84 * curve]})
    moments = profile_spline(unrounded)(z, nu=2)
    assert [f"{moment:.6e}" for moment in moments] == MOMENTS.split()
    np.testing.assert_allclose(geometry.radius_mm(z, 2), moments, atol=1e-11)


def test_spline_moments_solve_the_equations(geometry: Geometry, perkins: SkirtPart) -> None:
    """a''(z) at the nodes satisfies the moment equations of a clamped spline."""
    z = np.asarray(perkins.piston.profile.height_mm, dtype=float)
    moments = geometry.radius_mm(z, 2)
    h, d = np.diff(z), np.diff(geometry.radius_mm(z)) / np.diff(z)
    lam = h[1:] / (h[:-1] + h[1:])
    left = (1 - lam) * moments[:-2] + 2 * moments[1:-1] + lam * moments[2:]
    np.testing.assert_allclose(left, 6 * np.diff(d) / (h[:-1] + h[1:]), rtol=1e-9)
    first = 6 * (d[0] - 0.0029818594) / h[0]
    assert 2 * moments[0] + moments[1] == pytest.approx(first, rel=1e-9)


def test_largest_diameter_stays_at_20_mm(geometry: Geometry) -> None:
    """The maximum of a(z) lies at z = 20.005220 and is 46.000000002028 mm."""
    (top,) = geometry.radius.derivative().solve(0, extrapolate=False)
    assert f"{top:.6f}" == "20.005220"
    assert f"{float(geometry.radius_mm(float(top))):.12f}" == "46.000000002028"


def test_linear_ovality_is_golden(geometry: Geometry) -> None:
    """G(5) = 0.1625 and G(41) = 0.25."""
    np.testing.assert_allclose(geometry.ovality_mm([5.0, 41.0]), [0.1625, 0.25], atol=1e-15)


@pytest.mark.parametrize(("z_mm", "diameter", "ovality"), V240_SPLINES)
def test_not_a_knot_splines_are_golden(z_mm: float, diameter: str, ovality: str) -> None:
    """The 16V240ZJ-like skirt has the printed diameters and ovalities."""
    profile = Profile(height_mm=V240_HEIGHT, diameter_mm=V240_DIAMETER)
    oval = Ovality(height_mm=V240_HEIGHT, ovality_mm=V240_OVALITY, interpolation="spline")
    assert f"{2 * float(profile_spline(profile)(z_mm)):.6f}" == diameter
    assert f"{float(ovality_spline(oval)(z_mm)):.6f}" == ovality


def test_natural_spline_has_no_end_moments() -> None:
    """A natural spline is straight at its ends and agrees with a library spline of diameters."""
    profile = Profile(height_mm=V240_HEIGHT, diameter_mm=V240_DIAMETER, spline="natural")
    spline = profile_spline(profile)
    np.testing.assert_allclose(spline([0, 210], nu=2), 0, atol=1e-15)
    whole = CubicSpline(np.array(V240_HEIGHT), V240_DIAMETER, bc_type="natural")
    np.testing.assert_allclose(2 * spline(65), whole(65), rtol=1e-14)


@pytest.mark.parametrize("n_points", [2, 3, 4])
def test_few_ovality_points_still_make_a_spline(n_points: int) -> None:
    """Two points give a line, three a parabola, four a cubic."""
    z = np.arange(n_points) * 10.0
    ovality = Ovality(
        height_mm=z.tolist(),
        ovality_mm=((z / 10) ** (n_points - 1)).tolist(),
        interpolation="spline",
    )
    assert float(ovality_spline(ovality)(7.0)) == pytest.approx(0.7 ** (n_points - 1))


@pytest.mark.parametrize("row", PEAKS)
def test_motion_peaks_are_golden(row: str) -> None:
    """Frequency, velocity, acceleration and jerk of U have the printed peaks."""
    n, g, f, v, acc, jerk, exact_v, acc_0, acc_90 = row.split()
    turns = np.linspace(0, 1, 180_001)
    flat = make_flat(float(g))
    cosine = turning_at(flat["cosine"], float(n), 0.0, turns)
    exact = turning_at(flat["ellipse"], float(n), 0.0, turns)
    assert f"{2 * float(n) / 60:.4f}" == f
    assert f"{cosine.velocity_mm_s.max():.5f}" == v
    assert f"{cosine.acceleration_mm_s2.max():.3f}" == acc
    assert f"{cosine.jerk_mm_s3.max():.6g}" == jerk
    assert f"{exact.velocity_mm_s.max():.5f}" == exact_v
    assert f"{exact.acceleration_mm_s2[0]:.3f}" == acc_0
    assert f"{exact.acceleration_mm_s2[45_000]:.3f}" == acc_90


def make_flat(g_mm: float) -> dict[str, Geometry]:
    """Return cylinders of a = 46 mm with constant ovality, ellipse and cosine form."""
    radius = profile_spline(Profile(height_mm=[0, 10], diameter_mm=[92, 92]))
    ovality = ovality_spline(Ovality(height_mm=[0, 10], ovality_mm=[g_mm, g_mm]))
    laws: dict[str, Section] = {"ellipse": Ellipse(), "cosine": DoubleEllipse()}
    return {
        name: Geometry(radius, ovality, OvalSurface(law, radius, ovality), 0.0, 10.0)
        for name, law in laws.items()
    }


def test_velocity_is_the_derivative_of_u() -> None:
    """Differences of U over time agree with the velocity, and of velocity with acceleration."""
    turns = np.linspace(0, 1, 20_001)
    motion = turning_at(make_flat(0.3)["ellipse"], 2500.0, 0.0, turns)
    dt = 60 / 2500 / 20_000
    middle = slice(1, -1)
    speed, rate = np.gradient(motion.u_mm, dt), np.gradient(motion.velocity_mm_s, dt)
    np.testing.assert_allclose(speed[middle], motion.velocity_mm_s[middle], atol=1e-4)
    np.testing.assert_allclose(rate[middle], motion.acceleration_mm_s2[middle], atol=1e-2)


def test_axes_along_a_helix_are_profile_and_section(geometry: Geometry) -> None:
    """At the height of each turn X is the profile there, and U the section there."""
    turns = np.array([0.0, 0.25, 200.0, 620.0])
    motion = turning_at(geometry, 2500.0, 0.1 * turns, turns)
    np.testing.assert_allclose(motion.x_mm[[0, 2, 3]], [45.97, 46.0, 45.8685])
    np.testing.assert_allclose(motion.u_mm[[0, 1]], [0, 0.15 / 2 + 0.025 * 0.0025 / 2], atol=1e-12)


def test_magnified_part_has_the_papers_numbers() -> None:
    """Enlarged 30 times, the long axis at 62 mm is 84.11 mm and the ovality 9 mm."""
    geometry = make_geometry(load_part(PERKINS.with_name("perkins240_x30.toml")))
    assert 2 * float(geometry.radius_mm(62.0)) == pytest.approx(84.11, abs=1e-12)
    assert float(geometry.ovality_mm(62.0)) == pytest.approx(9.0, abs=1e-12)
    assert 2 * float(geometry.radius_mm(20.0)) == pytest.approx(92.0, abs=1e-12)


def test_ovality_alone_may_be_magnified(perkins: SkirtPart) -> None:
    """The other reading of the demonstration: ovality 9 mm at 62 mm, the diameter as drawn."""
    magnify = {"factor": 30.0, "of": "ovality"}
    part = SkirtPart.model_validate(perkins.model_dump() | {"magnify": magnify})
    geometry = make_geometry(part)
    assert 2 * float(geometry.radius_mm(62.0)) == pytest.approx(91.737, abs=1e-12)
    assert float(geometry.ovality_mm(62.0)) == pytest.approx(9.0, abs=1e-12)
    short_mm = float(geometry.radius_mm(62.0) - geometry.delta(np.pi / 2, 62.0).delta)
    assert short_mm == pytest.approx(91.737 / 2 - 4.5, abs=1e-12)
    assert part.magnify is not None
    assert part.magnify.words == "ovality enlarged 30 times"


def _changed(part: SkirtPart, **piston: object) -> SkirtPart:
    tree = part.model_dump()
    tree["piston"] |= piston
    return SkirtPart.model_validate(tree)


def test_overshooting_ovality_spline_is_refused(perkins: SkirtPart) -> None:
    """A spline that would fall below zero between its points is refused, naming the field."""
    steep = {"height_mm": [0, 20, 30, 62], "ovality_mm": [0.3, 0.0, 0.0, 0.3]}
    part = _changed(perkins, ovality={**steep, "interpolation": "spline"})
    with pytest.raises(GeometryError, match=r"piston\.ovality\.interpolation.*falls to -") as info:
        make_geometry(part)
    assert info.value.field == "piston.ovality.interpolation"


def test_magnifying_below_zero_is_refused(perkins: SkirtPart) -> None:
    """A factor that turns the piston inside out is refused, naming the factor."""
    part = SkirtPart.model_validate(perkins.model_dump() | {"magnify": {"factor": 1000.0}})
    with pytest.raises(GeometryError, match=r"magnify\.factor.*half axis"):
        make_geometry(part)
