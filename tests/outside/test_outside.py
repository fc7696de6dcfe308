# SPDX-License-Identifier: Apache-2.0
"""The outside sees what it saw before the house was rebuilt, or something better.

outside.json holds what `python tests/outside/record.py` found at the commit before. It is not
recorded again: what changes on purpose has an entry in improved.py, with the reason.
"""

from __future__ import annotations

import fnmatch
import json
import re
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from tests.outside.facts import GROUPS, Fact, Facts, Shop
from tests.outside.improved import Improved, improved

GOLDEN: dict[str, Facts] = json.loads(Path(__file__).with_name("outside.json").read_text())
AT_ONCE = 3  # groups that run side by side; one of them mostly waits


# Figures of a cut, by the end of their names. What is in no list must be equal.
ANYWHERE = re.compile(r"\.max_at_\w+$")
NOT_WORSE = re.compile(
    r"(form_error_um\.(max|rms|roundness)|following_error_um\.\w+|\.gouge_um|_ripple\.\w+"
    r"|lobes\.\d+\.(max|rms)_um|\.off_plan_percent|peak_to_valley\w+|rake_deg\.(min|max))$"
)
NOT_ABOVE = re.compile(r"removal\.\w+\.max$|surface_speed_mm_s\.max$")
NOT_BELOW = re.compile(r"removal\.\w+\.min$|surface_speed_mm_s\.min$")
ABOUT = re.compile(
    r"(: ticks|: machine_time_s|cut\.(turns|seconds|samples|depth_\w+|removed_mm3)|\.samples"
    r"|removal\.(volume_mm3|turns|\w+\.mean)|surface_speed_mm_s\.\w+|without_swing_\w+"
    r"|scallop\.\w+|feasibility\.(highest_rpm|\w+\.needed|\w+\.margin))$"
)
SHARE, SLACK = 0.05, 0.002  # by which a figure may be worse: of itself, and in um, degrees, 1
ABOUT_SHARE = 0.01


def is_as_good(name: str, was: float, now: float) -> bool:
    """Return whether a figure of a cut is at least as good as it was."""
    if ANYWHERE.search(name):
        return True
    room = SHARE * abs(was) + SLACK
    if NOT_WORSE.search(name):
        return abs(now) <= abs(was) + room
    if NOT_ABOVE.search(name):
        return now <= was + room
    if NOT_BELOW.search(name):
        return now >= was - room
    if ABOUT.search(name):
        return abs(now - was) <= ABOUT_SHARE * abs(was)
    return now == was


def is_number(value: object) -> bool:
    """Return whether a fact is a figure."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def entries_for(name: str) -> list[Improved]:
    """Return what is known to have changed of a fact."""
    return [one for one in improved if fnmatch.fnmatchcase(name, one.facts.replace("[", "[[]"))]


def replaced(fact: Fact, old: str, new: str) -> Fact:
    """Return a recorded text with words replaced."""
    if isinstance(fact, list):
        return "\n".join(fact).replace(old, new).split("\n")
    return fact.replace(old, new) if isinstance(fact, str) else fact


def problem(name: str, was: Any, now: Any) -> str | None:  # noqa: ANN401 - any fact
    """Return what is wrong with a fact, nothing when it is as it was or better."""
    for one in entries_for(name):
        if one.at_most is not None:
            if not (is_number(was) and is_number(now) and now <= one.at_most < was):
                return f"{name}: was {was}, should be at most {one.at_most}, is {now}"
            return None
        if one.is_now is not None:
            was = one.is_now
        elif one.old:
            was = replaced(was, one.old, one.new)
    if is_number(was) and is_number(now) and is_as_good(name, was, now):
        return None
    if was == now:
        return None
    if isinstance(was, list) and isinstance(now, list):
        lines = [f"  - {line}" for line in was if line not in now]
        lines += [f"  + {line}" for line in now if line not in was]
        return "\n".join([f"{name}:", *(lines or ["  other order or number of lines"])])
    return f"{name}: was {was}, is {now}"


def problems(golden: Facts, found: Facts) -> list[str]:
    """Return what is wrong with the facts of a group."""

    def presence(name: str) -> str:
        return next((one.presence for one in entries_for(name) if one.presence), "")

    told = [f"{n}: is gone" for n in golden if n not in found and presence(n) != "gone"]
    told += [f"{n}: is new" for n in found if n not in golden and presence(n) != "new"]
    both = (problem(n, golden[n], found[n]) for n in golden if n in found)
    return told + [line for line in both if line is not None]


Find = Callable[[str], Facts]


@pytest.fixture(scope="session")
def find(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Find]:
    """Return what finds the facts of a group.

    They are found side by side, those that come later meanwhile. Where the tests of this file are
    spread over processes that is left to them.
    """
    shop = Shop(tmp_path_factory.mktemp("outside"))
    is_spread = request.config.getoption("dist", "no") not in ("no", "loadfile", "loadscope")
    names = [item.callspec.params.get("group") for item in request.session.items
             if isinstance(item, pytest.Function) and hasattr(item, "callspec")]  # fmt: skip
    found: dict[str, Future[Facts]] = {}
    with ThreadPoolExecutor(AT_ONCE) as pool:

        def get(group: str) -> Facts:
            for name in [group] if is_spread else [group, *(n for n in names if n in GROUPS)]:
                if name not in found:
                    found[name] = pool.submit(GROUPS[name], shop)
            return found[group].result()

        yield get
        pool.shutdown(cancel_futures=True)


@pytest.mark.parametrize("group", GROUPS)
def test_outside_sees_what_it_saw(group: str, find: Find) -> None:
    """Every fact of the group is as recorded, as good, or improved for a reason."""
    wrong = problems(GOLDEN[group], find(group))
    assert not wrong, "\n" + "\n".join(wrong)


def test_every_group_is_recorded() -> None:
    """No group of facts was forgotten, none is left over."""
    assert set(GOLDEN) == set(GROUPS)


def test_improvements_have_reasons_and_facts() -> None:
    """Each entry has a reason and names facts that are there and hold what it replaces."""
    facts = {name: fact for group in GOLDEN.values() for name, fact in group.items()}
    for one in improved:
        assert one.reason.endswith("."), one
        hit = [fact for name, fact in facts.items() if one in entries_for(name)]
        assert hit or one.presence == "new", one
        assert not one.old or any(replaced(fact, one.old, "") != fact for fact in hit), one


@pytest.mark.parametrize(
    ("name", "was", "now", "is_good"),
    [
        ("cut x: form_error_um.max", 0.1, 0.106, True),
        ("cut x: form_error_um.max", 0.1, 0.108, False),
        ("cut x: form_error_um.max", 0.1, 0.01, True),
        ("cut x: rake_deg.min", -0.004, -0.007, False),
        ("cut x: removal.rate_mm3_s.min", 15.0, 20.0, True),
        ("cut x: removal.rate_mm3_s.min", 15.0, 14.0, False),
        ("cut x: ticks", 1000, 1009, True),
        ("cut x: ticks", 1000, 1011, False),
        ("cut x: seed", 1, 2, False),
        ("cut x: is_good", True, False, False),
        ("run x", ["status 2", "! run: x"], ["status 1", "! run: x"], False),
        ("run x", ["a", "b"], ["b", "a"], False),
        ("run x", ["a"], ["a", "a"], False),
        ("table x", "10 bytes, sha256 a", "10 bytes, sha256 b", False),
        ("cut x: form_error_um.max", 0.1, None, False),
    ],
)
def test_what_counts_as_worse(name: str, was: Fact, now: Fact, is_good: bool) -> None:
    """Figures have room, everything else has none."""
    assert (problem(name, was, now) is None) == is_good


def test_facts_that_come_or_go_are_told() -> None:
    """A key that vanished and one that nobody knew are both reported."""
    assert problems({"a": 1, "b": 2}, {"b": 2, "c": 3}) == ["a: is gone", "c: is new"]
