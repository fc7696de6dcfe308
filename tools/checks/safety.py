"""Make firmware/SAFETY.md and THREATS.md of safety.toml, or tell what is named there and missing.

>>> named_function("void test_a(void)", "test_a"), named_function("def test_ab():", "test_a")
(True, False)
"""

from __future__ import annotations

import json
import re
import sys
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from camtools.base.errors import CamtoolsError
from camtools.base.project_paths import ROOT
from checks.page_command import page_command

SOURCE = ROOT / "firmware" / "safety.toml"
_ALL = "*"
_STATES = ROOT / "firmware" / "base" / "cam_state.h"
FAULTS = re.findall(r"^    X\((\w+), ", _STATES.read_text(encoding="utf-8"), re.MULTILINE)
_RESERVED = "corrupt"  # a bit without a fault

_HEAD = """# Safety case

How a lathe with a driven tool can hurt somebody, what this controller does against it, what the
rest of the machine must do, and the tests that verify it. The page is generated from
[safety.toml](safety.toml) by `build/venv/bin/python -m checks.safety --write` (in tools/); a test
compares the two.

**The controller is not a safety component, and this page is not a certificate.** The framework is
that of ISO 12100 (risk assessment by the machine builder) and ISO 23125 (safety of turning
machines): the builder assesses the whole machine, and protective functions with a performance
level (ISO 13849-1) belong to the cabinet below, where they work without software. What the
controller does only makes it less likely that they are needed. [FAULTS.md](FAULTS.md) lists the
faults with reaction and time, [THREATS.md](THREATS.md) says who may command and what is not
protected.
"""


def named_function(text: str, name: str) -> bool:
    """Return whether a source in C or Python defines a function of that name."""
    return re.search(rf"\b(?:void|def) {re.escape(name)}\(", text) is not None


def read_case(path: Path = SOURCE) -> dict[str, Any]:
    """Return the safety case.

    Raises
    ------
    CamtoolsError
        It cannot be read.
    """
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, tomllib.TOMLDecodeError) as error:
        raise CamtoolsError([f"{path}: {error}; mend the file"]) from error


def _missing_test(place: str) -> str | None:
    file, _, function = place.partition("::")
    path = ROOT / file
    if not path.is_file():
        return f"{place}: there is no such file"
    is_there = not function or named_function(path.read_text(encoding="utf-8"), function)
    return None if is_there else f"{place}: there is no such test"


def figure(place: str) -> str:
    """Return a figure with its unit.

    Raises
    ------
    CamtoolsError
        Nobody recorded it.
    """
    file, _, rest = place.partition(":")
    key, _, unit = rest.partition(" ")
    try:
        value = json.loads((ROOT / file).read_text(encoding="utf-8"))[key]
    except (OSError, ValueError, KeyError) as error:
        raise CamtoolsError([f"{place}: no such figure; run its campaign with --record"]) from error
    shown = f"{value:,}".replace(",", " ") if isinstance(value, int) else f"{value:.4g}"
    return f"{shown} {unit}".strip()


def _faults_of(requirement: dict[str, Any]) -> list[str]:
    named = requirement.get("faults", [])
    return sorted(FAULTS) if named == [_ALL] else list(named)


def problems(case: dict[str, Any]) -> list[str]:
    """Return what the safety case names and is not there, and what it leaves open."""
    hazards = {one["id"] for one in case["hazard"]}
    found = []
    for one in case["requirement"]:
        if not one["tests"]:
            found.append(f"{one['id']}: no test shows it")
        found += [f"{one['id']}: {bad}" for bad in map(_missing_test, one["tests"]) if bad]
        found += [f"{one['id']}: no hazard {h}" for h in one["against"] if h not in hazards]
        found += [f"{one['id']}: no fault {f}" for f in _faults_of(one) if f not in FAULTS]
    numbers = [one["id"] for one in case["requirement"]]
    found += [f"{n}: twice" for n in sorted({n for n in numbers if numbers.count(n) > 1})]
    single = [one for one in case["requirement"] if one.get("faults") != [_ALL]]
    told = {fault for one in single for fault in _faults_of(one)}
    found += [f"fault {one}: no requirement" for one in sorted(set(FAULTS) - told - {_RESERVED})]
    met = {hazard for one in case["requirement"] for hazard in one["against"]}
    found += [f"{hazard}: no requirement" for hazard in sorted(hazards - met)]
    for one in case["threat"]:
        found += [f"{one['id']}: no test shows it"] if not one["tests"] else []
        found += [f"{one['id']}: {bad}" for bad in map(_missing_test, one["tests"]) if bad]
    return found


def _rows(cells: Iterable[Iterable[str]], *head: str) -> str:
    lines = [head, ["---"] * len(head), *cells]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def _tests(names: list[str]) -> str:
    shown = []
    for name in names:
        file, _, function = name.partition("::")
        shown.append(f"[{function or Path(file).name}](../{file})")
    return ", ".join(shown)


def page(case: dict[str, Any]) -> str:
    """Return the text of SAFETY.md."""
    hazards = _rows(
        ([one["id"], one["what"], one["when"]] for one in case["hazard"]), "", "hazard", "how"
    )
    cabinet = _rows(
        ([one["what"], ", ".join(one["against"])] for one in case["cabinet"]), "what", "against"
    )
    requirements = _rows(
        (
            [
                one["id"],
                one["text"],
                ", ".join(one["against"]),
                "all"
                if one.get("faults") == [_ALL]
                else ", ".join(f"`{f}`" for f in _faults_of(one)),
                _tests(one["tests"]),
                "; ".join(f"{f['text']}: {figure(f['from'])}" for f in one.get("figures", [])),
            ]
            for one in case["requirement"]
        ),
        *("", "the controller", "against", "faults", "shown by", "figures"),
    )
    limits = _list(case["not_shown"])
    return (
        f"{_HEAD}\n## Hazards\n\n{hazards}\n## What the cabinet must do\n\n{cabinet}"
        f"\n## What the controller does\n\n{requirements}\n## What is not shown\n\n{limits}"
    )


def _list(lines: list[str]) -> str:
    return "".join(f"- {line}\n" for line in lines)


def threats_page(case: dict[str, Any]) -> str:
    """Return the text of THREATS.md."""
    rows = (
        [one["id"], one["what"], one["protection"], _tests(one["tests"])] for one in case["threat"]
    )
    table = _rows(rows, "", "threat", "protection", "shown by")
    return (
        f"{case['threats_head']}\n## Trusted\n\n{_list(case['trusted'])}\n## Protected\n\n{table}"
        f"\n## Not protected\n\n{_list(case['unprotected'])}"
    )


def pages(case: dict[str, Any]) -> dict[str, str]:
    """Return the texts of both pages by their names in firmware/."""
    return {"SAFETY.md": page(case), "THREATS.md": threats_page(case)}


def _checked_pages() -> dict[str, str]:
    case = read_case()
    found = problems(case)
    if found:
        raise CamtoolsError([f"{SOURCE.name}: {one}" for one in found])
    return pages(case)


def main(words: list[str] | None = None) -> int:
    """Check SAFETY.md and THREATS.md, or write them anew."""
    return page_command("safety", __doc__, SOURCE.parent, _checked_pages, words)


if __name__ == "__main__":
    sys.exit(main())
