# SPDX-License-Identifier: Apache-2.0
"""A force drive is measured by its set-point, with the loop of the firmware closed."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest

from camtools.base.project_paths import ROOT
from camtools.cli.tune import main
from camtools.link.controller import Link
from camtools.link.messages import NUMBERS
from camtools.link.refusal_text import ask_done
from camtools.tune.excited import Measured, measure, simulated_u
from tests.tools.cases.camctl_bench import Bench, ready
from tests.tools.cases.command_cases import complaint
from tests.tools.cases.live_cases import live_case

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


def margins_of(at: dict[str, int]) -> tuple[float, float, float]:
    """Return crossover [Hz], phase [degrees] and gain margin [dB] of a loop on the machine."""
    hz = np.arange(1.0, 9000.0, 0.5)
    s, z = 2j * np.pi * hz, np.exp(2j * np.pi * hz / _TICK_HZ)
    tustin = 2.0 * _TICK_HZ * (z - 1.0) / (z + 1.0)
    pole, wc = 2.0 * np.pi * at["servo_pole_hz"], 2.0 * np.pi * at["servo_crossover_hz"]
    zero = pole / (at["servo_lead_percent"] / 100.0)
    integral = 2.0 * np.pi * at["servo_integral_mHz"] / 1000.0
    gain = at["servo_mass_g"] / 1000.0 * wc**2 * abs((1 + 1j * wc / pole) / (1 + 1j * wc / zero))
    control = gain * (1 + integral / tustin) * (1 + tustin / zero) / (1 + tustin / pole)
    q = (z - 1.0) / (z + 1.0) / np.tan(np.pi * at["servo_notch_hz"] / _TICK_HZ)
    dampings = (at[f"servo_notch_{name}_permille"] / 500.0 for name in ("zero", "pole"))
    above, below = (q * q + twice * q + 1.0 for twice in dampings)
    late = np.exp(-s * (25e-6 + 0.5 / _TICK_HZ)) / (1.0 + s / (2.0 * np.pi * 2000.0))
    opened = control * above / below * late / (1.5 * s * s)
    last = int(np.flatnonzero(np.abs(opened) > 1.0)[-1])
    phase = 180.0 + np.degrees(np.angle(opened[last]))
    turn = last + int(np.argmax(opened[last:].imag > 0.0))
    return float(hz[last]), float(phase), float(-20.0 * np.log10(np.abs(opened[turn])))


def values_over(link: Link, names: Iterable[str]) -> dict[str, int]:
    """Return parameters in force."""
    return {name: int(ask_done(link, "get_parameter", NUMBERS["parameter"][name]).value)
            for name in names}  # fmt: skip


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


def test_a_loop_is_set_over_can_and_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """From a weak loop on; the report of the second run has the margins of the loop that was set.

    A drive file gives the limits of the force.
    """
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    machine, limits = tmp_path / "weak.toml", tmp_path / "coil.toml"
    machine.write_text(_MACHINE.read_text("utf-8") + _WEAK, "utf-8")
    limits.write_text("force_limit_n = 450.0\ncontinuous_n = 200.0\n")
    words = [str(limits), "--bus", "-o", str(tmp_path / "out")]
    with live_case(tmp_path, "--machine", machine) as live:
        live.order("enable", "ready")
        live.link.rights.release()
        assert main([*words, "--apply"]) == 0
        said = capsys.readouterr().out
        weak = re.search(rf"as it is \(measured\): {_FIGURES}", said)
        assert weak is not None and float(weak[1]) == pytest.approx(60.0, rel=0.1)
        assert "applied: 18 parameters; the drives are off, enable and home again" in said
        path = tmp_path / "out" / "coil_servo.toml"
        loop = tomllib.loads(path.read_text("utf-8"))["axis_u"]
        assert loop["servo_force_limit_mn"] == 450_000
        assert loop["servo_mass_g"] == pytest.approx(1500, rel=0.02)
        live.until("off")
        assert values_over(live.link, loop) == loop
        live.order("enable", "ready")
        live.link.rights.release()
        assert main(words) == 0
    found = re.search(rf"as it is \(measured\): {_FIGURES}", capsys.readouterr().out)
    assert found is not None
    crossover_hz, phase_deg, gain_db = margins_of(loop)
    assert float(found[1]) == pytest.approx(crossover_hz, rel=0.1)
    assert float(found[2]) == pytest.approx(phase_deg, abs=5.0)
    assert float(found[3]) == pytest.approx(gain_db, abs=1.0)


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
    assert main(["--machine", str(_MACHINE), "--pulse", "10"]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1 and "um alone; set a weaker loop, of 30 Hz" in lines[0], lines


def test_a_pulse_above_the_force_limit_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    """One line with the limit."""
    assert main(["--machine", str(_MACHINE), "--pulse", "700"]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1 and "servo_force_limit_mn is 600000" in lines[0], lines


def test_a_drive_that_takes_positions_is_refused(
    bench: Bench, capsys: pytest.CaptureFixture[str]
) -> None:
    """By its parameters before it moves, or by the force that was not recorded."""
    words = ["--bus", "--interface", "virtual", "--channel", bench.channel]
    ready(bench)
    for crossover_hz, says in (
        (0, "servo_crossover_hz = 0: U takes positions, or"),
        (50, "no force was recorded, so its U takes positions"),
    ):
        bench.do("set", "servo_crossover_hz", str(crossover_hz))
        capsys.readouterr()
        assert main(words) == 2
        lines = capsys.readouterr().err.splitlines()
        assert len(lines) == 1 and says in lines[0] and "use tools/identify" in lines[0], lines
    assert main(["--machine", "default"]) == 2
    assert "tune: default: servo_crossover_hz = 0" in capsys.readouterr().err


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
        ("a.toml --secret f", "--secret: needs a bus: add --bus"),
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
