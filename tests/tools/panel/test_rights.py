"""Command, presses of a jog button and the log, by themselves."""

import errno
import json
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from io import FileIO
from pathlib import Path

import pytest

from camtools.base.errors import CamtoolsError
from camtools.panel.orders import commander
from camtools.panel.orders.commander import Commander, CommandLog, Visitor
from camtools.panel.orders.jog_press import LATE_S, SILENT_S, Press, Presses
from camtools.panel.orders.order import Outcome
from tests.tools.cases.command_cases import files_end_at

DONE = Outcome(True, "done")


@dataclass
class Bench:
    """Presses by a clock that a test turns, and a visitor."""

    now_s: float = 1000.0
    visitor: Visitor = field(default_factory=lambda: Visitor("v1"))

    def __post_init__(self) -> None:
        """Make the presses."""
        self.presses = Presses(lambda: self.now_s)

    def hold(self, number: int, sent_ms: float | None = None) -> bool:
        """Send a heartbeat."""
        return self.presses.hold(self.visitor, number, sent_ms)

    def begin(self, number: int, sent_ms: float | None = None) -> Press:
        """Begin a press."""
        return self.presses.begin(self.visitor, number, sent_ms)


def test_a_press_lives_by_its_heartbeats() -> None:
    """Silence ends it for good, whatever comes then."""
    bench = Bench()
    press = bench.begin(1)
    for _ in range(20):
        bench.now_s += SILENT_S - 0.01
        assert bench.hold(1) and press.is_alive()
    bench.now_s += SILENT_S + 0.001
    assert not press.is_alive()
    assert not any(bench.hold(number) for number in (1, 1, 1, 0, 2))
    assert not press.is_alive()


def test_a_heap_of_heartbeats_that_were_kept_back_moves_nothing() -> None:
    """They all tell when they were sent: the connection stood still for two seconds."""
    bench = Bench()
    bench.presses.is_late(bench.visitor, 0.0)
    begun_s = bench.now_s
    press = bench.begin(1, 10.0)
    bench.now_s += 2.0
    assert not press.is_alive()
    assert not any(bench.hold(1, 1e2 * i) for i in range(1, 20))
    with pytest.raises(CamtoolsError, match="took too long to arrive"):
        bench.begin(2, 500.0)
    bench.now_s = begun_s + 3.0
    assert bench.begin(3, 3000.0).is_alive()


def test_late_heartbeats_do_not_keep_a_press_alive() -> None:
    """Each comes 100 ms behind the other, but all of them half a second late."""
    bench = Bench()
    start_s = bench.now_s
    press = bench.begin(1, 0.0)
    for i in range(1, 6):
        bench.now_s = start_s + 0.1 * i
        assert not bench.hold(1, 1e3 * (0.1 * i - LATE_S - 0.05))
    assert not press.is_alive()


def test_a_browser_whose_clock_goes_slowly_is_heard_all_day() -> None:
    """By 1e-4 slower than ours, for ten hours."""
    bench = Bench()
    start_s = bench.now_s
    for number in range(600):
        bench.now_s += 60.0
        assert bench.begin(number, 1e3 * (bench.now_s - start_s) * (1 - 1e-4)).is_alive()
        bench.presses.end(bench.visitor, number)


def test_numbers_of_presses_rise() -> None:
    """What is duplicated on the way begins nothing; another's press is not held or ended."""
    presses, one, other = Bench().presses, Visitor("v1"), Visitor("v2")
    press = presses.begin(one, 5)
    with pytest.raises(CamtoolsError, match="another button is held"):
        presses.begin(other, 1)
    presses.end(other, 5)
    assert press.is_alive() and not presses.hold(other, 5)
    presses.end(one, 5)
    for number in (5, 4, -1):
        with pytest.raises(CamtoolsError, match="is over"):
            presses.begin(one, number)
    assert not press.is_alive() and press.ending == "released"


def test_of_many_who_take_the_command_at_once_one_has_it() -> None:
    """Each from a thread of its own."""
    commander = Commander(CommandLog(None))
    visitors = [Visitor(f"v{i}") for i in range(32)]
    with ThreadPoolExecutor(32) as pool:
        results = [outcome.is_done for outcome in pool.map(commander.take, visitors)]
    assert sum(results) == 1
    guest = Visitor("g")
    assert not commander.take(guest).is_done and not commander.release(guest).is_done
    assert commander.holder in visitors


def test_the_log_is_its_owners_alone_and_bounded(tmp_path: Path) -> None:
    """JSON lines; a second panel is refused; a full file gets another name."""
    path = tmp_path / "deep" / "commands.jsonl"
    log, visitor = CommandLog(path, 4000), Visitor("v1")
    assert path.stat().st_mode & 0o777 == 0o600
    with pytest.raises(CamtoolsError, match="another panel writes it; give another --log"):
        CommandLog(path)
    for i in range(100):
        log.add(visitor, "feed", {"percent": i, "name": "a\nb\u2028<c>"}, DONE)
    log.close()
    files = sorted(path.parent.iterdir())
    assert [one.name for one in files] == [f"commands.jsonl{end}" for end in ("", ".1", ".2")]
    for one in files:
        assert one.stat().st_size <= 4000 and one.stat().st_mode & 0o777 == 0o600
    rows = [json.loads(line) for line in path.read_text("ascii").splitlines()]
    assert rows[-1]["arguments"] == {"percent": 99, "name": "a\nb\u2028<c>"}
    assert set(rows[-1]) == {*("time", "visitor", "order", "arguments", "is_done", "outcome")}
    CommandLog(path).close()


def test_a_full_disc_is_told_and_spoils_no_line_but_its_own(tmp_path: Path) -> None:
    """The half of a line that found room stands alone when there is room again."""
    path = tmp_path / "a.jsonl"
    log, visitor = CommandLog(path), Visitor("v1")
    log.add(visitor, "first", {}, DONE)
    with files_end_at(path.stat().st_size + 20):
        log.add(visitor, "second", {}, DONE)
        assert "commands are not logged" in log.problem
        log.add(visitor, "third", {}, DONE)
        assert "commands are not logged" in log.problem
    log.add(visitor, "fourth", {}, DONE)
    assert log.problem == ""
    log.close()
    first, half, fourth = path.read_text("ascii").splitlines()
    assert [json.loads(line)["order"] for line in (first, fourth)] == ["first", "fourth"]
    assert len(half) == 20


def test_a_log_that_could_not_begin_anew_goes_on_when_it_can(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The old one has its new name already, and is not lost."""
    path = tmp_path / "a.jsonl"
    log, visitor = CommandLog(path, 300), Visitor("v1")
    log.add(visitor, "first", {}, DONE)

    def no_room(_path: Path) -> FileIO:
        raise OSError(errno.ENOSPC, "no space left")

    with monkeypatch.context() as patch:
        patch.setattr(commander, "_open", no_room)
        for _ in range(3):
            log.add(visitor, "lost", {"what": "x" * 200}, DONE)
            assert "no space left" in log.problem
    log.add(visitor, "last", {"what": "x" * 200}, DONE)
    assert log.problem == ""
    log.close()
    assert json.loads(path.read_text("ascii"))["order"] == "last"
    assert json.loads(path.with_name("a.jsonl.1").read_text("ascii"))["order"] == "first"


@pytest.mark.parametrize("make", ["folder", "unwritable"])
def test_a_log_that_cannot_be_written_is_one_line(tmp_path: Path, make: str) -> None:
    """Before the panel begins."""
    path = tmp_path if make == "folder" else Path("/proc/nosuch/a.jsonl")
    with pytest.raises(CamtoolsError, match="give another --log"):
        CommandLog(path)
