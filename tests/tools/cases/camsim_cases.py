# SPDX-License-Identifier: Apache-2.0
"""How the tests call the simulator."""

import itertools
import json
import os
import subprocess
from pathlib import Path
from typing import Any

from numpy.typing import NDArray
from pyarrow import csv

ROOT = Path(__file__).resolve().parents[3]
BUILD = (ROOT / (os.environ.get("CAMTURN_BUILD") or "build/host")).resolve()
CAMSIM = BUILD / "host_sim" / "camsim"


def camsim(*words: str | Path, stdin: str = "") -> subprocess.CompletedProcess[str]:
    """Run camsim with some words on its command line."""
    assert CAMSIM.exists(), f"{CAMSIM} is missing: build the preset host, or let tools/test do it"
    command = [str(CAMSIM), *map(str, words)]
    return subprocess.run(command, input=stdin, capture_output=True, text=True, check=False)


def cut(table: Path, folder: Path, *words: str | Path, status: int = 0) -> dict[str, Any]:
    """Return the summary of a cut, which must end with a status."""
    path = folder / "summary.json"
    done = camsim("run", table, *words, "--summary", path)
    assert done.returncode == status, done.stderr
    loaded: dict[str, Any] = json.loads(path.read_text())
    return loaded


def columns_of(path: Path, *names: str) -> dict[str, NDArray[Any]]:
    """Return columns of a CSV file that camsim wrote, all by default; text as it is."""
    wanted = csv.ConvertOptions(include_columns=list(names))
    table = csv.read_csv(path, convert_options=wanted)
    return {name: table[name].to_numpy() for name in table.column_names}


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
