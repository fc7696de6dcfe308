# SPDX-License-Identifier: Apache-2.0
"""Cams on the simulator: the profile that the wheel leaves, lobe by lobe, and what is refused."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camtools.cli.mktables import main as mktables
from camtools.lobe.contact import contact
from camtools.lobe.lift import Poly345
from tests.tools.cases.camsim_cases import ROOT, camsim, columns_of, only_error

MACHINE = ROOT / "host_sim" / "machines" / "cam.toml"
SHORT = ("--feed", "2", "--set", "engage_turns=1", "--set", "disengage_turns=1")
GROUND = (ROOT / "tools" / "parts" / "cam-345-ground.toml").read_text()


def ground(table: Path, *words: str | Path, out: Path, status: int = 0) -> dict[str, Any]:
    """Grind a cam; return the summary."""
    done = camsim("run", table, "--machine", MACHINE, "--summary", out, *words)
    assert done.returncode == status, done.stderr
    summary: dict[str, Any] = json.loads(out.read_text())
    return summary


def changed(folder: Path, name: str, *changes: tuple[str, str]) -> Path:
    """Make the table of the ground cam with changes of its part file."""
    text = GROUND.replace('name = "cam-345-ground"', f'name = "{name}"')
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    part = folder / f"{name}.toml"
    part.write_text(text)
    assert mktables([str(part), "-o", str(folder)]) == 0
    return folder / f"{name}.camtab"


@pytest.mark.parametrize(("part", "most_um"), [("cam-disc", 0.05), ("cam-345-ground", 0.15)])
def test_ground_profile_is_far_within_a_micrometre(
    part: str, most_um: float, table_of: Callable[[str], Path], tmp_path: Path
) -> None:
    """All round and in every turn, measured along the normals; nowhere deeper in any state."""
    summary = ground(table_of(part), *SHORT, out=tmp_path / "s.json")
    form, [lobe] = summary["form_error_um"], summary["cam"]["lobes"]
    assert summary["gauge"]["reference"] == "design"
    assert 0 < form["rms"] <= form["max"] <= most_um
    assert lobe["max_um"] == pytest.approx(form["max"], abs=1e-9)
    assert lobe["samples"] == pytest.approx(3600 * summary["cut"]["turns"], abs=1200)
    assert summary["cut"]["gouge_um"] <= most_um
    assert "removal" not in summary


def test_surface_speed_is_constant_as_far_as_the_spindle_can(
    table_of: Callable[[str], Path], tmp_path: Path
) -> None:
    """The disc within the spindle's ripple; the 3-4-5 cam never much above its base circle."""
    disc = ground(table_of("cam-disc"), *SHORT, out=tmp_path / "d.json")["cam"]
    speed = disc["surface_speed_mm_s"]
    assert speed["base_circle"] == pytest.approx(60 / 60 * 2 * np.pi * 20, rel=1e-5)
    assert speed["min"] == pytest.approx(speed["base_circle"], rel=0.004)
    assert speed["max"] == pytest.approx(speed["base_circle"], rel=0.004)
    cam = ground(table_of("cam-345-ground"), *SHORT, out=tmp_path / "c.json")["cam"]
    speed = cam["surface_speed_mm_s"]
    assert speed["max"] <= 1.03 * speed["base_circle"]
    assert speed["mean"] >= 0.9 * speed["base_circle"]
    assert speed["off_plan_percent"] <= 3.0
    table = changed(tmp_path, "uniform", ('"constant-surface"', '"uniform"'))
    speed = ground(table, *SHORT, out=tmp_path / "u.json")["cam"]["surface_speed_mm_s"]
    assert speed["max"] >= 8 * speed["base_circle"]


def test_gauge_sees_what_the_controller_leaves_out(
    table_of: Callable[[str], Path], tmp_path: Path
) -> None:
    """Without lead and feed-forward the profile is off by tens of micrometres, and told so."""
    words = ("--no-lead", "--no-feed-forward", "--turns-limit", "2")
    summary = ground(table_of("cam-345-ground"), *words, out=tmp_path / "s.json", status=1)
    assert 30 < summary["form_error_um"]["max"] < 100


def test_phase_turns_the_cam_on_its_shaft(tmp_path: Path) -> None:
    """The gauge stands still where the drawing has the nose: 5 degrees of phase are millimetres."""
    table = changed(tmp_path, "phased", ('law = "poly345"', 'law = "poly345"\nphase_deg = 35'))
    surface = tmp_path / "surface.csv"
    summary = ground(table, *SHORT, "--surface", surface, out=tmp_path / "s.json")
    assert summary["form_error_um"]["max"] <= 0.15
    cells = columns_of(surface)
    nose = int(cells["radius_mm"].argmax())
    assert cells["turn"][nose] == pytest.approx(35 / 360, abs=2e-3)
    assert cells["radius_mm"][nose] == pytest.approx(28, abs=1e-3)
    off = ground(table, *SHORT, "--set", "phase_udeg=5000000", out=tmp_path / "p.json")
    assert off["form_error_um"]["max"] == pytest.approx(summary["form_error_um"]["max"], abs=0.05)


def test_surface_file_holds_the_profile(table_of: Callable[[str], Path], tmp_path: Path) -> None:
    """Radius over angle is that of the contacts, from other equations than the simulator's."""
    surface = tmp_path / "surface.csv"
    ground(table_of("cam-345-ground"), *SHORT, "--surface", surface, out=tmp_path / "s.json")
    turn, _, radius_mm, error_nm = columns_of(surface).values()
    theta = np.radians(np.linspace(-180, 180, 72_001))
    touch = contact(Poly345(8, float(np.radians(70))), 20, 10, theta)
    alpha = np.mod(turn + 0.5, 1) - 0.5
    exact_mm = np.interp(2 * np.pi * alpha, touch.alpha, touch.radius)
    assert np.abs(radius_mm - error_nm * 1e-6 - exact_mm).max() < 5e-5
    assert np.abs(error_nm).max() < 150


def test_each_lobe_is_gauged_by_itself(table_of: Callable[[str], Path], tmp_path: Path) -> None:
    """Three lobes of two laws in one go; the change-over touches none of them."""
    words = ("--feed", "0.2", "--set", "engage_turns=1", "--set", "disengage_turns=1")
    summary = ground(table_of("camshaft"), *words, out=tmp_path / "s.json")
    lobes = summary["cam"]["lobes"]
    assert [lobe["z_first_mm"] for lobe in lobes] == [0, 5, 10]
    for lobe in lobes:
        assert lobe["max_um"] <= 0.05
        assert lobe["samples"] >= 3600 * 14
    largest_um = max(lobe["max_um"] for lobe in lobes)
    assert summary["form_error_um"]["max"] == pytest.approx(largest_um, abs=1e-6)
    assert summary["cut"]["gouge_um"] <= 0.05


def test_eight_lobes_of_two_profiles(tmp_path: Path) -> None:
    """Every lobe at its own angle, with M4; nothing is cut below the base circle between."""
    text = (ROOT / "tools" / "parts" / "camshaft8.toml").read_text()
    part = tmp_path / "camshaft8.toml"
    part.write_text(text.replace("feed_mm = 1", "feed_mm = 2\ndirection = -1"))
    assert mktables([str(part), "-o", str(tmp_path)]) == 0
    summary = ground(tmp_path / "camshaft8.camtab", out=tmp_path / "s.json")
    lobes = summary["cam"]["lobes"]
    assert len(lobes) == 8
    for lobe in lobes:
        assert lobe["max_um"] <= 0.05
        assert lobe["samples"] >= 3600 * 6
    assert summary["cut"]["gouge_um"] <= 0.05
    assert summary["is_good"]


@pytest.mark.parametrize("feed_mm", ["0.2", "2"])
def test_shaft_is_cut_at_a_measured_height(
    feed_mm: str, table_of: Callable[[str], Path], tmp_path: Path
) -> None:
    """The scale of Z has steps of 10 nm, which between two lobes would be many of U."""
    words = ("--feed", feed_mm, "--set", "z_is_measured=1")
    summary = ground(table_of("camshaft"), *words, out=tmp_path / "s.json")
    assert [lobe["max_um"] <= 0.05 for lobe in summary["cam"]["lobes"]] == [True] * 3
    assert summary["cut"]["gouge_um"] <= 0.05


def test_lobe_that_was_not_cut_all_round_is_not_good(
    table_of: Callable[[str], Path], tmp_path: Path
) -> None:
    """Three quarters of a turn leave the rest unseen: status 1; the feed that is told is good."""
    table = table_of("camshaft")
    slow = ("--rpm", "12", "--set", "stopped_mrpm=2000")
    words = ("run", table, "--machine", MACHINE, *SHORT[2:], *slow)
    done = camsim(*words, "--feed", "4", "--summary", tmp_path / "s.json")
    summary = json.loads((tmp_path / "s.json").read_text())
    least = summary["cam"]["lobes"][1]["samples"]
    assert 2600 < least < 2800
    assert (done.returncode, summary["is_good"]) == (1, False)
    told = f"not gauged: lobe 1 has {least} samples of the 3600 of a whole turn; give at most"
    assert done.stderr == f"camsim: {table}: {told} --feed 1.5\n"
    assert camsim(*words, "--feed", "1.5").returncode == 0


def test_listed_lift_is_gauged_against_its_spline(tmp_path: Path) -> None:
    """Points of a lift, given by list: the report holds the pieces of the spline itself."""
    degrees = np.arange(0, 360, 10)
    lift = ", ".join(f"{mm:.9f}" for mm in 2 - 2 * np.cos(np.radians(degrees)))
    points = f'law = "list"\nangle_deg = {degrees.tolist()}\nlift_mm = [{lift}]'
    old = 'law = "poly345"\nlift_mm = 8\nhalf_angle_deg = 70'
    summary = ground(changed(tmp_path, "listed", (old, points)), *SHORT, out=tmp_path / "s.json")
    assert summary["form_error_um"]["max"] <= 0.05


def test_turned_profile_and_its_rake(table_of: Callable[[str], Path], tmp_path: Path) -> None:
    """The swung tool leaves the drawing and stands along its normal; unswung by the pressure angle.

    The bound of the rake is what the swing's drive and the steps of its set-points leave.
    """
    summary = ground(table_of("cam-345"), *SHORT, out=tmp_path / "s.json")
    cam = summary["cam"]
    assert summary["form_error_um"]["max"] <= 0.05
    assert summary["cut"]["gouge_um"] <= 0.05
    assert cam["operation"] == "turning" and cam["tip_mm"] == 0.4
    assert -0.02 <= cam["rake_deg"]["min"] < cam["rake_deg"]["max"] <= 0.02
    assert cam["rake_deg"]["without_swing_max"] == pytest.approx(19.967381, abs=0.02)
    assert cam["rake_deg"]["without_swing_min"] == pytest.approx(-19.967381, abs=0.02)


@pytest.mark.parametrize("tip_mm", ["0.05", "10"])
def test_tip_of_any_size_leaves_the_same_profile(
    tip_mm: str, table_of: Callable[[str], Path], tmp_path: Path
) -> None:
    """Sharp, or as large as the roller itself: the tip touches where the roller does."""
    words = ("--tool-tip-mm", tip_mm, "--turns-limit", "1")
    summary = ground(table_of("cam-345"), *SHORT, *words, out=tmp_path / "s.json")
    assert summary["cam"]["tip_mm"] == float(tip_mm)
    assert summary["form_error_um"]["max"] <= 0.05


def test_swing_that_lags_shows_in_the_rake(table_of: Callable[[str], Path], tmp_path: Path) -> None:
    """Told a millisecond too little of its lag, the tool is off by its speed times that.

    A tip of the roller's radius stays where it is; the contact of a smaller one moves along, and
    with it the normal.
    """
    good = ground(table_of("cam-345"), *SHORT, "--turns-limit", "1", out=tmp_path / "a.json")
    lag_ns = good["parameters"]["swing_lag_ns"]
    words = ("--set", f"swing_lag_ns={lag_ns - 1_000_000}", "--tool-tip-mm", "10")
    cam = ground(table_of("cam-345"), *SHORT, *words, out=tmp_path / "b.json")["cam"]
    report = json.loads(table_of("cam-345").with_suffix(".json").read_text())
    speed_deg_s = report["feasibility"]["needed"]["swing_speed_deg_s"]
    largest = max(-cam["rake_deg"]["min"], cam["rake_deg"]["max"])
    assert largest == pytest.approx(speed_deg_s * 1e-3, rel=0.05)


def test_tip_larger_than_the_roller_is_refused(table_of: Callable[[str], Path]) -> None:
    """It would reach beyond the swing's centre."""
    words = ("--machine", MACHINE, "--tool-tip-mm", "10.5")
    line = only_error(camsim("run", table_of("cam-345"), *words))
    assert "--tool-tip-mm 10.5: larger than the roller; give at most 10" in line


def test_cam_without_its_report_has_no_profile(
    table_of: Callable[[str], Path], tmp_path: Path
) -> None:
    """Only U can be compared with the table then, and a warning tells; nor does another report."""
    table = tmp_path / "lonely.camtab"
    table.write_bytes(table_of("cam-disc").read_bytes())
    words = (*SHORT, "--turns-limit", "1", "--summary", tmp_path / "s.json")
    done = camsim("run", table, "--machine", MACHINE, *words)
    assert done.returncode == 0, done.stderr
    assert "lonely.json: missing, so the gauge compares with the table itself" in done.stderr
    summary = json.loads((tmp_path / "s.json").read_text())
    assert summary["gauge"]["reference"] == "table"
    assert "cam" not in summary and "removal" not in summary
    other = table_of("cam-345-ground").with_suffix(".json")
    line = only_error(camsim("run", table, "--machine", MACHINE, "--design", other))
    assert "belongs to another table" in line


@pytest.mark.parametrize(
    ("key", "value", "named"),
    [
        ("lobes", [], "design.lobes"),
        ("base_mm", 0, "design.base_mm"),
        ("roller_mm", 1e300, "design.roller_mm"),
        ("operation", "milling", 'design.operation = "milling"'),
        ("operation", "turning", "table and design disagree"),
    ],
)
def test_bad_report_is_refused_by_field(
    key: str, value: object, named: str, table_of: Callable[[str], Path], tmp_path: Path
) -> None:
    """A report that was spoilt is refused, and nothing is written."""
    table = table_of("cam-disc")
    report = json.loads(table.with_suffix(".json").read_text())
    report["design"][key] = value
    (tmp_path / "bad.json").write_text(json.dumps(report))
    words = ("--design", tmp_path / "bad.json", "--summary", tmp_path / "s.json")
    assert named in only_error(camsim("run", table, "--machine", MACHINE, *words))
    assert not (tmp_path / "s.json").exists()


@pytest.mark.parametrize(
    "option", [("--removal", "r.csv"), ("--tool-tip-mm", "1"), ("--nose-mm", "0.8")]
)
def test_option_without_a_meaning_is_refused(
    option: tuple[str, str], table_of: Callable[[str], Path], tmp_path: Path
) -> None:
    """What a ground cam has not is not passed over in silence."""
    name, value = option
    word = str(tmp_path / value) if value.endswith("csv") else value
    line = only_error(camsim("run", table_of("cam-disc"), "--machine", MACHINE, name, word))
    assert name in line and "leave it out" in line
    assert list(tmp_path.iterdir()) == []


def test_tip_belongs_to_turned_cams_only(table_of: Callable[[str], Path]) -> None:
    """A skirt has no swung tool either."""
    line = only_error(camsim("run", table_of("perkins240"), "--tool-tip-mm", "1"))
    assert "--tool-tip-mm" in line and "leave it out" in line
    line = only_error(camsim("run", table_of("perkins240"), "--tool-tip-mm", "0"))
    assert "out of range" in line


def test_feed_beyond_the_height_names_the_feed(tmp_path: Path) -> None:
    """No speed would help."""
    text = (
        (ROOT / "tools" / "parts" / "cam-disc.toml")
        .read_text()
        .replace("z_mm = [0, 12]", "z_mm = [0, 5]")
    )
    (tmp_path / "cam-disc.toml").write_text(text)
    assert mktables([str(tmp_path / "cam-disc.toml"), "-o", str(tmp_path)]) == 0
    words = ("--machine", MACHINE, "--feed", "10")
    line = only_error(camsim("run", tmp_path / "cam-disc.camtab", *words))
    assert line.startswith("camsim: --feed 10: infeasible:") and "at most --feed 5" in line


def test_speed_that_counts_as_stopped_is_not_recommended(tmp_path: Path) -> None:
    """Of the two remedies only the feed is left, and works; where less counts, the speed, too."""
    text = (ROOT / "tools" / "parts" / "camshaft.toml").read_text()
    text = text.replace("[5, 8]", "[3.2, 6.2]").replace("[10, 13]", "[6.4, 40]")
    text = text.replace("u_acceleration_mm_s2 = 20000", "u_acceleration_mm_s2 = 3500")
    text = text.replace("u_speed_mm_s = 400", "u_speed_mm_s = 2000")
    (tmp_path / "camshaft.toml").write_text(text)
    assert mktables([str(tmp_path / "camshaft.toml"), "-o", str(tmp_path)]) == 0
    fast = ("--set", "u_speed_um_per_s=2000000")
    words = ("run", tmp_path / "camshaft.camtab", "--machine", MACHINE, *SHORT[2:], *fast)
    line = only_error(camsim(*words, "--feed", "5"))
    found = re.search(r"mm/s2; give at most --feed (\S+)$", line)
    assert found, line
    done = camsim(*words, "--feed", found[1], "--turns-limit", "1")
    assert done.returncode == 0, done.stderr
    slow = ("--feed", "5", "--set", "stopped_mrpm=2000")
    line = only_error(camsim(*words, *slow))
    found = re.search(r"mm/s2; give at most --rpm (\S+) or --feed \S+$", line)
    assert found, line
    done = camsim(*words, *slow, "--rpm", found[1], "--turns-limit", "1")
    assert done.returncode == 0, done.stderr


def test_spindle_that_counts_as_stopped_is_refused_before_motion(tmp_path: Path) -> None:
    """A slow cam ground at constant surface speed: what the line tells instead is cut."""
    text = (ROOT / "tools" / "parts" / "cam-345-ground.toml").read_text()
    text = re.sub(r"(?m)^spindle_rpm = 60\b", "spindle_rpm = 20", text)
    (tmp_path / "slow.toml").write_text(text)
    assert mktables([str(tmp_path / "slow.toml"), "-o", str(tmp_path)]) == 0
    words = ("run", tmp_path / "cam-345-ground.camtab", "--machine", MACHINE, "--turns-limit", "1")
    line = only_error(camsim(*words))
    told = "--rpm 18.26: in a turn it falls to 2.262, and for 172 ms below 5 (stopped_mrpm), which "
    told += "is a fault after 100 ms (stopped_ms); make the table for a faster spindle, or "
    assert line == f"camsim: {told}--set stopped_mrpm=2262"
    assert camsim(*words, "--set", "stopped_mrpm=2262").returncode == 0
    line = only_error(camsim(*words, "--rpm", "4"))
    assert "--rpm 4: below 5 (stopped_mrpm) the spindle counts as stopped; " in line


def test_bus_has_no_gauge_for_cams(table_of: Callable[[str], Path]) -> None:
    """The machine on a bus gauges skirts only, and says so before it opens the bus."""
    line = only_error(camsim("bus", table_of("cam-disc"), "--can", "none0", "--gpiochip", "none0"))
    assert "the bus cannot gauge" in line and "camsim run" in line
