# SPDX-License-Identifier: Apache-2.0
"""requirements.lock holds what the lists ask for."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from locked import needed

from part_cases import ROOT

LOCK = (ROOT / "tools" / "requirements.lock").read_text(encoding="ascii")
LISTS = sorted((ROOT / "tools").glob("requirements*.in"))


@pytest.mark.parametrize("file", LISTS, ids=lambda file: file.stem)
def test_a_list_gets_what_it_names_with_hashes(file: Path) -> None:
    """Each package in the version of the list, where it states one; pip demands the hashes."""
    found = needed(LOCK, [file.stem])
    pins = dict(re.findall(r"^([\w.-]+)==(\S+) \\\n    --hash=sha256:", found, re.M))
    assert len(pins) == len(re.findall(r"^\w", found, re.M))
    asked = re.findall(r"^(\w[\w-]*)(?:==(\S+))?", file.read_text(encoding="ascii"), re.M)
    assert asked
    for name, version in asked:
        assert version in ("", pins[name.lower()])


def test_the_lists_need_the_whole_lock() -> None:
    """Nothing is pinned that no list needs."""
    whole = needed(LOCK, [file.stem for file in LISTS])
    assert re.findall(r"^\w.*", whole, re.M) == re.findall(r"^\w.*", LOCK, re.M)
