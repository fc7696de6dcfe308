"""Laws of flanks against the handbooks' peaks, and flat-faced followers against their envelope."""

from pathlib import Path

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError, GeometryError
from camtools.base.quantities import Floats
from camtools.cli.mktables import main as mktables
from camtools.lobe.generate import generate_lobes
from camtools.lobe.lift import LiftLaw, Risen
from camtools.lobe.motion import make_lobes
from camtools.lobe.rise_laws import (
    Cycloidal,
    Harmonic,
    ModifiedSine,
    ModifiedTrapezoid,
    Polydyne,
    Quintic,
    RiseLaw,
)
from tests.tools.cases.camsim_cases import camsim
from tests.tools.cases.lobe_cases import NM, cam, evaluate
from tests.tools.cases.part_cases import ROOT

GROUND = (ROOT / "tools" / "parts" / "cam-345-ground.toml").read_text()
GROUND = GROUND.replace('"constant-surface"', '"uniform"')
TURNED = (ROOT / "tools" / "parts" / "cam-345.toml").read_text()
LAW = 'law = "poly345"\nlift_mm = 8\nhalf_angle_deg = 70'
MACHINE = ROOT / "host_sim" / "machines" / "cam.toml"

# Cv, Ca of R. L. Norton, Cam Design and Manufacturing Handbook; of the driven mass of a polydyne
# the slope 630 q^4 and the bend 2520 q^3 (1 - 2 x) of the 4-5-6-7-8-9 polynomial
PEAKS: list[tuple[RiseLaw, float, float]] = [
    (Quintic(), 1.875, 5.773),
    (Cycloidal(), 2.0, 6.283),
    (ModifiedSine(), 1.760, 5.528),
    (ModifiedTrapezoid(), 2.0, 4.888),
    (Harmonic(), 1.571, 4.935),
    (Polydyne(0.0), 2.461, 9.372),
]
STEPS = (Harmonic,)  # whose acceleration steps at the ends


@pytest.mark.parametrize(("law", "speed", "acceleration"), PEAKS)
def test_peaks_are_those_of_the_handbooks(law: RiseLaw, speed: float, acceleration: float) -> None:
    """Largest speed and acceleration of a rise of 1 over 1."""
    at = law.evaluate(np.linspace(0, 1, 200_001))
    assert float(at.d1.max()) == pytest.approx(speed, abs=6e-4)
    assert float(np.abs(at.d2).max()) == pytest.approx(acceleration, abs=6e-4)


@pytest.mark.parametrize(("law", "speed", "acceleration"), PEAKS)
def test_derivatives_and_ends(law: RiseLaw, speed: float, acceleration: float) -> None:
    """Each derivative is that of the one before, and the ends are at rest."""
    h, x = 1e-5, np.linspace(0.01, 0.99, 981) + 3e-4
    low, here, high = (law.evaluate(x + k * h) for k in (-1, 0, 1))
    for n in range(3):
        slope = (high[n] - low[n]) / (2 * h)
        near = np.abs(slope - here[n + 1]) / np.abs(here[n + 1]).max()
        assert np.quantile(near, 0.99) < 1e-6  # a piece may begin between the two places
    ends = law.evaluate(np.array([0.0, 1.0]))
    assert ends.y == pytest.approx([0, 1], abs=1e-12)
    assert ends.d1 == pytest.approx([0, 0], abs=1e-12)
    if not isinstance(law, STEPS):
        assert ends.d2 == pytest.approx([0, 0], abs=1e-9)


def test_polydyne_moves_its_follower_by_the_polynomial() -> None:
    """A mass on a spring, m y'' = k (H - y), moves as was asked for at the speed of the design."""
    rise_rad, rpm, natural_hz = float(np.radians(60)), 1500.0, 150.0
    law = Polydyne((rpm / 60 / natural_hz / rise_rad) ** 2)
    per_s = rpm * 2 * np.pi / 60 / rise_rad
    omega = 2 * np.pi * natural_hz
    dt, y, v = 1e-7, 0.0, 0.0
    times = np.arange(0, 1 / per_s, dt)
    lift = law.evaluate(times * per_s).y
    path = []
    for one in lift:  # symplectic: the mass itself, no polynomial
        v += omega**2 * (one - y) * dt
        y += v * dt
        path.append(y)
    wanted = Polydyne(0.0).evaluate(times * per_s).y
    assert np.abs(np.array(path) - wanted).max() < 1e-4
    rigid = np.abs(lift - wanted).max()
    assert rigid > 0.01


def test_flanks_dwell_and_fall_in_their_places() -> None:
    """The middle of the nose is at angle 0; rise and fall have angles of their own."""
    angles = (np.radians(60), np.radians(20), np.radians(90))
    law = Risen(Cycloidal(), Cycloidal(), 8.0, *map(float, angles))
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


@pytest.mark.parametrize("name", LAWS)
def test_simulator_knows_the_law_from_its_own_equations(name: str, tmp_path: Path) -> None:
    """Table by the generator, gauge by closed forms written apart from it."""
    text = GROUND.replace(LAW, LAWS[name]).replace("base_radius_mm = 20", "base_radius_mm = 30")
    (tmp_path / "c.toml").write_text(text)
    assert mktables([str(tmp_path / "c.toml"), "-o", str(tmp_path)]) == 0
    words = ("--machine", MACHINE, "--feed", "4", "--turns-limit", "1.2")
    done = camsim("run", tmp_path / "cam-345-ground.camtab", *words, "--tolerance-um", "0.1")
    assert done.returncode == 0, done.stdout + done.stderr


def test_harmonic_is_ground_but_not_turned() -> None:
    """Its acceleration steps: a swing would have to jump in speed; a wheel only reports it."""
    harmonic = 'law = "harmonic"\nlift_mm = 6\nhalf_angle_deg = 80'
    wide = GROUND.replace("base_radius_mm = 20", "base_radius_mm = 30").replace(LAW, harmonic)
    result = generate_lobes(cam(wide))
    assert result.lift.error <= 10
    assert 1e-4 < result.angle.error < 0.05
    with pytest.raises(CamtoolsError, match="changes too fast"):
        generate_lobes(cam(TURNED.replace(LAW, harmonic)))
    closed = harmonic.replace("half_angle_deg = 80", "half_angle_deg = 180")
    assert generate_lobes(cam(TURNED.replace(LAW, closed))).angle.error <= 1e-4


REFUSED = [(LAWS["polydyne"].replace("= 250", "= 20"), "would need a lift that falls on its rise")]


@pytest.mark.parametrize(("law", "problem"), REFUSED)
def test_law_that_cannot_be_is_refused(law: str, problem: str) -> None:
    """With the place and a remedy."""
    with pytest.raises(GeometryError, match=problem) as info:
        make_lobes(cam(GROUND.replace(LAW, law)))
    assert "; give" in info.value.lines[0]


FLAT = 'roller_radius_mm = 10\nfollower = "flat"\n'


def flat(text: str) -> str:
    """Return the cam with a flat-faced follower."""
    text = text.replace("roller_radius_mm = 10\n", FLAT).replace(
        "half_angle_deg = 70", "half_angle_deg = 75"
    )
    return text.replace("base_radius_mm = 20", "base_radius_mm = 34")


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


def test_disc_under_a_flat_face_is_a_disc() -> None:
    """Its contacts lie on the circle about its own centre."""
    disc = 'law = "disc"\ndisc_radius_mm = 40\noffset_mm = 6'
    [lobe] = make_lobes(cam(flat(TURNED.replace(LAW, disc))))
    touch, _ = lobe.contacts(np.linspace(-np.pi, np.pi, 361))
    places = touch.radius * np.exp(1j * touch.alpha)
    assert np.abs(places - 6) == pytest.approx(40, abs=1e-9)


def test_curvature_under_a_flat_face_is_checked() -> None:
    """The radius of curvature is r + H + H''; where it is 0 the face rides on edges."""
    with pytest.raises(GeometryError, match=r"undercut at .* under a flat face"):
        make_lobes(cam(TURNED.replace("roller_radius_mm = 10\n", FLAT)))
    [lobe] = make_lobes(cam(flat(TURNED)))
    law = lobe.law.evaluate(np.linspace(-np.pi, np.pi, 100_001))
    least_mm = float((34 + law.lift + law.d2).min())
    assert lobe.shape.least_radius_mm == pytest.approx(least_mm, abs=1e-4)


@pytest.mark.parametrize("text", [TURNED, GROUND], ids=["turned", "ground"])
def test_flat_faced_lobe_is_cut_to_its_drawing(text: str, tmp_path: Path) -> None:
    """The simulator's own envelope of the face."""
    (tmp_path / "c.toml").write_text(flat(text))
    assert mktables([str(tmp_path / "c.toml"), "-o", str(tmp_path)]) == 0
    [table] = tmp_path.glob("*.camtab")
    words = ("--machine", MACHINE, "--feed", "4", "--turns-limit", "1.2")
    done = camsim("run", table, *words, "--tolerance-um", "0.1")
    assert done.returncode == 0, done.stdout + done.stderr
