"""Recordings of the HAL component: the black box of a fault, and by command, in files."""

import csv
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from checks.patience import limit_s
from tests.linuxcnc.halbox import Halbox
from tests.linuxcnc.replays import Whole, cut, replay
from tests.tools.cases.part_cases import TableOf

pytest_plugins = ["tests.linuxcnc.halrun_fixtures"]

FAULT, AFTER_MS, TICK_HZ = 2, 20, 1000
LOAD = """loadrt camturn table=./part.camtab tick_hz=1000 {}
loadrt threads name1=servo period1=1000000
addf camturn.update servo
addf camturn.poll servo
start
"""


def read(path: Path) -> dict[str, Whole]:
    """Return the columns of a recording, time in ms."""
    with path.open() as lines:
        rows = list(csv.DictReader(lines))
    columns = {name: [row[name] for row in rows] for name in rows[0] if name != "t_s"}
    whole = {name: np.array(values, dtype=np.int64) for name, values in columns.items()}
    return whole | {"t_ms": np.array([round(float(row["t_s"]) * 1000) for row in rows])}


@pytest.mark.long
def test_black_box_of_a_fault_is_what_camsim_did(
    box: Halbox, table_of: TableOf, tmp_path: Path
) -> None:
    """Through 20 ms after the fault, tick by tick, with the fault at the time 0."""
    recorded = cut(table_of("perkins240"), tmp_path, "--rpm", "1000", "--inject", "estop@0.05",
                   "--machine", _machine(tmp_path))  # fmt: skip
    replay(box, recorded, "recordings=./box")
    found = read(box.folder / "box-1.csv")
    assert found["t_ms"][-1] == AFTER_MS - 1
    assert (np.diff(found["t_ms"]) == 1).all()
    assert (np.diff(found["tick"]) == 1).all()
    fault = int(np.argmax((recorded.columns["out_outputs"] & FAULT) != 0))
    rows = fault + np.arange(-40, AFTER_MS)
    last = slice(-len(rows), None)
    assert found["u_command_nm"][last].tolist() == recorded.columns["out_u_nm"][rows].tolist()
    assert found["u_actual_nm"][last].tolist() == recorded.columns["in_u_nm"][rows].tolist()
    assert ((found["faults"] != 0) == (found["t_ms"] >= 0)).all()


def _machine(folder: Path) -> Path:
    path = folder / "machine.toml"
    path.write_text(f"[machine]\ntick_hz = {TICK_HZ}\n")
    return path


@pytest.fixture
def loaded(box: Halbox, table_of: TableOf) -> Callable[[str], Halbox]:
    """Return a function that loads the component and starts its thread."""

    def load(words: str) -> Halbox:
        (box.folder / "part.camtab").write_bytes(table_of("perkins240").read_bytes())
        assert box.load(LOAD.format(words)) == 0, box.said()
        return box

    return load


def _set(box: Halbox, value: int) -> None:
    assert box.load(f"setp camturn.record {value}\n") == 0
    time.sleep(limit_s(0.2))


def test_recordings_by_command_get_numbered_files(loaded: Callable[[str], Halbox]) -> None:
    """Each has every tick between the two edges of the pin; the pin recording spans them."""
    box = loaded("recordings=./cut")
    for number in (1, 2):
        _set(box, 1)
        box.wait("camturn.recording", "TRUE")
        _set(box, 0)
        box.wait("camturn.recording", "FALSE")
        found = read(box.folder / f"cut-{number}.csv")
        assert found["t_ms"].tolist() == list(range(len(found["t_ms"])))
        assert len(found["t_ms"]) > 100
        box.wait_said(f"camturn: ./cut-{number}.csv: {len(found['t_ms'])} rows")


@pytest.mark.long
@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("", "camturn: record: no file is given; load camturn with recordings="),
        ("recordings=/nowhere/cut", "/nowhere/cut-1.csv: No such file or directory; make room"),
    ],
)
def test_recording_that_cannot_be_kept_is_reported(
    loaded: Callable[[str], Halbox], words: str, said: str
) -> None:
    """Without a name nothing is recorded; without the folder the recording is given up."""
    box = loaded(words)
    _set(box, 1)
    _set(box, 0)
    box.wait_said(said)
    box.wait("camturn.recording", "FALSE")
