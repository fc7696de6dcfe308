"""What needs no LinuxCNC: sources of the components, the panel, the lock of the other tests."""

import os
import re
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from tests.linuxcnc.halbox import locked
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


def test_legend_of_the_panel_has_every_state() -> None:
    """As the pin's description, with the same numbers."""
    described = re.search(r'state_number "(.*)"', (SIM.parent / "camturn.comp").read_text())
    assert described is not None
    legend = (SIM / "panel.xml").read_text().split('"0 off')[1].split('"')[0]
    assert ("0 off" + legend).replace("\\n", " ").split() == described[1].split()


def test_lock_serves_every_user_of_the_machine(tmp_path: Path) -> None:
    """Its file can be opened by others, whatever the umask of the user who made it."""
    path = tmp_path / "hal.lock"
    before = os.umask(0o077)
    try:
        with locked(path):
            assert path.stat().st_mode & 0o444 == 0o444
    finally:
        os.umask(before)
    path.chmod(0o444)  # as seen by those who may not write it
    command = ["flock", "--nonblock", str(path), "true"]
    with locked(path):
        assert subprocess.run(command, check=False).returncode == 1
    assert subprocess.run(command, check=False).returncode == 0
