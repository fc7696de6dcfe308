"""What the change from lobe to lobe demands: refused before motion with numbers that would do."""

import re
from pathlib import Path

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import omega_rad_s
from camtools.cli.mktables import main as mktables
from camtools.cut.feasibility import highest_speed, needed_of
from camtools.lobe.generate import GeneratedLobes, generate_lobes
from camtools.lobe.lobe_machine import lobe_machine_text
from camtools.lobe.summary import emit_lobe_text, make_lobe_summary
from camtools.skirt.table.generate import generate, peaks_of_table
from tests.tools.cases.camsim_cases import ROOT, camsim
from tests.tools.cases.lobe_cases import cam
from tests.tools.cases.part_cases import PERKINS, load_part

SHAFT = (ROOT / "tools" / "parts" / "camshaft.toml").read_text()
NARROW = SHAFT.replace("[5, 8]", "[3.2, 6.2]").replace("[10, 13]", "[6.4, 9.4]")
NARROW = NARROW.replace("u_acceleration_mm_s2 = 20000", "u_acceleration_mm_s2 = 3500")
TURNED = NARROW.replace('"grinding"', '"turning"').replace("mm_s2 = 3500", "mm_s2 = 1000")
SURFACE = NARROW.replace('"uniform"', '"constant-surface"').replace("rpm = 40", "rpm = 30")
MACHINE = ROOT / "host_sim" / "machines" / "cam.toml"


def with_feed(text: str, feed_mm: float) -> str:
    """Return a part file with a feed."""
    return re.sub(r'(\nspeed = "[a-z-]+"\n)', rf"\g<1>feed_mm = {feed_mm}\n", text)


def made(text: str) -> GeneratedLobes:
    """Return the table of a part file's text."""
    return generate_lobes(cam(text))


def refusal(text: str) -> str:
    """Return the only line that refuses a part."""
    with pytest.raises(CamtoolsError) as info:
        made(text)
    [line] = info.value.lines
    return line


def told(line: str, before: str) -> float:
    """Return the number behind some words."""
    found = re.search(re.escape(before) + r" ([0-9.]+)", line)
    assert found, line
    return float(found[1])


def in_between(result: GeneratedLobes, turns: float) -> tuple[float, float]:
    """Return speed and acceleration of U over the mean speed where a lobe's lift falls and rises.

    The lift itself is differentiated: (1 - E(s)) H(phi), with phi and s of the time. E moves in
    lines over 8 ticks, so that one of them takes what bends over all.
    """
    phi = np.linspace(0, 2 * np.pi, 721)
    s = np.linspace(0, 1, 201)[:, None]
    share = 1 - s**3 * (10 - 15 * s + 6 * s**2)
    share1 = -30 * s**2 * (1 - s) ** 2 / (2 * np.pi * turns)
    share2 = -8 * 60 * s * (1 - s) * (1 - 2 * s) / (2 * np.pi * turns) ** 2
    speed = acceleration = 0.0
    for lobe in result.lobes:
        path = lobe.at(phi)
        one = share * path.d1 + share1 * path.lift
        two = share * path.d2 + 2 * share1 * path.d1 + share2 * path.lift
        speed = max(speed, float(np.abs(one).max()))
        acceleration = max(acceleration, float(np.abs(two).max()))
    return speed, acceleration


@pytest.mark.parametrize("feed_mm", [0.02, 0.1, 0.3, 1.0])
def test_needs_cover_what_happens_between_two_lobes(feed_mm: float) -> None:
    """Of every angle at every place of the change; at most twice, as peaks count at once."""
    result = made(NARROW)
    peaks = result.peaks._replace(feed_mm=feed_mm)
    needed = needed_of(peaks, result.part.machine.limits, 1.0)
    assert result.peaks.change_mm == pytest.approx(0.08)
    speed, acceleration = in_between(result, 0.08 / feed_mm)
    assert speed * 0.999 <= needed["u_speed_mm_s"] <= 2 * speed
    assert acceleration * 0.999 <= needed["u_acceleration_mm_s2"] <= 2 * acceleration


def test_table_without_change_over_height_drifts_by_nothing() -> None:
    """One lobe: all slices are alike, and the feed adds nothing."""
    result = made((ROOT / "tools" / "parts" / "cam-345.toml").read_text())
    assert result.peaks.u_drift == (0, 0, 0)
    assert result.peaks.swing_drift == (0, 0, 0)


def test_highest_speed_meets_its_limit() -> None:
    """At the highest speed the deciding need is its limit, the change between lobes included."""
    result = made(NARROW)
    limits, peaks = result.part.machine.limits, result.peaks._replace(feed_mm=0.1)
    best = highest_speed(peaks, limits)
    needed = needed_of(peaks, limits, omega_rad_s(best.rpm))
    assert best.decides == "u_acceleration_mm_s2"
    assert needed[best.decides] == pytest.approx(limits.u_acceleration_mm_s2, rel=1e-9)
    assert best.rpm < highest_speed(peaks._replace(feed_mm=0.001), limits).rpm


def test_feed_too_fast_for_the_gaps_is_refused() -> None:
    """With needed, limit, and a speed and a feed each of which is accepted; 1 % more is not."""
    line = refusal(with_feed(SURFACE, 0.9))
    assert line.startswith("machine.limits.u_acceleration_mm_s2 = ")
    assert told(line, "the part needs") > told(line, "u_acceleration_mm_s2 =")
    rpm, feed_mm = told(line, "may be at most"), told(line, "process.feed_mm at most")
    made(with_feed(SURFACE, feed_mm))
    assert "process.feed_mm at most" in refusal(with_feed(SURFACE, round(feed_mm * 1.01, 4)))
    fast = with_feed(SURFACE, 0.9)
    slower = re.sub(r"spindle_rpm = \d+\n", f"spindle_rpm = {rpm}\n", fast, count=1)
    best = made(slower).highest_speed
    assert best.rpm == pytest.approx(rpm, rel=0.02)
    assert best.decides == "u_acceleration_mm_s2"


def test_change_of_the_swing_is_refused_too() -> None:
    """It falls and rises with the lift, and its limit is its own."""
    strong = TURNED.replace("mm_s2 = 1000", "mm_s2 = 200000")
    weak = strong.replace(
        "spindle_rpm = 300", "spindle_rpm = 300\nswing_acceleration_deg_s2 = 15000"
    )
    line = refusal(with_feed(weak, 1.2))
    assert line.startswith("machine.limits.swing_acceleration_deg_s2 = 15000 degrees/s2: ")
    made(with_feed(weak, told(line, "process.feed_mm at most")))


PAIR = SHAFT[: SHAFT.index("[[cam.lobe]]\nz_mm = [5")] + (
    """[[cam.lobe]]
z_mm = [4, 7]
phase_deg = 180
law = "poly345"
lift_mm = 8
half_angle_deg = 70

[process]
operation = "grinding"
speed = "constant-surface"
feed_mm = 0.01
spindle_rpm = 60

"""
    + SHAFT[SHAFT.index("[machine.limits]") :].replace("u_stroke_mm = 24", "u_stroke_mm = 30")
)


@pytest.mark.parametrize(("phase_deg", "rpm"), [(0, 60), (20, 120), (90, 30), (180, 60)])
def test_laws_of_neighbours_are_made_for_each_alone(phase_deg: int, rpm: int) -> None:
    """Between two lobes the ratio goes to 1: their phases are no matter to the spindle's limit."""
    text = PAIR.replace("phase_deg = 180", f"phase_deg = {phase_deg}")
    result = made(text.replace("rpm = 60\n", f"rpm = {rpm}\n", 1))
    together = result.peaks.spindle_rad2 * omega_rad_s(result.mean_rpm) ** 2
    assert 40 < together <= 60


def test_highest_surface_speed_of_a_shaft_is_accepted() -> None:
    """Also where U decides; a tenth more is not."""
    weak = PAIR.replace("u_acceleration_mm_s2 = 20000", "u_acceleration_mm_s2 = 1200")
    rpm = told(refusal(weak.replace("rpm = 60\n", "rpm = 300\n", 1)), "may be at most")
    assert 10 < rpm < 300
    made(weak.replace("rpm = 60\n", f"rpm = {rpm}\n", 1))
    refusal(weak.replace("rpm = 60\n", f"rpm = {1.1 * rpm:.1f}\n", 1))


def test_feed_beyond_the_speed_of_z_is_refused() -> None:
    """What the controller would refuse, with the feed that would do."""
    slow = SHAFT.replace("[machine.limits]", "[machine.limits]\nz_speed_mm_s = 0.1\ntick_hz = 500")
    line = refusal(with_feed(slow, 0.3))
    assert line.startswith("machine.limits.z_speed_mm_s = 0.1 mm/s: the part needs 0.2 mm/s")
    made(with_feed(slow, told(line, "process.feed_mm at most")))


def test_highest_speed_that_is_printed_is_accepted() -> None:
    """Rounded down, for cams and skirts."""
    result = made(SHAFT)
    text = emit_lobe_text(make_lobe_summary(result))
    rpm = told(text, "highest speed")
    assert rpm <= result.highest_speed.rpm
    assert made(SHAFT.replace("rpm = 40", f"rpm = {rpm}")).highest_speed.rpm >= rpm


def test_no_feed_is_told_where_the_turning_alone_is_too_fast() -> None:
    """A smaller feed would not help."""
    line = refusal(SHAFT.replace("spindle_rpm = 40", "spindle_rpm = 200"))
    assert "may be at most" in line
    assert "feed_mm" not in line


def test_simulator_gets_the_ticks_of_the_part_file() -> None:
    """A slower controller is simulated as such."""
    slow = SHAFT.replace("u_stroke_mm = 24", "u_stroke_mm = 24\ntick_hz = 2000")
    assert "tick_hz = 2000\n" in lobe_machine_text(made(slow).part.machine.limits)


def test_skirts_are_judged_alike() -> None:
    """A skirt whose ovality changes smoothly drifts by little; a kink counts as that of a cam."""
    result = generate(load_part(PERKINS))
    peaks = peaks_of_table(result.table, result.speed)
    assert 0 < peaks.u_drift.step < 1e-3 * peaks.u1_mm
    assert 0 < peaks.u_drift.kink * 20_000 < 1e-2 * peaks.u2_mm * omega_rad_s(2500)
    kinked = peaks._replace(u_drift=peaks.u_drift._replace(kink=0.05))
    slower = highest_speed(kinked, result.part.machine.limits)
    assert slower.rpm < result.highest_speed.rpm
    assert slower.decides == "u_acceleration_mm_s2"


@pytest.mark.parametrize("text", [NARROW, TURNED], ids=["ground", "turned"])
def test_firmware_and_tool_judge_alike(text: str, tmp_path: Path) -> None:
    """Largest feed within 2 %, told before motion; the cut at it has no fault."""
    (tmp_path / "narrow.toml").write_text(text)
    assert mktables([str(tmp_path / "narrow.toml"), "-o", str(tmp_path)]) == 0
    table = tmp_path / "camshaft.camtab"
    too_fast = camsim("run", table, "--machine", MACHINE, "--feed", "1.5")
    assert too_fast.returncode == 2
    assert "would have to accelerate more than it can: needs " in too_fast.stderr
    feed = re.search(r"or --feed ([0-9.]+)\n", too_fast.stderr)
    rpm = re.search(r"give at most --rpm ([0-9.]+) or", too_fast.stderr)
    assert feed and rpm
    line = refusal(with_feed(text, 1.5))
    assert float(feed[1]) == pytest.approx(told(line, "process.feed_mm at most"), rel=0.02)
    assert float(rpm[1]) == pytest.approx(told(line, "may be at most"), rel=0.03)
    cut = camsim("run", table, "--machine", MACHINE, "--feed", feed[1])
    assert cut.returncode == 0, cut.stderr
    assert "fault" not in cut.stderr
