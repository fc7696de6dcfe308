"""camctl's recorder against the firmware, over a bus."""

import json
import threading
from pathlib import Path

import can
import numpy as np
import pyarrow.parquet as pq
import pytest
from pytest import MonkeyPatch

from camtools.cli.camctl_files import ABOUT
from camtools.link import scope
from camtools.link.controller import FD_PART_ID, PART_ID, Link
from checks.patience import limit_s
from tests.tools.cases.camctl_bench import Bench, Refusal, columns, order, pass_time


def test_signals_of_ticks_are_recorded(bench: Bench, tmp_path: Path) -> None:
    """In any state; every n-th tick, as long as asked for; what is kept can be read again."""
    record, again = tmp_path / "record.csv", tmp_path / "again.csv"
    words = ("--signals", "state,counts", "--every", "4", "--seconds", "0.05", "--keep")
    assert "250 rows" in bench.do("scope", record, *words)
    told = columns(record)
    assert list(told) == ["t_s", "tick", "state", "counts"]
    ticks = np.array([int(row) for row in told["tick"]], np.int64)
    assert np.all(np.diff(ticks) == 4)
    assert set(told["state"]) == {"0"}
    bench.do("scope", again, "--again")
    assert again.read_bytes() == record.read_bytes()


def home_when_armed(bench: Bench, monkeypatch: MonkeyPatch) -> None:
    """Order home once the recorder runs and has recorded for a tenth of a second."""
    start = scope.start

    def start_then_home(link: Link) -> None:
        start(link)
        pass_time(link, 0.1)
        threading.Thread(target=order, args=[bench, "home"]).start()

    monkeypatch.setattr(scope, "start", start_then_home)


def test_recording_waits_for_state(bench: Bench, tmp_path: Path, monkeypatch: MonkeyPatch) -> None:
    """From the first tick of homing to its last."""
    record = tmp_path / "record.csv"
    home_when_armed(bench, monkeypatch)
    bench.do("scope", record, "--signals", "state", "--from-state", "homing")
    states = columns(record)["state"]
    assert set(states) == {"1"}
    assert len(states) > 100


def test_bad_recordings_are_refused(bench: Bench, tmp_path: Path, refusal: Refusal) -> None:
    """Signals that are none, names without a format, triggers, nothing recorded."""
    record = tmp_path / "record.csv"
    assert "u_set: no such signal" in refusal(bench, 2, f"scope {record} --signals u_set")
    assert "ends in .csv" in refusal(bench, 2, f"scope {tmp_path / 'record'}")
    assert "less than --seconds" in refusal(bench, 2, f"scope {record} --before 1 --seconds 1")
    assert "leave none after it" in refusal(bench, 1, f"scope {record} --before 60")
    for trigger, why in (
        ("fast", "give one of now"),
        ("u_set>3", "u_set: no such signal"),
        ("u_set_q6>x", "x is not a number"),
        ("angle>nan", "give less than 2^31"),
        ("time=-1", "give 0 .. 107374 s"),
        ("state=cut", "give one of off"),
        ("fault=stop", "stop is not a fault; give some of estop"),
    ):
        assert why in refusal(bench, 2, f"scope {record} --trigger {trigger}")
    assert "no recording is complete" in refusal(bench, 1, f"scope {record} --again")
    assert not record.exists()


def test_trigger_has_rows_before_it(bench: Bench, tmp_path: Path, monkeypatch: MonkeyPatch) -> None:
    """The state's trigger is in the row of time 0; Parquet and CSV hold the same numbers."""
    record, other = tmp_path / "record.csv", tmp_path / "record.parquet"
    home_when_armed(bench, monkeypatch)
    words = ("--signals", "state,angle_q32,u_actual_nm", "--trigger", "state=homing")
    bench.do("scope", record, *words, "--before", "0.02", "--seconds", "0.05", "--keep")
    told = columns(record)
    times = np.array(told["t_s"], np.float64)
    at = told["state"].index("1")
    assert at == 400
    assert set(told["state"][:at]) == {"0"}
    assert times[at] == 0
    assert np.allclose(np.diff(times), 1 / 20000)
    bench.do("scope", other, "--again")
    table = pq.read_table(other)
    assert table.column_names == list(told)
    for name in told:
        values = np.array(told[name], np.float64)
        assert np.allclose(table[name].to_numpy(), values, rtol=1e-11)
    assert json.loads(table.schema.metadata[ABOUT.encode()])["n_before"] == 400


@pytest.mark.long
def test_turns_are_drawn_over_each_other(bench: Bench, tmp_path: Path) -> None:
    """Numbered recordings from one angle on, each with its picture."""
    bench.do("home")
    record, picture = tmp_path / "run.csv", tmp_path / "turns.png"
    words = ("--signals", "u_actual_nm,speed_q32", "--trigger", "angle>90", "--seconds", "0.1")
    bench.do("scope", record, *words, "--repeat", "2", "--over-angle", picture)
    for number in (1, 2):
        told = columns(tmp_path / f"run-{number}.csv")
        angle, speed = float(told["angle_deg"][0]), float(told["speed_rpm"][0])
        assert 90 <= angle < 90 + speed * 6 / 20000 * 1.01
        assert (tmp_path / f"turns-{number}.png").read_bytes().startswith(b"\x89PNG")
    assert "black box         recording" in bench.do("blackbox")


@pytest.mark.parametrize("is_fd", [False, True])
def test_pieces_come_by_the_longest_frames(bench: Bench, link: Link, *, is_fd: bool) -> None:
    """Long frames where the bus carries them; a classic controller behind it is found out."""
    sound = record_some(link)
    bench.is_fd, link.is_fd = is_fd, True
    ids: set[int] = set()
    take = link._take

    def look(frame: can.Message) -> None:
        ids.add(frame.arbitration_id)
        take(frame)

    link._take = look  # type: ignore[method-assign]
    assert np.array_equal(scope.read(link).rows, sound.rows)
    assert ids & {PART_ID, FD_PART_ID} == ({FD_PART_ID} if is_fd else {PART_ID})


def test_the_black_box_keeps_what_was_before_a_fault(
    bench: Bench, link: Link, tmp_path: Path, refusal: Refusal
) -> None:
    """Told, kept from recordings, read, and cleared; then it records again."""
    box = tmp_path / "box.parquet"
    assert "holds no fault" in refusal(bench, 1, f"blackbox {box}")
    bench.do("home")
    pass_time(link, 0.7)
    bench.estop(True)
    pass_time(link, 0.3)
    assert "black box         of estop: camctl blackbox FILE" in bench.do("status")
    text = bench.do("blackbox")
    assert "unread: estop" in text
    assert "0.500 s before it and 0.020 s after it" in text
    assert "camctl blackbox FILE" in refusal(bench, 1, f"scope {tmp_path / 'a.csv'}")
    bench.is_fd = True
    link.is_fd = True
    recording = scope.read(link)
    assert recording.faults == 1
    assert recording["faults"].tolist() == [0] * 10000 + [1] * 400
    assert recording.trigger_tick - recording.first_tick == 10000
    assert "cleared" in bench.do("blackbox", "--clear")
    assert "no fault since" in bench.do("blackbox")


def test_a_recording_that_fails_gives_the_black_box_back(
    bench: Bench, tmp_path: Path, refusal: Refusal, monkeypatch: MonkeyPatch
) -> None:
    """One with lost ticks is dropped; one that cannot be read waits, and the message says so."""
    record = tmp_path / "record.csv"
    whole = scope.Recording.is_whole
    monkeypatch.setattr(scope.Recording, "is_whole", property(lambda recording: False))
    assert "ticks were lost" in refusal(bench, 1, f"scope {record} --seconds 0.05")
    assert "black box         recording" in bench.do("blackbox")
    monkeypatch.setattr(scope.Recording, "is_whole", whole)
    monkeypatch.setattr(scope, "MOST_REPEATS", 0)
    assert "--clear ends that" in refusal(bench, 1, f"scope {record} --seconds 0.05")
    assert "paused" in bench.do("blackbox")
    bench.do("blackbox", "--clear")
    assert "black box         recording" in bench.do("blackbox")


def record_some(link: Link) -> scope.Recording:
    """Record 600 rows and read them over a sound bus."""
    scope.configure(link, ["tick", "counts"], rows=600)
    scope.start(link)
    scope.wait(link, limit_s())
    return scope.read(link)


def test_lost_and_damaged_messages_are_asked_for_again(bench: Bench, link: Link) -> None:
    """Of the recording's messages some are lost, some changed: the rows are the same."""
    sound = record_some(link)
    assert np.all(np.diff(sound["tick"]) == 1)
    n_parts, take = 0, link._take

    def spoil(frame: can.Message) -> None:
        nonlocal n_parts
        if frame.arbitration_id == PART_ID:
            n_parts += 1
            if n_parts % 331 == 0:
                return
            if n_parts % 523 == 0:
                frame.data[3] ^= 0x10
        take(frame)

    link._take = spoil  # type: ignore[method-assign]
    assert np.array_equal(scope.read(link).rows, sound.rows)
    assert n_parts > 600 * 8 / 7 + 100
