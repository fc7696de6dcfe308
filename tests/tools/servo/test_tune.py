"""tools/tune: a force drive by file, record or excitation; reports hold for the firmware's loop."""

import math
import re
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from camtools.base.project import ROOT
from camtools.cli.tune import main
from camtools.link.controller import Link
from camtools.link.messages import NUMBERS
from camtools.link.refusal_text import ask_done
from camtools.plots import style
from camtools.tune import plots
from camtools.tune.excited import Measured, measure, simulated_u
from camtools.tune.judgement import OpenLoop, figures, judge, loop_text
from camtools.tune.loop_design import Loop, Plant
from tests.tools.cases.camctl_bench import Bench, ready
from tests.tools.cases.command_cases import complaint
from tests.tools.cases.drive_plant import Drive, library
from tests.tools.cases.live_cases import live_case
from tests.tools.servo.test_servo_loop import QUICK, STEP_HZ, closed, opened

DRIVE = """\
mass_kg = 1.5
amplifier_hz = 1500.0
delay_us = 25.0
tick_hz = 20000.0
mode_hz = 1200.0
mode_damping = 0.03
mode_share = -0.2
scale_quantum_nm = 100.0
force_limit_n = 500.0
continuous_n = 210.0
thermal_s = 20.0
force_rate_n_per_ms = 1000000.0
"""
TASK = "[task]\ntravel_mm = 1.0\nspindle_rpm = 3000.0\nlobes = 2\n"


def tuned(folder: Path, text: str, *options: str) -> int:
    """Run the command on the text of a drive; results go to folder/out."""
    (folder / "coil.toml").write_text(text)
    return main([str(folder / "coil.toml"), "-o", str(folder / "out"), *options])


def number(text: str, pattern: str) -> float:
    """Return the number that a report has at a place."""
    found = re.search(pattern.replace("#", r"([\d.]+)"), text)
    assert found is not None, (pattern, text)
    return float(found[1])


@dataclass(frozen=True)
class Proposal:
    """What the command makes of the drive: report, parameter file, parameters of the firmware."""

    text: str
    file: Path
    values: dict[str, int]


@pytest.fixture(scope="module")
def proposal(tmp_path_factory: pytest.TempPathFactory) -> Proposal:
    """Tune the drive once."""
    folder = tmp_path_factory.mktemp("coil")
    assert tuned(folder, DRIVE + TASK) == 0
    file = folder / "out" / "coil_servo.toml"
    table = tomllib.loads(file.read_text())["axis_u"]
    assert table.pop("lead_ns") == 10**9 // STEP_HZ + table["servo_force_delay_ns"]
    assert [table.pop(name) for name in ("k1_ns", "k2_us2", "u_friction_nm")] == [0, 0, 0]
    assert all(name.startswith("servo_") for name in table)
    text = (folder / "out" / "coil_loop.txt").read_text()
    return Proposal(text, file, {"u_scale_latency_ns": 0} | table)


@pytest.mark.long
def test_firmware_with_the_written_parameters_does_what_the_report_says(proposal: Proposal) -> None:
    """Peak and end of a step, least stiffness, noise; the feed-forward has the drive's delay."""
    text, values = proposal.text, proposal.values
    hold_and_lag_ns = 25e3 + 1e9 / (2 * math.pi * 1500)
    assert values["servo_force_delay_ns"] == pytest.approx(25e3 + hold_and_lag_ns, abs=1)
    opened(values)
    seen = np.abs(closed(Drive(QUICK, 0.0), 1300, lambda i: 10.0 if i >= 100 else 0.0)[100:])
    assert seen.max() == pytest.approx(number(text, "peak # um"), rel=0.03)
    back_ms = (np.flatnonzero(seen > 0.1)[-1] + 1) * 1e3 / STEP_HZ
    assert back_ms == pytest.approx(number(text, "after # ms"), abs=0.7)

    opened(values)
    weakest_hz = number(text, "N/um at # Hz")
    turn = 2 * math.pi * weakest_hz / STEP_HZ
    seen = closed(Drive(QUICK, 0.0), 6000, lambda i: 10.0 * math.sin(turn * i))[2000:]
    assert 10.0 / np.abs(seen).max() == pytest.approx(number(text, "stiffness: # N"), rel=0.03)

    opened(values)  # white noise of a quantum's rms on the reading gives the force
    drive, random, force_n = Drive(QUICK, 0.0), np.random.default_rng(3), np.empty(8000)
    for i in range(force_n.size):
        read_nm = drive.scale_m() * 1e9 + random.uniform(-50.0, 50.0)
        force_n[i] = library().servo_step(0, 0, 0, round(read_nm * 64)) / 64e3
        drive.move(float(force_n[i]), 0.0)
    assert force_n[500:].std() == pytest.approx(number(text, "force: # N rms"), rel=0.08)


def test_task_is_compared_with_the_limits(tmp_path: Path, proposal: Proposal) -> None:
    """0.5 mm at 100 Hz of 1.5 kg: 296 N, 209 N rms."""
    text = proposal.text
    peak_n = 1.5 * 0.5e-3 * (2 * math.pi * 100) ** 2
    assert f"{peak_n:.0f} N peak; force_limit_n = 500: enough" in text
    assert f"{peak_n / math.sqrt(2):.0f} N rms; continuous_n = 210: enough" in text
    assert tuned(tmp_path, DRIVE.replace("210.0", "205.0") + TASK) == 0
    assert "continuous_n = 205: NOT ENOUGH" in (tmp_path / "out" / "coil_loop.txt").read_text()


def test_written_parameters_are_judged_as_they_were_proposed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], proposal: Proposal
) -> None:
    """A loop made for a mass that is 20 % too large has a gain that is as much too high."""
    text, kept = proposal.text, proposal.file
    capsys.readouterr()
    assert tuned(tmp_path, DRIVE + TASK, "--loop", str(kept)) == 0
    assert capsys.readouterr().out == text
    lighter = DRIVE.replace("mass_kg = 1.5", f"mass_kg = {1.5 * 1.2}")
    assert tuned(tmp_path, lighter, "--loop", str(kept)) == 0
    gains = [number(one, "at 1 of the mass: # dB") for one in (text, capsys.readouterr().out)]
    assert gains[1] - gains[0] == pytest.approx(20 * math.log10(1.2), abs=0.11)


@pytest.mark.parametrize(
    ("change", "culprit"),
    [
        pytest.param(
            ("mode_damping = 0.03\nmode_share = -0.2", "mode_damping = 0.001\nmode_share = 1.0"),
            "the mode at 60 Hz: damp or stiffen it", marks=pytest.mark.long),
        (("delay_us = 25.0", "delay_us = 200.0"), "the delay of 200 us: shorten it"),
        (("amplifier_hz = 1500.0", "amplifier_hz = 250.0"), "the lag of the amplifier of 250 Hz"),
    ],
    ids=["mode", "delay", "amplifier"],
)  # fmt: skip
def test_margins_that_are_missing_are_refused(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    proposal: Proposal,
    change: tuple[str, str],
    culprit: str,
) -> None:
    """One line names the cause; nothing is written. The mode has no loop at all."""
    kept = tmp_path / "kept.toml"
    kept.write_text("".join(f"{name} = {value}\n" for name, value in proposal.values.items()))
    text = DRIVE.replace(*change)
    given = ["--loop", str(kept)]
    if culprit.startswith("the mode"):
        text, given = text.replace("mode_hz = 1200.0", "mode_hz = 60.0"), []
    capsys.readouterr()
    assert tuned(tmp_path, text, *given) == 1
    out, error = capsys.readouterr()
    assert out == ""
    assert error.count("\n") == 1
    assert "at least 6 dB and 30 degrees" in error
    assert culprit in error
    assert not (tmp_path / "out").exists()


GOOD_LOOP = """\
[servo]
servo_mass_g = 1500
servo_crossover_hz = 200
servo_lead_percent = 2000
servo_pole_hz = 4000
servo_integral_mHz = 9000
servo_notch_hz = 1200
servo_notch_zero_permille = 60
servo_notch_pole_permille = 100
"""


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("mass_kg = 1.5\n", "", "mass_kg: is missing; add it"),
        ("mass_kg = 1.5", "mass_kg = -1.0", "mass_kg = -1.0: "),
        (
            "mode_hz = 1200.0",
            "mode_hz = 1e-308",
            "mode_hz = 1e-308: must be at least 1; give hertz",
        ),
        ("delay_us", "delay_ms", "delay_ms: unknown key"),
        ("mass_kg = 1.5", "mass_kg = ", "not TOML"),
        ("continuous_n = 210.0", "continuous_n = 20.0", "servo_continuous_mn = 20000: out of"),
        ("pole_hz = 4000", "pole_hz = 4001", "servo_pole_hz = 4001: out of range 10 .. 4000 at 2"),
        ("notch_hz = 1200\n", "notch_hz = 5001\n", "servo_notch_hz = 5001: out of range"),
        ("mass_g = 1500", "mass_g = 100000", "servo_integral_mHz = 9000: 1.26 times"),
        ("servo_crossover_hz = 200\n", "", "servo_crossover_hz: is missing"),
    ],
)
def test_bad_drive_or_loop_is_one_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, problem: str
) -> None:
    """File, key and remedy; nothing is written. The bounds of a loop are those of the firmware."""
    (tmp_path / "kept.toml").write_text(GOOD_LOOP.replace(old, new))
    given = ["--loop", str(tmp_path / "kept.toml")] if old in GOOD_LOOP else []
    assert tuned(tmp_path, DRIVE.replace(old, new), *given) == 2
    assert problem in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_stiff_drive_is_judged_with_its_stiffness() -> None:
    """A loop without integral yields to a constant force as its gain and the flexure allow."""
    plant = replace(QUICK, mode_hz=0.0, stiffness_n_per_m=2e5, drag_n_s_per_m=50.0)
    judged = judge(Loop(100.0, 10.0, 1000.0, 0.0, 2500.0, 1.0, 1.0), plant)
    lead = abs((1 + 1j) / (1 + 0.1j))
    gain_n_per_m = 1.5 * (2 * math.pi * 100.0) ** 2 / lead
    assert all(one.is_stable for one in judged.at)
    assert judged.step_um[-1] == pytest.approx(1e7 / (gain_n_per_m + 2e5), rel=1e-3)


_MACHINE = ROOT / "tests" / "scenarios" / "cases" / "machines" / "force.toml"
_MODE = "mode_hz = 1200\nmode_share = -0.2\nmode_on_scale = 1\n"
_WEAK = """\
[controller]
servo_crossover_hz = 60
servo_lead_percent = 2000
servo_pole_hz = 1000
servo_integral_mHz = 3000
"""
_LATE_US = 25.0 + 80.0  # delay of the machine file, amplifier of 2 kHz
_TICK_HZ = 20_000.0
_FIGURES = r"crossover (\d+) Hz, phase margin ([\d.]+) degrees, gain margin ([\d.]+) dB"


def measured(file: Path) -> Measured:
    """Excite U of a machine file."""
    with simulated_u(file.read_bytes(), str(file)) as u:
        return measure(u, str(file))


def values_over(link: Link, names: Iterable[str]) -> dict[str, int]:
    """Return parameters in force."""
    return {name: int(ask_done(link, "get_parameter", NUMBERS["parameter"][name]).value)
            for name in names}  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("mode", ["", _MODE])
def test_the_set_point_shows_mass_delay_and_mode(mode: str, tmp_path: Path) -> None:
    """Mass within 2 %, the delays within 5 us, a mode only where there is one; by all lines."""
    file = tmp_path / "drive.toml"
    file.write_text(_MACHINE.read_text("utf-8") + mode, "utf-8")
    one = measured(file)
    found = one.fit
    assert one.tick_hz == _TICK_HZ
    assert found.n_lines == 251  # 5 .. 2495 Hz, and the carrier of 20 Hz
    assert found.mass_kg == pytest.approx(1.5, rel=0.02)
    late_us = 1e6 * found.delay_s + 0.5e6 / 3.14159265 / found.amplifier_hz
    assert late_us == pytest.approx(_LATE_US, abs=5.0)
    assert found.has_mode == bool(mode)
    if mode:
        assert found.values[6:9].tolist() == pytest.approx([1200.0, 0.03, -0.2], rel=0.05)


def test_a_weak_loop_keeps_u_within_its_travel(tmp_path: Path) -> None:
    """A crossover of 30 Hz overshoots: U is excited where there is room for that."""
    file = tmp_path / "weak.toml"
    weak = _WEAK.replace("crossover_hz = 60", "crossover_hz = 30")
    file.write_text(_MACHINE.read_text("utf-8") + weak, "utf-8")
    assert measured(file).fit.mass_kg == pytest.approx(1.5, rel=0.03)


@pytest.mark.long
def test_a_simulated_machine_gets_the_loop_that_was_proposed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The machine file has the parameters that are written, and is otherwise as it was."""
    assert main(["--machine", str(_MACHINE), "-o", str(tmp_path), "--apply"]) == 0
    assert "applied: force_tuned.toml" in capsys.readouterr().out
    written = tomllib.loads((tmp_path / "force_servo.toml").read_text("utf-8"))["axis_u"]
    assert written["servo_mass_g"] == pytest.approx(1500, rel=0.02)
    tuned = tomllib.loads((tmp_path / "force_tuned.toml").read_text("utf-8"))
    assert tuned.pop("controller") == written
    assert tuned == tomllib.loads(_MACHINE.read_text("utf-8"))
    assert measured(tmp_path / "force_tuned.toml").values.items() >= {
        name: value for name, value in written.items() if name.startswith("servo_")
    }.items()  # fmt: skip


@pytest.mark.long
def test_a_loop_is_set_over_can_and_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """From a weak loop on; the report of the second run has the margins of the loop that was set.

    A drive file gives the limits of the force. The lathe runs at half the speed of the clock, as on
    a slow machine.
    """
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    machine, limits = tmp_path / "weak.toml", tmp_path / "coil.toml"
    machine.write_text(_MACHINE.read_text("utf-8") + _WEAK, "utf-8")
    limits.write_text("force_limit_n = 450.0\ncontinuous_n = 200.0\n")
    words = [str(limits), "--bus", "-o", str(tmp_path / "out")]
    with live_case(tmp_path, "--machine", machine, "--speed-up", "0.5") as live:
        live.order("enable", "ready")
        live.link.rights.release()
        assert main([*words, "--apply"]) == 0
        said = capsys.readouterr().out
        weak = re.search(rf"as it is \(measured\): {_FIGURES}", said)
        assert weak is not None and float(weak[1]) == pytest.approx(60.0, rel=0.1)
        assert "applied: 19 parameters; the drives are off, enable and home again" in said
        path = tmp_path / "out" / "coil_servo.toml"
        loop = tomllib.loads(path.read_text("utf-8"))["axis_u"]
        assert loop["servo_force_limit_mn"] == 450_000
        assert loop["servo_mass_g"] == pytest.approx(1500, rel=0.02)
        live.until("off")
        assert values_over(live.link, loop) == loop
        live.order("enable", "ready")
        live.link.rights.release()
        assert main(words) == 0
    found = re.findall(_FIGURES, capsys.readouterr().out)
    (crossover_hz, phase_deg, gain_db), model = (np.array(one, float) for one in found)
    assert crossover_hz == pytest.approx(model[0], rel=0.1)
    assert phase_deg == pytest.approx(model[1], abs=5.0)
    assert gain_db == pytest.approx(model[2], abs=1.0)


def test_a_pulse_over_can_tells_mass_and_friction(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """1.5 kg with 4.5 N of friction, believed to be 1.2 kg with 3.6 N; --apply sets both."""
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    machine = tmp_path / "weak.toml"
    believed = "[believed.u]\nmass_kg = 1.2\n"
    machine.write_text(_MACHINE.read_text("utf-8") + believed + _WEAK, "utf-8")
    with live_case(tmp_path, "--machine", machine) as live:
        live.order("enable", "ready")
        live.link.rights.release()
        assert main(["--bus", "--pulse", "15", "--apply"]) == 0
        said = capsys.readouterr().out.splitlines()
        assert said[0] == "a positive force moves the scale up"
        assert said[-1].startswith("applied: 2 parameters; the drives are off")
        live.until("off")
        found = values_over(live.link, ["servo_mass_g", "servo_friction_mn"])
    assert found["servo_mass_g"] == pytest.approx(1500, rel=0.04)
    assert found["servo_friction_mn"] == pytest.approx(4500, rel=0.1)


def test_a_stiff_loop_is_refused_for_a_pulse(capsys: pytest.CaptureFixture[str]) -> None:
    """The loop of the machine holds U within a few micrometres: that would tell of friction."""
    for words, says in (
        (["--machine", str(_MACHINE), "--pulse", "10"], "um alone; set a weaker loop, of 30 Hz"),
        (["--machine", str(_MACHINE), "--pulse", "700"], "servo_force_limit_mn is 600000"),
        (["--machine", "default"], "tune: default: servo_crossover_hz = 0"),  # takes positions
    ):
        assert says in complaint(main, words, capsys)


@pytest.mark.parametrize(
    ("crossover_hz", "says"),
    [
        (0, "servo_crossover_hz = 0: U takes positions, or"),
        pytest.param(50, "no force was recorded, so its U takes positions", marks=pytest.mark.long),
    ],
)
def test_a_drive_that_takes_positions_is_refused(
    bench: Bench, capsys: pytest.CaptureFixture[str], crossover_hz: int, says: str
) -> None:
    """By its parameters before it moves, or by the force that was not recorded."""
    words = ["--bus", "--interface", "virtual", "--channel", bench.channel]
    bench.do("set", "servo_crossover_hz", str(crossover_hz))
    ready(bench)
    capsys.readouterr()
    line = complaint(main, words, capsys)
    assert says in line and "use tools/identify" in line


def test_a_refused_loop_is_not_set(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Given parameters without the margins: one line, no file."""
    loop = tmp_path / "wild.toml"
    loop.write_text(
        "servo_mass_g = 1500\nservo_crossover_hz = 2500\nservo_lead_percent = 3000\n"
        "servo_pole_hz = 4000\nservo_integral_mHz = 9000\n"
    )
    words = ["--machine", str(_MACHINE), "--loop", str(loop), "-o", str(tmp_path / "out")]
    assert main([*words, "--apply"]) == 1
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1 and "at least 6 dB and 30 degrees" in lines[0], lines
    assert not (tmp_path / "out").exists()


@pytest.mark.long
def test_given_parameters_are_set_with_the_delay_that_was_measured(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A file without servo_force_delay_ns: it is that of the drive, and the lead with it."""
    loop = tmp_path / "calm.toml"
    loop.write_text(
        "servo_mass_g = 1500\nservo_crossover_hz = 300\nservo_lead_percent = 2000\n"
        "servo_pole_hz = 4000\nservo_integral_mHz = 9000\n"
    )
    words = ["--machine", str(_MACHINE), "--loop", str(loop), "-o", str(tmp_path)]
    assert main([*words, "--apply"]) == 0
    assert "given:" in capsys.readouterr().out.splitlines()
    tuned = tomllib.loads((tmp_path / "force_tuned.toml").read_text("utf-8"))["controller"]
    assert tuned["servo_crossover_hz"] == 300
    assert tuned["servo_force_delay_ns"] == pytest.approx(1e3 * _LATE_US + 25e3, abs=5e3)
    assert tuned["lead_ns"] == tuned["servo_force_delay_ns"] + 50_000


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("", "no drive: give DRIVE.toml, --record FILE.csv, --machine M or --bus"),
        ("a.toml --apply", "--apply: needs a controller: add --bus, or --machine M"),
        ("--record a.csv --apply", "--apply: needs a controller: add --bus, or --machine M"),
        ("--machine m --apply", "--apply: needs a folder for the machine file: add -o DIR"),
        ("--bus --record a.csv", "argument --record: not allowed with argument --bus"),
        ("--bus --machine m", "argument --machine: not allowed with argument --bus"),
        ("--machine m --record a.csv", "argument --record: not allowed with argument --machine"),
        ("--machine m -c can0", "--channel: needs a bus: use --bus instead of --machine"),
        ("a.toml --node 5", "--node: needs a bus: add --bus"),
        ("a.toml --highest-hz 900", "--highest-hz: needs a controller: add --bus, or --machine M"),
        ("a.toml --pulse 10", "--pulse: needs a controller: add --bus, or --machine M"),
        ("a.toml --bus --pulse 10", "DRIVE.toml: has no effect with --pulse; leave it out"),
        ("--machine m --pulse 10 -o d", "-o: has no effect with --pulse; leave it out"),
        ("--machine m --pulse 10 --apply", "--apply: sets the result of a pulse over CAN only"),
        ("--machine m --pulse 1e9", "--pulse 1e+09: give at most 4000"),
        ("--bus --highest-hz 20", "--highest-hz 20: give at least 50"),
        ("--bus --interface nobus", "interface nobus: unknown to python-can"),
    ],
)
def test_options_that_do_not_go_together_are_one_line(
    words: str, says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """It names the option and the remedy; status 2."""
    line = complaint(main, words.split(), capsys)
    assert line.startswith(f"tune: {says}"), line


def double(last_hz: float) -> OpenLoop:
    """Return K (1 + s T) exp(-s d) / s^2 at every 10 Hz; |L| = 1 at 200 Hz."""
    hz = np.arange(5.0, last_hz, 10.0)
    s, cross = 2j * np.pi * hz, 2j * np.pi * 200.0
    lead_s, delay_s = 2e-3, 0.2e-3
    gain = abs(cross**2 / (1 + cross * lead_s))
    return OpenLoop(hz, gain * (1 + s * lead_s) * np.exp(-s * delay_s) / s**2)


def test_figures_are_those_of_the_formula() -> None:
    """Phase, gain where the lead is eaten up; lines that end before the crossing are named."""
    found = figures(double(3000.0))
    assert found.crossover_hz == pytest.approx(200.0, rel=2e-3)
    phase_deg = np.degrees(np.arctan(2 * np.pi * 200 * 2e-3)) - 360 * 200 * 0.2e-3
    assert found.phase_deg == pytest.approx(phase_deg, abs=0.1)
    turns = np.arange(200.0, 3000.0, 0.01)
    left = np.degrees(np.arctan(2 * np.pi * turns * 2e-3)) - 360 * turns * 0.2e-3
    turn_hz = float(turns[int(np.argmin(np.abs(left)))])
    assert found.gain_hz == pytest.approx(turn_hz, rel=2e-3)
    ratio = np.abs(1 + 2j * np.pi * np.array([200.0, turn_hz]) * 2e-3)
    level = 20 * np.log10(ratio[1] / ratio[0] * (200.0 / turn_hz) ** 2)
    assert found.gain_db == pytest.approx(-level, abs=0.05)
    assert loop_text(double(900.0)).endswith("gain margin not within the lines of 5 .. 895 Hz")
    assert figures(double(900.0)).phase_deg == figures(double(3000.0)).phase_deg
    assert loop_text(double(150.0)) == "crossover not within the lines of 5 .. 145 Hz"


def test_picture_has_the_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """Level, phase and Nyquist; without a record there are none."""
    seen: list[Figure] = []
    monkeypatch.setattr(style, "png_of", seen.append)
    plant = Plant(mass_kg=1.5, amplifier_hz=1500.0, delay_s=25e-6, step_hz=20000.0)
    judged = judge(Loop(250.0, 20.0, 4000.0, 10.0, 4000.0, 0.5, 0.5), plant)
    one = double(3000.0)
    for measured in (None, one):
        plots.loop_png(judged, "demo", measured)
    dots = [[line for axes in figure.axes for line in axes.lines if line.get_marker() == "."]
            for figure in seen]  # fmt: skip
    assert not dots[0]
    level, phase, nyquist = (np.asarray(line.get_ydata()) for line in dots[1])
    np.testing.assert_allclose(10 ** (level / 20), np.abs(one.response))
    turns = np.exp(1j * np.radians(phase))
    np.testing.assert_allclose(turns, one.response / np.abs(one.response), atol=1e-9)
    np.testing.assert_allclose(nyquist, one.response.imag)
    assert phase.max() <= 0.0 and phase.min() > -360.0
