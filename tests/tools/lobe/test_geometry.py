"""Cams by law: contacts, followers, rise laws, flat faces and heels against other methods."""

from pathlib import Path

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError, GeometryError
from camtools.base.quantities import Floats
from camtools.lobe.contact import (
    Contact,
    Follower,
    all_round,
    check_follower,
    check_wheel,
    contact,
    follow,
    shape_of,
    solved_at,
)
from camtools.lobe.generate import (
    check_lobe_heel,
    generate_lobes,
    nearest_heel,
    needed_clearance_deg,
)
from camtools.lobe.kind import KIND
from camtools.lobe.lift import Disc, LiftLaw, Listed, Poly345, RiseLaw, Risen
from camtools.lobe.list_curve import periodic_spline
from camtools.lobe.motion import ShaftLobe, example_lobe, make_lobes
from camtools.lobe.part import LobePart
from camtools.lobe.summary import emit_lobe_text, make_lobe_summary
from camtools.part.common import SwungTool
from camtools.pipeline.load import Made
from camtools.table.image import pack
from tests.tools.cases.camsim_cases import cut
from tests.tools.cases.cut_cases import PARTS, written
from tests.tools.cases.lobe_cases import MACHINE, NM, QUICK, cam, evaluate, ground_list
from tests.tools.cases.lobe_tables import DISC, POLY345, POLY345_WHEEL
from tests.tools.cases.part_cases import refused

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
    places = [one[0].radius * np.exp(1j * one[0].alpha) for one in (before, behind)]
    way = np.abs(places[1] - places[0]) / (2 * h)
    assert way == pytest.approx(here[1].ds_dphi, rel=1e-6)
    assert here[1].phi == pytest.approx(phi, abs=1e-12)


@pytest.mark.parametrize(("step_deg", "digits"), [(1, 7), (5, 4)])
def test_hollow_flank_has_one_contact_at_each_angle(
    step_deg: int, digits: int, tmp_path: Path
) -> None:
    """Where dphi/dtheta is 0.15 on the flank and 1 at the nose, Newton's method runs in circles."""
    part = cam(ground_list(tmp_path / "a.csv", step_deg, digits, (8, 65)))
    made = generate_lobes(part)
    assert made.lift.error < 1  # nm
    assert len(pack(made.table)) < 100_000
    phi = np.linspace(-np.pi, np.pi, 1 << 16, endpoint=False)
    path = make_lobes(part)[0].at(phi)
    assert np.abs(path.phi - phi).max() <= 1e-12
    steps = np.diff(path.centre)
    assert np.abs(steps - path.d1[:-1] * (phi[1] - phi[0])).max() < 3e-6


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


def test_shapes_that_cannot_be_made_are_refused() -> None:
    """A nose sharper than the roller, a flank more hollow than the wheel; smaller ones do."""
    with pytest.raises(GeometryError, match=r"undercut at .* degrees.*smaller roller"):
        check_follower(all_round(Poly345(8.0, 0.35), BASE_MM, ROLLER_MM), "cam.lobe.0")
    check_follower(all_round(POLY_LAW, BASE_MM, ROLLER_MM), "cam.lobe.0")
    steep = Poly345(8.0, float(np.radians(60)))
    shape = shape_of(steep, BASE_MM, ROLLER_MM)
    assert 50 < shape.hollow_radius_mm < 1000
    touch = all_round(steep, BASE_MM, ROLLER_MM)
    with pytest.raises(GeometryError, match=r"is hollow with a radius of .* does not reach it"):
        check_wheel(touch, shape.hollow_radius_mm * 1.01, "cam.lobe.0")
    check_wheel(touch, shape.hollow_radius_mm * 0.5, "cam.lobe.0")
    assert shape_of(POLY_LAW, BASE_MM, ROLLER_MM).hollow_radius_mm == float("inf")
    check_wheel(all_round(POLY_LAW, BASE_MM, ROLLER_MM), WHEEL_MM, "cam.lobe.0")


TURNED = (PARTS / "cam-345.toml").read_text()
GROUND = (PARTS / "cam-345-ground.toml").read_text().replace('"constant-surface"', '"uniform"')
LAW = 'law = "poly345"\nlift_mm = 8\nhalf_angle_deg = 70'
# Cv, Ca of R. L. Norton, Cam Design and Manufacturing Handbook; of the driven mass of a polydyne
# the slope 630 q^4 and the bend 2520 q^3 (1 - 2 x) of the 4-5-6-7-8-9 polynomial
PEAKS = [
    ("poly345", 1.875, 5.773),
    ("cycloidal", 2.0, 6.283),
    ("modified-sine", 1.760, 5.528),
    ("modified-trapezoid", 2.0, 4.888),
    ("harmonic", 1.571, 4.935),  # the acceleration steps at its ends
    ("polydyne", 2.461, 9.372),
]


@pytest.mark.parametrize(("name", "speed", "acceleration"), PEAKS)
def test_peaks_are_those_of_the_handbooks(name: str, speed: float, acceleration: float) -> None:
    """Of a rise of 1 over 1; each derivative is that of the one before, the ends are at rest."""
    law = RiseLaw(name)
    at = law.evaluate(np.linspace(0, 1, 20_001))
    assert float(at.d1.max()) == pytest.approx(speed, abs=6e-4)
    assert float(np.abs(at.d2).max()) == pytest.approx(acceleration, abs=6e-4)
    h, x = 1e-5, np.linspace(0.01, 0.99, 981) + 3e-4
    low, here, high = (law.evaluate(x + k * h) for k in (-1, 0, 1))
    for n in range(3):
        slope = (high[n] - low[n]) / (2 * h)
        near = np.abs(slope - here[n + 1]) / np.abs(here[n + 1]).max()
        assert np.quantile(near, 0.99) < 1e-6  # a piece may begin between the two places
    ends = law.evaluate(np.array([0.0, 1.0]))
    assert ends.y == pytest.approx([0, 1], abs=1e-12)
    assert ends.d1 == pytest.approx([0, 0], abs=1e-12)
    if name != "harmonic":
        assert ends.d2 == pytest.approx([0, 0], abs=1e-9)


def test_polydyne_moves_its_follower_by_the_polynomial() -> None:
    """A mass on a spring, m y'' = k (H - y), moves as was asked for at the speed of the design."""
    rise_rad, rpm, natural_hz = float(np.radians(60)), 1500.0, 150.0
    law = RiseLaw("polydyne", (rpm / 60 / natural_hz / rise_rad) ** 2)
    per_s = rpm * 2 * np.pi / 60 / rise_rad
    omega = 2 * np.pi * natural_hz
    dt, y, v = 2e-7, 0.0, 0.0
    times = np.arange(0, 1 / per_s, dt)
    lift = law.evaluate(times * per_s).y
    path = []
    for one in lift.tolist():  # symplectic: the mass itself, no polynomial
        v += omega**2 * (one - y) * dt
        y += v * dt
        path.append(y)
    wanted = RiseLaw("polydyne").evaluate(times * per_s).y
    assert np.abs(np.array(path) - wanted).max() < 1e-4
    rigid = np.abs(lift - wanted).max()
    assert rigid > 0.01


def test_flanks_dwell_and_fall_in_their_places() -> None:
    """The middle of the nose is at angle 0; rise and fall have angles of their own."""
    angles = (np.radians(60), np.radians(20), np.radians(90))
    rise = RiseLaw("cycloidal")
    law = Risen(rise, rise, 8.0, *map(float, angles))
    at = law.evaluate(np.radians([-71, -70, -40, -10, 0, 10, 55, 100, 101, 180, 290]))
    half = [0, 0, 4, 8, 8, 8, 4, 0, 0, 0, 0]
    assert at.lift == pytest.approx(half, abs=1e-9)
    assert at.d1[2] > 0 > at.d1[6]
    assert at.d1[2] == pytest.approx(8 * 2 / angles[0])
    assert at.d1[6] == pytest.approx(-8 * 2 / angles[2])


LAWS = {
    "cycloidal": 'law = "cycloidal"\nlift_mm = 6\nrise_deg = 80\ndwell_deg = 15\nfall_deg = 95',
    "modified-sine": 'law = "modified-sine"\nlift_mm = 6\nhalf_angle_deg = 80',
    "modified-trapezoid": 'law = "modified-trapezoid"\nlift_mm = 6\nhalf_angle_deg = 85',
    "polydyne": 'law = "polydyne"\nlift_mm = 6\nrise_deg = 90\nfall_deg = 100\n'
    "design_rpm = 1500\nnatural_hz = 250",
    "poly345": 'law = "poly345"\nlift_mm = 6\nrise_deg = 80\ndwell_deg = 10\nfall_deg = 100',
}
WIDE = GROUND.replace("base_radius_mm = 20", "base_radius_mm = 30")
FLAT = 'roller_radius_mm = 10\nfollower = "flat"\n'


def flat(text: str) -> str:
    """Return the cam with a flat-faced follower."""
    text = text.replace("roller_radius_mm = 10\n", FLAT)
    text = text.replace("half_angle_deg = 70", "half_angle_deg = 75")
    return text.replace("base_radius_mm = 20", "base_radius_mm = 34")


CUT = {name: WIDE.replace(LAW, law) for name, law in LAWS.items()}
CUT |= {"flat, turned": flat(TURNED), "flat, ground": flat(GROUND)}


@pytest.mark.long
@pytest.mark.parametrize("name", CUT)
def test_simulator_knows_the_law_from_its_own_equations(name: str, tmp_path: Path) -> None:
    """Table by the generator, gauge by closed forms and an envelope written apart from it."""
    table = written(Made(KIND, generate_lobes(cam(CUT[name]))), tmp_path)
    words = ("--machine", MACHINE, *QUICK, "--feed", "4", "--turns-limit", "1.2")
    cut(table, *words, "--tolerance-um", "0.1")


def test_law_that_cannot_be_is_refused() -> None:
    """With the place and a remedy."""
    law = LAWS["polydyne"].replace("= 250", "= 20")
    with pytest.raises(GeometryError, match="would need a lift that falls on its rise") as info:
        make_lobes(cam(GROUND.replace(LAW, law)))
    assert "; give" in info.value.lines[0]


def test_harmonic_is_ground_but_not_turned() -> None:
    """Its acceleration steps: a swing would have to jump in speed; a wheel only reports it."""
    harmonic = 'law = "harmonic"\nlift_mm = 6\nhalf_angle_deg = 80'
    result = generate_lobes(cam(WIDE.replace(LAW, harmonic)))
    assert result.lift.error <= 10
    assert 1e-4 < result.angle.error < 0.05
    with pytest.raises(CamtoolsError, match="changes too fast"):
        generate_lobes(cam(TURNED.replace(LAW, harmonic)))
    closed = harmonic.replace("half_angle_deg = 80", "half_angle_deg = 180")
    assert generate_lobes(cam(TURNED.replace(LAW, closed))).angle.error <= 1e-4


def support(points: np.ndarray, alpha_rad: Floats) -> Floats:
    """Return how far a face across each direction stands from the axis, on points of a profile."""
    return np.array([float((points * np.exp(-1j * a)).real.max()) for a in alpha_rad])


@pytest.mark.parametrize("text", [TURNED, GROUND], ids=["turned", "ground"])
def test_flat_face_rests_on_the_profile_at_its_lift(text: str, tmp_path: Path) -> None:
    """The envelope: faces laid on the contacts of camsim eval stand at the lift of the law."""
    result = generate_lobes(cam(flat(text)))
    turn = np.arange(20_000) / 20_000
    got = evaluate(tmp_path, result, turn, np.full(turn.size, 5.0))
    phi, normal = 2 * np.pi * turn, 2 * np.pi * turn - np.radians(got["contact_deg"])
    centre = (got["x_nm"] + got["u_nm"]) * NM * np.exp(1j * phi)
    radius_mm = 10.0 if text is TURNED else 200.0
    contacts = centre - radius_mm * np.exp(1j * normal)
    alpha = np.radians(np.arange(-180, 180, 3.0))
    law: LiftLaw = result.lobes[0].law
    face_mm = support(contacts, alpha)
    # between two contacts a face misses at most 1/8 of radius of curvature times angle squared
    assert face_mm == pytest.approx(34 + law.evaluate(alpha).lift, abs=2e-5)
    radii = np.abs(contacts)
    assert radii.max() == pytest.approx(42, abs=1e-5)
    assert radii.min() == pytest.approx(34, abs=1e-5)


def test_curvature_under_a_flat_face() -> None:
    """A disc stays a disc; the radius is r + H + H'', and where it is 0 the face rides on edges."""
    disc = 'law = "disc"\ndisc_radius_mm = 40\noffset_mm = 6'
    [lobe] = make_lobes(cam(flat(TURNED.replace(LAW, disc))))
    touch, _ = lobe.contacts(np.linspace(-np.pi, np.pi, 361))
    places = touch.radius * np.exp(1j * touch.alpha)
    assert np.abs(places - 6) == pytest.approx(40, abs=1e-9)
    with pytest.raises(GeometryError, match=r"undercut at .* under a flat face"):
        make_lobes(cam(TURNED.replace("roller_radius_mm = 10\n", FLAT)))
    [lobe] = make_lobes(cam(flat(TURNED)))
    law = lobe.law.evaluate(np.linspace(-np.pi, np.pi, 100_001))
    least_mm = float((34 + law.lift + law.d2).min())
    assert lobe.shape.least_radius_mm == pytest.approx(least_mm, abs=1e-4)


def hollow_part(**tables: object) -> LobePart:
    """Return a turned cam whose flanks are hollow: 8 mm of lift within 32 degrees."""
    tree = example_lobe().model_dump(exclude_unset=True)
    tree["cam"]["lobe"][0] |= {"half_angle_deg": 32}
    tree["cam"] |= {"base_radius_mm": 40}
    tree["machine"] = {"limits": {"swing_deg": 60, "swing_acceleration_deg_s2": 1e6}}
    return LobePart.model_validate(tree | tables)


def rubs(lobe: ShaftLobe, clearance_deg: float, heel_mm: float, direction: int) -> bool:
    """Return whether any point of a flank lies inside the lobe, at any of its contacts."""
    touch = all_round(lobe.law, lobe.base_mm, lobe.roller_mm)
    order = np.argsort(np.mod(touch.alpha, 2 * np.pi))
    polar, radius = np.mod(touch.alpha, 2 * np.pi)[order], touch.radius[order]
    alpha, t = np.radians(clearance_deg), np.geomspace(1e-2, heel_mm, 100)
    for i in range(0, touch.theta.size, 160):
        outward = np.exp(1j * (touch.theta[i] - touch.gamma[i]))
        back = -1j * direction * outward
        edge = touch.radius[i] * np.exp(1j * touch.alpha[i])
        flank = edge + t * (np.cos(alpha) * back + np.sin(alpha) * outward)
        work = np.interp(np.mod(np.angle(flank), 2 * np.pi), polar, radius, period=2 * np.pi)
        if (np.abs(flank) < work - 1e-9).any():
            return True
    return False


@pytest.mark.long
@pytest.mark.parametrize(("heel_mm", "direction"), [(1.0, 1), (5.0, -1)])
def test_needed_clearance_against_brute_force(heel_mm: float, direction: int) -> None:
    """A tenth of a degree more clears the hollow flank, a tenth less lies in it."""
    [lobe] = make_lobes(hollow_part())
    assert lobe.shape.hollow_radius_mm < 200
    needed = nearest_heel([lobe], heel_mm, direction).needed_deg
    assert needed > 0.1
    assert not rubs(lobe, needed + 0.1, heel_mm, direction)
    assert rubs(lobe, needed - 0.1, heel_mm, direction)


def test_a_hollow_needs_the_angle_of_its_chord() -> None:
    """A circle touched from inside, as a hollow of 50 mm: asin(heel / 2 R)."""
    turn = np.exp(2j * np.pi * np.arange(20_000) / 20_000)
    needed = needed_clearance_deg(50 * turn[::-1], -turn[::-1], 5.0, 1)
    assert needed.max() == pytest.approx(np.degrees(np.arcsin(5 / 100)), abs=0.01)


def test_the_tool_of_a_hollow_cam_is_refused_with_what_does() -> None:
    """With the angle and with the length of the message the same cam is taken."""
    part = hollow_part(tool={"clearance_deg": 1.0, "heel_mm": 8.0})
    lobes = make_lobes(part)
    line = refused(lambda: generate_lobes(part))
    assert line.startswith("tool.clearance_deg: the heel of 1 degrees rubs on the hollow flank of")
    least_deg = float(line.split("give a tool with at least ")[1].split(",")[0])
    longest_mm = float(line.split("heel_mm at most ")[1])
    assert 0 < longest_mm < 8
    check_lobe_heel(lobes, SwungTool(clearance_deg=least_deg, heel_mm=8), 1)
    check_lobe_heel(lobes, SwungTool(clearance_deg=1.0, heel_mm=longest_mm), 1)
    with pytest.raises(CamtoolsError):
        check_lobe_heel(lobes, SwungTool(clearance_deg=1.0, heel_mm=longest_mm + 0.3), 1)


def test_a_convex_cam_needs_nothing_and_a_wheel_has_no_heel() -> None:
    """What the sections need stands in the report of a turned cam only."""
    assert "mm, required 0.00\n" in emit_lobe_text(
        make_lobe_summary(generate_lobes(example_lobe()))
    )
    ground = example_lobe("grinding").model_dump(exclude_unset=True)
    with pytest.raises(ValueError, match='no meaning for operation = "grinding"'):
        LobePart.model_validate(ground | {"tool": {"clearance_deg": 7}})
