# SPDX-License-Identifier: Apache-2.0
"""The campaign of mutants: its figures, its explanations, and that it goes on where it was."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.mutation.account import (
    HERE,
    LEAST_PERCENT,
    MOST_DEAF_PERCENT,
    Reason,
    figures_of,
    reasons,
)
from tests.mutation.asserted import asserted, unseen
from tests.mutation.journal import Journal, Judged
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


def test_all_lines_of_what_the_compiler_asserts_are_left_out() -> None:
    """One that goes on in the next line is left out to its end, and nothing behind it."""
    lines = (HERE.parent.parent / "firmware/record/cam_record.h").read_text("utf-8").splitlines()
    left_out = asserted(lines)
    begin = next(n for n, line in enumerate(lines, 1) if line.startswith("_Static_assert("))
    end = next(n for n, line in enumerate(lines, 1) if n >= begin and line.endswith(");"))
    assert end > begin
    assert {n for n in left_out if begin <= n <= end + 1} == set(range(begin, end + 1))
    assert begin - 1 not in left_out


def test_lines_for_the_cortex_m_alone_are_left_out() -> None:
    """What the compiler of the host reads instead is drawn."""
    lines = (HERE.parent.parent / "firmware/base/cam_fix.h").read_text("utf-8").splitlines()
    left_out = unseen(lines)
    texts = [lines[n - 1] for n in sorted(left_out)]
    n_asm = sum("__asm" in line for line in lines)
    assert sum("__asm" in text for text in texts) == n_asm > 0
    assert not any("int64_t" in text for text in texts)
    assert sum(line.startswith("#else") for line in lines) == n_asm


def test_figures_count_only_what_says_something() -> None:
    """Neither what the compiler refuses nor what is the same code; a survivor counts against."""
    verdicts = ("killed by x", "invalid", "same code", "survived", "killed by x (crash)")
    figures = figures_of(
        [judged(n, verdict) for n, verdict in enumerate(verdicts)], 7, ["survived", "killed by x"]
    )
    assert figures == {
        "seed": 7,
        "count": 3,
        "killed": 2,
        "explained": 0,
        "survived": 1,
        "percent": 66.67,
        "refused_by_compiler": 1,
        "same_code": 1,
        "deaf_count": 2,
        "deaf_percent": 50.0,
    }


def test_journal_knows_what_was_judged(tmp_path: Path) -> None:
    """A line that was being written counts for nothing; nothing of another tree is believed."""
    path = tmp_path / "mutation.jsonl"
    first = Journal(path, "tree", "firmware")
    for line in (1, 2):
        first.add(judged(line, "survived"))
    path.write_text(path.read_text(encoding="utf-8")[:-9], encoding="utf-8")
    again = Journal(path, "tree", "firmware")
    assert list(again.judged.values()) == [judged(1, "survived")]
    again.add(judged(3, "invalid"))
    assert len(Journal(path, "tree", "firmware").judged) == 2
    assert not Journal(path, "another tree", "another firmware").judged


def test_journal_believes_the_compiler_when_only_tests_have_changed(tmp_path: Path) -> None:
    """What it refused stays refused; in a header it may have been the text of a test."""
    path = tmp_path / "mutation.jsonl"
    refused, header = judged(1, "invalid"), judged(2, "invalid")._replace(file="firmware/no.h")
    first = Journal(path, "tree", "firmware")
    for one in (refused, header, judged(3, "same code"), judged(4, "killed by x")):
        first.add(one)
    assert list(Journal(path, "other tests", "firmware").judged.values()) == [refused]
    assert list(Journal(path, "tree", "firmware").judged.values()) == [refused]
    assert not Journal(path, "tree", "another firmware").judged
