"""The command that identifies U: on the simulator, over CAN, and what it refuses."""

import contextlib
import io
import json
import os
import re
import signal
import tomllib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pytest import MonkeyPatch

from camtools.cli.identify import main
from camtools.identify import drives
from camtools.link import excitation
from camtools.link.controller import Link
from camtools.link.scope import Recording
from checks.patience import until
from tests.tools.cases.camctl_bench import Bench, ready
from tests.tools.cases.camsim_cases import cut
from tests.tools.cases.drive_plant import Plant, faded, played
from tests.tools.cases.part_cases import PERKINS, Capture, TableOf

MACHINE = """\
[u]
friction_m_per_s2 = 5
{more}
[believed.u]
bandwidth_hz = 270
damping = 0.77
delay_us = 65
"""
MODE = "mode_hz = 800\nmode_share = 0.1\nmode_on_scale = 1\n"
W = 2 * np.pi * 300


def run(*words: str | Path) -> tuple[int, str]:
    """Run the command in this process; return its status and what it printed."""
    with contextlib.redirect_stdout(io.StringIO()) as out:
        return main([str(word) for word in words]), out.getvalue()


@pytest.fixture
def machine(tmp_path: Path) -> Path:
    """Return a machine file whose controller believes another drive."""
    path = tmp_path / "lathe.toml"
    path.write_text(MACHINE.format(more=""), "ascii")
    return path


def test_constants_are_found_and_applied(machine: Path, tmp_path: Path) -> None:
    """Table, lines to paste, error of the part, picture, and a machine file that is right."""
    status, text = run("--machine", machine, PERKINS, "-o", tmp_path / "out", "--apply")
    assert status == 0
    names = sorted(path.name for path in (tmp_path / "out").iterdir())
    ends = ("bode.png", "identified.json", "identified.toml", "identified.txt")
    assert names == [f"lathe_{end}" for end in ends]
    tree = tomllib.loads((tmp_path / "out" / "lathe_identified.toml").read_text())
    set_lines = re.findall(r"^tools/camctl set (\w+) (\d+)$", text, re.MULTILINE)
    assert {name: int(value) for name, value in set_lines} == tree.pop("controller")
    assert tree == tomllib.loads(machine.read_text())
    told = json.loads((tmp_path / "out" / "lathe_identified.json").read_text())
    w = 2 * np.pi * 300
    assert told["settings"]["k1_ns"] == pytest.approx(1.4 / w * 1e9, rel=0.003)
    assert told["settings"]["k2_us2"] == pytest.approx(1e12 / w**2, rel=0.003)
    assert told["settings"]["lead_ns"] == pytest.approx(100_000, abs=600)
    assert told["problems"] == []
    assert told["form_error_um"]["believed"] > 1
    assert "perkins240 at 2500 r/min: U moves at up to 39.3 mm/s" in text
    assert (tmp_path / "out" / "lathe_identified.txt").read_text() in text


@pytest.mark.long
def test_form_error_is_that_of_a_cut(table_of: TableOf, tmp_path: Path) -> None:
    """What is expected with the believed constants is what the simulator gauges."""
    machine = tmp_path / "m.toml"
    machine.write_text(MACHINE.format(more="").replace("friction_m_per_s2 = 5", ""), "ascii")
    text = run("--machine", machine, PERKINS, "-o", tmp_path)[1]
    assert " um" in text and text.isascii()  # for every terminal
    expected = json.loads((tmp_path / "m_identified.json").read_text())["form_error_um"]["believed"]
    words = ("--machine", machine, "--set", "learn_harmonics=0", "--set", "rehearse_turns=0")
    gauged = cut(table_of("perkins240"), *words, status=None)
    assert expected == pytest.approx(gauged.form_error_um, rel=0.03)


def off_inverse(settings: dict[str, float], hz: float) -> float:
    """Return by how much the feed-forward is off the inverse of a drive with `MODE`."""
    s = 2j * np.pi * hz
    true = 1 + (1.4 * s / W + (s / W) ** 2)
    wm = 2 * np.pi * 800
    true /= 1 - 0.1 * s**2 / (s**2 + 0.06 * wm * s + wm**2)
    set_to = 1 + settings["k1_ns"] * 1e-9 * s + settings["k2_us2"] * 1e-12 * s**2
    lead_s = settings["lead_ns"] * 1e-9 - 100e-6
    return float(abs(set_to * np.exp(s * lead_s) / true - 1))


@pytest.mark.long
def test_drive_that_rings_is_fitted_beside_its_mode(tmp_path: Path) -> None:
    """Without a mode the fit is 10 % off; with it harmonic 2 of 3000 r/min or a part decides."""
    rings = tmp_path / "rings.toml"
    rings.write_text(MACHINE.format(more=MODE), "ascii")
    words = ["--machine", str(rings), "-o", str(tmp_path), "--apply"]
    status, text = run(*words)
    assert status == 0
    found = re.search(r"a fit without it is off: k1 \S+ %, k2 (\S+) %", text)
    assert found is not None and abs(float(found[1])) > 10
    result = tmp_path / "rings_identified.toml"
    alone = tomllib.loads(result.read_text())["controller"]
    assert off_inverse(alone, 100) < 2e-3
    assert run(*words, str(PERKINS))[0] == 0
    for_part = tomllib.loads(result.read_text())["controller"]
    assert off_inverse(for_part, 5000 / 60) < 5e-4  # the second harmonic decides
    friction_nm = 5e9 / W**2
    for settings in (alone, for_part):
        assert settings["u_friction_nm"] == pytest.approx(friction_nm, rel=0.02)


@pytest.mark.usefixtures("undrawn")
def test_part_may_decide(tmp_path: Path, capsys: Capture) -> None:
    """Known too little, but good enough for the part; else status 1, one line and no file."""
    machine = tmp_path / "coarse.toml"
    machine.write_text(MACHINE.format(more="quantum_nm = 2000"), "ascii")
    place = ["--machine", str(machine), str(PERKINS), "-o", str(tmp_path)]
    words = [*place, "--rms-um", "3", "--periods", "3", "--apply", "--form-error-um"]
    status, text = run(*words, "0.1")
    assert status == 1
    assert "camctl set" not in text
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1 and lines[0].startswith("identify: nothing was applied: k1 is known to")
    assert not (tmp_path / "coarse_identified.toml").exists()
    status, text = run(*words, "1.0")
    assert status == 0
    assert "doubtful: k2 is known to" in text
    assert (tmp_path / "coarse_identified.toml").exists()


@pytest.mark.usefixtures("undrawn")
def test_recording_of_another_instrument(tmp_path: Path, capsys: Capture) -> None:
    """Text and JSON have each constant with its deviation; a file that cannot be used is named."""
    noise = np.random.default_rng(1).normal(0, 20_000.0, 8_020)
    u_nm = np.convolve(noise, np.hanning(21), "valid")[:8_000]
    y_nm = played([Plant()], u_nm, 10_000.0)[0]
    path, header = tmp_path / "scope.csv", "time_s,command_um,position_nm"
    rows = np.column_stack([np.arange(u_nm.size) / 10_000, u_nm / 1000, y_nm])
    np.savetxt(path, rows, delimiter=",", fmt="%.9g", header=header, comments="")
    status, text = run("--record", path, "-o", tmp_path / "out")
    assert status == 0
    assert text == (tmp_path / "out" / "scope_identified.txt").read_text()
    told = json.loads((tmp_path / "out" / "scope_identified.json").read_text())
    assert told["constants"]["k1 ns"]["found"] == pytest.approx(Plant().k1_s * 1e9, rel=0.02)
    assert told["problems"] == []
    assert re.search(r"^natural frequency Hz +30[01]\S* +\S+$|^natural .* 29\d", text, re.MULTILINE)
    assert run("--record", tmp_path / "none.csv")[0] == 2
    line = capsys.readouterr().err
    assert line.startswith(f"identify: --record {tmp_path / 'none.csv'}: cannot be read: No such")
    path.write_text("time_s,command_um\n0,1\n")
    assert run("--record", path)[0] == 2
    assert "line 1: needs one column of the position" in capsys.readouterr().err


def test_part_that_the_machine_cannot_cut_is_refused(tmp_path: Path, capsys: Capture) -> None:
    """Before anything moves; a drive that is too slow for its own feed-forward is one, too."""
    machine = tmp_path / "slow.toml"
    refusals = {
        "bandwidth_hz = 1000": "U would have to move faster than it can: needs 39.286 mm/s",
        "bandwidth_hz = 300": "parameter k2_us2 = 281448: refused: the command to U,"
        " feed-forward included, would exceed its limits;"
        " with the other parameters it is at most 32000",
    }
    for bandwidth, says in refusals.items():
        machine.write_text(f"[u]\nspeed_mm_per_s = 5\n{bandwidth}\n", "ascii")
        assert run("--machine", machine, PERKINS)[0] == 2
        [line] = capsys.readouterr().err.splitlines()
        assert says in line


# Over CAN: the firmware in a process of its own; its U is ideal, so records are a plant's.


def bus_words(bench: Bench) -> list[str]:
    """Return the options that name the bench."""
    return ["--bus", "--interface", "virtual", "--channel", bench.channel]


def excited_plant(plant: Plant) -> Callable[..., Recording]:
    """Return what stands for an excitation over the bus."""

    def excite(_link: object, u_nm: np.ndarray, periods: int, **options: object) -> Recording:
        n = u_nm.size
        wave = type("OnePeriod", (), {"u_nm": u_nm, "grid": type("G", (), {"n_ticks": n})})
        u = faded(wave, periods + 1)  # type: ignore[arg-type]
        rows = np.column_stack([u, played([plant], u, 20_000.0)[0]]).astype(np.int32)
        assert options["signals"] == ("u_command_nm", "u_actual_nm")
        signals = ("u_command_nm", "u_actual_nm")
        return Recording(signals, rows, 20_000, 1, 100, "state_left", 0, 0)

    return excite


@pytest.mark.usefixtures("undrawn")
def test_settings_reach_controller(bench: Bench, monkeypatch: MonkeyPatch, tmp_path: Path) -> None:
    """The drives go off, the parameters are set, and read back by camctl."""
    ready(bench)
    monkeypatch.setattr(drives, "excite", excited_plant(Plant(friction_m_s2=5)))
    status, text = run(*bus_words(bench), "--periods", "3", "--apply", "-o", tmp_path)
    assert status == 0, text
    assert "applied: k1_ns, k2_us2, lead_ns, u_friction_nm; the drives are off" in text
    assert "off" in bench.do("status").splitlines()[0]
    for name, value in re.findall(r"^tools/camctl set (\w+) (\d+)$", text, re.MULTILINE):
        assert bench.do("get", name) == f"{name} = {value}\n"
    assert (tmp_path / "node64_bode.png").exists()


def test_state_must_be_ready(bench: Bench, capsys: Capture) -> None:
    """Off: told with the order of things."""
    assert run(*bus_words(bench))[0] == 1
    said = capsys.readouterr().err
    assert "the state is off, U is excited in ready only; enable and home" in said


def test_interrupt_lets_u_rest(bench: Bench, monkeypatch: MonkeyPatch, capsys: Capture) -> None:
    """Ctrl-C while U is excited: the state goes back to ready, nothing is set."""
    ready(bench)
    before = bench.do("get", "k1_ns", "k2_us2", "lead_ns")
    states = []

    def interrupted(link: Link, _timeout_s: float) -> str:
        link.wait(lambda: link.status.state == "identifying", 5.0)
        states.append(link.status.state)
        os.kill(os.getpid(), signal.SIGINT)
        return "done"

    monkeypatch.setattr(excitation, "_follow", interrupted)
    assert run(*bus_words(bench), "--apply")[0] == 130
    assert capsys.readouterr().err == "identify: interrupted; nothing was written\n"
    assert states == ["identifying"]
    until(lambda: "ready" in bench.do("status").splitlines()[0], "ready")
    assert bench.do("get", "k1_ns", "k2_us2", "lead_ns") == before
