# SPDX-License-Identifier: Apache-2.0
"""The table of tests/learn/README.md: each machine keeps its form error once it has learned."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.tools.cases.camsim_cases import ROOT, camsim

LEARN = ROOT / "tests" / "learn"
PARTS = {"oval30", "oval_doubles", "perkins240", "twist80"}


class Row(NamedTuple):
    """A line of the table."""

    machine: str
    part: str
    rpm: str
    feed: str
    most_um: float


def rows() -> list[Row]:
    """Return the lines of the table; a line without a feed has that of its part."""
    found = []
    for line in (LEARN / "README.md").read_text().splitlines():
        cells = [cell.strip() for cell in line.split("|")[1:-1]]
        if len(cells) == 4 and cells[3].endswith(" um"):
            machine = re.sub(r"\[(\w+)\].*", r"\1", cells[0])
            part = re.sub(r"^\[?(\w+).*", r"\1", cells[2])
            rpm = re.search(r"(\d+) r/min", cells[2])
            feed = re.search(r"feed ([\d.]+) mm", cells[2])
            most_um = float(cells[3][:-3])
            rpm_text, feed_text = rpm[1] if rpm else "3000", feed[1] if feed else ""
            found.append(Row(machine, part, rpm_text, feed_text, most_um))
    return found


def test_every_machine_has_its_row() -> None:
    """The folder and the table have the same machines; bends is for the gauged part."""
    files = {path.stem for path in (LEARN / "machines").glob("*.toml")}
    assert files == {row.machine for row in rows()} | {"bends"}
    assert {row.part for row in rows()} == PARTS


@pytest.mark.parametrize("row", rows(), ids=lambda row: f"{row.machine}-{row.rpm}")
def test_what_is_learned_keeps_the_form_error(
    table_of: Callable[[str], Path], tmp_path: Path, row: Row
) -> None:
    """The whole cut is gauged, also while the force of the chip rises and falls."""
    machine, summary = LEARN / "machines" / f"{row.machine}.toml", tmp_path / "s.json"
    words: list[str | Path] = ["--machine", machine, "--rpm", row.rpm, "--summary", summary]
    words += ["--feed", row.feed] if row.feed else []
    done = camsim("run", table_of(row.part), *words, "--tolerance-um", str(row.most_um))
    error = json.loads(summary.read_text())["form_error_um"]
    assert done.returncode == 0, (error, done.stderr)
    assert error["max"] <= row.most_um
