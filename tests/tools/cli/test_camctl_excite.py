"""camctl's excitation of U and learned values against the firmware, over a bus."""

import signal
import threading
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from camtools.link import excitation, scope
from camtools.link.controller import Link
from camtools.link.kept_values import LAYOUT
from camtools.link.messages import COMMAND, Refused
from checks.patience import until
from tests.tools.cases.camctl_bench import Bench, Refusal, act_when, columns, linked, order

N, PERIODS, HEIGHT_NM = 400, 2, 40_000.0


def tone(amplitude_nm: float, line: int = 2) -> npt.NDArray[np.int64]:
    """Return a period of one line."""
    turn = 2 * np.pi * np.arange(N) / N
    return np.rint(amplitude_nm * np.sin(line * turn + 1)).astype(np.int64)


@pytest.fixture
def wave(tmp_path: Path) -> Path:
    """Write a wave."""
    path = tmp_path / "wave.csv"
    path.write_text("u_nm\n" + "".join(f"{value}\n" for value in tone(HEIGHT_NM)))
    return path


def test_u_plays_what_the_file_says(bench: Bench, wave: Path, tmp_path: Path) -> None:
    """Every tick of both periods; U is then where it was, and the state ready."""
    bench.do("home")
    record = tmp_path / "record.csv"
    words = ("--periods", str(PERIODS), "--fade-ticks", "200", "--place-nm", "-300000")
    assert "signals at 20000 Hz" in bench.do("excite", wave, record, *words)
    told = columns(record)
    assert list(told) == ["tick", "t_s", *scope.DEFAULT_SIGNALS]
    played = np.array(told["u_set_q6"][-PERIODS * N :], np.int64).reshape(PERIODS, N)
    assert np.all(played == (tone(HEIGHT_NM) - 300_000) * 64)
    assert np.all(np.diff(np.array(told["tick"], np.int64)) == 1)
    assert "state             ready" in bench.do("status")
    assert "black box         recording" in bench.do("blackbox")


def test_a_force_is_chosen_by_the_heading(bench: Bench, tmp_path: Path, refusal: Refusal) -> None:
    """Sample by sample in the force of U, a row later; a U that takes positions refuses it."""
    wave, record = tmp_path / "force.csv", tmp_path / "record.csv"
    samples = tone(9000)
    wave.write_text("force_mn\n" + "".join(f"{value}\n" for value in samples))
    bench.do("home")
    assert "takes positions: give a wave of nm" in refusal(bench, 1, f"excite {wave} {record}")
    bench.do("disable")
    bench.take_forces()
    for name, value in (("servo_integral_mHz", 0), ("servo_crossover_hz", 1)):
        bench.do("set", name, str(value))
    bench.do("home")
    words = f"excite {wave} {record} --periods 2 --fade-ticks 200 --signals u_set_q6,u_force_q6"
    bench.do(*words.split())
    told = columns(record)
    force_q6 = np.array(told["u_force_q6"][-2 * N + 1 :], np.int64)
    assert np.all(np.abs(force_q6 - 64 * np.tile(samples, 2)[:-1]) <= 2)
    assert not np.any(np.array(told["u_set_q6"][-2 * N :], np.int64))
    wave.write_text("force_mn\n" + "600001\n" * 20)
    line = refusal(bench, 1, f"excite {wave} {record}")
    assert "600001 mN, servo_force_limit_mn is 600000" in line
    wave.write_text("u_nm\n" + "0\n" * 20)
    bench.do(*words.split())
    assert max(map(abs, map(int, columns(record)["u_force_q6"][-20:]))) <= 2


def test_excitation_needs_ready(bench: Bench, wave: Path, tmp_path: Path, refusal: Refusal) -> None:
    """Refused in off; beyond the limits with the numbers; nothing is written."""
    record = tmp_path / "record.csv"
    assert "must be ready" in refusal(bench, 1, f"excite {wave} {record}")
    bench.do("home")
    line = refusal(bench, 1, f"excite {wave} {record} --place-nm 590000")
    assert "629999 nm, u_stroke_nm is 1200000" in line
    line = refusal(bench, 1, f"excite {wave} {record} --fade-ticks 20")
    assert "u_acceleration_mm_per_s2 is 250000" in line
    assert "at most 1200000 ticks" in refusal(bench, 1, f"excite {wave} {record} --periods 3001")
    for words in ("--periods 65536", "--fade-ticks 15", "--place-nm 15000001", "--signals u_set"):
        assert words.split()[1] in refusal(bench, 2, f"excite {wave} {record} {words}")
    short = tmp_path / "short.csv"
    short.write_text("u_nm\n" + "1\n" * 15)
    assert "wave length" in refusal(bench, 1, f"excite {short} {record}")
    for text, why in (
        ("", "no heading u_nm or force_mn"),
        ("force_mn\n0.5\n", "line 2: no whole number of mN"),
        ("force_mn\n", "one per line after force_mn"),
        ("u_nm\n", "no samples"),
        ("u_nm\nx\n", "line 2: no whole number of nm"),
    ):
        short.write_text(text)
        assert why in refusal(bench, 2, f"excite {short} {record}")
    assert "check the path" in refusal(bench, 2, f"excite {tmp_path / 'none'} {record}")
    with linked(bench) as link, pytest.raises(Refused, match="the controller holds 131072"):
        excitation.download_wave(link, np.zeros(131073))
    assert not record.exists()


@pytest.mark.parametrize("is_heard", [True, False])
def test_what_ends_an_excitation(bench: Bench, link: Link, *, is_heard: bool) -> None:
    """The stop of another program, and a tool that is not heard; U rests without a fault."""

    def act() -> None:
        if is_heard:
            order(bench, "stop")
        else:
            bench.drop = lambda frame: frame.arbitration_id == COMMAND.frame_id

    bench.do("home")
    link.rights.on_lost = lambda text, holder: None
    thread = act_when(bench, lambda status: status.state == "identifying", act)
    with pytest.raises(Refused, match="cut short: stopped" if is_heard else None):
        excitation.excite(link, tone(HEIGHT_NM), 300, place_nm=-300_000)
    thread.join()
    bench.drop = lambda frame: False
    until(lambda: "state             ready" in bench.do("status"), "ready")
    if not is_heard:
        assert scope.EXCITED[scope.get(link, "excited")] == "silent"
    assert "faults            none" in bench.do("status")


def test_an_interrupted_tool_stops_u(bench: Bench, wave: Path, tmp_path: Path) -> None:
    """Ctrl-C: U comes to rest at once, no file."""
    bench.do("home")
    record = tmp_path / "record.csv"
    threading.Timer(1.0, signal.raise_signal, [signal.SIGINT]).start()
    status, _ = bench.run("excite", wave, record, "--periods", "1000")
    assert status != 0
    assert not record.exists()
    until(lambda: "state             ready" in bench.do("status"), "ready")


def test_learned_values_are_told_and_kept(bench: Bench, tmp_path: Path) -> None:
    """The report tells why nothing is learned; what is saved can be brought back."""
    text = bench.do("learned")
    assert "learning          off, not" in text
    file = tmp_path / "kept.toml"
    assert "saved" in bench.do("learned", "save", file)
    lines = file.read_text().splitlines()
    assert 'part = "short skirt"' in lines
    assert [line.split()[0] for line in lines[3:]] == list(LAYOUT)
    assert "in force" in bench.do("learned", "load", file)


def test_bad_learned_values_are_refused(bench: Bench, tmp_path: Path, refusal: Refusal) -> None:
    """No TOML, a key missing, too few, no integers, foreign; half a command."""
    file = tmp_path / "kept.toml"
    bench.do("learned", "save", file)
    good = file.read_text()
    for old, new, why in (
        ("part =", "part", "kept.toml: no learned values"),
        ("k1_q16 = 0", "", "k1_q16: not a whole number"),
        ("k1_q16 = 0", "k1_q16 = 3000000000", "k1_q16: not a whole number"),
        ("gain_q12 = [0, ", "gain_q12 = [", "gain_q12: not 34 whole numbers"),
        ("k2_q16 = 0", "k2_q16 = 0\nother = 1", "other: unknown key"),
    ):
        file.write_text(good.replace(old, new))
        assert why in refusal(bench, 2, f"learned load {file}")
    assert "save FILE or load FILE" in refusal(bench, 2, "learned save")
    assert "check the path" in refusal(bench, 2, f"learned load {tmp_path / 'none'}")
