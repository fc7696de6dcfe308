"""Tables do not grow, and nothing needless is loaded for them."""

import os
import subprocess
import sys
from math import inf
from pathlib import Path

import numpy as np
import pytest

from camtools.table.channel import KIND_U
from camtools.table.evaluate import evaluate_grid
from camtools.table.image import Table, pack
from tests.bench.bench_tables import ROOT, parts, recorded
from tests.tools.cases.cut_cases import evaluated, made_of

SAMPLE = ("cam-345-ground", "camshaft", "hexagon", "perkins240")
NAMES = [
    pytest.param(name, marks=[] if name in SAMPLE else [pytest.mark.long])
    for name in sorted(parts())
]


def test_every_part_is_recorded() -> None:
    """A new part gets its bytes by `tests/bench/tables --record`."""
    assert set(recorded()) == set(parts())


@pytest.mark.parametrize("name", NAMES)
def test_table_is_small_and_keeps_what_its_header_promises(name: str, tmp_path: Path) -> None:
    """It has at most the bytes that are recorded, and the controller takes it.

    U stays within at 64 places between any two knots, on all slices and between them.
    """
    table: Table = made_of(name).table.table
    assert len(pack(table)) <= recorded().get(name, inf)
    evaluated(tmp_path, table, np.zeros(1), np.zeros(1))
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


@pytest.mark.long
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
