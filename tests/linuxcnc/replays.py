"""Cuts of the simulator, played again tick by tick through the HAL component."""

import csv
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tests.linuxcnc.halbox import Halbox
from tests.tools.cases.camsim_cases import camsim

Whole = NDArray[np.int64]
FROM_REPLAY = (
    "spindle-rawcounts spindle-counts enable start estop-ok drive-ready u-limit-low u-limit-high "
    "u-fb x-fb z-fb"
)
TO_REPLAY = "u-cmd x-cmd z-cmd u-force spindle-speed-cmd drive-enable fault in-cut"
COMMANDED = ("out_u_nm", "out_x_nm", "out_z_nm", "out_force_q6", "out_spindle_mrpm", "out_outputs")
PERIOD_NS = 25000  # of the thread, whatever the rate of the tick: time is nominal
ENABLE, START, STOP = 1, 3, 4  # cam_request_t


@dataclass(frozen=True)
class Cut:
    """A cut of the simulator: its table, the controller's parameters, what every tick did."""

    table: Path
    params: dict[str, int]
    columns: dict[str, Whole]
    states: list[str]

    @property
    def commanded(self) -> Whole:
        """Return what the simulator's firmware commanded, a row per tick."""
        return np.stack([self.columns[name] for name in COMMANDED], axis=1)


def cut(table: Path, folder: Path, *words: str | Path) -> Cut:
    """Let camsim cut without learning, which depends on the pace of the main loop; keep all."""
    trace = folder / "trace.csv"
    done = camsim("run", table, "--no-learning", *words, "--trace", trace)
    assert trace.exists(), done.stderr
    with trace.open() as lines:
        rows = list(csv.DictReader(lines))
    wanted = [name for name in rows[0] if name.startswith(("in_", "out_"))]
    columns = {name: np.array([int(row[name]) for row in rows], dtype=np.int64) for name in wanted}
    asked = [word for word in words if word in ("--machine", "--rpm", "--set")]
    output = camsim("params", table, "--no-learning", *_pairs(words, asked)).stdout
    pairs = [line.split(",") for line in output.splitlines()[1:] if not line.startswith("planned_")]
    params = {pair[0]: int(pair[1]) for pair in pairs}
    return Cut(table, params, columns, [row["state"] for row in rows])


def _pairs(words: tuple[str | Path, ...], names: Sequence[str | Path]) -> list[str | Path]:
    return [word for name in names for word in words[words.index(name) : words.index(name) + 2]]


def _levels(request: Whole) -> tuple[Whole, Whole]:
    """Return the pins enable and start that lead to the requests; they act in the next tick."""
    enables, starts = np.zeros_like(request), np.zeros_like(request)
    changed = np.flatnonzero(np.diff(request)) + 1
    for tick in changed:
        kind = request[tick] & 0xFF
        if kind == ENABLE:
            enables[tick - 1 :] = 1
        elif kind in (START, STOP):
            starts[tick - 1 :] = kind == START
    return enables, starts


def rows_of(cut: Cut) -> bytes:
    """Return the rows of replay.comp."""
    c = cut.columns
    columns = (
        c["in_counts"], c["in_counts"] - c["in_index_counts"], c["in_n_index"], c["in_u_nm"],
        c["in_x_nm"], c["in_z_nm"], c["in_inputs"], *_levels(c["in_request"]),
    )  # fmt: skip
    return np.stack(columns, axis=1).astype(np.uint32).tobytes()


def script(params: dict[str, int], more: str, pins: str) -> str:
    """Return the HAL file that puts camturn between the two functions of replay."""
    rest = {name: value for name, value in params.items() if name != "tick_hz"}
    feeding = "measures_u=1 measures_x=1 nominal_time=1 waive_acknowledge=1"
    lines = [
        f"loadrt threads name1=fast period1={PERIOD_NS}",
        "loadrt replay rows=./rows kept=./kept",
        f"loadrt camturn table=./part.camtab tick_hz={params['tick_hz']} {feeding} {more}",
        *(f"setp camturn.{name.replace('_', '-')} {value}" for name, value in rest.items()),
        *(f"net {pin} replay.{pin} => camturn.{pin}" for pin in FROM_REPLAY.split()),
        *(f"net {pin} camturn.{pin} => replay.{pin}" for pin in TO_REPLAY.split()),
        "net index-enable replay.index-enable <=> camturn.index-enable",
        *(f"addf {name} fast" for name in ("replay.feed", "camturn.update", "camturn.poll")),
        "addf replay.note fast",
        f"{pins}start",
    ]
    return "\n".join(lines) + "\n"


def replay(box: Halbox, cut: Cut, more: str = "", pins: str = "") -> Whole:
    """Return what the component commanded, given what the simulator's firmware sensed.

    `more` is added to the parameters of the component, `pins` are lines that set its pins.
    """
    (box.folder / "rows").write_bytes(rows_of(cut))
    shutil.copy(cut.table, box.folder / "part.camtab")
    assert box.load(script(cut.params, more, pins)) == 0, box.said()
    box.wait("replay.done", "TRUE")
    box.wait("camturn.recording", "FALSE")
    box.stop()
    kept = np.frombuffer((box.folder / "kept").read_bytes(), dtype="<i4")
    return kept.reshape(-1, len(COMMANDED)).astype(np.int64)
