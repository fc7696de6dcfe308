# SPDX-License-Identifier: Apache-2.0
"""tools/camctl against the firmware with an ideal machine, over a bus within this process."""

from __future__ import annotations

import csv
import io
import os
import signal
import struct
import subprocess
import threading
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path

import can
import pytest

from camtools.camctl import main
from camtools.can_download import BLOCK_BYTES
from camtools.can_link import BLOCK_ID, COMMAND, NAMES
from camtools.can_watch import COLUMNS
from camtools.mktables import main as mktables

ROOT = Path(__file__).resolve().parents[2]
BENCH = ROOT / os.environ.get("CAMTURN_BUILD", "build/host") / "tests" / "camctl" / "can_bench"
FRAME = struct.Struct("<IB3x8s")
ESTOP_ID = 0x10000

pytestmark = pytest.mark.alone  # the controller keeps pace with the clock


class Bench:
    """The firmware in a process of its own, its frames on a virtual bus.

    Attributes
    ----------
    channel : str
        of the virtual bus
    drop : callable
        tells of a frame for the controller whether it gets lost
    node : int
        number of the controller; the firmware knows itself as 64
    """

    def __init__(self, channel: str, node: int = 64) -> None:
        assert BENCH.exists(), f"{BENCH} is missing: build the preset host, or let tools/test do it"
        self.channel, self.node = channel, node
        self.drop: Callable[[can.Message], bool] = lambda frame: False
        self._bus = can.Bus(interface="virtual", channel=channel)
        self._process = subprocess.Popen(
            [str(BENCH)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )
        self._stopping = False
        self._threads = [threading.Thread(target=loop) for loop in (self._forth, self._back)]
        for thread in self._threads:
            thread.start()

    def _write(self, identifier: int, data: bytes) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(FRAME.pack(identifier, len(data), data))
        self._process.stdin.flush()

    def _forth(self) -> None:
        while not self._stopping:
            frame = self._bus.recv(0.05)
            if frame is not None and not self.drop(frame):
                self._write(frame.arbitration_id - self.node + 64, bytes(frame.data))

    def _back(self) -> None:
        assert self._process.stdout is not None
        while len(record := self._process.stdout.read(FRAME.size)) == FRAME.size:
            identifier, n, data = FRAME.unpack(record)
            own = identifier - 64 + self.node
            self._bus.send(can.Message(arbitration_id=own, data=data[:n], is_extended_id=False))

    def estop(self, is_pressed: bool) -> None:
        """Press or release the emergency stop."""
        self._write(ESTOP_ID, bytes([is_pressed]))

    def close(self) -> None:
        """End the process and the threads."""
        self._stopping = True
        self._threads[0].join()
        assert self._process.stdin is not None and self._process.stdout is not None
        self._process.stdin.close()
        self._threads[1].join()
        self._process.wait(10)
        self._process.stdout.close()
        self._bus.shutdown()

    def run(self, *words: str | Path) -> tuple[int, str]:
        """Run camctl; return its status and what it printed."""
        out = io.StringIO()
        bus = ["--interface", "virtual", "--channel", self.channel, "--node", str(self.node)]
        return main([*bus, *map(str, words)], out), out.getvalue()

    def do(self, *words: str | Path) -> str:
        """Run camctl, which must succeed."""
        status, text = self.run(*words)
        assert status == 0, text
        return text


@pytest.fixture
def bench(request: pytest.FixtureRequest) -> Iterator[Bench]:
    """Return a fresh controller."""
    one = Bench(request.node.name)
    yield one
    one.close()


@pytest.fixture
def refusal(capsys: pytest.CaptureFixture[str]) -> Callable[[Bench, int, str], str]:
    """Return a function that runs what must end with a status, and gives its one line."""

    def run(bench: Bench, status: int, words: str) -> str:
        capsys.readouterr()
        assert bench.run(*words.split())[0] == status
        lines = capsys.readouterr().err.splitlines()
        assert len(lines) == 1, lines
        assert lines[0].startswith("camctl: ")
        return lines[0]

    return run


def named(table: bytes, name: str) -> bytes:
    """Return the table with another name and a checksum that fits: TABLE_FORMAT.md."""
    body = bytearray(table)
    body[32:64] = name.encode().ljust(32, b"\0")
    struct.pack_into("<I", body, 20, zlib.crc32(body[24:]))
    return bytes(body)


def test_a_part_is_cut_and_recorded(bench: Bench, tmp_path: Path) -> None:
    """Home, cut, stop, off; the record shows the cut with U near its set-point."""
    assert "off" in bench.do("status")
    assert bench.do("home") == "home: ready\n"
    assert bench.do("speed", "1500.5") == "speed = 1500.5 r/min\n"
    assert "start: engaging" in bench.do("start")
    file = tmp_path / "cut.csv"
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


def test_a_record_of_a_cut_that_fails_says_so(bench: Bench, tmp_path: Path) -> None:
    """The emergency stop in the cut ends the record with status 1, the rows are there."""
    bench.do("home")
    bench.do("start")
    stop = threading.Timer(0.3, bench.estop, [True])
    stop.start()
    file = tmp_path / "cut.csv"
    status, text = bench.run("record", file, "--cut")
    assert status == 1
    assert "rows" in text
    assert file.read_text().splitlines()[-1].split(",")[1:3] == ["fault", "estop"]


def test_start_waits_for_the_part(bench: Bench) -> None:
    """With --wait the command ends when the part is cut."""
    bench.do("home")
    assert bench.do("start", "--wait") == "start: ready\n"
    assert bench.do("home") == "home: ready\n"


def test_a_fault_is_told_and_left(bench: Bench, refusal: Callable[[Bench, int, str], str]) -> None:
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


def test_wrong_state_is_refused(bench: Bench, refusal: Callable[[Bench, int, str], str]) -> None:
    """The line names the command and the order of commands."""
    for command in ("start", "stop", "disable", "reset"):
        line = refusal(bench, 1, command)
        assert line.startswith(f"camctl: {command}: refused: state; see status")


def test_parameters_are_read_and_set_with_their_range(
    bench: Bench, refusal: Callable[[Bench, int, str], str]
) -> None:
    """By name; a value beyond the range is told the range, also beyond 32 bits."""
    assert (
        bench.do("get", "counts_per_turn", "lead_ns")
        == "counts_per_turn = 10000\nlead_ns = 50000\n"
    )
    assert bench.do("set", "engage_turns", "7") == "engage_turns = 7\n"
    assert bench.do("get", "engage_turns") == "engage_turns = 7\n"
    assert "engage_turns is 1 .. 100" in refusal(bench, 1, "set engage_turns 101")
    assert "engage_turns is 1 .. 100" in refusal(bench, 1, "set engage_turns 99999999999")
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


def test_quick_values_have_units_and_ranges(
    bench: Bench, refusal: Callable[[Bench, int, str], str]
) -> None:
    """Speed, feed, amplitude and phase in the operator's units."""
    assert bench.do("feed", "0.15") == "feed = 0.15 mm\n"
    assert bench.do("get", "feed_nm") == "feed_nm = 150000\n"
    assert bench.do("amplitude", "50.5") == "amplitude = 50.5 %\n"
    assert bench.do("phase", "-12.25") == "phase = -12.25 deg\n"
    assert bench.do("get", "phase_udeg") == "phase_udeg = -12250000\n"
    assert "125" in refusal(bench, 2, "amplitude 126")
    bench.do("speed", "3500")
    assert "highest feasible speed is 3000 r/min" in refusal(bench, 1, "enable")


def test_what_must_not_change_in_the_cut_is_refused(
    bench: Bench, refusal: Callable[[Bench, int, str], str]
) -> None:
    """Only phase and amplitude follow the operator while cutting."""
    bench.do("home")
    bench.do("set", "engage_turns", "100")
    bench.do("start")
    assert "param state; only phase_udeg" in refusal(bench, 1, "speed 1000")
    assert bench.do("phase", "5") == "phase = 5 deg\n"
    bench.do("stop")


@pytest.fixture(scope="module")
def fine_table(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Make a table that is finer than it need be."""
    folder = tmp_path_factory.mktemp("fine")
    part = ROOT / "tools" / "parts" / "perkins240.toml"
    assert mktables([str(part), "-o", str(folder), "--tolerance-nm", "0.03"]) == 0
    return folder / "perkins240.camtab"


@pytest.fixture
def other(fine_table: Path, tmp_path: Path) -> Path:
    """Return the table of a real part, of more than one block."""
    file = tmp_path / "other.camtab"
    file.write_bytes(named(fine_table.read_bytes(), "other part"))
    assert file.stat().st_size > BLOCK_BYTES
    return file


def test_a_table_is_downloaded_and_selected(bench: Bench, other: Path) -> None:
    """Progress is told; the old table stays in use until select."""
    crc = struct.unpack_from("<I", other.read_bytes(), 20)[0]
    before = bench.do("table", "info")
    assert "short skirt" in before
    assert "generation 1" in before
    text = bench.do("table", "download", other)
    assert f"{other.stat().st_size} of {other.stat().st_size} bytes, 100 %" in text
    assert "short skirt" in bench.do("table", "info")
    selected = bench.do("select")
    assert "other part" in selected
    assert f"CRC-32 {crc:08x}, generation 2" in selected
    assert "other part" in bench.do("table", "info")


def test_neighbours_on_one_bus_do_not_hear_one_another(bench: Bench, other: Path) -> None:
    """Each is commanded and gets its table by its own number; the next numbers are the hardest."""
    after, before = Bench(bench.channel, 65), Bench(bench.channel, 63)
    try:
        assert "other part" in bench.do("table", "download", other, "--select")
        for one in (after, before):
            assert "short skirt" in one.do("table", "info")
        assert after.do("home") == "home: ready\n"
        for one in (bench, before):
            assert "state             off" in one.do("status")
        assert "other part" in before.do("table", "download", other, "--select")
    finally:
        after.close()
        before.close()


def test_lost_frames_are_repeated(bench: Bench, other: Path) -> None:
    """A first frame and two in the middle of blocks get lost: the download goes on."""
    seen = 0

    def drop(frame: can.Message) -> bool:
        nonlocal seen
        seen += frame.arbitration_id == BLOCK_ID
        return frame.arbitration_id == BLOCK_ID and seen in (1, 50, 1000)

    bench.drop = drop
    assert "other part" in bench.do("table", "download", other, "--select")


def test_a_download_that_cannot_go_on_leaves_the_old_table(
    bench: Bench,
    other: Path,
    refusal: Callable[[Bench, int, str], str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The line says that nothing is lost; a damaged table is refused by the controller."""
    monkeypatch.setattr("camtools.can_download.MOST_REPEATS", 1)
    bench.drop = lambda frame: frame.arbitration_id == BLOCK_ID
    assert "old table stays in force" in refusal(bench, 1, f"table download {other}")
    bench.drop = lambda frame: False
    bad = other.with_name("bad.camtab")
    bad.write_bytes(other.read_bytes()[:-1] + b"\x55")
    assert "image crc" in refusal(bench, 1, f"table download {bad}")
    assert "short skirt" in bench.do("select")
    bench.do("home")
    assert "begin download: refused: state" in refusal(bench, 1, f"table download {other}")


def test_files_that_are_no_tables_are_bad_input(
    bench: Bench, tmp_path: Path, refusal: Callable[[Bench, int, str], str]
) -> None:
    """Neither a missing file nor a text is sent."""
    assert "check the path" in refusal(bench, 2, f"table download {tmp_path / 'none'}")
    text = tmp_path / "text"
    text.write_text("no table" * 100)
    assert "not a cam table" in refusal(bench, 2, f"table download {text}")
    assert "check the path" in refusal(bench, 2, f"record {tmp_path / 'none' / 'x.csv'}")


def test_an_interrupt_ends_a_record_whole(bench: Bench, tmp_path: Path) -> None:
    """Control-C is how a record without --seconds ends: status 0, all rows written."""
    file = tmp_path / "cut.csv"
    stop = threading.Timer(0.5, signal.raise_signal, [signal.SIGINT])
    stop.start()
    assert "rows" in bench.do("record", file)
    lines = file.read_text().splitlines()
    assert len(lines) > 3
    assert all(line.count(",") == len(COLUMNS) - 1 for line in lines)


def test_a_record_of_nobody_leaves_the_old_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """No controller: status 1, the file of before is there, and nothing beside it."""
    file = tmp_path / "cut.csv"
    file.write_text("an older cut\n")
    assert main(["-i", "virtual", "-c", "nobody", "record", str(file)]) == 1
    assert "no answer and no status" in capsys.readouterr().err
    assert file.read_text() == "an older cut\n"
    assert list(tmp_path.iterdir()) == [file]


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


class Terminal(io.StringIO):
    """A stream that says it can be drawn on."""

    def isatty(self) -> bool:
        """Yes."""
        return True


def test_watch_prints_lines_or_draws(bench: Bench) -> None:
    """Without a terminal a line at a time; with one a page that is drawn over."""
    bench.do("home")
    lines = bench.do("watch", "--seconds", "0.5", "--every", "0.1").splitlines()
    assert 1 <= len(lines) <= 6
    assert all(line.startswith("ready") and "following error" in line for line in lines)
    screen = Terminal()
    words = ["-i", "virtual", "-c", bench.channel, "watch", "--seconds", "0.3"]
    bench.estop(True)
    assert main(words, screen) == 0
    text = screen.getvalue()
    assert text.startswith("\x1b[2J\x1b[H")
    assert "estop: Emergency stop." in text
    assert "short skirt   state: FAULT" in text


def test_no_controller_is_told_with_what_to_check(capsys: pytest.CaptureFixture[str]) -> None:
    """An empty bus: status 1 and one line for both a command and the status."""
    for command in ("enable", "status"):
        assert main(["-i", "virtual", "-c", "nobody", command]) == 1
        line = capsys.readouterr().err
        assert "no answer and no status" in line
        assert "--bitrate" in line


def test_an_answer_that_does_not_come_is_told_from_silence(
    bench: Bench, refusal: Callable[[Bench, int, str], str]
) -> None:
    """Status comes, the command gets lost."""
    bench.drop = lambda frame: frame.arbitration_id == COMMAND.frame_id
    assert "no answer, though status comes" in refusal(bench, 1, "stop")


def test_a_bus_that_cannot_be_opened_is_bad_input(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Unknown interface, none at all: status 2 and the remedy; the environment gives defaults."""
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("CAN_INTERFACE", raising=False)
    for words in (["-i", "nosuch"], []):
        assert main([*words, "status"]) == 2
        assert "set CAN_INTERFACE and CAN_CHANNEL" in capsys.readouterr().err
    monkeypatch.setenv("CAN_INTERFACE", "virtual")
    assert main(["status"]) == 1


@pytest.mark.parametrize(
    "words",
    [
        *([], ["fly"], ["speed"], ["speed", "fast"], ["table"]),
        *(["speed", "nan"], ["speed", "inf"], ["amplitude", "nan"], ["phase", "--", "-inf"]),
        *(["watch", "--every", "0"], ["watch", "--every", "nan"], ["watch", "--seconds", "-1"]),
        *(
            ["record", "x.csv", "--seconds", "0"],
            ["--node", "0", "status"],
            ["-n", "128", "status"],
        ),
    ],
)
def test_wrong_usage_is_status_2(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """One line that names the help."""
    with pytest.raises(SystemExit) as stop:
        main(words)
    assert stop.value.code == 2
    assert "--help" in capsys.readouterr().err
