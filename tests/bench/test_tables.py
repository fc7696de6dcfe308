# SPDX-License-Identifier: Apache-2.0
"""Tables do not grow, the documents tell their bytes, and nothing needless is loaded for them."""

from __future__ import annotations

import doctest
import os
import re
import subprocess
import sys
from math import inf
from pathlib import Path

import bench_tables
import pytest
from bench_tables import ROOT, parts, recorded

from camtools.pipeline.load import load
from camtools.pipeline.make import make as make_table
from camtools.table.image import pack

LONG = ("16v240zj", "perkins240_equal_volume", "perkins240_papers_speed", "twist80")
NAMES = [pytest.param(one, marks=[pytest.mark.slow] * (one in LONG)) for one in sorted(parts())]


def test_examples_are_true() -> None:
    """What the examples of the module show is what it does."""
    result = doctest.testmod(bench_tables)
    assert result.attempted
    assert not result.failed


def test_every_part_is_recorded() -> None:
    """A new part gets its bytes by `tests/bench/tables --record`."""
    assert set(recorded()) == set(parts())


@pytest.mark.parametrize("name", NAMES)
def test_no_table_has_grown(name: str) -> None:
    """The table of each part has at most the bytes that are recorded."""
    path = parts()[name]
    made = make_table(load(path), path)
    assert len(pack(made.table.table)) <= recorded().get(name, inf)


def test_the_manual_tells_the_recorded_bytes() -> None:
    """The table of the manual of the tools has them, in groups of three digits."""
    text = (ROOT / "tools" / "README.md").read_text()
    rows = re.findall(
        r"^\| `(\w[\w-]*)\.toml` \|[^|]*\| ([\d ]+) \| [\d.]+ \|$", text, re.MULTILINE
    )
    assert len(rows) >= 10
    told = {name: int(size.replace(" ", "")) for name, size in rows}
    assert told == {name: recorded()[name] for name in told}


def test_making_a_table_loads_what_it_needs(tmp_path: Path) -> None:
    """What draws, reports and speaks to controllers costs a table's maker no start-up time."""
    code = "import sys; from camtools.cli.mktables import main; main(sys.argv[1:]); "
    words = [str(parts()["perkins240"]), "-o", str(tmp_path)]
    said = subprocess.run(
        [sys.executable, "-c", code + "print(*sys.modules, file=sys.stderr)", *words],
        env=os.environ | {"PYTHONPATH": str(ROOT / "tools")},
        capture_output=True,
        text=True,
        check=True,
    ).stderr
    loaded = {name.partition(".")[0] for name in said.split()}
    assert "numpy" in loaded
    assert not loaded & {"matplotlib", "pandas", "pyarrow", "dask", "cantools", "can"}
