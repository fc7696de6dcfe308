"""One name means one thing in the tools, and the modules of the firmware are listed by theirs."""

from __future__ import annotations

import ast
import re
from collections import Counter

from part_cases import ROOT


def test_no_two_classes_have_one_name() -> None:
    """A reader who meets a class need not ask which of several it is."""
    paths = [
        path
        for package in ("camtools", "checks")
        for path in (ROOT / "tools" / package).rglob("*.py")
    ]
    names = Counter(
        node.name
        for path in paths
        for node in ast.walk(ast.parse(path.read_text("utf-8")))
        if isinstance(node, ast.ClassDef)
    )
    assert len(names) > 100
    assert [name for name, count in names.items() if count > 1] == []


def test_every_module_of_the_firmware_is_in_its_table() -> None:
    """The table of README.md names the modules that exist, each in the room where it lies."""
    rows = (ROOT / "firmware" / "README.md").read_text("utf-8").splitlines()
    listed: dict[str, set[str]] = {}
    room = ""
    for row in rows:
        if found := re.match(r"\| \*\*(\w+)\*\* \|", row):
            room = found[1]
        elif room and row.startswith("| cam_"):
            modules = row.split("|")[1].replace(".h", "").split(",")
            listed.setdefault(room, set()).update(module.strip() for module in modules)
    there: dict[str, set[str]] = {}
    for path in (ROOT / "firmware").glob("*/cam_*.h"):
        there.setdefault(path.parent.name, set()).add(path.stem)
    assert listed == there
