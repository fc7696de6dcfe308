"""The safety case: its pages are what its source says, and what it names is there."""

from __future__ import annotations

import copy
from typing import Any

import pytest

from camtools.base.errors import CamtoolsError
from checks.safety import FAULTS, SOURCE, figure, pages, problems, read_case


@pytest.fixture(scope="module")
def case() -> dict[str, Any]:
    """Return the safety case of the project."""
    return read_case()


def test_pages_are_what_the_source_says(case: dict[str, Any]) -> None:
    """Whoever changes the source, or a figure, writes the pages anew."""
    assert problems(case) == []
    for name, text in pages(case).items():
        assert (SOURCE.parent / name).read_text(encoding="utf-8") == text, name


def test_what_is_not_there_is_told(case: dict[str, Any]) -> None:
    """A test that was renamed, a fault or a hazard without a requirement, a number twice."""
    assert "estop" in FAULTS and "table" in FAULTS
    wrong = copy.deepcopy(case)
    first = wrong["requirement"][0]
    first["tests"] = ["tests/nowhere.c::test_a", "firmware/main.c::test_b"]
    wrong["requirement"][1] |= {"id": first["id"], "tests": [], "against": ["H99"]}
    for one in wrong["requirement"]:
        one["faults"] = [f for f in one.get("faults", []) if f not in ("table", "*")]
    wrong["hazard"].append({"id": "H98", "what": "", "when": ""})
    wrong["threat"][0]["tests"] = ["tests/nowhere.c"]
    found = problems(wrong)
    assert f"{first['id']}: tests/nowhere.c::test_a: there is no such file" in found
    assert f"{first['id']}: firmware/main.c::test_b: there is no such test" in found
    assert f"{first['id']}: no test shows it" in found
    assert f"{first['id']}: no hazard H99" in found
    assert f"{first['id']}: twice" in found
    assert "fault table: no requirement" in found
    assert "H98: no requirement" in found
    assert f"{wrong['threat'][0]['id']}: tests/nowhere.c: there is no such file" in found


def test_a_figure_that_nobody_recorded_is_an_error() -> None:
    """No figure stands in a page that no campaign has written."""
    with pytest.raises(CamtoolsError, match="no such figure; run its campaign with --record"):
        figure("tests/nowhere/figures.json:count")
