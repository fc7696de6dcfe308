# SPDX-License-Identifier: Apache-2.0
"""An encoder that stops counting, at any speed and anywhere on the ellipse, costs no part."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.tools.cases.camsim_cases import camsim

GOUGE_UM = 3.0
UNREHEARSED = ("--set", "rehearse_turns=0")
AT_TURNS = (2.03, 2.21, 2.37, 2.44, 2.71, 2.86)  # after the full amplitude is reached
CUTS = [
    *(("perkins240", rpm) for rpm in (10, 20, 50, 110, 230, 400, 700, 1100, 1900, 3000)),
    *(("perkins240_equal_volume", rpm) for rpm in (25, 60, 230)),
]


@pytest.mark.parametrize(("part", "rpm"), CUTS)
def test_the_tool_leaves_before_it_gouges(
    table_of: Callable[[str], Path], tmp_path: Path, part: str, rpm: int
) -> None:
    """The fault is latched, and the tool was nowhere deeper than 3 um below the drawing."""
    summary = tmp_path / "summary.json"
    for turns in AT_TURNS:
        inject = f"encoder-stuck@{turns * 60.0 / rpm}"
        words = ("--rpm", str(rpm), "--feed", "1", *UNREHEARSED, "--inject", inject)
        done = camsim("run", table_of(part), *words, "--summary", summary)
        assert done.returncode == 1, done.stderr
        said = json.loads(summary.read_text("utf-8"))
        assert {"spindle_stopped", "encoder_jump"} & set(said["first_faults"])
        assert said["cut"]["gouge_um"] <= GOUGE_UM
