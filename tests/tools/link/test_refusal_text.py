# SPDX-License-Identifier: Apache-2.0
"""The remedies of refusals."""

from typing import cast

import pytest

from camtools.link.controller import Link
from camtools.link.messages import NAMES, Answer
from camtools.link.refusal_text import explain


@pytest.mark.parametrize(
    ("result", "command", "remedy"),
    [
        ("servo_none", "enable", "design the loop with tools/tune"),
        ("servo", "set_parameter", "servo_pole_hz within a fifth"),
        ("servo_force", "set_parameter", "raise servo_force_limit_mn"),
    ],
)
def test_a_refused_position_loop_is_told_with_its_remedy(
    result: str, command: str, remedy: str
) -> None:
    """The names are those of cam_err.h; no question to the controller is needed."""
    assert result in NAMES["result"].values()
    nobody = cast("Link", None)
    text = explain(nobody, Answer(command, result, 0.0, 0))
    assert text.startswith(f"refused: {result.replace('_', ' ')}; ")
    assert remedy in text
