"""Cams on the simulator: the profile that wheel and tool leave, the swing, what is refused."""

import json
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from camtools.lobe.contact import contact
from camtools.lobe.generate import generate_lobes
from camtools.lobe.kind import KIND
from camtools.lobe.lift import Poly345
from camtools.pipeline.load import Made
from camtools.sim.binding import Rows
from tests.tools.cases.camsim_cases import ROOT, camsim, cut, only_error, plain, refusal, while_in
from tests.tools.cases.cut_cases import PARTS, evaluated, made_of, written
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


def test_cam_without_its_report_has_no_profile(table_of: TableOf, tmp_path: Path) -> None:
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
    line = refusal(table, "--machine", MACHINE, "--design", other)
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
    key: str, value: object, named: str, table_of: TableOf, tmp_path: Path
) -> None:
    """A report that was spoilt is refused."""
    table = table_of("cam-disc")
    report = json.loads(table.with_suffix(".json").read_text())
    report["design"][key] = value
    (tmp_path / "bad.json").write_text(json.dumps(report))
    assert named in refusal(table, "--machine", MACHINE, "--design", tmp_path / "bad.json")


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


@pytest.mark.long
def test_speed_that_counts_as_stopped_is_not_recommended(tmp_path: Path) -> None:
    """Of the two remedies only the feed is left, and works; where less counts, the speed, too."""
    table = changed(
        tmp_path,
        *(("[5, 8]", "[3.2, 6.2]"), ("[10, 13]", "[6.4, 40]")),
        ("u_acceleration_mm_s2 = 20000", "u_acceleration_mm_s2 = 3500"),
        ("u_speed_mm_s = 400", "u_speed_mm_s = 2000"),
        text=(PARTS / "camshaft.toml").read_text(),
    )
    fast = ("--set", "u_speed_um_per_s=2000000")
    words = (table, "--machine", MACHINE, *QUICK, *fast)
    line = refusal(*words, "--feed", "5")
    found = re.search(r"mm/s2; give at most --feed (\S+)$", line)
    assert found, line
    cut(*words, "--feed", found[1], "--turns-limit", "0.2")
    slow = ("--feed", "5", "--set", "stopped_mrpm=2000")
    line = refusal(*words, *slow)
    found = re.search(r"mm/s2; give at most --rpm (\S+) or --feed \S+$", line)
    assert found, line
    cut(*words, *slow, "--rpm", found[1], "--turns-limit", "0.2")


def test_spindle_that_counts_as_stopped_is_refused_before_motion(tmp_path: Path) -> None:
    """A slow cam ground at constant surface speed: what the line tells instead is cut."""
    text = re.sub(r"(?m)^spindle_rpm = 60\b", "spindle_rpm = 20", GROUND)
    words = (changed(tmp_path, text=text), "--machine", MACHINE, "--turns-limit", "1", *QUICK)
    line = refusal(*words)
    told = "--rpm 18.26: in a turn it falls to 2.262, and for 172 ms below 5 (stopped_mrpm), which "
    told += "is a fault after 100 ms (stopped_ms); make the table for a faster spindle, or "
    assert line == f"{told}--set stopped_mrpm=2262"
    cut(*words, "--set", "stopped_mrpm=2262")
    line = refusal(*words, "--rpm", "4")
    assert "--rpm 4: below 5 (stopped_mrpm) the spindle counts as stopped; " in line


def test_bus_has_no_gauge_for_cams(table_of: TableOf) -> None:
    """The machine on a bus gauges skirts only, and says so before it opens the bus."""
    line = only_error(camsim("bus", table_of("cam-disc"), "--can", "none0", "--gpiochip", "none0"))
    assert "the bus cannot gauge" in line and "camsim run" in line


TICK_S = 50e-6
LAG_S = 100e-6 + 2 * 0.7 / (2 * np.pi * 200) + TICK_S / 2  # of the default drive of the swing
SPEED_DEG_S, ACCELERATION_DEG_S2 = 1000.0, 100_000.0
LIFT_MM = 8.0
OUT_NM = -(1.25 * LIFT_MM + 0.5) * 1e6  # of U beyond the highest point, largest amplitude
FAST = ("--no-learning", "--feed", "4", "--set", "engage_turns=2", "--set", "disengage_turns=2")


@pytest.fixture(scope="module")
def cam(table_of: TableOf, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the table of cam-345 alone."""
    return Path(shutil.copy(table_of("cam-345"), tmp_path_factory.mktemp("cam")))


def traced(cam: Path, *words: str, status: int = 0) -> Rows:
    """Cut with a coarse feed, engaging fast; return the trace."""
    words = ("--machine", str(MACHINE), *FAST, *words)
    return cut(cam, *words, status=status, tables=["trace"]).trace


@pytest.fixture(scope="module")
def whole(cam: Path) -> Rows:
    """Return the trace of a whole cut at 60 r/min."""
    return traced(cam)


def swing_of_table(folder: Path, turn: NDArray[Any], z_mm: NDArray[Any]) -> NDArray[Any]:
    """Return the firmware's own evaluation of the swing [degrees]."""
    return evaluated(folder, made_of("cam-345").table.table, np.mod(turn, 1), z_mm)["swing_deg"]


@pytest.mark.long
def test_tool_swings_as_the_table_wants(whole: Rows, tmp_path: Path) -> None:
    """Set-points to 6e-4 degrees, index edges included; the drive to 6e-3, where it jumps."""
    in_cut = while_in(whole, "cutting")[::3]
    ahead = in_cut["speed_q32"] / 2**32 * LAG_S / TICK_S
    wanted = swing_of_table(tmp_path, in_cut["turn"] + ahead, in_cut["z_mm"])
    error_deg = in_cut["swing_set_deg"] - wanted
    assert 1e-4 < np.abs(error_deg).max() < 6e-4
    assert np.sqrt(np.mean(error_deg**2)) < 1.2e-4
    wanted = swing_of_table(tmp_path, in_cut["true_turn"], in_cut["z_mm"])
    error_deg = in_cut["swing_act_deg"] - wanted
    assert np.abs(error_deg).max() < 6e-3
    assert np.sqrt(np.mean(error_deg**2)) < 5e-4


def test_swing_rises_and_falls_with_the_envelope(whole: Rows) -> None:
    """From 0 and back to rest at 0; in the traced the pressure angle of the cam to either side."""
    swing_deg = whole["swing_set_deg"]
    assert np.all(np.abs(while_in(whole, "homing")["swing_set_deg"]) < 1e-6)
    most = np.abs(while_in(whole, "cutting")["swing_set_deg"]).max()
    assert most == pytest.approx(19.967381, abs=1e-3)
    assert np.abs(swing_deg).max() <= most + 1e-5
    rest = swing_deg[-8:]
    assert np.all(np.abs(rest) < 1e-5)
    assert np.ptp(rest) == 0
    # the clearance of X contains the lift: the roller's centre comes from outside everywhere
    in_work = while_in(whole, "engaging", "cutting", "disengaging")
    assert in_work["error_nm"].min() > -200


def check_set_points(trace: Rows) -> None:
    """Check speed and acceleration of the set-point, over the distance of two of them."""
    speed_deg_s = np.diff(trace["swing_set_deg"]) / TICK_S
    assert np.abs(speed_deg_s).max() <= 1.001 * SPEED_DEG_S
    change = np.abs(speed_deg_s[8:] - speed_deg_s[:-8]) / (8 * TICK_S)
    assert change.max() <= 1.05 * ACCELERATION_DEG_S2


@pytest.mark.parametrize("at_s", ["0.82", pytest.param("1.0", marks=pytest.mark.long)])
def test_emergency_stop_brings_the_swing_back(cam: Path, at_s: str) -> None:
    """Within its limits, and enable holds until it rests at 0; U and X leave beyond the lift."""
    trace = traced(cam, "--inject", f"estop@{at_s}", status=1)
    check_set_points(trace)
    fault = while_in(trace, "fault")
    held = fault["swing_set_deg"][fault["out_outputs"].astype(int) & 1 == 0]
    assert len(held) > 0
    assert np.all(np.abs(held) < 1e-4)
    assert trace["u_set_nm"][-1] == pytest.approx(OUT_NM, abs=2)
    off_mm = (trace["out_x_nm"][-1] - fault["out_x_nm"][0]) * 1e-6
    assert off_mm == pytest.approx(1.25 * LIFT_MM + 1, abs=1e-3)


def test_stop_of_the_operator_ends_at_rest(cam: Path) -> None:
    """By the envelope, as any traced."""
    trace = traced(cam, "--inject", "stop@0.3")
    check_set_points(trace)
    assert abs(trace["swing_set_deg"][-1]) < 1e-5


def test_blocked_swing_is_a_fault(cam: Path) -> None:
    """It is detected a plan after it is off by its limit of a degree; the tool leaves the work."""
    trace = traced(cam, "--inject", "swing-block@0.85", status=1)
    fault = while_in(trace, "fault")[0]
    assert 0 < fault["t_s"] - while_in(trace, "cutting")["t_s"][0] - 0.85 < 0.02
    assert 1 < abs(fault["swing_set_deg"] - fault["swing_act_deg"]) < 4
    assert trace["u_set_nm"][-1] == pytest.approx(OUT_NM, abs=2)


REFUSED = {
    "swing_speed_mdeg_per_s=0": "swings the tool, for which there is no axis: needs 1",
    "swing_range_mdeg=15000": "swing farther than it can: needs 19.968 degrees, limit 15",
    "swing_speed_mdeg_per_s=100000": "swing faster than it can: needs 347",
    "swing_acceleration_deg_per_s2=5000": "have to accelerate more than it can: needs 2",
}


@pytest.mark.parametrize("name", REFUSED)
def test_infeasible_swing_is_refused_before_motion(cam: Path, name: str) -> None:
    """With the numbers, and the highest speed where one helps, which then passes."""
    line = refusal(cam, "--machine", MACHINE, *FAST, "--set", name)
    assert REFUSED[name] in line
    if "give at most --rpm" in line:
        rpm = line.rsplit(" ", 1)[1]
        words = ("--set", name, "--rpm", rpm, "--turns-limit", "0.1")
        cut(cam, "--machine", MACHINE, *FAST, *words)
    else:
        assert "no speed helps" in line


def test_machine_without_the_axis_refuses(cam: Path, table_of: TableOf) -> None:
    """A speed of 0 in the machine file says that there is none; a skirt does not ask for it."""
    line = refusal(cam, machine=MACHINE.read_text() + "\n[swing]\nspeed_deg_per_s = 0\n")
    assert "for which there is no axis" in line
    trace = cut(table_of("perkins240"), "--turns-limit", "1", tables=["trace"]).trace
    assert not [name for name in trace.dtype.names or () if "swing" in name]
