"""Tables of cams: errors, several lobes, speeds, refusals, and the firmware's own evaluation."""

import json
from pathlib import Path

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.lobe.contact import contact, follow
from camtools.lobe.generate import generate_lobes
from camtools.lobe.lift import Disc, LiftLaw, Poly345
from camtools.lobe.motion import example_lobe, make_lobes
from camtools.lobe.part import LobePart
from camtools.lobe.speed import N_GRID, SpindleLimits, mean_of, surface_speed
from camtools.pipeline.load import load
from camtools.skirt.table.generate import generate
from camtools.table.channel import KIND_SPEED, KIND_U
from camtools.table.image import pack, unpack
from tests.tools.cases.lobe_cases import NM, cam, evaluate
from tests.tools.cases.lobe_tables import DISC, POLY345, POLY345_WHEEL
from tests.tools.cases.part_cases import PERKINS, ROOT, Command, load_part

PARTS = ROOT / "tools" / "parts"
TEXT = (PARTS / "cam-345.toml").read_text()
DISC_TEXT = (PARTS / "cam-disc.toml").read_text()
TEN_MM = TEXT.replace("lift_mm = 8", "lift_mm = 10").replace("= 70", "= 80")


def ground(text: str, speed: str = "constant-surface") -> str:
    """Return the turned cam, ground."""
    return text.replace('"turning"', '"grinding"').replace('"uniform"', f'"{speed}"')


def columns(lines: list[str]) -> Floats:
    """Return a table of worked numbers, shape (columns, rows)."""
    return np.array([[float(word) for word in line.split()] for line in lines]).T


def test_eval_gives_the_turned_cam_of_the_notes(tmp_path: Path) -> None:
    """Golden B: lift to 10 nm, swing to 1e-4 degrees, in the firmware's own evaluation."""
    theta, lift, swing = columns(POLY345)[:3]
    result = generate_lobes(cam(TEXT))
    got = evaluate(tmp_path, result, theta / 360, np.full(theta.size, 5.0))
    assert got["u_nm"] * NM == pytest.approx(lift, abs=10e-6)
    assert got["swing_deg"] == pytest.approx(swing, abs=1e-4)
    assert np.all(got["speed_ratio"] == 1)
    assert np.all(got["x_nm"] == 30e6)
    assert np.array_equal(got["contact_deg"], got["swing_deg"])


def test_eval_gives_the_ground_disc_of_the_notes(tmp_path: Path) -> None:
    """Golden A: S against the cam angle to 10 nm, and speeds that are N_C at n0 = 60."""
    table = columns(DISC)
    part = load(PARTS / "cam-disc.toml").part
    assert isinstance(part, LobePart)
    result = generate_lobes(part)
    got = evaluate(tmp_path, result, table[4] / 360, np.full(13, 6.0))
    assert got["u_nm"] * NM == pytest.approx(table[3], abs=10e-6)
    assert got["speed_ratio"] * result.mean_rpm == pytest.approx(table[8], rel=1e-6)
    assert result.mean_rpm == pytest.approx(48, abs=1e-6)  # 60 r/min, 2 pi 20 mm to 2 pi 25 mm
    exact = np.degrees(np.arcsin(-5 * np.sin(np.radians(table[4])) / 225))
    assert got["contact_deg"] == pytest.approx(exact, abs=1e-4)
    assert np.all(got["swing_deg"] == 0)
    assert np.all(got["x_nm"] == 220e6)


def test_eval_gives_the_ground_poly345_of_the_notes(tmp_path: Path) -> None:
    """Golden B ground: S at the printed cam angles, speeds where the spindle can follow them."""
    _, s_mm, phi, _, n_c = columns(POLY345_WHEEL)
    text = ground(TEXT).replace("spindle_acceleration_rad_s2 = 60", "spindle_torque_nm = 5e4")
    result = generate_lobes(cam(text + "spindle_inertia_kgm2 = 0.1\n"))
    got = evaluate(tmp_path, result, phi / 360, np.full(phi.size, 6.0))
    assert got["u_nm"] * NM == pytest.approx(s_mm, abs=20e-6)  # phi is printed to 1e-6 degrees
    speed = got["speed_ratio"] * result.mean_rpm
    assert np.all(speed <= n_c * 1.02)  # the law has a corner at the nose
    assert speed[8:11:2] == pytest.approx(n_c[8:11:2], rel=1e-4)
    assert speed[[0, 1, -2, -1]] == pytest.approx([60] * 4, rel=2e-3)


@pytest.mark.parametrize("text", [TEN_MM, ground(TEN_MM), ground(TEN_MM, "uniform")])
def test_cam_of_10_mm_is_within_its_tolerances(text: str, tmp_path: Path) -> None:
    """Judge lift (10 nm) and angle (1e-4 degrees) on random points, many turns out."""
    part = cam(text)
    result, [lobe] = generate_lobes(part), make_lobes(part)
    assert result.lift.error <= 10
    assert result.angle.error <= 1e-4
    rng = np.random.default_rng(9)
    turn, z_mm = rng.uniform(-9, 9, 5000), rng.uniform(0, 12, 5000)
    got, exact = evaluate(tmp_path, result, turn, z_mm), lobe.at(2 * np.pi * np.mod(turn, 1.0))
    assert np.abs(got["u_nm"] - exact.lift / NM).max() <= 10
    assert np.abs(got["contact_deg"] - np.degrees(exact.angle)).max() <= 1e-4
    for column, exact_column in (("u1_nm_per_rad", exact.d1), ("u2_nm_per_rad2", exact.d2)):
        peak = np.abs(exact_column / NM).max()
        assert np.abs(got[column] - exact_column / NM).max() <= 0.01 * peak
    assert np.all(got["clamped"] == 0)
    table = unpack(pack(result.table))
    assert table.bounds.u_max_nm >= 0
    assert table.bounds.u_min_nm <= -10_000_000


def test_lobes_keep_their_phases_and_places(tmp_path: Path) -> None:
    """Three lobes of two laws: each is exact on all of its height, at its phase."""
    disc = 'z_mm = [16, 24]\nphase_deg = 120\nlaw = "disc"\ndisc_radius_mm = 24\noffset_mm = 4\n'
    third = 'z_mm = [28, 40]\nphase_deg = -95\nlaw = "poly345"\nlift_mm = 6\nhalf_angle_deg = 90\n'
    more = f"[[cam.lobe]]\n{disc}\n[[cam.lobe]]\n{third}\n[process]"
    result = generate_lobes(cam(TEXT.replace("[process]", more)))
    turn = np.linspace(0, 1, 401)
    laws: tuple[tuple[int, LiftLaw], ...] = (
        (0, Poly345(8, np.radians(70))),
        (120, Disc(34, 4)),
        (-95, Poly345(6, np.pi / 2)),
    )
    for (phase, law), heights in zip(laws, ((0, 12), (16, 20, 24), (28, 40)), strict=True):
        exact = contact(law, 20, 10, 2 * np.pi * turn - np.radians(phase))
        for z_mm in heights:
            got = evaluate(tmp_path, result, turn, np.full(401, float(z_mm)))
            assert np.abs(got["u_nm"] - exact.lift / NM).max() <= 10
            assert np.abs(got["swing_deg"] - np.degrees(exact.gamma)).max() <= 1e-4


def test_largest_centre_of_a_part_file_is_in_the_firmwares_range(tmp_path: Path) -> None:
    """A wheel as large as the part file takes makes a table that the firmware reads."""
    text = DISC_TEXT.replace("wheel_radius_mm = 200", "wheel_radius_mm = 1970")
    got = evaluate(tmp_path, generate_lobes(cam(text)), np.zeros(1), np.ones(1))
    assert got["x_nm"] == pytest.approx([1990e6])
    with pytest.raises(CamtoolsError, match=r"a table holds 2000 mm; give at most 1970, or a sm"):
        cam(text.replace("1970", "1970.001"))


def test_listed_cam_is_that_of_its_law(tmp_path: Path) -> None:
    """Points of the disc, a CSV file beside the part, ground with a phase: the disc's solution."""
    angle_deg = np.arange(0, 360, 5.0)
    lift = np.maximum(Disc(35, 5).evaluate(np.radians(angle_deg)).lift, 0)
    rows = "".join(f"{a!r},{h!r}\n" for a, h in zip(angle_deg.tolist(), lift.tolist(), strict=True))
    (tmp_path / "lift.csv").write_text("angle_deg,lift_mm\n" + rows)
    law = 'law = "disc"\ndisc_radius_mm = 25\noffset_mm = 5\n'
    text = DISC_TEXT.replace(law, 'law = "list"\ncsv = "lift.csv"\n')
    text = text.replace("phase_deg = 0", "phase_deg = 90")
    (tmp_path / "c.toml").write_text(text)
    part = load(tmp_path / "c.toml").part
    assert isinstance(part, LobePart)
    turn = np.linspace(0, 1, 361)
    got = evaluate(tmp_path, generate_lobes(part), turn, np.full(361, 1.0))
    phi = 2 * np.pi * turn - np.pi / 2
    exact = 5 * np.cos(phi) + np.sqrt(225**2 - 25 * np.sin(phi) ** 2) - 220
    assert np.abs(got["u_nm"] * NM - exact).max() <= 12e-6  # 1 nm of it is the spline's


def test_surface_speed_is_constant_where_the_spindle_can() -> None:
    """With a strong spindle the way per time is that of the base circle all round."""
    touch = contact(Disc(35, 5), 20, 10, 2 * np.pi * np.arange(N_GRID) / N_GRID)
    path = follow(touch, 10)
    law = surface_speed(path.ds_dphi, 20, 6.0, SpindleLimits(1e5, 1e3))
    assert law * path.ds_dphi == pytest.approx(120, rel=1e-6)
    capped = surface_speed(path.ds_dphi, 20, 6.0, SpindleLimits(1e5, 4.5))
    assert capped.max() <= 4.5


@pytest.mark.parametrize("alpha", [2.0, 20.0, 200.0])
def test_surface_speed_keeps_the_spindles_acceleration(alpha: float) -> None:
    """A weak spindle is never faster than the constant-speed law, and never beyond its limit."""
    lobe = make_lobes(example_lobe("grinding"))[0]
    path = lobe.at(2 * np.pi * np.arange(N_GRID, dtype=float) / N_GRID)
    wanted = 2 * np.pi * 20 / path.ds_dphi
    law = surface_speed(path.ds_dphi, 20, 2 * np.pi, SpindleLimits(alpha, 1e3))
    acceleration = np.diff(np.append(law, law[0]) ** 2 / 2) / (2 * np.pi / N_GRID)
    assert np.abs(acceleration).max() <= alpha
    assert (law / wanted).max() <= 1.02  # where averages cut a corner
    assert mean_of(law) < mean_of(wanted) * 1.001
    at_slowest = int(np.argmin(wanted))
    assert law[at_slowest] == pytest.approx(wanted[at_slowest], rel=0.02)


def test_modulated_table_keeps_the_machines_limits() -> None:
    """The header's promises of a constant-surface table are within the machine's limits."""
    result = generate_lobes(cam(ground(TEXT)))
    omega = result.mean_rpm * 2 * np.pi / 60
    assert result.peaks.spindle_rad2 * omega**2 <= 60
    assert result.table.bounds.spindle_peak_ppm_per_rad <= 10_000_000
    speed = result.table.channel(KIND_SPEED)
    assert speed.p_max / 2**speed.frac_bits + speed.value_offset <= 4 * 2**20
    assert result.table.channel(KIND_U).knots.shape[0] == 2
    assert result.mean_rpm < 60  # the flanks are longer than the base circle


WEAK = [
    ("uniform", "u_stroke_mm = 24", "u_stroke_mm = 10", "no speed helps: give less lift"),
    ("constant-surface", "u_speed_mm_s = 400", "u_speed_mm_s = 40", "limited by u_speed_mm_s"),
    (
        "uniform",
        "u_acceleration_mm_s2 = 20000",
        "u_acceleration_mm_s2 = 500",
        "limited by u_acceleration_mm_s2",
    ),
    (
        "constant-surface",
        "swing_deg = 30",
        "swing_deg = 15",
        "no speed helps: give a less steep lift",
    ),
    (
        "uniform",
        "swing_speed_deg_s = 1000",
        "swing_speed_deg_s = 100",
        "limited by swing_speed_deg_s",
    ),
    (
        "constant-surface",
        "swing_acceleration_deg_s2 = 100000",
        "swing_acceleration_deg_s2 = 5000",
        "limited by swing_acceleration_deg_s2",
    ),
    ("uniform", "spindle_rpm = 300", "spindle_rpm = 50", "limited by spindle_rpm"),
]


@pytest.mark.parametrize(("speed", "limit", "weaker", "remedy"), WEAK)
def test_weak_machine_is_told_the_speed_that_would_do(
    speed: str, limit: str, weaker: str, remedy: str
) -> None:
    """Refused with needed, limit and highest speed; that speed is accepted then."""
    text = TEXT.replace('"uniform"', f'"{speed}"').replace(limit, weaker)
    with pytest.raises(CamtoolsError) as info:
        generate_lobes(cam(text))
    name = weaker.partition(" ")[0]
    line = next(line for line in info.value.lines if line.startswith(f"machine.limits.{name} ="))
    assert "the part needs" in line
    assert remedy in line
    if "at most" in line:
        rpm = line.partition("may be at most ")[2].partition(" ")[0]
        before, after = "spindle_rpm = 60\n", f"spindle_rpm = {rpm}\n"
        slower = generate_lobes(cam(text.replace(before, after, 1)))
        assert slower.highest_speed.rpm == pytest.approx(float(rpm), rel=0.02)


def test_what_cannot_be_made_is_refused(mktables: Command, tmp_path: Path) -> None:
    """Undercut lobes, hollow flanks for the wheel, tolerances out of reach: status 2, one line."""
    cases = {
        "undercut": (TEXT.replace("= 70", "= 20"), [], "cam.lobe.0.lift_mm: undercut at"),
        "hollow": (ground(TEXT.replace("= 70", "= 60")), [], "is hollow with a radius of"),
        "tight": (TEXT, ["--tolerance-nm", "0.01"], "unreachable for u"),
        "csv": (
            TEXT.replace(
                'law = "poly345"\nlift_mm = 8\nhalf_angle_deg = 70', 'law = "list"\ncsv = "no"'
            ),
            [],
            "cam.lobe.0.csv: no: cannot be read",
        ),
    }
    for name, (text, words, problem) in cases.items():
        path = tmp_path / f"{name}.toml"
        path.write_text(text)
        done = mktables(path, "-o", tmp_path / "out", *words)
        assert done.returncode == 2
        assert problem in done.stderr, done.stderr
        assert "; " in done.stderr
    assert not (tmp_path / "out").exists()


def test_mktables_writes_all_files_of_a_cam(mktables: Command, tmp_path: Path) -> None:
    """Table, C source, report; the report agrees with the table."""
    part = PARTS / "cam-345.toml"
    done = mktables(part, "-o", tmp_path / "one")
    assert done.returncode == 0, done.stderr
    assert "swing 19.9674 degrees" in done.stdout
    names = sorted(path.name for path in (tmp_path / "one").iterdir())
    assert names == ["cam-345.camtab", "cam-345.json", "cam-345_table.c", "cam-345_table.h"]
    report = json.loads((tmp_path / "one" / "cam-345.json").read_text())
    assert report["feasibility"]["needed"]["swing_deg"] == pytest.approx(19.967381, abs=1e-4)
    assert report["lobes"][0]["least_radius_mm"] == pytest.approx(10.679909, abs=1e-6)
    assert set(report["channels"]) == {"u", "x", "swing"}


def test_piston_tables_have_no_angle() -> None:
    """What is no cam has neither of its channels."""
    assert generate(load_part(PERKINS)).table.angle is None
