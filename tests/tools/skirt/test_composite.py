"""Ellipse and eccentric circle against the worked numbers of MATHS.md (10) .. (13)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from camtools.skirt.geometry.composite import Joint, fold
from camtools.skirt.geometry.sections import DoubleEllipse, Ellipse
from camtools.skirt.geometry.skirt_geometry import make_geometry
from tests.tools.cases.part_cases import ROOT, load_part

JOINT_RAD = float(np.radians(48.0))
DIAMETER_MM = 90.929096914
PAPER = Joint(DIAMETER_MM / 2, 0.38, 0.4, JOINT_RAD)
OMEGA = 2 * np.pi * 800 / 60

ECCENTRICITIES = [
    (90, "1.960772379", "46.370772379"),
    (91, "1.959941734", "46.869941734"),
    (92, "1.959129964", "47.369129964"),
    (100, "1.953244550", "51.363244550"),
    (105, "1.950039560", "53.860039560"),
    (110, "1.947136890", "56.357136890"),
    (116, "1.943995747", "59.353995747"),
    (126, "1.939447022", "64.349447022"),
]
DIAMETERS = [  # eccentricity, trim, joint deg, printed diameter
    (1.955, 0.4, 48.0, "97.47"),
    (1.965, 0.4, 48.0, "85.25"),
    (1.96, 0.395, 48.0, "70.88"),
    (1.96, 0.405, 48.0, "125.97"),
    (1.96, 0.4, 47.5, "59.43"),
    (1.96, 0.4, 48.5, "192.84"),
]
V240 = [  # height, diameter, ovality, e, R, delta(70), delta(90)
    "20 239.360000 0.300000 1.34676318 120.62676318 0.31965970 0.40000000",
    "65 239.435104 0.327837 1.37183704 120.67547093 0.33209859 0.41391835",
    "125 239.395657 0.414238 1.44973810 120.69044762 0.37070779 0.45711915",
    "190 239.150000 0.560000 1.58137810 120.62637810 0.43584380 0.53000000",
]
MEASURED = [  # angle, G = 0.35, G = 0.38, in um
    (10, "-5.277", "-5.729"),
    (20, "-20.471", "-22.226"),
    (30, "-43.750", "-47.500"),
    (40, "-72.306", "-78.503"),
    (48, "-96.646", "-104.930"),
]


@pytest.mark.parametrize(("diameter_mm", "eccentricity", "radius"), ECCENTRICITIES)
def test_circle_is_the_printed_one(diameter_mm: float, eccentricity: str, radius: str) -> None:
    """Eccentricity and radius follow from diameter, ovality, trim and joint by MATHS.md (11)."""
    arc = Joint(diameter_mm / 2, 0.38, 0.4, JOINT_RAD).arc()
    assert (f"{arc.eccentricity_mm:.9f}", f"{arc.radius_mm:.9f}") == (eccentricity, radius)


def diameter_for(trim_mm: float, joint_rad: float, e_mm: float) -> float:
    """Return the diameter that goes with an eccentricity at G = 0.38, MATHS.md (12)."""
    sine = float(np.sin(joint_rad))
    d, short = 0.19 * sine**2, 0.19 + trim_mm
    q = short - d
    return (q * (d + short) - 2 * e_mm * (short - d * sine)) / (q - e_mm * (1 - sine))


@pytest.mark.parametrize(("eccentricity_mm", "trim_mm", "joint_deg", "diameter"), DIAMETERS)
def test_diameter_from_the_others_is_ill_conditioned(
    eccentricity_mm: float, trim_mm: float, joint_deg: float, diameter: str
) -> None:
    """Micrometres of eccentricity move the diameter by millimetres, MATHS.md (12)."""
    found = diameter_for(trim_mm, float(np.radians(joint_deg)), eccentricity_mm)
    assert f"{found:.2f}" == diameter


def test_papers_numbers_fit_one_diameter_only() -> None:
    """G, h, joint and e as printed make the section continuous at one diameter."""
    assert f"{diameter_for(0.4, JOINT_RAD, 1.96):.9f}" == "90.929096914"
    assert f"{float(PAPER.arc().radius_mm):.9f}" == "46.834548457"


def test_exact_ellipse_fits_another_diameter() -> None:
    """With the exact ellipse the printed eccentricity needs D = 89.4243."""
    arc = Joint(89.4243 / 2, 0.38, 0.4, JOINT_RAD, Ellipse()).arc()
    assert float(arc.eccentricity_mm) == pytest.approx(1.96, abs=5e-8)


def test_forced_diameter_leaves_a_step() -> None:
    """D = 126 with e = 1.96: the reduction of the arc is 5.005 um too small at the joint."""
    step_mm = float(Joint(63.0, 0.38, 0.4, JOINT_RAD).step_mm(1.96))
    assert f"{step_mm * 1000:.3f}" == "-5.005"


def test_both_branches_at_the_joint() -> None:
    """Reduction, slopes, curvatures, velocities and their jump at the joint, 800 r/min."""
    oval = PAPER.law.evaluate(JOINT_RAD, DIAMETER_MM / 2, 0.38)
    circle = PAPER.arc().reduction(JOINT_RAD, DIAMETER_MM / 2)
    assert [f"{float(one.delta):.9f}" for one in (oval, circle)] == ["0.104930204"] * 2
    assert f"{float(oval.d1):.9f} {float(circle.d1):.9f}" == "0.188959160 1.270692199"
    assert f"{float(oval.d2):.6f} {float(circle.d2):.6f}" == "-0.039721 -1.447951"
    speeds = f"{float(oval.d1) * OMEGA:.4f} {float(circle.d1) * OMEGA:.4f}"
    assert speeds == "15.8302 106.4533"
    assert f"{float(PAPER.corner_mm_rad()) * OMEGA:.5f}" == "90.62306"
    bends = f"{float(oval.d2) * OMEGA**2:.2f} {float(circle.d2) * OMEGA**2:.2f}"
    assert bends == "-278.78 -10162.28"
    assert float(PAPER.reduction(np.pi / 2).delta) == pytest.approx(0.59, abs=1e-13)


def test_large_bore_sections() -> None:
    """Sections of the 16V240ZJ-like part between and at its nodes."""
    corner = make_geometry(load_part(ROOT / "tools" / "parts" / "16v240zj.toml")).corner
    assert corner is not None
    for row in V240:
        z_mm = float(row.split()[0])
        joint = corner.joint(z_mm)
        arc, delta = joint.arc(), joint.reduction(np.radians([70.0, 90.0])).delta
        assert row == (
            f"{z_mm:.0f} {2 * joint.a_mm:.6f} {joint.ovality_mm:.6f} {arc.eccentricity_mm:.8f} "
            f"{arc.radius_mm:.8f} {delta[0]:.8f} {delta[1]:.8f}"
        )


@pytest.mark.parametrize(("angle_deg", "milder", "printed"), MEASURED)
def test_measured_piston_has_less_ovality(angle_deg: float, milder: str, printed: str) -> None:
    """The paper's measured design column is that of G = 0.35, not of its theory part."""
    law = DoubleEllipse(0.0)
    found = [
        float(-1000 * law.evaluate(np.radians(angle_deg), 45.0, g_mm).delta)
        for g_mm in (0.35, 0.38)
    ]
    assert [f"{um:.3f}" for um in found] == [milder, printed]


def test_ovality_that_fits_the_measured_piston() -> None:
    """Least squares G = 0.35025, rounding allows 0.34947 .. 0.35049; no beta repairs 0.38."""
    design_um = np.array([5, 20, 44, 72, 97])
    shape = np.sin(np.radians([10, 20, 30, 40, 48])) ** 2 / 2
    assert f"{float(design_um @ shape / (shape @ shape)) / 1000:.5f}" == "0.35025"
    low, high = (design_um - 0.5) / shape / 1000, (design_um + 0.5) / shape / 1000
    assert f"{low.max():.5f} {high.min():.5f}" == "0.34947 0.35049"
    extra = 0.38 / 4 / 25 * (1 - np.cos(4 * np.radians(48)))
    beta = (0.097 - 0.38 * shape[-1]) / extra
    assert f"{beta:.2f}" == "-1.05"
    at_30 = 1000 * float(DoubleEllipse(beta).evaluate(np.radians(30), 45.0, 0.38).delta)
    assert f"{at_30:.1f}" == "41.5"


joints = st.builds(
    lambda a, g, h, deg, is_exact: Joint(
        a, g, h, float(np.radians(deg)), Ellipse() if is_exact else DoubleEllipse(0.0)
    ),
    st.floats(30, 200),
    st.floats(0.05, 0.8),
    st.floats(0.02, 0.5),
    st.floats(35, 60),
    st.booleans(),
)


@given(joints)
def test_contour_is_continuous_and_two_fold(joint: Joint) -> None:
    """No step at the joint; the quadrants are mirror images; every trim makes a corner."""
    theta = float(joint.joint_rad)
    left, right = joint.reduction(np.array([theta - 1e-9, theta])).delta
    assert right - left == pytest.approx(0, abs=1e-8)
    phi = np.linspace(0, np.pi / 2, 50)
    quadrants = [joint.reduction(turned).delta for turned in (phi, np.pi - phi, np.pi + phi, -phi)]
    for other in quadrants[1:]:
        np.testing.assert_allclose(other, quadrants[0], atol=1e-12)
    assert float(joint.corner_mm_rad()) > 0


@given(joints)
def test_derivatives_are_those_of_the_reduction(joint: Joint) -> None:
    """Differences of each derivative agree with the next one, away from the joint."""
    phi = np.radians(np.arange(61, 120, 3.0))
    step = 1e-5
    below, here, above = (joint.reduction(phi + k * step) for k in (-1, 0, 1))
    for order in range(3):
        slope = (above[order] - below[order]) / (2 * step)
        np.testing.assert_allclose(slope, here[order + 1], atol=2e-6, rtol=1e-6)


@given(joints)
def test_trim_follows_from_the_eccentricity(joint: Joint) -> None:
    """The closed form for the trim, MATHS.md (12), inverts that for the eccentricity."""
    a, ovality = float(joint.a_mm), float(joint.ovality_mm)
    e, sine = float(joint.arc().eccentricity_mm), float(np.sin(joint.joint_rad))
    p = a - float(joint.law.evaluate(joint.joint_rad, a, ovality).delta)
    found = a - ovality / 2 + e - float(np.sqrt(e * e + p * p + 2 * e * p * sine))
    assert found == pytest.approx(float(joint.trim_mm), abs=1e-9)


def test_fold_keeps_the_first_quadrant() -> None:
    """Angles of the first quadrant are theirs already."""
    phi = np.radians([0.0, 30.0, 90.0])
    folded, sign = fold(phi)
    np.testing.assert_array_equal(folded, phi)
    np.testing.assert_array_equal(sign, 1.0)
