# SPDX-License-Identifier: Apache-2.0
"""The campaign of mutants: its figures, its explanations, and that it goes on where it was."""

import json

import pytest

from tests.mutation.account import HERE, LEAST_PERCENT, MOST_DEAF_PERCENT, Reason, reasons
from tests.mutation.journal import Judged
from tests.mutation.pristine import judging_tests

RECORDED = json.loads((HERE / "figures.json").read_text(encoding="utf-8"))


def judged(line: int, verdict: str) -> Judged:
    """Return a mutant of a file that is not there."""
    return Judged("firmware/no.c", line, "a = b;", "a = c;", verdict, 1.0)


def test_recorded_campaign_is_whole_and_notices() -> None:
    """It judged as many as it says, and a judge that hears no assertion lets most of them live."""
    noticed = RECORDED["killed"] + RECORDED["explained"]
    assert RECORDED["count"] == noticed + RECORDED["survived"] >= 300
    assert RECORDED["percent"] == round(100 * noticed / RECORDED["count"], 2) >= LEAST_PERCENT
    assert RECORDED["deaf_percent"] < MOST_DEAF_PERCENT


def test_every_unit_test_of_the_firmware_judges() -> None:
    """In whatever folder it is."""
    root = HERE.parent.parent
    named = {path.stem for path in (root / "tests/unit/firmware").rglob("test_cam_*.c")}
    assert len(named) > 100
    assert named <= set(judging_tests(root))


@pytest.mark.parametrize("reason", reasons(), ids=lambda reason: f"{reason.file}: {reason.was}")
def test_each_explanation_is_of_one_line(reason: Reason) -> None:
    """One that fits no line, or several, explains something else than was meant."""
    assert len(reason.lines()) == 1
    assert reason.was != reason.becomes
    assert len(reason.why.split()) > 5
