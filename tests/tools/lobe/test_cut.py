"""Cams on the simulator: the profile that wheel and tool leave, the swing, what is refused."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camtools.lobe.contact import contact
from camtools.lobe.generate import generate_lobes
from camtools.lobe.kind import KIND
from camtools.lobe.lift import Poly345
from camtools.pipeline.load import Made
from tests.tools.cases.camsim_cases import ROOT, camsim, cut, only_error, plain, refusal
from tests.tools.cases.cut_cases import PARTS, written
from tests.tools.cases.lobe_cases import MACHINE, QUICK
from tests.tools.cases.lobe_cases import cam as cam_of
from tests.tools.cases.part_cases import TableOf

SHORT = ("--feed", "2", *QUICK)
GROUND = (ROOT / "tools" / "parts" / "cam-345-ground.toml").read_text()


def ground(table: Path, *words: str, status: int = 0) -> dict[str, Any]:
    """Grind a cam; return the summary."""
    return cut(table, "--machine", MACHINE, *words, status=status).summary


def changed(folder: Path, *changes: tuple[str, str], text: str = GROUND) -> Path:
    """Make the table of a cam, by default the ground one, with changes of its part file."""
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return written(Made(KIND, generate_lobes(cam_of(text))), folder)


@pytest.mark.parametrize(
    ("part", "most_um", "words"),
    [("cam-disc", 0.05, SHORT), ("cam-345-ground", 0.15, SHORT[:-1])],
    ids=["disc", "learning"],
)
def test_ground_profile_is_far_within_a_micrometre(
    part: str, most_um: float, words: tuple[str, ...], table_of: TableOf
) -> None:
    """All round and in every turn, measured along the normals; nowhere deeper in any state."""
    found = cut(table_of(part), "--machine", MACHINE, *words)
    summary = found.summary
    form, [lobe] = summary["form_error_um"], summary["cam"]["lobes"]
    assert summary["gauge"]["reference"] == "design"
    assert 0 < form["rms"] <= form["max"] <= most_um
    assert lobe["max_um"] == pytest.approx(form["max"], abs=1e-9)
    assert lobe["samples"] == pytest.approx(3600 * summary["cut"]["turns"], abs=1200)
    assert summary["cut"]["gouge_um"] <= most_um
    assert "removal" not in summary
    if part == "cam-disc":
        return
    # radius over angle is that of the contacts, from other equations than the simulator's
    turn, _, radius_mm, error_nm = plain(found.surface)
    theta = np.radians(np.linspace(-180, 180, 72_001))
    touch = contact(Poly345(8, float(np.radians(70))), 20, 10, theta)
    alpha = np.mod(turn + 0.5, 1) - 0.5
    exact_mm = np.interp(2 * np.pi * alpha, touch.alpha, touch.radius)
    assert np.abs(radius_mm - error_nm * 1e-6 - exact_mm).max() < 5e-5
    assert np.abs(error_nm).max() < 150


@pytest.mark.long
@pytest.mark.parametrize(
    ("changes", "words", "n_samples"),
    [
        ((), ("--feed", "0.8"), [3600 * 3] * 3),
        ((("feed_mm = 1", "feed_mm = 5\ndirection = -1"),), (), [3600 * 2] * 8),
        ((), ("--feed", "2", "--set", "z_is_measured=1"), [3600] * 3),
    ],
    ids=["three lobes of two laws", "eight lobes with M4", "height measured"],
)
def test_each_lobe_is_gauged_by_itself(
    changes: tuple[tuple[str, str], ...],
    words: tuple[str, ...],
    n_samples: list[int],
    tmp_path: Path,
) -> None:
    """Every lobe at its own angle; the change-over touches none and is nowhere too deep.

    The scale of a measured Z has steps of 10 nm, which between two lobes would be many of U.
    """
    name = "camshaft" if len(n_samples) == 3 else "camshaft8"
    table = changed(tmp_path, *changes, text=(PARTS / f"{name}.toml").read_text())
    summary = ground(table, *QUICK, *words)
    lobes = summary["cam"]["lobes"]
    assert len(lobes) == len(n_samples)
    if not changes:
        assert [lobe["z_first_mm"] for lobe in lobes] == [0, 5, 10]
    for lobe, least in zip(lobes, n_samples, strict=True):
        assert lobe["max_um"] <= 0.05
        assert lobe["samples"] >= least
    largest_um = max(lobe["max_um"] for lobe in lobes)
    assert summary["form_error_um"]["max"] == pytest.approx(largest_um, abs=1e-6)
    assert summary["cut"]["gouge_um"] <= 0.05
    assert summary["is_good"]


@pytest.mark.long
def test_surface_speed_is_constant_as_far_as_the_spindle_can(
    table_of: TableOf, tmp_path: Path
) -> None:
    """The disc within the spindle's ripple; the 3-4-5 cam never much above its base circle."""
    disc = ground(table_of("cam-disc"), *SHORT)["cam"]
    speed = disc["surface_speed_mm_s"]
    assert speed["base_circle"] == pytest.approx(60 / 60 * 2 * np.pi * 20, rel=1e-5)
    assert speed["min"] == pytest.approx(speed["base_circle"], rel=0.004)
    assert speed["max"] == pytest.approx(speed["base_circle"], rel=0.004)
    cam = ground(table_of("cam-345-ground"), *SHORT)["cam"]
    speed = cam["surface_speed_mm_s"]
    assert speed["max"] <= 1.03 * speed["base_circle"]
    assert speed["mean"] >= 0.9 * speed["base_circle"]
    assert speed["off_plan_percent"] <= 3.0
    table = changed(tmp_path, ('"constant-surface"', '"uniform"'))
    speed = ground(table, *SHORT)["cam"]["surface_speed_mm_s"]
    assert speed["max"] >= 8 * speed["base_circle"]


def test_gauge_sees_what_the_controller_leaves_out(table_of: TableOf) -> None:
    """Without lead and feed-forward the profile is off by tens of micrometres, and told so."""
    words = ("--no-lead", "--no-feed-forward", "--no-learning", "--turns-limit", "2")
    summary = ground(table_of("cam-345-ground"), *words, status=1)
    assert 30 < summary["form_error_um"]["max"] < 100


@pytest.mark.long
def test_phase_turns_the_cam_on_its_shaft(tmp_path: Path) -> None:
    """The gauge stands still where the drawing has the nose: 5 degrees of phase are millimetres."""
    table = changed(tmp_path, ('law = "poly345"', 'law = "poly345"\nphase_deg = 35'))
    found = cut(table, "--machine", MACHINE, *SHORT)
    assert found.summary["form_error_um"]["max"] <= 0.15
    cells = found.surface
    nose = int(cells["radius_mm"].argmax())
    assert cells["turn"][nose] == pytest.approx(35 / 360, abs=2e-3)
    assert cells["radius_mm"][nose] == pytest.approx(28, abs=1e-3)
    off = ground(table, *SHORT, "--set", "phase_udeg=5000000")
    assert off["form_error_um"]["max"] == pytest.approx(found.form_error_um, abs=0.05)


def test_lobe_that_was_not_cut_all_round_is_not_good(table_of: TableOf) -> None:
    """Three quarters of a turn leave the rest unseen: status 1; the feed that is told is good."""
    table = table_of("camshaft")
    slow = ("--rpm", "20", "--set", "stopped_mrpm=2000")
    words = (table, "--machine", MACHINE, *QUICK, *slow)
    found = cut(*words, "--feed", "4", status=1)
    least = found.summary["cam"]["lobes"][1]["samples"]
    assert 2600 < least < 2800
    assert not found.summary["is_good"]
    told = f"not gauged: lobe 1 has {least} samples of the 3600 of a whole turn; give at most"
    assert found.message == f"{table}: {told} --feed 1.5"
    cut(*words, "--feed", "1.5")


def test_listed_lift_is_gauged_against_its_spline(tmp_path: Path) -> None:
    """Points of a lift, given by list: the report holds the pieces of the spline itself."""
    degrees = np.arange(0, 360, 10)
    lift = ", ".join(f"{mm:.9f}" for mm in 2 - 2 * np.cos(np.radians(degrees)))
    points = f'law = "list"\nangle_deg = {degrees.tolist()}\nlift_mm = [{lift}]'
    old = 'law = "poly345"\nlift_mm = 8\nhalf_angle_deg = 70'
    summary = ground(changed(tmp_path, (old, points)), *SHORT)
    assert summary["form_error_um"]["max"] <= 0.05


def test_turned_profile_and_its_rake(table_of: TableOf) -> None:
    """The swung tool leaves the drawing and stands along its normal; unswung by the pressure angle.

    The bound of the rake is what the swing's drive and the steps of its set-points leave.
    """
    summary = ground(table_of("cam-345"), *SHORT)
    cam = summary["cam"]
    assert summary["form_error_um"]["max"] <= 0.05
    assert summary["cut"]["gouge_um"] <= 0.05
    assert cam["operation"] == "turning" and cam["tip_mm"] == 0.4
    assert -0.02 <= cam["rake_deg"]["min"] < cam["rake_deg"]["max"] <= 0.02
    assert cam["rake_deg"]["without_swing_max"] == pytest.approx(19.967381, abs=0.02)
    assert cam["rake_deg"]["without_swing_min"] == pytest.approx(-19.967381, abs=0.02)


@pytest.mark.parametrize("tip_mm", ["0.05", "10"])
def test_tip_of_any_size_leaves_the_same_profile(tip_mm: str, table_of: TableOf) -> None:
    """Sharp, or as large as the roller itself: the tip touches where the roller does."""
    words = ("--tool-tip-mm", tip_mm, "--turns-limit", "1")
    summary = ground(table_of("cam-345"), *SHORT, *words)
    assert summary["cam"]["tip_mm"] == float(tip_mm)
    assert summary["form_error_um"]["max"] <= 0.05


def test_swing_that_lags_shows_in_the_rake(table_of: TableOf) -> None:
    """Told a millisecond too little of its lag, the tool is off by its speed times that.

    A tip of the roller's radius stays where it is; the contact of a smaller one moves along, and
    with it the normal.
    """
    good = ground(table_of("cam-345"), *SHORT, "--turns-limit", "1")
    lag_ns = good["parameters"]["swing_lag_ns"]
    words = ("--set", f"swing_lag_ns={lag_ns - 1_000_000}", "--tool-tip-mm", "10")
    cam = ground(table_of("cam-345"), *SHORT, *words)["cam"]
    report = json.loads(table_of("cam-345").with_suffix(".json").read_text())
    speed_deg_s = report["feasibility"]["needed"]["swing_speed_deg_s"]
    largest = max(-cam["rake_deg"]["min"], cam["rake_deg"]["max"])
    assert largest == pytest.approx(speed_deg_s * 1e-3, rel=0.05)


OPTIONS = [
    ("cam-disc", "--removal", "r.csv", "leave it out"),
    ("cam-disc", "--tool-tip-mm", "1", "leave it out"),
    ("cam-disc", "--nose-mm", "0.8", "leave it out"),
    ("cam-345", "--tool-tip-mm", "10.5", " 10.5: larger than the roller; give at most 10"),
    ("perkins240", "--tool-tip-mm", "1", "leave it out"),
    ("perkins240", "--tool-tip-mm", "0", "out of range"),
]


@pytest.mark.parametrize(("part", "name", "value", "told"), OPTIONS)
def test_option_without_a_meaning_is_refused(
    part: str, name: str, value: str, told: str, table_of: TableOf
) -> None:
    """What a ground cam, or a skirt, has not is not passed over."""
    machine = () if part == "perkins240" else ("--machine", MACHINE)
    line = refusal(table_of(part), *machine, name, value)
    assert name in line and told in line


def test_feed_beyond_the_height_names_the_feed(tmp_path: Path) -> None:
    """No speed would help."""
    text = (PARTS / "cam-disc.toml").read_text()
    table = changed(tmp_path, ("z_mm = [0, 12]", "z_mm = [0, 5]"), text=text)
    line = refusal(table, "--machine", MACHINE, "--feed", "10")
    assert line.startswith("--feed 10: infeasible:") and "at most --feed 5" in line


def test_bus_has_no_gauge_for_cams(table_of: TableOf) -> None:
    """The machine on a bus gauges skirts only, and says so before it opens the bus."""
    line = only_error(camsim("bus", table_of("cam-disc"), "--can", "none0", "--gpiochip", "none0"))
    assert "the bus cannot gauge" in line and "camsim run" in line
