# SPDX-License-Identifier: Apache-2.0
"""Tables do not grow, and nothing needless is loaded for them."""

import os
import subprocess
import sys
from functools import cache
from math import inf
from pathlib import Path

import numpy as np
import pytest

from camtools.pipeline.load import load
from camtools.pipeline.make_table import make as make_table
from camtools.table.channel import KIND_U
from camtools.table.evaluate import evaluate_grid
from camtools.table.image import Table, pack
from tests.bench.bench_tables import ROOT, parts, recorded

CAMSIM = ROOT / os.environ.get("CAMTURN_BUILD", "build/host") / "host_sim" / "camsim"
NAMES = sorted(parts())


def test_every_part_is_recorded() -> None:
    """A new part gets its bytes by `tests/bench/tables --record`."""
    assert set(recorded()) == set(parts())


@cache
def table_of(name: str) -> Table:
    """Return the table of a part, which is made once."""
    path = parts()[name]
    table: Table = make_table(load(path), path).table.table
    return table


@pytest.mark.parametrize("name", NAMES)
def test_no_table_has_grown(name: str) -> None:
    """The table of each part has at most the bytes that are recorded."""
    assert len(pack(table_of(name))) <= recorded().get(name, inf)


@pytest.mark.parametrize("name", NAMES)
def test_a_dense_evaluation_keeps_what_the_header_promises(name: str) -> None:
    """U stays within at 64 places between any two knots, on all slices and between them."""
    table = table_of(name)
    u, bounds = table.channel(KIND_U), table.bounds
    spacing_nm = (u.z_last_nm - u.z_first_nm) / (u.n_slices - 1)
    heights = np.arange(0, u.n_slices - 0.5, 0.5)
    if not u.has_patterns:
        heights = u.z_first_nm + spacing_nm * heights
    low, high = inf, -inf
    for some in np.array_split(heights, -(-heights.size * u.knots.shape[1] // 20_000)):
        value = evaluate_grid(u, some, np.arange(64) / 64).value
        low, high = min(low, float(value.min())), max(high, float(value.max()))
    assert bounds.u_min_nm <= low - u.lsb
    assert high + u.lsb <= bounds.u_max_nm
    assert (bounds.u_min_nm, bounds.u_max_nm) == pytest.approx((low, high), abs=20)


@pytest.mark.parametrize("name", NAMES)
def test_the_controller_takes_every_table(name: str, tmp_path: Path) -> None:
    """The controller's own check finds what the header promises."""
    image = tmp_path / "part.camtab"
    image.write_bytes(pack(table_of(name)))
    done = subprocess.run(
        [CAMSIM, "eval", image],
        input="turn,z_mm\n0,0\n",
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")


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
