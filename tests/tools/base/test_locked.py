"""requirements.lock holds what the groups of packages ask for."""

import re
import tomllib

import pytest
from packaging.requirements import Requirement

from locked import needed
from tests.tools.cases.part_cases import ROOT

TOOLS = ROOT / "tools"
LOCK = (TOOLS / "requirements.lock").read_text(encoding="ascii")
PROJECT = tomllib.loads((TOOLS / "pyproject.toml").read_text(encoding="utf-8"))["project"]
LINE = re.compile(r"^\w[\w.-]*(?:[=~>]=[\w.]+)?", re.M)
GROUPS = {
    "base": PROJECT["dependencies"],
    **PROJECT["optional-dependencies"],
    **{
        file.stem.removeprefix("requirements-"): LINE.findall(file.read_text(encoding="ascii"))
        for file in TOOLS.glob("requirements-*.in")
    },
}


@pytest.mark.parametrize("group", GROUPS)
def test_a_group_gets_what_it_names_with_hashes(group: str) -> None:
    """Each package in a version that the group accepts; pip demands the hashes."""
    found = needed(LOCK, PROJECT, [group])
    pins = dict(re.findall(r"^([\w.-]+)==(\S+) \\\n    --hash=sha256:", found, re.M))
    assert len(pins) == len(re.findall(r"^\w", found, re.M))
    assert GROUPS[group]
    for asked in map(Requirement, GROUPS[group]):
        assert pins[asked.name.lower()] in asked.specifier


def test_the_groups_need_the_whole_lock() -> None:
    """Nothing is pinned that no group needs."""
    whole = needed(LOCK, PROJECT, GROUPS)
    assert re.findall(r"^\w.*", whole, re.M) == re.findall(r"^\w.*", LOCK, re.M)
