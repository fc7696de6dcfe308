# SPDX-License-Identifier: Apache-2.0
"""The figures that README.md tells are those of the campaign that was recorded."""

from __future__ import annotations

import json
from pathlib import Path

HERE = Path(__file__).resolve().parent


def test_readme_tells_the_recorded_figures() -> None:
    """Each target's row of the table has the recorded numbers, and nothing was found."""
    flat = json.loads((HERE / "figures.json").read_text("utf-8"))
    rows = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in (HERE / "README.md").read_text("utf-8").splitlines()
        if line.startswith("| ")
    ]
    told = {row[0]: row[1:] for row in rows if f"{row[0]}_executions" in flat}
    keys = ("executions", "per_second", "edges", "edges_of", "inputs")
    assert len(told) == sum(key.endswith("_executions") for key in flat)
    for name, numbers in told.items():
        assert numbers == [str(flat[f"{name}_{key}"]) for key in keys], name
    assert flat["found"] == 0
    assert flat["executions"] == sum(v for k, v in flat.items() if k.endswith("_executions"))
