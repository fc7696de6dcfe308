"""How the tests call the simulator: `cut` in this process, `camsim` as people in a shell."""

import itertools
import os
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from pyarrow import csv

from camtools.base.errors import CamtoolsError
from camtools.sim.binding import Rows
from camtools.sim.machine_file import Machine
from camtools.sim.results import STATES
from camtools.sim.simulate import Result
from camtools.sim.simulate import cut as played

ROOT = Path(__file__).resolve().parents[3]
BUILD = (ROOT / (os.environ.get("CAMTURN_BUILD") or "build/host")).resolve()
CAMSIM = Path(os.environ.get("CAMTURN_CAMSIM") or BUILD / "host_sim" / "camsim")


def camsim(
    *words: str | Path, stdin: str = "", cwd: Path | None = None
) -> subprocess.CompletedProcess[str]:
    """Run camsim with some words on its command line."""
    assert CAMSIM.exists(), f"{CAMSIM} is missing: build the preset host, or let tools/test do it"
    command = [str(CAMSIM), *map(str, words)]
    return subprocess.run(
        command, input=stdin, capture_output=True, text=True, check=False, cwd=cwd
    )


def cut(
    table: Path,
    *words: str | Path | float,
    status: int | None = 0,
    tables: Sequence[str] = ("surface",),
    machine: str | None = None,
) -> Result:
    """Cut a table in this process, with the words of `camsim run`.

    status: with which the cut must end; None: any but a refusal; machine: text of the machine file.
    """
    given = None if machine is None else Machine("machine.toml", machine)
    result = played([str(table), *map(str, words)], given, tables=tables)
    assert result.status in ((0, 1) if status is None else (status,)), result.message
    return result


def form_um(found: Result) -> float:
    """Return the largest form error of a cut [um], which must have been gauged."""
    assert found.form_error_um is not None
    return found.form_error_um


def refusal(table: Path, *words: str | Path | float, machine: str | None = None) -> str:
    """Return the one line of a cut that the simulator refuses to begin."""
    with pytest.raises(CamtoolsError) as refused:
        cut(table, *words, machine=machine)
    (line,) = refused.value.lines
    return line


def columns_of(path: Path, *names: str) -> dict[str, NDArray[Any]]:
    """Return columns of a CSV file that camsim wrote, all by default; text as it is."""
    wanted = csv.ConvertOptions(include_columns=list(names))
    table = csv.read_csv(path, convert_options=wanted)
    return {name: table[name].to_numpy() for name in table.column_names}


def plain(rows: Rows) -> NDArray[np.float64]:
    """Return the rows of a table as an array, shape (columns, rows)."""
    return np.array([rows[name] for name in rows.dtype.names or ()])


def while_in(rows: Rows, *states: str) -> Rows:
    """Return the ticks of a trace in some states of the controller."""
    return rows[np.isin(rows["state"], [STATES.index(state) for state in states])]


def first_difference(path: Path, other: Path) -> str:
    """Return "" of files that are the same to the byte, else the first line that differs.

    Where CI is set, pytest explains an assertion on the bytes themselves by comparing all lines
    with all, for hours.
    """
    if path.read_bytes() == other.read_bytes():
        return ""
    with path.open() as ours, other.open() as theirs:
        for number, pair in enumerate(itertools.zip_longest(ours, theirs), start=1):
            if pair[0] != pair[1]:
                return f"line {number}: {pair[0]!r} and {pair[1]!r}"
    return "bytes that are no lines"


def only_error(done: subprocess.CompletedProcess[str]) -> str:
    """Return the one line on stderr of a run that was refused."""
    assert done.returncode == 2, (done.returncode, done.stderr)
    lines = done.stderr.splitlines()
    assert len(lines) == 1, done.stderr
    assert lines[0].startswith("camsim: ")
    return lines[0]
