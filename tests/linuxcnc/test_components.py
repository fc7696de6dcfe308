# SPDX-License-Identifier: Apache-2.0
"""Sources of the components, whatever LinuxCNC is here."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from tests.tools.cases.part_cases import ROOT

SIM = ROOT / "hal" / "linuxcnc" / "sim"
FOLDERS = (ROOT / "hal" / "linuxcnc", ROOT / "tests" / "linuxcnc")
COMPONENTS = sorted(path for folder in FOLDERS for path in folder.rglob("*.comp"))


@pytest.mark.parametrize("path", COMPONENTS, ids=lambda path: path.name)
def test_no_function_has_the_attribute_that_linuxcnc_2_10_drops(path: Path) -> None:
    """2.10 warns of fp and nofp; in 2.9 a function without them may use floating point."""
    functions = re.findall(r"^function [^;\"]*", path.read_text(), re.MULTILINE)
    assert functions
    assert [line for line in functions if re.search(r"\b(no)?fp\b", line)] == []


def test_rows_of_the_panel_are_marks_without_content() -> None:
    """PyVCP ends with an error at a widget inside of a tablerow."""
    rows = list(ET.parse(SIM / "panel.xml").iter("tablerow"))
    assert rows
    assert [len(row) for row in rows] == [0] * len(rows)
