"""What SAFETY.md and THREATS.md name exists, and no fault or hazard lacks a test."""

import re
from functools import cache

from camtools.base.project import ROOT

TEXT = "".join(
    (ROOT / "firmware" / f"{one}.md").read_text("utf-8") for one in ("SAFETY", "THREATS")
)
ROWS = re.findall(r"^\| ([ST]\d+) \|(.*)\|(.*)\|$", TEXT, re.MULTILINE)


@cache
def names() -> set[str]:
    """Return the test functions, the files and the folders in tests/."""
    files = [path for path in (ROOT / "tests").rglob("*") if path.suffix in (".c", ".py")]
    tests = re.findall(r"\b(?:void|def) (test_\w+)\(", "".join(p.read_text("utf-8") for p in files))
    folders = {str(one.relative_to(ROOT)) for path in files for one in (path, path.parent)}
    return {*tests, *folders, *(path.name for path in files)}


def test_each_row_names_tests_that_exist() -> None:
    """The last cell of a row has at least one."""
    assert len(ROWS) >= 38
    for number, _, tests in ROWS:
        named = re.findall(r"`([^`]+)`", tests)
        assert named and set(named) <= names(), (number, set(named) - names())


def test_each_fault_and_each_hazard_has_a_row() -> None:
    """No fault and no hazard is left out."""
    cells = " ".join(cell for number, cell, _ in ROWS if number.startswith("S"))
    states = (ROOT / "firmware/base/cam_state.h").read_text("utf-8")
    faults = re.findall(r"^    X\((\w+), ", states, re.MULTILINE)
    hazards = re.findall(r"^\| (H\d+) \|", TEXT, re.MULTILINE)
    assert faults and hazards
    assert [one for one in faults if f"`{one}`" not in cells] == []
    assert [one for one in hazards if one not in cells] == []
