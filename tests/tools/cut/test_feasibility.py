"""What a cut demands: generator and controller refuse by one rule, with numbers that would do."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import omega_rad_s
from camtools.cut.feasibility import highest_speed, needed_of
from camtools.cut.verdict import RefusedError, check_table, judge_of, parameters_of
from camtools.judge.binding import PROTOTYPES, Judge
from camtools.lobe.generate import GeneratedLobes, generate_lobes
from camtools.lobe.kind import KIND, lobe_machine_text
from camtools.lobe.summary import emit_lobe_text, make_lobe_summary
from camtools.part.common import MachineLimits, SwingLimits
from camtools.pipeline.load import Made, parse
from camtools.sim.machine_file import machine_text
from camtools.skirt.table.generate import peaks_of_table
from camtools.table.header import image_limits
from camtools.table.image import Table, pack, unpack
from tests.tools.cases.camsim_cases import ROOT, camsim, columns_of
from tests.tools.cases.cut_cases import PARTS, made_of, skirt_of, written
from tests.tools.cases.lobe_cases import MACHINE, cam
from tests.tools.cases.part_cases import refused, refused_lines
from tests.tools.cases.prototypes import declared_in, named

SHAFT = (PARTS / "camshaft.toml").read_text()
NARROW = SHAFT.replace("[5, 8]", "[3.2, 6.2]").replace("[10, 13]", "[6.4, 9.4]")
NARROW = NARROW.replace("u_acceleration_mm_s2 = 20000", "u_acceleration_mm_s2 = 3500")
TURNED = NARROW.replace('"grinding"', '"turning"').replace("mm_s2 = 3500", "mm_s2 = 1000")
SURFACE = NARROW.replace('"uniform"', '"constant-surface"').replace("rpm = 40", "rpm = 30")


def with_feed(text: str, feed_mm: float) -> str:
    """Return a part file with a feed."""
    return re.sub(r'(\nspeed = "[a-z-]+"\n)', rf"\g<1>feed_mm = {feed_mm}\n", text)


@cache
def made(text: str) -> GeneratedLobes:
    """Return the table of a part file's text."""
    return generate_lobes(cam(text))


def refusal(text: str) -> str:
    """Return the only line that refuses a part."""
    return refused(lambda: made(text))


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


def test_highest_speed_meets_its_limit() -> None:
    """The change between lobes included, of which one lobe alone has none."""
    result = made_of("cam-345").table
    assert result.peaks.u_drift == (0, 0, 0)
    result = made(NARROW)
    limits, peaks = result.part.machine.limits, result.peaks._replace(feed_mm=0.1)
    best = highest_speed(peaks, limits)
    needed = needed_of(peaks, limits, omega_rad_s(best.rpm))
    assert best.decides == "u_acceleration_mm_s2"
    assert needed[best.decides] == pytest.approx(limits.u_acceleration_mm_s2, rel=1e-9)
    assert best.rpm < highest_speed(peaks._replace(feed_mm=0.001), limits).rpm


@pytest.mark.long
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


@pytest.mark.parametrize(
    ("phase_deg", "rpm"),
    [
        pytest.param(0, 60, marks=pytest.mark.long),
        (20, 120),
        pytest.param(90, 30, marks=pytest.mark.long),
        (180, 60),
    ],
)
def test_laws_of_neighbours_are_made_for_each_alone(phase_deg: int, rpm: int) -> None:
    """Between two lobes the ratio goes to 1: their phases are no matter to the spindle's limit."""
    text = PAIR.replace("phase_deg = 180", f"phase_deg = {phase_deg}")
    result = made(text.replace("rpm = 60\n", f"rpm = {rpm}\n", 1))
    together = result.peaks.spindle_rad2 * omega_rad_s(result.mean_rpm) ** 2
    assert 40 < together <= 60


@pytest.mark.long
def test_highest_surface_speed_of_a_shaft_is_accepted() -> None:
    """Also where U decides; a tenth more is not."""
    weak = PAIR.replace("u_acceleration_mm_s2 = 20000", "u_acceleration_mm_s2 = 1200")
    rpm = told(refusal(weak.replace("rpm = 60\n", "rpm = 300\n", 1)), "may be at most")
    assert 10 < rpm < 300
    made(weak.replace("rpm = 60\n", f"rpm = {rpm}\n", 1))
    refusal(weak.replace("rpm = 60\n", f"rpm = {1.1 * rpm:.1f}\n", 1))


def test_feed_and_ticks_of_the_machine() -> None:
    """A feed beyond Z's speed is refused, none is named where turning is too fast; ticks stay."""
    slow = SHAFT.replace("[machine.limits]", "[machine.limits]\nz_speed_mm_s = 0.1\ntick_hz = 500")
    line = refusal(with_feed(slow, 0.3))
    assert line.startswith("machine.limits.z_speed_mm_s = 0.1 mm/s: the part needs 0.2 mm/s")
    made(with_feed(slow, told(line, "process.feed_mm at most")))
    line = refusal(SHAFT.replace("spindle_rpm = 40", "spindle_rpm = 200"))
    assert "may be at most" in line
    assert "feed_mm" not in line
    slow = SHAFT.replace("u_stroke_mm = 24", "u_stroke_mm = 24\ntick_hz = 2000")
    assert "tick_hz = 2000\n" in lobe_machine_text(made(slow).part.machine.limits)


def test_highest_speed_that_is_printed_is_accepted() -> None:
    """Rounded down, for cams and skirts."""
    result = made_of("camshaft").table
    text = emit_lobe_text(make_lobe_summary(result))
    rpm = told(text, "highest speed")
    assert rpm <= result.highest_speed.rpm
    assert made(SHAFT.replace("rpm = 40", f"rpm = {rpm}")).highest_speed.rpm >= rpm


def test_skirts_are_judged_alike() -> None:
    """A skirt whose ovality changes smoothly drifts by little; a kink counts as that of a cam."""
    result = skirt_of("perkins240")
    peaks = peaks_of_table(result.table, result.speed)
    assert 0 < peaks.u_drift.step < 1e-3 * peaks.u1_mm
    assert 0 < peaks.u_drift.kink * 20_000 < 1e-2 * peaks.u2_mm * omega_rad_s(2500)
    kinked = peaks._replace(u_drift=peaks.u_drift._replace(kink=0.05))
    slower = highest_speed(kinked, result.part.machine.limits)
    assert slower.rpm < result.highest_speed.rpm
    assert slower.decides == "u_acceleration_mm_s2"


@pytest.mark.long
@pytest.mark.parametrize(
    "text",
    [pytest.param(NARROW, id="ground"), pytest.param(TURNED, id="turned", marks=pytest.mark.long)],
)
def test_firmware_and_tool_judge_alike(text: str, tmp_path: Path) -> None:
    """Largest feed within 2 %, told before motion; the cut at it has no fault."""
    table = written(Made(KIND, made(text)), tmp_path)
    words = ("run", table, "--machine", MACHINE, "--no-learning")
    too_fast = camsim(*words, "--feed", "1.5")
    assert too_fast.returncode == 2
    assert "would have to accelerate more than it can: needs " in too_fast.stderr
    feed = re.search(r"or --feed ([0-9.]+)\n", too_fast.stderr)
    rpm = re.search(r"give at most --rpm ([0-9.]+) or", too_fast.stderr)
    assert feed and rpm
    line = refusal(with_feed(text, 1.5))
    assert float(feed[1]) == pytest.approx(told(line, "process.feed_mm at most"), rel=0.02)
    assert float(rpm[1]) == pytest.approx(told(line, "may be at most"), rel=0.03)
    done = camsim(*words, "--feed", feed[1])
    assert done.returncode == 0, done.stderr
    assert "fault" not in done.stderr


HEADER = ROOT / "host_sim" / "api" / "judge" / "judge_api.h"
SKIRT = {"u_speed_mm_s": 80.0, "u_acceleration_mm_s2": 4e4, "z_speed_mm_s": 50.0}
# What is changed of the machine of the part file, the feed, and the words of a shorter cut.
SHORT = ("--turns-limit", "1")
CUTS: dict[str, tuple[dict[str, float], float | None, tuple[str, ...]]] = {
    "perkins240": (SKIRT, 1.0, ()),
    "perkins240_ring_helix": (SKIRT, None, ()),
    "cam-disc": ({}, None, SHORT),
    "camshaft8": ({"swing_speed_deg_s": 300.0}, None, SHORT),
    "camshaft-plunge": ({}, None, SHORT),
}
DRAWN = (
    *("u_speed_mm_s", "u_acceleration_mm_s2", "z_speed_mm_s", "z_acceleration_mm_s2"),
    *("spindle_rpm", "swing_speed_deg_s", "swing_acceleration_deg_s2"),
)
EVERY, XZ_ROWS = 16, 10  # ticks of a row of the trace, rows of a step: the noise is small in it
NOISE, REACHED = 0.01, 0.95  # of a limit: the angle is known to a count
FIELDS = {
    "u_speed": "u_speed_mm_s",
    "u_acceleration": "u_acceleration_mm_s2",
    "z_speed": "z_speed_mm_s",
    "z_acceleration": "z_acceleration_mm_s2",
    "spindle_speed": "spindle_rpm",
    "spindle_set_point": "spindle_rpm",
    "swing_speed": "swing_speed_deg_s",
    "swing_acceleration": "swing_acceleration_deg_s2",
}
TEXTS = dict(
    re.findall(
        r'X\((\w+), +-\d+, "([^"]+)"', (ROOT / "firmware" / "base" / "cam_err.h").read_text()
    )
)
DISC = (PARTS / "cam-disc.toml").read_text()


def limits_of(part: str) -> MachineLimits:
    """Return the machine of a part file, without ripple of its spindle."""
    data = (PARTS / f"{part}.toml").read_bytes()
    limits: MachineLimits = parse(data, part).part.machine.limits
    return limits.model_copy(update={"spindle_ripple": 0.0} | CUTS[part][0])


def drawn(limits: MachineLimits, seed: int) -> MachineLimits:
    """Return a weaker machine."""
    rng = np.random.default_rng(seed)
    update = {
        name: getattr(limits, name) * 10 ** rng.uniform(-0.8, 0)
        for name in DRAWN
        if name in type(limits).model_fields
    }
    return limits.model_copy(update=update)


def text_of(limits: MachineLimits) -> str:
    """Return the machine file of limits."""
    if isinstance(limits, SwingLimits):
        return lobe_machine_text(limits)
    return machine_text(limits)


def peaks_in(trace: Path, tick_hz: int) -> dict[str, float]:
    """Return the largest motions in a trace, by the names and in the units of the limits."""
    columns = columns_of(trace)
    in_cut = np.isin(columns["state"].astype(str), ("engaging", "cutting"))
    assert (np.diff(columns["tick"]) == EVERY).all()

    def derivative(column: str, order: int, rows: int = 1) -> float:
        place = columns[column][in_cut][::rows].astype(np.float64)
        return float(np.abs(np.diff(place, order)).max()) * (tick_hz / EVERY / rows) ** order

    found = {
        "u_stroke": float(np.abs(columns["u_set_nm"][in_cut]).max()),
        "u_speed": derivative("u_due_q6", 1) / 64e3,
        "u_acceleration": derivative("u_due_q6", 2) / 64e6,
        "spindle_speed": float(np.abs(columns["speed_q32"][in_cut]).max()) * tick_hz * 6e4 / 2**32,
        "spindle_set_point": float(np.abs(columns["out_spindle_mrpm"]).max()),
    }
    if "swing_set_deg" in columns:
        found["swing_speed"] = derivative("swing_set_deg", 1) * 1e3
        found["swing_acceleration"] = derivative("swing_set_deg", 2)
    for axis in "xz":  # both follow the angle in whole nanometres
        found[f"{axis}_speed"] = derivative(f"out_{axis}_nm", 1, XZ_ROWS) / 1e3
        found[f"{axis}_acceleration"] = derivative(f"out_{axis}_nm", 2, XZ_ROWS) / 1e6
    return found


def cut(
    folder: Path, table: Table, limits: MachineLimits, mrpm: int, *short: str
) -> tuple[str, Path]:
    """Cut at a speed; return what the simulator prints and where the trace is."""
    image, machine, trace = folder / "t.camtab", folder / "m.toml", folder / "t.csv"
    image.write_bytes(pack(table))
    machine.write_text(text_of(limits))
    words = ("--rpm", f"{mrpm / 1000:.3f}", "--no-learning", *short)
    traced = ("--trace", trace, "--trace-every", str(EVERY))
    done = camsim("run", image, "--machine", machine, *words, *traced)
    return done.stderr, trace


@pytest.mark.parametrize("part", CUTS)
@pytest.mark.parametrize("seed", [0, *(pytest.param(n, marks=pytest.mark.long) for n in (1, 2))])
def test_what_is_accepted_is_cut_within_all_limits(
    part: str, seed: int, table_of: Callable[[str], Path], tmp_path: Path
) -> None:
    """At the highest speed; just above it generator and controller refuse for the same limit."""
    made, base = unpack(table_of(part).read_bytes()), limits_of(part)
    _, feed_mm, short = CUTS[part]
    feed_nm = round(feed_mm * 1e6) if feed_mm else made.feed_nm
    limits = drawn(base, seed)
    table = replace(made, limits=image_limits(limits), feed_nm=feed_nm)
    judge = judge_of(table, limits)
    highest = judge.highest_mrpm()
    beyond = replace(table, spindle_mrpm=highest + 1)
    text, trace = cut(tmp_path, table, limits, highest, *short)
    assert not re.search(r"infeasible|: fault", text), (seed, text)
    limit_of = {one.name: one.limit for one in judge.demands(highest)}
    shares = {name: peak / limit_of[name] for name, peak in peaks_in(trace, limits.tick_hz).items()}
    assert max(shares.values()) <= 1 + NOISE, (seed, shares)
    decides = judge.exceeded(highest + 1)[0].name
    assert shares[decides] > REACHED, (seed, decides, shares)
    text, _ = cut(tmp_path, beyond, limits, highest + 1)
    assert TEXTS[decides] in text
    lines = refused_lines(lambda: check_table(beyond, limits), RefusedError)
    assert any(line.startswith(f"machine.limits.{FIELDS[decides]} = ") for line in lines)


@pytest.mark.parametrize(("bandwidth_hz", "stroke_mm"), [(120, 0.33)])
def test_command_that_is_accepted_keeps_the_stroke(
    bandwidth_hz: float, stroke_mm: float, table_of: Callable[[str], Path], tmp_path: Path
) -> None:
    """The feed-forward takes U's command ahead of a set-point that fits the stroke."""
    limits = MachineLimits(u_stroke_mm=stroke_mm, u_speed_mm_s=1000, spindle_ripple=0.0)
    table = replace(unpack(table_of("perkins240").read_bytes()), feed_nm=1_000_000)
    table = replace(table, limits=image_limits(limits))
    machine, trace = tmp_path / "m.toml", tmp_path / "t.csv"
    text = machine_text(limits).replace("[u]", f"[u]\nbandwidth_hz = {bandwidth_hz}")
    machine.write_text(text)
    (tmp_path / "t.camtab").write_bytes(pack(table))
    omega = 2 * np.pi * bandwidth_hz
    gains = {"k1_ns": 1.4 / omega * 1e9, "k2_us2": 1e12 / omega**2}
    judge = Judge(pack(table), limits.tick_hz, parameters_of(limits) | gains)
    highest = judge.highest_mrpm()
    assert [one.name for one in judge.exceeded(highest + 1)] == ["u_command"]
    traced = ("--no-learning", "--trace", trace)
    words = ("run", tmp_path / "t.camtab", "--machine", machine, *traced, "--rpm")
    done = camsim(*words, f"{(highest + 1) / 1000:.3f}")
    assert TEXTS["u_command"] in done.stderr
    done = camsim(*words, f"{highest / 1000:.3f}")
    assert not re.search(r"infeasible|: fault", done.stderr)
    columns = columns_of(trace)
    in_cut = columns["state"].astype(str) == "cutting"
    [limit] = [one.limit for one in judge.demands(highest) if one.name == "u_command"]
    assert 0.98 * limit < np.abs(columns["out_u_nm"][in_cut]).max() <= limit


@pytest.mark.parametrize("part", ["perkins240", "camshaft8"])
def test_parameters_are_those_of_the_simulated_machine(
    part: str, table_of: Callable[[str], Path], tmp_path: Path
) -> None:
    """The generator judges by what the simulator derives from the machine file of the part.

    Arguments and results of its library are those of the header.
    """
    words = {
        "const judge_api_demand_t *": "LP__Demand",
        "const judge_api_peaks_t *": "LP_TablePeaks",
    }
    assert declared_in(HEADER, words) == named(PROTOTYPES)
    limits, machine = limits_of(part), tmp_path / "m.toml"
    machine.write_text(text_of(limits))
    done = camsim("params", table_of(part), "--machine", machine)
    assert done.returncode == 0, done.stderr
    told = dict(line.split(",") for line in done.stdout.splitlines())
    judged = parameters_of(limits)
    if not isinstance(limits, SwingLimits):
        judged.pop("swing_speed_mdeg_per_s")  # only lobes have a machine with a swing
    assert {name: int(told[name]) for name in judged} == {
        name: int(value + 0.5) for name, value in judged.items()
    }
    assert int(told["tick_hz"]) == limits.tick_hz


def test_judge_refuses_in_one_line(
    table_of: Callable[[str], Path], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """With the controller's numbers in the units of the part file, its own line, or a remedy."""
    image = bytearray(table_of("perkins240").read_bytes())
    table, weak = unpack(bytes(image)), MachineLimits(u_acceleration_mm_s2=100.0)
    demands = judge_of(table, weak).exceeded(table.spindle_mrpm)
    [demand] = [one for one in demands if one.name == "u_acceleration"]
    assert any(
        line.startswith("machine.limits.u_acceleration_mm_s2 = 100 mm/s2: the part needs ")
        and f"{demand.needed:.9g} mm/s2" in line
        for line in refused_lines(lambda: check_table(table, weak))
    )
    image[-1] ^= 1
    with pytest.raises(CamtoolsError, match=r"refuses the table: .* its CRC-32 differs"):
        Judge(bytes(image), 20_000, {})
    monkeypatch.setenv("CAMTURN_BUILD", str(tmp_path))
    with pytest.raises(CamtoolsError, match="cannot be loaded; start tools/mktables"):
        Judge(b"", 20_000, {})


@pytest.mark.parametrize("is_ring_helix", [False, True])
def test_feed_too_small_is_refused(table_of: Callable[[str], Path], *, is_ring_helix: bool) -> None:
    """More turns than the controller counts, at the edge of it; the feed is what helps."""
    made = unpack(table_of("perkins240_ring_helix" if is_ring_helix else "perkins240").read_bytes())
    span_nm, per_feed = made.z_last_nm - made.z_first_nm, 1 + is_ring_helix
    least_nm = -(-span_nm * per_feed // ((1 << 22) - 2 - per_feed))
    limits = MachineLimits()
    for feed_nm in (1, least_nm - 1):
        with pytest.raises(
            RefusedError, match=r"controller's turns = .* no speed helps: give a larger"
        ):
            check_table(replace(made, feed_nm=feed_nm, spindle_mrpm=1000), limits)
    check_table(replace(made, feed_nm=least_nm + 1, spindle_mrpm=1000), limits)


@pytest.mark.parametrize("offset_mm", [7.49, 7.6])
def test_disc_that_fits_its_stroke_is_accepted(offset_mm: float, tmp_path: Path) -> None:
    """A stroke of 30 mm has 15 to either side of the base circle: lifts up to 15 fit."""
    text = re.sub(r"offset_mm = [\d.]+", f"offset_mm = {offset_mm}", DISC)
    text = re.sub(r"base_radius_mm = [\d.]+", f"base_radius_mm = {25 - offset_mm:.12g}", text)
    text = re.sub(r"u_stroke_mm = [\d.]+", "u_stroke_mm = 30", text)
    if offset_mm > 7.5:
        with pytest.raises(CamtoolsError, match=r"u_stroke_mm = 30 mm: the part needs 30\.[4-6]"):
            generate_lobes(cam(text))
        return
    made = generate_lobes(cam(text))
    said, _ = cut(tmp_path, made.table, made.part.machine.limits, made.table.spindle_mrpm, *SHORT)
    assert "infeasible" not in said
