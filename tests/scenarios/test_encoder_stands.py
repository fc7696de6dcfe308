# SPDX-License-Identifier: Apache-2.0
"""An encoder that stops counting, at any speed and anywhere on the ellipse, costs no part."""

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.scenarios.cuts import Outcome

GOUGE_UM = 3.0
UNREHEARSED = ("--set", "rehearse_turns=0")
AT_TURNS = (2.03, 2.21, 2.37, 2.44, 2.71, 2.86)  # after the full amplitude is reached
CUTS = [
    *(("perkins240", rpm) for rpm in (10, 20, 50, 110, 230, 400, 700, 1100, 1900, 3000)),
    *(("perkins240_equal_volume", rpm) for rpm in (25, 60, 230)),
]


@pytest.mark.parametrize(("part", "rpm"), CUTS)
def test_the_tool_leaves_before_it_gouges(
    table_of: Callable[[str], Path], part: str, rpm: int
) -> None:
    """The fault is latched, and the tool was nowhere deeper than 3 um below the drawing."""
    for turns in AT_TURNS:
        inject = f"encoder-stuck@{turns * 60.0 / rpm}"
        words = ("--rpm", str(rpm), "--feed", "1", *UNREHEARSED, "--inject", inject)
        cut = Outcome(table_of(part), *words)
        assert cut.status == 1, cut.message
        assert {"spindle_stopped", "encoder_jump"} & set(cut.summary["first_faults"])
        assert cut.summary["cut"]["gouge_um"] <= GOUGE_UM
