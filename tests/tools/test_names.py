"""One name means one thing in the tools, and the modules of the firmware are listed by theirs."""

from __future__ import annotations

import ast
from collections import Counter

from tests.tools.cases.part_cases import ROOT


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
