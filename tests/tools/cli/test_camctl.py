"""tools/camctl against the firmware with an ideal machine, over a bus within this process."""

import csv
import io
import os
import re
import signal
import threading
from functools import partial
from pathlib import Path

import pytest
from pytest import MonkeyPatch

from camtools.cli.camctl import main
from camtools.link.messages import NAMES
from camtools.link.status_text import COLUMNS
from checks.patience import limit_s, until
from tests.tools.cases.camctl_bench import Act, Bench, Refusal
from tests.tools.cases.part_cases import Capture

interrupt = partial(signal.raise_signal, signal.SIGINT)  # press control-C


def test_a_part_is_cut_and_recorded(bench: Bench, tmp_path: Path) -> None:
    """Home, cut, stop, off; the record shows the cut with U near its set-point."""
    assert "off" in bench.do("status")
    assert bench.do("home") == "home: ready\n"
    assert bench.do("speed", "1500.5") == "speed = 1500.5 r/min\n"
    file = tmp_path / "cut.csv"
    with bench.cutting("engaging"):
        assert "rows" in bench.do("record", file, "--cut")
    with file.open(newline="") as text:
        rows = list(csv.DictReader(text))
    assert tuple(rows[0]) == COLUMNS
    cutting = [row for row in rows if row["state"] == "cutting"]
    assert cutting
    assert all(abs(float(row["speed_rpm"]) - 1500.5) < 2 for row in cutting)
    assert max(abs(float(row["u_set_mm"])) for row in cutting) > 0.05
    assert all(abs(float(row["following_error_mm"])) < 1e-3 for row in cutting)
    assert all(row["faults"] == "" for row in rows)
    assert rows[-1]["state"] == "ready"
    assert float(rows[0]["t_s"]) < float(rows[-1]["t_s"])
    assert "off" in bench.do("disable")


def when_it_grows(folder: Path, act: Act) -> None:
    """Act beside the test when a record has begun to fill a file of a folder."""

    def wait() -> None:
        until(lambda: any(f.stat().st_size for f in folder.rglob("*.csv")), "rows of a record")
        act()

    threading.Thread(target=wait).start()


def test_a_record_of_a_cut_that_fails_says_so(bench: Bench, tmp_path: Path) -> None:
    """The emergency stop in the cut ends the record with status 1, the rows are there."""
    bench.do("home")
    file = tmp_path / "cut.csv"
    bench.do("set", "engage_turns", "100")
    with bench.cutting("engaging"):
        when_it_grows(tmp_path, lambda: bench.estop(True))
        status, text = bench.run("record", file, "--cut")
    assert status == 1
    assert "rows" in text
    assert file.read_text().splitlines()[-1].split(",")[1:3] == ["fault", "estop"]


def test_start_waits_for_the_part(bench: Bench) -> None:
    """The command shows how far it is, and ends when the part is cut."""
    bench.do("home")
    lines = bench.do("start").splitlines()
    assert re.fullmatch(r"start: part cut, \d+ turns", lines[-1])
    assert lines[0].startswith("engaging: 0 %, ")
    assert any(re.match(r"cutting: \d+ %, 0:\d\d left", line) for line in lines)
    assert bench.do("home") == "home: ready\n"


def test_control_c_stops_the_cut_and_waits_for_its_end(bench: Bench, refusal: Refusal) -> None:
    """The status tells that the part is not whole."""
    bench.do("home")
    bench.do("set", "engage_turns", "100")
    line = refusal(bench, 1, "start", on="engaging", act=interrupt)
    assert line == "camctl: start: stopped by control-C before its end"
    assert "state             ready" in bench.do("status")


def test_a_fault_is_told_and_left(bench: Bench, refusal: Refusal) -> None:
    """Emergency stop: enable says why not; in ready it is a fault, shown with its meaning."""
    bench.estop(True)
    assert "emergency stop    yes" in bench.do("status")  # a tick has seen it
    assert "estop; release the emergency stop" in refusal(bench, 1, "enable")
    bench.estop(False)
    assert "emergency stop    no" in bench.do("status")
    bench.do("home")
    bench.estop(True)
    bench.do("status")
    assert "home: refused: state" in refusal(bench, 1, "home")
    text = bench.do("status")
    assert "state             fault" in text
    assert "estop: Emergency stop." in text
    bench.estop(False)
    answers = (bench.run("reset") for _ in range(100))  # refused until the retract has ended
    assert next(text for status, text in answers if status == 0) == "reset: off\n"


def test_wrong_state_is_refused(bench: Bench, refusal: Refusal) -> None:
    """The line names the state and what to do in it."""
    for command, remedy in (
        ("start", "home first"),
        ("reset", "there is no fault to reset"),
        ("home x", "give manual first"),
    ):
        line = refusal(bench, 1, command)
        assert line.endswith(f": refused: state off; {remedy}")
    bench.do("home")
    assert refusal(bench, 1, "manual").endswith("refused: state ready; disable first")
    assert refusal(bench, 1, "home u").endswith("state ready; disable, then give manual first")


def test_parameters_are_read_and_set_with_their_range(bench: Bench, refusal: Refusal) -> None:
    """By name; a value beyond the range is told the range, also beyond 32 bits."""
    assert (
        bench.do("get", "counts_per_turn", "lead_ns")
        == "counts_per_turn = 10000\nlead_ns = 50000\n"
    )
    assert bench.do("set", "engage_turns", "7") == "engage_turns = 7\n"
    assert bench.do("get", "engage_turns") == "engage_turns = 7\n"
    assert "engage_turns is 1 .. 100" in refusal(bench, 1, "set engage_turns 101")
    assert "engage_turns is 1 .. 100" in refusal(bench, 1, "set engage_turns 99999999999")
    assert refusal(bench, 2, "feed 99") == "camctl: feed = 99 mm: out of range; give 0 .. 10 mm"
    assert bench.do("get", "engage_turns") == "engage_turns = 7\n"
    assert "no such parameter" in refusal(bench, 2, "set engage_turn 5")
    assert "no such parameter" in refusal(bench, 2, "get phase")
    listed = bench.do("list")
    assert len(listed.splitlines()) == len(NAMES["parameter"])
    assert bench.do("list", "z_[im]*").split() == [
        *("z_is_measured", "0", "0", "..", "1"),
        *("z_margin_nm", "100000", "0", "..", "10000000"),
    ]
    assert "no parameter" in refusal(bench, 2, "list x?x")


def test_quick_values_have_units_and_ranges(bench: Bench, refusal: Refusal) -> None:
    """Speed, feed, amplitude and phase in the operator's units."""
    assert bench.do("feed", "0.15") == "feed = 0.15 mm\n"
    assert bench.do("get", "feed_nm") == "feed_nm = 150000\n"
    assert bench.do("amplitude", "50.5") == "amplitude = 50.5 %\n"
    assert bench.do("phase", "-12.25") == "phase = -12.25 deg\n"
    assert bench.do("get", "phase_udeg") == "phase_udeg = -12250000\n"
    assert "125" in refusal(bench, 2, "amplitude 126")
    bench.do("speed", "3500")
    assert refusal(bench, 1, "enable").endswith(
        "needs 3500 r/min, limit 3000 r/min (spindle_limit_mrpm); "
        "the highest feasible speed is 3000 r/min"
    )


def test_an_interrupt_ends_a_record_whole(bench: Bench, tmp_path: Path) -> None:
    """Control-C is how a record without --seconds ends: status 0, all rows written."""
    file = tmp_path / "cut.csv"
    when_it_grows(tmp_path, interrupt)
    assert "rows" in bench.do("record", file)
    lines = file.read_text().splitlines()
    assert len(lines) > 3
    assert all(line.count(",") == len(COLUMNS) - 1 for line in lines)


def test_a_record_replaces_the_old_one_at_its_end(bench: Bench, tmp_path: Path) -> None:
    """While it goes on the old one is whole."""
    file, seen = tmp_path / "cut.csv", list[str]()
    file.write_text("an older cut\n")
    look = threading.Timer(0.3, lambda: seen.append(file.read_text()))
    look.start()
    assert "rows" in bench.do("record", file, "--seconds", "0.6")
    look.join()
    assert seen == ["an older cut\n"]
    assert file.read_text().startswith(",".join(COLUMNS))
    assert list(tmp_path.iterdir()) == [file]


def test_a_record_into_no_file_is_written_at_once(bench: Bench, tmp_path: Path) -> None:
    """A pipe is no file that could be replaced; a folder is refused."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    read: list[str] = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_text()))
    reader.start()
    assert "rows" in bench.do("record", pipe, "--seconds", "0.2")
    reader.join()
    assert pipe.is_fifo() and read[0].startswith(",".join(COLUMNS))
    assert bench.run("record", tmp_path, "--seconds", "0.2")[0] == 2


def test_watch_prints_lines_or_draws(bench: Bench, monkeypatch: MonkeyPatch) -> None:
    """Without a terminal a line at a time; with one a page that is drawn over."""
    bench.do("home")
    seconds, every = str(limit_s(0.5)), str(limit_s(0.1))
    lines = bench.do("watch", "--seconds", seconds, "--every", every).splitlines()
    assert 1 <= len(lines) <= 6
    assert all(line.startswith("ready") and "following error" in line for line in lines)
    screen = io.StringIO()
    monkeypatch.setattr(screen, "isatty", lambda: True)
    words = ["-i", "virtual", "-c", bench.channel, "watch", "--seconds", seconds]
    bench.estop(True)
    assert main(words, screen) == 0
    text = screen.getvalue()
    assert text.startswith("\x1b[2J\x1b[H")
    assert "estop: Emergency stop." in text
    assert "short skirt   state: FAULT" in text


def test_no_controller_is_told_with_what_to_check(tmp_path: Path, capsys: Capture) -> None:
    """An empty bus: status 1 and one line; a record leaves the older one, and nothing beside it."""
    file = tmp_path / "cut.csv"
    file.write_text("an older cut\n")
    for command in (["enable"], ["status"], ["record", str(file)]):
        assert main(["-i", "virtual", "-c", "nobody", *command]) == 1
        (line,) = capsys.readouterr().err.splitlines()
        assert "no answer and no status" in line and "--bitrate" in line
    assert file.read_text() == "an older cut\n"
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.usefixtures("no_bus")
def test_a_bus_that_cannot_open(capsys: Capture, monkeypatch: MonkeyPatch) -> None:
    """Unknown interface, none at all: status 2 and the remedy; the environment gives defaults."""
    for words, remedy in (
        (["-i", "slcn"], "did you mean slcan?"),
        ([], "set CAN_INTERFACE and CAN_CHANNEL, or start tools/live\n"),
    ):
        assert main([*words, "status"]) == 2
        assert remedy in capsys.readouterr().err
    monkeypatch.setenv("CAN_INTERFACE", "virtual")
    assert main(["status"]) == 1


@pytest.mark.parametrize(
    "words",
    [
        *([], ["fly"], ["speed"], ["speed", "fast"], ["table"]),
        *(["speed", "nan"], ["speed", "inf"], ["amplitude", "nan"], ["phase", "--", "-inf"]),
        *(["watch", "--every", "0"], ["watch", "--every", "nan"], ["watch", "--seconds", "-1"]),
        *(["record", "x.csv", "--seconds", "0"], ["--node", "0", "status"]),
        *(["-n", "128", "status"], ["jog"], ["jog", "w", "+"], ["jog", "x", "up"], ["home", "y"]),
        *(["jog", "x", "+", "--speed", "0"], ["jog", "x", "--step", "nan"], ["tool", "5"]),
        ["zero", "u", "--height", "1"],
    ],
)
def test_wrong_usage_is_status_2(words: list[str], capsys: Capture) -> None:
    """One line that names the help."""
    with pytest.raises(SystemExit) as stop:
        main(words)
    assert stop.value.code == 2
    assert "--help" in capsys.readouterr().err
