"""Tables of cams: errors, several lobes, patterns, speeds, refusals, the firmware's evaluation."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError, GeometryError
from camtools.base.quantities import Floats, Ints
from camtools.lobe.channels import (
    N_GRID,
    SpindleLimits,
    choose_angle,
    choose_lift,
    mean_of,
    patterns_of,
    surface_speed,
)
from camtools.lobe.contact import contact, follow
from camtools.lobe.generate import GeneratedLobes, generate_lobes
from camtools.lobe.lift import Disc
from camtools.lobe.motion import ShaftLobe, example_lobe, make_lobes
from camtools.table.channel import KIND_SPEED, KIND_U, MAX_CHANNEL_BYTES
from camtools.table.image import pack, unpack
from tests.tools.cases.cut_cases import PARTS, made_of
from tests.tools.cases.lobe_cases import NM, cam, evaluate
from tests.tools.cases.lobe_tables import DISC
from tests.tools.cases.part_cases import refused, refused_lines

TEXT = (PARTS / "cam-345.toml").read_text()
DISC_TEXT = (PARTS / "cam-disc.toml").read_text()
TEN_MM = TEXT.replace("lift_mm = 8", "lift_mm = 10").replace("= 70", "= 80")


def ground(text: str, speed: str = "constant-surface") -> str:
    """Return the turned cam, ground."""
    return text.replace('"turning"', '"grinding"').replace('"uniform"', f'"{speed}"')


def columns(lines: list[str]) -> Floats:
    """Return a table of worked numbers, shape (columns, rows)."""
    return np.array([[float(word) for word in line.split()] for line in lines]).T


def test_eval_gives_the_ground_disc_of_the_notes(tmp_path: Path) -> None:
    """Golden A: S against the cam angle to 10 nm, and speeds that are N_C at n0 = 60."""
    table = columns(DISC)
    result = made_of("cam-disc").table
    got = evaluate(tmp_path, result, table[4] / 360, np.full(13, 6.0))
    assert got["u_nm"] * NM == pytest.approx(table[3], abs=10e-6)
    assert got["speed_ratio"] * result.mean_rpm == pytest.approx(table[8], rel=1e-6)
    assert result.mean_rpm == pytest.approx(48, abs=1e-6)  # 60 r/min, 2 pi 20 mm to 2 pi 25 mm
    exact = np.degrees(np.arcsin(-5 * np.sin(np.radians(table[4])) / 225))
    assert got["contact_deg"] == pytest.approx(exact, abs=1e-4)
    assert np.all(got["swing_deg"] == 0)
    assert np.all(got["x_nm"] == 220e6)


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


def test_largest_centre_of_a_part_file_is_in_the_firmwares_range(tmp_path: Path) -> None:
    """A wheel as large as the part file takes makes a table that the firmware reads."""
    text = DISC_TEXT.replace("wheel_radius_mm = 200", "wheel_radius_mm = 1970")
    got = evaluate(tmp_path, generate_lobes(cam(text)), np.zeros(1), np.ones(1))
    assert got["x_nm"] == pytest.approx([1990e6])
    with pytest.raises(CamtoolsError, match=r"a table holds 2000 mm; give at most 1970, or a sm"):
        cam(text.replace("1970", "1970.001"))


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
    ("uniform", "u_stroke_mm", 24, 10, "no speed helps: give less lift"),
    pytest.param("constant-surface", "u_speed_mm_s", 400, 40, "", marks=pytest.mark.long),
    ("uniform", "u_acceleration_mm_s2", 20000, 500, ""),
    ("constant-surface", "swing_deg", 30, 15, "no speed helps: give a less steep lift"),
    ("uniform", "swing_speed_deg_s", 1000, 100, ""),
    ("constant-surface", "swing_acceleration_deg_s2", 100_000, 5000, ""),
    ("uniform", "spindle_rpm", 300, 50, ""),
]


@pytest.mark.parametrize(("speed", "name", "limit", "weaker", "remedy"), WEAK)
def test_weak_machine_is_told_the_speed_that_would_do(
    speed: str, name: str, limit: int, weaker: int, remedy: str
) -> None:
    """Refused with needed, limit and highest speed; that speed is accepted then."""
    text = TEXT.replace('"uniform"', f'"{speed}"').replace(
        f"{name} = {limit}", f"{name} = {weaker}"
    )
    lines = refused_lines(lambda: generate_lobes(cam(text)))
    line = next(line for line in lines if line.startswith(f"machine.limits.{name} ="))
    assert "the part needs" in line and (remedy or f"limited by {name}") in line
    if "at most" in line:
        rpm = line.partition("may be at most ")[2].partition(" ")[0]
        before, after = "spindle_rpm = 60\n", f"spindle_rpm = {rpm}\n"
        slower = generate_lobes(cam(text.replace(before, after, 1)))
        assert slower.highest_speed.rpm == pytest.approx(float(rpm), rel=0.02)


GROUND_TEXT = TEXT.replace('"turning"', '"grinding"')
SHARED_BYTES = 65_536
KEPT_OFF_MM = 0.02


def pitched(n: int, width_mm: float, gap_mm: float) -> list[tuple[float, float]]:
    """Return places of lobes of one width, apart by one gap."""
    pitch_mm = width_mm + gap_mm
    return [(round(i * pitch_mm, 6), round(i * pitch_mm + width_mm, 6)) for i in range(n)]


def shaft(text: str, places: list[tuple[float, float]], n_profiles: int = 2) -> str:
    """Return the part with lobes of several profiles at places and angles of their own."""
    start, end = text.index("[[cam.lobe]]"), text.index("[process]")
    lobes = ""
    for i, z_mm in enumerate(places):
        lobe = text[start:end].replace("[0, 12]", str(list(z_mm)))
        lobe = lobe.replace("phase_deg = 0", f"phase_deg = {i * 37.123457 % 360:.6f}")
        lobes += lobe.replace("lift_mm = 8", f"lift_mm = {8 - i % n_profiles * 0.25}")
    return text[:start] + lobes + text[end:].replace("spindle_rpm = 60", "spindle_rpm = 10")


SHAFTS = [
    (pitched(8, 14, 31), 2),
    (pitched(64, 10, 5), 2),
    ([(0, 3), (3.2, 6.2)], 2),
    (pitched(1, 700, 0), 1),
    ([(-300.0, -100.0), (0.0, 100.0), (100.2, 300.0)], 3),
]


def share_of(z_mm: Floats, places: list[tuple[float, float]]) -> tuple[Ints, Floats]:
    """Return the lobe and the share of its lift at heights, by the words of the format."""
    edges = np.array(places)
    middles = (edges[1:, 0] + edges[:-1, 1]) / 2
    i = np.searchsorted(middles, z_mm, side="right")
    beside = np.maximum(edges[i, 0] - z_mm, z_mm - edges[i, 1]) - KEPT_OFF_MM
    between = edges[1:, 0] - edges[:-1, 1]
    gaps = np.concatenate([[np.inf], between, [np.inf]])
    half = np.where(z_mm < edges[i, 0], gaps[i], gaps[i + 1]) / 2 - KEPT_OFF_MM
    s = np.clip(beside / half, 0, 1)
    return i, 1 - s**3 * (10 - 15 * s + 6 * s**2)


def check_lift(result: GeneratedLobes, places: list[tuple[float, float]], folder: Path) -> None:
    """Compare camsim eval with the exact lift on every lobe and between them."""
    edges = np.array(places).ravel()
    heights = np.unique(np.concatenate([edges, np.linspace(edges[0], edges[-1], 301)]))
    turn = np.linspace(0, 1, 73)
    got = evaluate(folder, result, np.tile(turn, heights.size), np.repeat(heights, turn.size))
    i_lobe, share = share_of(np.round(heights, 6), places)
    lift = np.array([lobe.at(2 * np.pi * turn).lift for lobe in result.lobes])
    exact_mm = share[:, None] * lift[i_lobe]
    u_mm = got["u_nm"].reshape(exact_mm.shape) * NM
    assert np.abs(u_mm - exact_mm).max() <= 1.05e-5  # 10 nm, and the height's own rounding
    assert u_mm.min() >= -1e-5 and u_mm.max() <= lift.max() + 1e-5
    angle_deg = np.degrees(np.array([lobe.at(2 * np.pi * turn).angle for lobe in result.lobes]))
    off_deg = got["contact_deg"].reshape(exact_mm.shape) - share[:, None] * angle_deg[i_lobe]
    assert np.abs(off_deg).max() <= 1.05e-4


@pytest.mark.long
@pytest.mark.parametrize("text", [TEXT, GROUND_TEXT], ids=["turned", "ground"])
@pytest.mark.parametrize(("places", "n_profiles"), SHAFTS)
def test_shafts_are_exact_on_every_lobe_and_between(
    places: list[tuple[float, float]], n_profiles: int, text: str, tmp_path: Path
) -> None:
    """Every lobe has its lift; between two the follower goes down to the base circle and up."""
    result = generate_lobes(cam(shaft(text, places, n_profiles)))
    image = pack(result.table)
    if n_profiles <= 2:
        assert len(image) <= SHARED_BYTES
    counts = {one.n_slices for one in result.table.channels if one.has_patterns}
    assert counts == {max(2, n_profiles)}
    check_lift(result, places, tmp_path)


def test_table_of_eight_lobes_holds_two_profiles() -> None:
    """The example part: 8 lobes of 14 mm at a pitch of 45 mm, in at most 64 KiB at 10 nm."""
    result = made_of("camshaft8").table
    assert [lobe.profile for lobe in result.lobes] == [0, 1] * 4
    assert len(pack(result.table)) <= SHARED_BYTES
    assert result.lift.error <= 10


def test_speed_of_each_lobe_goes_to_the_mean_in_the_gap(tmp_path: Path) -> None:
    """The ratio of a lobe is kept while U moves, and is 1 in the middle of the gap."""
    places = pitched(2, 10, 5)
    text = shaft(GROUND_TEXT.replace('"uniform"', '"constant-surface"'), places)
    result = generate_lobes(cam(text.replace("spindle_rpm = 10\n", "spindle_rpm = 60\n", 1)))
    turn = np.linspace(0, 1, 181)
    heights = np.array([5.0, 10.0, 10.6, 11.875, 12.5, 14.4, 15.0])
    got = evaluate(tmp_path, result, np.tile(turn, heights.size), np.repeat(heights, turn.size))
    ratio = got["speed_ratio"].reshape(heights.size, -1)
    lift = got["u_nm"].reshape(heights.size, -1)
    assert np.array_equal(ratio[0], ratio[1])
    assert np.abs(ratio[2] - ratio[0]).max() <= 1e-3 < np.abs(lift[2]).max() * NM
    assert np.abs(lift[3]).max() == 0 and np.abs(ratio[3] - 1).max() > 0.1
    assert np.all(ratio[4] == 1) and np.all(lift[4] == 0)
    assert np.abs(lift[5] - lift[6]).max() * NM > 1


@pytest.mark.long
def test_too_many_profiles_are_told_how_many_would_do() -> None:
    """1 MiB at 2048 knots is 42 patterns; what is asked for is taken."""
    [lobe] = make_lobes(example_lobe())
    lobes = [replace(lobe, z_mm=z_mm, profile=i) for i, z_mm in enumerate(pitched(43, 5, 5))]
    assert refused(lambda: choose_angle(lobes, is_swung=True), GeometryError) == (
        "cam.lobe: has 43 different profiles: the swing channel needs 2048 knots of each, 1056768 "
        "bytes, and may have 1048576; make tables of at most 42 profiles each"
    )
    assert choose_angle(lobes[:42], is_swung=True).channel.size <= MAX_CHANNEL_BYTES


def test_phase_is_part_of_the_error() -> None:
    """A phase is rounded to 2^-32 turn; the error that is told holds what that does to u."""
    lobes = make_lobes(cam(shaft(TEXT, pitched(2, 5, 5), 1)))
    alone: list[ShaftLobe] = patterns_of(lobes)
    shared, bare = choose_lift(lobes, 10.0), choose_lift(alone, 10.0)
    assert shared.error - bare.error == pytest.approx(1.2e7 * 2 * np.pi / 2**33, rel=0.1)


def test_tolerance_out_of_reach_is_refused() -> None:
    """With what is possible; undercut and hollow lobes are those of test_geometry."""
    with pytest.raises(CamtoolsError, match=r"unreachable for u, best .*; ask for at least"):
        generate_lobes(cam(TEXT), 0.01)


def test_mktables_writes_all_files_of_a_cam() -> None:
    """Table, C source, report; the report agrees with the table. A piston has no angle."""
    made = made_of("cam-345")
    assert "swing 19.9674 degrees" in made.text()
    files = made.files(with_plots=False)
    assert sorted(files) == [
        *("cam-345.camtab", "cam-345.json", "cam-345_table.c", "cam-345_table.h")
    ]
    report = json.loads(files["cam-345.json"])
    assert report["feasibility"]["needed"]["swing_deg"] == pytest.approx(19.967381, abs=1e-4)
    assert report["lobes"][0]["least_radius_mm"] == pytest.approx(10.679909, abs=1e-6)
    assert set(report["channels"]) == {"u", "x", "swing"}
    assert made_of("perkins240").table.table.angle is None
